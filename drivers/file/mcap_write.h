/*
 * Writes MCAP files: messages gathered into compressed chunks, each with its message indexes, and
 * at the end the summary. All memory is allocated by new() and by the definition of channels; a
 * file after the other can then be written with it (rotation). Owned by one thread, which alone
 * waits for the sink.
 *
 * Each chunk declares the channels that it uses, so that it can be read when the chunks before it
 * are damaged.
 *
 * Errors of the sink come back as they are (-ENOSPC, -EIO), and never leave the writer in doubt:
 * the file counts as ending where its last whole chunk (or attachment, metadata) ends, and what
 * could not be written is still held. After one, the caller may
 *   - call again: the same place is written anew, nothing is lost;
 *   - recover(): cut the torn bytes off, so that the file is whole while the writer waits;
 *   - drop(): give up the messages of the open chunk, and go on;
 *   - finish(), or free(): a file without its summary is read by scanning, and repaired.
 */
#ifndef DX_MCAP_WRITE_H
#define DX_MCAP_WRITE_H

#include "core/base/err.h"
#include "drivers/file/mcap_pack.h"

/* Zeros stand for the defaults. */
struct dx_mcap_writer_config {
    enum dx_mcap_compression compression;
    int level;
    size_t chunk_len;      /* a chunk closes at so many bytes; 0: 1 MiB */
    uint64_t chunk_ns;     /* and when its log times span as much; 0: 1 s */
    size_t max_message;    /* bytes of data; 0: 16 MiB. A larger one is refused */
    uint32_t max_messages; /* of a chunk; 0: 32768 */
    uint32_t max_channels; /* and schemas; 0: 256 */
    size_t max_defs;       /* bytes of their records; 0: 1 MiB */
    size_t index_len;      /* bytes of the index of chunks; 0: 4 MiB (some 40000 chunks) */
    size_t items_len;      /* and of those of attachments, of metadata, each; 0: 256 KiB */
    const char *profile;   /* NULL: "" */
    const char *library;   /* NULL: "dexeld" and its version */
};

struct dx_mcap_writer;

/* Errors: -ENOMEM; -EINVAL: bounds that no chunk can hold. */
int dx_mcap_writer_new(struct dx_mcap_writer **out, const struct dx_mcap_writer_config *config,
                       struct dx_err *err);
void dx_mcap_writer_free(struct dx_mcap_writer *w);

/* Declares a schema or a channel, for this file and the next ones; any time. Ids are the caller's;
 * the same again is fine. Errors: -EEXIST, the id is another's; -E2BIG, a bound; -ENOENT, no such
 * schema; -ENOMEM. */
int dx_mcap_writer_schema(struct dx_mcap_writer *w, const struct dx_mcap_schema *s);
int dx_mcap_writer_channel(struct dx_mcap_writer *w, const struct dx_mcap_channel *c);

/* Begins a file. The sink's ctx must live until finish() or the next begin(). What an unfinished
 * file before it still held is dropped. 0 or the sink's error: begin again. */
int dx_mcap_writer_begin(struct dx_mcap_writer *w, const struct dx_mcap_sink *sink);

/*
 * Takes a message, after closing the open chunk where it is due. 0: taken. DX_MCAP_E_FULL, or the
 * sink's error, or -EMSGSIZE (larger than max_message), -ENOENT (no such channel), -ENOMEM: not
 * taken.
 */
int dx_mcap_writer_message(struct dx_mcap_writer *w, const struct dx_mcap_message *m);

/* Closes the open chunk now (nothing has come for a while). 0 or the sink's error. */
int dx_mcap_writer_flush(struct dx_mcap_writer *w);
/* Gives up the messages of the open chunk; returns how many. */
uint32_t dx_mcap_writer_drop(struct dx_mcap_writer *w);
/* Cuts off what a failed write left behind. */
int dx_mcap_writer_recover(struct dx_mcap_writer *w);

/* Between chunks; the open chunk stays open. Names of at most 1024 bytes (-EINVAL), also
 * DX_MCAP_E_FULL. */
int dx_mcap_writer_attachment(struct dx_mcap_writer *w, const struct dx_mcap_attachment *a);
int dx_mcap_writer_metadata(struct dx_mcap_writer *w, const struct dx_mcap_metadata *m);

/* The open chunk, then summary and footer: the file is complete. After an error it may be called
 * again. */
int dx_mcap_writer_finish(struct dx_mcap_writer *w);

struct dx_mcap_progress {
    uint64_t len;              /* of the file, up to its last whole chunk */
    uint64_t n_messages;       /* written */
    uint32_t n_chunks, n_open; /* messages of the open chunk */
    size_t open_len;           /* and its bytes */
};

struct dx_mcap_progress dx_mcap_writer_progress(const struct dx_mcap_writer *w);

#endif
