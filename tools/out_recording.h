/*
 * A recording as the service makes one (docs/recorder.md), written from the blocks of a source. One
 * thread's.
 */
#ifndef DX_OUT_RECORDING_H
#define DX_OUT_RECORDING_H

#include "drivers/file/mcap_write.h"
#include "drivers/file/recording.h"
#include "tools/out_file.h"

/* Who decodes the blocks: the driver, and the stream's name and configuration; copied. */
struct dx_out_recording_of {
    const char *driver, *stream;
    const char *yaml;
    size_t yaml_len;
};

struct dx_out_recording {
    struct dx_out_file file;
    struct dx_mcap_writer *writer;
    char *yaml;
    size_t yaml_len;
    uint8_t *geometry, *message;
    size_t geometry_len, message_cap;
    uint32_t n_messages;
};

/* Errors: -errno, the path in the text; zeroed then. */
int dx_out_recording_open(struct dx_out_recording *o, const char *path,
                          const struct dx_out_recording_of *of, struct dx_err *err);

/* In force from `time` (log time, ns) on; before the first block: from that on. */
int dx_out_recording_geometry(struct dx_out_recording *o, const struct dx_geometry *g,
                              uint8_t attr_bytes, uint64_t time, struct dx_err *err);
int dx_out_recording_add(struct dx_out_recording *o, const struct dx_block *block,
                         bool starts_frame, uint64_t time, struct dx_err *err);

/* The gaps that the recordings at `path` tell of (DX_RECORDING_GAP), as they are there. Behind the
 * first block. */
int dx_out_recording_copy_gaps(struct dx_out_recording *o, const char *path, struct dx_err *err);

/* Puts the file in its place; no block at all is -ENODATA. `o` is zeroed, whatever is returned. */
int dx_out_recording_commit(struct dx_out_recording *o, struct dx_err *err);
/* Takes it back. Zeroed is fine. */
void dx_out_recording_abort(struct dx_out_recording *o);

#endif
