/* Appending to an MCAP file in whole pieces. */
#include "drivers/file/mcap_write_priv.h"

#include "drivers/file/crc32.h"

struct dx_mcap_piece dx_mcap_piece_begin(struct dx_mcap_writer *w)
{
    return (struct dx_mcap_piece){.w = w, .at = w->file_len, .crc = w->file_crc};
}

static void put_through(struct dx_mcap_piece *p, const void *bytes, size_t len)
{
    struct dx_mcap_sink *sink = &p->w->sink;

    if (!p->failed && len)
        p->failed = sink->write(sink->ctx, p->at, bytes, len);
    p->at += len;
}

static void put_staged(struct dx_mcap_piece *p)
{
    put_through(p, p->w->stage, p->staged);
    p->staged = 0;
}

void dx_mcap_piece_put(struct dx_mcap_piece *p, const void *bytes, size_t len)
{
    if (p->failed || len == 0)
        return;
    p->crc = dx_crc32(p->crc, bytes, len);
    if (len > DX_MCAP_STAGE - p->staged)
        put_staged(p);
    if (len > DX_MCAP_STAGE) {
        put_through(p, bytes, len);
        return;
    }
    memcpy(p->w->stage + p->staged, bytes, len);
    p->staged += len;
}

int dx_mcap_piece_commit(struct dx_mcap_piece *p)
{
    put_staged(p);
    if (p->failed)
        return p->failed;
    p->w->file_len = p->at;
    p->w->file_crc = p->crc;
    return 0;
}
