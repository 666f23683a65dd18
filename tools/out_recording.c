/* Blocks to a recording. */
#include "tools/out_recording.h"

#include "drivers/file/file_list.h"
#include "drivers/file/recording_write.h"
#include "tools/mcap_open.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* What the writer returned, in words. */
static int failed(struct dx_out_recording *o, int rc, struct dx_err *err)
{
    if (rc == DX_MCAP_E_FULL)
        return dx_err_set(err, -EFBIG, "%s: more than one recording can hold", o->file.path);
    return rc ? dx_err_set(err, rc, "%s: cannot be written: %s", o->file.path, strerror(-rc)) : 0;
}

static int begin(struct dx_out_recording *o, const struct dx_out_recording_of *of)
{
    const struct dx_mcap_writer_config config = {
        .compression = DX_MCAP_ZSTD,
        .max_message = DX_RECORDING_HEAD + DX_RECORDING_MAX_SOURCE + DX_RECORDING_PIECE};
    const struct dx_mcap_sink sink = dx_mcap_sink_fd(fileno(o->file.stream));
    int rc;

    o->message_cap = config.max_message;
    o->message = malloc(o->message_cap);
    o->yaml = malloc(of->yaml_len + 1);
    if (!o->message || !o->yaml)
        return -ENOMEM;
    memcpy(o->yaml, of->yaml, of->yaml_len);
    o->yaml_len = of->yaml_len;
    rc = dx_mcap_writer_new(&o->writer, &config, NULL);
    if (rc == 0)
        rc = dx_recording_declare(o->writer, of->driver, of->stream);
    return rc ? rc : dx_mcap_writer_begin(o->writer, &sink);
}

int dx_out_recording_open(struct dx_out_recording *o, const char *path,
                          const struct dx_out_recording_of *of, struct dx_err *err)
{
    int rc;

    *o = (struct dx_out_recording){0};
    rc = dx_out_file_open(&o->file, path, err);
    if (rc < 0)
        return rc;
    rc = failed(o, begin(o, of), err);
    if (rc < 0)
        dx_out_recording_abort(o);
    return rc;
}

static int attach_geometry(struct dx_out_recording *o, uint64_t time)
{
    return o->geometry ? dx_recording_attach_geometry(o->writer, time, o->geometry, o->geometry_len)
                       : 0;
}

int dx_out_recording_geometry(struct dx_out_recording *o, const struct dx_geometry *g,
                              uint8_t attr_bytes, uint64_t time, struct dx_err *err)
{
    size_t len = dx_recording_geometry_len(g);
    uint8_t *bytes = malloc(len);

    if (!bytes)
        return failed(o, -ENOMEM, err);
    dx_recording_put_geometry(bytes, g, attr_bytes);
    free(o->geometry);
    o->geometry = bytes;
    o->geometry_len = len;
    return o->n_messages ? failed(o, attach_geometry(o, time), err) : 0;
}

static int put(struct dx_out_recording *o, const struct dx_block *block, bool starts_frame,
               uint64_t time)
{
    size_t offset = 0;
    int rc = 0;

    if (block->len > DX_RECORDING_MAX_BLOCK)
        return -EFBIG;
    if (o->n_messages == 0) {
        rc = dx_recording_attach_config(o->writer, time, o->yaml, o->yaml_len);
        if (rc == 0)
            rc = attach_geometry(o, time);
    }
    do {
        struct dx_recording_piece piece = dx_recording_piece_of(block, starts_frame, offset);

        dx_recording_put_piece(o->message, &piece);
        if (rc == 0)
            rc = dx_recording_put_message(o->writer, o->n_messages++, time, o->message,
                                          dx_recording_piece_len(&piece));
        offset += piece.len;
    } while (rc == 0 && offset < block->len);
    return rc;
}

int dx_out_recording_add(struct dx_out_recording *o, const struct dx_block *block,
                         bool starts_frame, uint64_t time, struct dx_err *err)
{
    return failed(o, put(o, block, starts_frame, time), err);
}

/* What cannot be read of them is lost, as the blocks beside it are. */
static int copy_gaps(struct dx_out_recording *o, struct dx_mcap_reader *r)
{
    const struct dx_mcap_item_index *item;
    struct dx_mcap_metadata m;
    int rc = 0;

    for (uint32_t k = 0; rc == 0 && (item = dx_mcap_reader_metadata(r, k)) != NULL; k++)
        if (dx_mcap_text_is(item->name, DX_RECORDING_GAP) &&
            dx_mcap_reader_read_metadata(r, item, &m, NULL) == 0)
            rc = dx_mcap_writer_metadata(o->writer, &m);
    return rc;
}

int dx_out_recording_copy_gaps(struct dx_out_recording *o, const char *path, struct dx_err *err)
{
    struct dx_file_list list;
    int rc = o->n_messages ? dx_file_list_init(&list, path, err) : 0;

    if (rc || !o->n_messages)
        return rc;
    for (size_t k = 0; rc == 0 && k < list.n; k++) {
        struct dx_mcap_file file;

        /* one that is no recording was passed over for its blocks, too */
        if (dx_mcap_file_open(&file, list.paths[k], NULL, NULL) < 0)
            continue;
        rc = failed(o, copy_gaps(o, file.reader), err);
        dx_mcap_file_close(&file);
    }
    dx_file_list_fini(&list);
    return rc;
}

int dx_out_recording_commit(struct dx_out_recording *o, struct dx_err *err)
{
    int rc = o->n_messages ? failed(o, dx_mcap_writer_finish(o->writer), err)
                           : dx_err_set(err, -ENODATA, "%s: not written: no frames", o->file.path);

    if (rc == 0)
        rc = dx_out_file_commit(&o->file, err);
    dx_out_recording_abort(o);
    return rc;
}

void dx_out_recording_abort(struct dx_out_recording *o)
{
    dx_mcap_writer_free(o->writer);
    dx_out_file_abort(&o->file);
    free(o->yaml);
    free(o->geometry);
    free(o->message);
    *o = (struct dx_out_recording){0};
}
