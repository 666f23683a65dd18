/*
 * The parts of a recording through a writer of MCAP: what the service's recorder and `dexel
 * convert` have in common. They write what is due and keep nothing; errors are the writer's, and
 * after one all is as before. Of the thread that owns the writer.
 */
#ifndef DX_RECORDING_WRITE_H
#define DX_RECORDING_WRITE_H

#include "drivers/file/mcap_write.h"
#include "drivers/file/recording.h"

/* The channel, once for a writer: which driver decodes, and the name of the stream. -E2BIG. */
int dx_recording_declare(struct dx_mcap_writer *w, const char *driver, const char *stream);

/* The attachments; `time` is a log time, ns. */
int dx_recording_attach_config(struct dx_mcap_writer *w, uint64_t time, const char *yaml,
                               size_t len);
/* As dx_recording_put_geometry() made it. */
int dx_recording_attach_geometry(struct dx_mcap_writer *w, uint64_t time, const uint8_t *bytes,
                                 size_t len);

/* A message: a piece of a block, as dx_recording_put_piece() made it. */
int dx_recording_put_message(struct dx_mcap_writer *w, uint32_t sequence, uint64_t time,
                             const uint8_t *bytes, size_t len);

/* Blocks that were not recorded: how many, the number of the first; log times of first and last. */
struct dx_recording_gap {
    uint64_t n, first, start, end;
};

int dx_recording_put_gap(struct dx_mcap_writer *w, const struct dx_recording_gap *gap);

#endif
