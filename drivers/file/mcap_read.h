/*
 * Reads MCAP files: by their index where there is one, else by scanning the whole file, which also
 * checks everything. Damaged parts are passed over and noted: where, how many bytes, what is wrong.
 * Memory is bounded by the constants of mcap.h whatever a file claims. A reader and its iterators
 * belong to one thread.
 */
#ifndef DX_MCAP_READ_H
#define DX_MCAP_READ_H

#include "core/base/err.h"
#include "drivers/file/mcap_pack.h"
#include "drivers/file/mcap_record.h"

struct dx_mcap_reader;

struct dx_mcap_read_options {
    bool scan;        /* read all of the file, whether it has an index or not, and check it */
    size_t max_chunk; /* 0: DX_MCAP_MAX_CHUNK */
    /* Each message that opening finds by scanning, in the file's order, so that a file need not be
     * read twice. Its data have a length alone. NULL: nobody asks. */
    void (*on_message)(void *ctx, const struct dx_mcap_message *m);
    void *ctx;
};

/* Errors: -EBADMSG, no MCAP file at all; -ENOMEM; the source's for its first bytes. A damaged file
 * opens. The source's ctx must outlive the reader. `options` may be NULL. */
int dx_mcap_reader_open(struct dx_mcap_reader **out, const struct dx_mcap_source *source,
                        const struct dx_mcap_read_options *options, struct dx_err *err);
void dx_mcap_reader_free(struct dx_mcap_reader *r);

struct dx_mcap_info {
    const char *profile, *library; /* printable */
    bool indexed;                  /* read by the index, not by scanning */
    uint64_t len;                  /* of the file */
    uint64_t n_messages;
    uint64_t start, end; /* log times of the first and the last message, ns; 0 when there is none */
    uint32_t n_chunks;
    uint32_t n_of[DX_MCAP_N_COMPRESSIONS]; /* chunks */
};

void dx_mcap_reader_info(const struct dx_mcap_reader *r, struct dx_mcap_info *out);

/* ---- what is damaged --------------------------------------------------------------------------
 */

struct dx_mcap_damage {
    uint64_t offset, len;
    char text[160];
};

/* How many were found so far; more may come as chunks are read. The first 64 can be looked at. */
uint64_t dx_mcap_reader_damages(const struct dx_mcap_reader *r);
const struct dx_mcap_damage *dx_mcap_reader_damage(const struct dx_mcap_reader *r, uint64_t k);

/* ---- schemas, channels, attachments, metadata -------------------------------------------------
 */

/* By number, 0 up to NULL, or by id. They stay until free(). Those that a file declares in chunks
 * alone appear as the chunks are read. */
const struct dx_mcap_channel *dx_mcap_reader_channel(const struct dx_mcap_reader *r, uint32_t k);
const struct dx_mcap_channel *dx_mcap_reader_find(const struct dx_mcap_reader *r, uint16_t id);
const struct dx_mcap_channel *dx_mcap_reader_topic(const struct dx_mcap_reader *r,
                                                   const char *topic);
const struct dx_mcap_schema *dx_mcap_reader_schema(const struct dx_mcap_reader *r, uint32_t k);
const struct dx_mcap_schema *dx_mcap_reader_find_schema(const struct dx_mcap_reader *r,
                                                        uint16_t id);
/* Messages of a channel, as the statistics tell or as were found by scanning. */
uint64_t dx_mcap_reader_count(const struct dx_mcap_reader *r, uint16_t id);

/* By number, 0 up to NULL. */
const struct dx_mcap_item_index *dx_mcap_reader_attachment(const struct dx_mcap_reader *r,
                                                           uint32_t k);
const struct dx_mcap_item_index *dx_mcap_reader_metadata(const struct dx_mcap_reader *r,
                                                         uint32_t k);

/* Reads one; its bytes are the reader's and hold until the next of these calls. -EBADMSG: damaged
 * (the CRC too); -EFBIG: larger than a chunk may be; -ENOMEM; the source's. err names the place. */
int dx_mcap_reader_read_attachment(struct dx_mcap_reader *r, const struct dx_mcap_item_index *item,
                                   struct dx_mcap_attachment *out, struct dx_err *err);
int dx_mcap_reader_read_metadata(struct dx_mcap_reader *r, const struct dx_mcap_item_index *item,
                                 struct dx_mcap_metadata *out, struct dx_err *err);

/* ---- messages ---------------------------------------------------------------------------------
 */

enum dx_mcap_order {
    DX_MCAP_LOG_TIME,   /* over all chunks; equal times as they lie in the file */
    DX_MCAP_FILE_ORDER, /* as they lie in the file */
};

struct dx_mcap_query {
    enum dx_mcap_order order;
    uint64_t start, end;      /* log times, the end exclusive; end 0: none */
    const uint16_t *channels; /* NULL: all */
    size_t n_channels;
};

struct dx_mcap_iter;

/* -ENOMEM. `query` may be NULL: all messages by log time. */
int dx_mcap_iter_new(struct dx_mcap_iter **out, struct dx_mcap_reader *r,
                     const struct dx_mcap_query *query);
void dx_mcap_iter_free(struct dx_mcap_iter *it);

/*
 * The next message. Its bytes hold until the next call for this reader or one of its iterators.
 * 0; DX_MCAP_E_END; -ENOMEM; -E2BIG: in order of log time, chunks that overlap too much: more than
 * DX_MCAP_MAX_PENDING messages in them, or DX_MCAP_MAX_AGAIN and three times their length were
 * decompressed a second time (file order can read it). Damaged chunks are passed over and noted.
 */
int dx_mcap_iter_next(struct dx_mcap_iter *it, struct dx_mcap_message *out);
/* What a negative result of next() means. */
const char *dx_mcap_iter_why(const struct dx_mcap_iter *it, int rc);
/* Goes to the first message of log time `start` or later; also back. */
void dx_mcap_iter_seek(struct dx_mcap_iter *it, uint64_t start);

#endif
