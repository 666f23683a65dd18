/* Blocks and geometries of a recording, to bytes and back. */
#include "drivers/file/recording.h"

#include "core/base/bytes.h"

#include <errno.h>
#include <math.h>

#define GEOMETRY_HEAD (8 + 2 * 4 + 4 + 12 * 8 + 4)

struct dx_recording_piece dx_recording_piece_of(const struct dx_block *block, bool starts_frame,
                                                size_t offset)
{
    size_t len = block->len - offset;

    return (struct dx_recording_piece){
        .number = block->number,
        .device_ns = block->stamp.device_ns,
        .clock_id = block->stamp.clock_id,
        .flags = (uint16_t)((starts_frame ? DX_RECORDING_STARTS_FRAME : 0) |
                            (block->first ? DX_RECORDING_FIRST : 0)),
        .block_len = block->len,
        .offset = offset,
        .source = block->source,
        .source_len = (uint16_t)(offset ? 0 : strnlen(block->source, DX_RECORDING_MAX_SOURCE)),
        .bytes = block->len ? block->bytes + offset : NULL,
        .len = len < DX_RECORDING_PIECE ? len : DX_RECORDING_PIECE,
    };
}

size_t dx_recording_piece_len(const struct dx_recording_piece *p)
{
    return DX_RECORDING_HEAD + (size_t)p->source_len + p->len;
}

void dx_recording_put_piece(uint8_t *out, const struct dx_recording_piece *p)
{
    dx_put_u64(out, p->number);
    dx_put_u64(out + 8, p->device_ns);
    dx_put_u32(out + 16, p->clock_id);
    dx_put_u16(out + 20, p->flags);
    dx_put_u16(out + 22, p->source_len);
    dx_put_u64(out + 24, p->block_len);
    dx_put_u64(out + 32, p->offset);
    if (p->source_len)
        memcpy(out + DX_RECORDING_HEAD, p->source, p->source_len);
    if (p->len)
        memcpy(out + DX_RECORDING_HEAD + p->source_len, p->bytes, p->len);
}

int dx_recording_get_piece(struct dx_recording_piece *out, const uint8_t *bytes, size_t len)
{
    struct dx_reader r = dx_reader_init(bytes, len);

    out->number = dx_read_u64(&r);
    out->device_ns = dx_read_u64(&r);
    out->clock_id = dx_read_u32(&r);
    out->flags = dx_read_u16(&r);
    out->source_len = dx_read_u16(&r);
    out->block_len = dx_read_u64(&r);
    out->offset = dx_read_u64(&r);
    out->source = (const char *)dx_read_bytes(&r, out->source_len);
    out->len = dx_reader_left(&r);
    out->bytes = r.p;
    if (r.failed || out->source_len > DX_RECORDING_MAX_SOURCE ||
        out->block_len > DX_RECORDING_MAX_BLOCK || out->offset > out->block_len ||
        out->len > out->block_len - out->offset || (out->len == 0 && out->block_len > 0))
        return -EBADMSG;
    return 0;
}

size_t dx_recording_geometry_len(const struct dx_geometry *g)
{
    return GEOMETRY_HEAD + 4 * g->n_table;
}

void dx_recording_put_geometry(uint8_t *out, const struct dx_geometry *g, uint8_t attr_bytes)
{
    const uint8_t small[8] = {(uint8_t)g->model, g->wrap,    g->flip,
                              g->range_bytes,    attr_bytes, g->exact};

    memcpy(out, small, sizeof(small));
    dx_put_u32(out + 8, g->height);
    dx_put_u32(out + 12, g->width);
    dx_put_u32(out + 16, dx_f32_bits(g->unit_m));
    for (size_t k = 0; k < 12; k++)
        dx_put_u64(out + 20 + 8 * k, dx_f64_bits(g->pose[k]));
    dx_put_u32(out + 116, (uint32_t)g->n_table);
    dx_put_f32s(out + GEOMETRY_HEAD, g->table, g->n_table);
}

/* The fields behind the sizes; what a geometry may not be is refused. */
static int get_fields(struct dx_geometry *g, struct dx_reader *r, const uint8_t *small)
{
    uint32_t n_table;

    g->wrap = small[1] != 0;
    g->flip = small[2] != 0;
    g->range_bytes = small[3];
    g->exact = small[5] != 0;
    g->unit_m = dx_read_f32(r);
    for (size_t k = 0; k < 12; k++) {
        g->pose[k] = dx_read_f64(r);
        if (!isfinite(g->pose[k]))
            return -EBADMSG;
    }
    n_table = dx_read_u32(r);
    if (r->failed || n_table != g->n_table || dx_reader_left(r) != 4 * g->n_table ||
        !(g->unit_m > 0) || isinf(g->unit_m) || (g->range_bytes != 2 && g->range_bytes != 4))
        return -EBADMSG;
    dx_get_f32s(g->table, r->p, g->n_table);
    for (size_t k = 0; k < g->n_table; k++)
        if (!isfinite(g->table[k]))
            return -EBADMSG;
    return 0;
}

int dx_recording_get_geometry(struct dx_geometry **out, uint8_t *attr_bytes, const uint8_t *bytes,
                              size_t len)
{
    struct dx_reader r = dx_reader_init(bytes, len);
    const uint8_t *small = dx_read_bytes(&r, 8);
    uint32_t height = dx_read_u32(&r), width = dx_read_u32(&r);
    size_t n_table;
    int rc;

    if (r.failed || small[4] > 2)
        return -EBADMSG;
    n_table = dx_geometry_table_len((enum dx_model)small[0], height, width);
    if (n_table == 0 || len != GEOMETRY_HEAD + 4 * n_table)
        return -EBADMSG;
    rc = dx_geometry_new(out, (enum dx_model)small[0], height, width);
    if (rc)
        return rc;
    *attr_bytes = small[4];
    rc = get_fields(*out, &r, small);
    if (rc) {
        dx_geometry_unref(*out);
        *out = NULL;
    }
    return rc;
}
