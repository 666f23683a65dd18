/*
 * MCAP records to bytes and back. Reading leaves views into the given bytes; lengths are checked
 * against what is there, fields that a later version may append are ignored. Writing goes through a
 * dx_writer, which fails when its room runs out.
 */
#ifndef DX_MCAP_RECORD_H
#define DX_MCAP_RECORD_H

#include "core/base/bytes.h"
#include "drivers/file/mcap.h"

/* ---- framing ----------------------------------------------------------------------------------
 */

struct dx_mcap_record {
    uint8_t op;
    const uint8_t *body;
    size_t len; /* of the body */
};

/* The next of a run of records in memory. 0; DX_MCAP_E_END after the last; -EBADMSG: it reaches
 * beyond the end. */
int dx_mcap_next_record(struct dx_mcap_record *out, struct dx_reader *r);

/* Opens a record; end() fills in the length. The address is of the record. */
uint8_t *dx_mcap_record_begin(struct dx_writer *w, enum dx_mcap_op op);
void dx_mcap_record_end(struct dx_writer *w, uint8_t *record);

/* ---- texts and maps ---------------------------------------------------------------------------
 */

struct dx_mcap_text dx_mcap_text(const char *text);
bool dx_mcap_text_is(struct dx_mcap_text text, const char *other);
/* A copy that ends in NUL, cut to `cap`; bytes of no text are '?', so that it may be printed. */
void dx_mcap_text_copy(char *out, size_t cap, struct dx_mcap_text text);

struct dx_mcap_pair {
    struct dx_mcap_text key, value;
};

/* Encoded bytes of a map (without its length); w fails when they do not fit. */
void dx_mcap_put_pairs(struct dx_writer *w, const struct dx_mcap_pair *pairs, size_t n);
/* The next pair of a map; 0, DX_MCAP_E_END, -EBADMSG. Start with dx_reader_init(map.p, map.len). */
int dx_mcap_next_pair(struct dx_mcap_pair *out, struct dx_reader *r);

/* ---- bodies: 0 or -EBADMSG --------------------------------------------------------------------
 */

int dx_mcap_get_header(struct dx_mcap_text *profile, struct dx_mcap_text *library,
                       const uint8_t *body, size_t len);
int dx_mcap_get_schema(struct dx_mcap_schema *out, const uint8_t *body, size_t len);
int dx_mcap_get_channel(struct dx_mcap_channel *out, const uint8_t *body, size_t len);
int dx_mcap_get_message(struct dx_mcap_message *out, const uint8_t *body, size_t len);
int dx_mcap_get_chunk(struct dx_mcap_chunk *out, const uint8_t *body, size_t len);
int dx_mcap_get_metadata(struct dx_mcap_metadata *out, const uint8_t *body, size_t len);
int dx_mcap_get_statistics(struct dx_mcap_statistics *out, const uint8_t *body, size_t len);

/* An Attachment up to its data, of which `len` bytes are there: what the data are is told as an
 * offset into the body and a length, for they may be larger than memory. */
int dx_mcap_get_attachment_head(struct dx_mcap_attachment *out, struct dx_mcap_extent *data,
                                const uint8_t *body, size_t len);

struct dx_mcap_chunk_index {
    struct dx_mcap_extent chunk;
    uint64_t start, end, message_index_len, compressed_len, uncompressed_len;
    struct dx_mcap_bytes offsets; /* map of u16 channel to u64 offset of its MessageIndex */
    struct dx_mcap_text compression;
};

struct dx_mcap_item_index { /* of an attachment, or of metadata (without times, data, type) */
    struct dx_mcap_extent record;
    uint64_t log_time, create_time, data_len;
    struct dx_mcap_text name, media_type;
};

int dx_mcap_get_chunk_index(struct dx_mcap_chunk_index *out, const uint8_t *body, size_t len);
int dx_mcap_get_attachment_index(struct dx_mcap_item_index *out, const uint8_t *body, size_t len);
int dx_mcap_get_metadata_index(struct dx_mcap_item_index *out, const uint8_t *body, size_t len);

/* ---- whole records ----------------------------------------------------------------------------
 */

void dx_mcap_put_header(struct dx_writer *w, const char *profile, const char *library);
void dx_mcap_put_schema(struct dx_writer *w, const struct dx_mcap_schema *s);
void dx_mcap_put_channel(struct dx_writer *w, const struct dx_mcap_channel *c);
void dx_mcap_put_message(struct dx_writer *w, const struct dx_mcap_message *m);
void dx_mcap_put_attachment_index(struct dx_writer *w, const struct dx_mcap_item_index *i);
void dx_mcap_put_metadata_index(struct dx_writer *w, const struct dx_mcap_item_index *i);
void dx_mcap_put_summary_offset(struct dx_writer *w, uint8_t op, const struct dx_mcap_extent *e);

/* Up to the data, which the caller appends: opcode, the length of the whole, the fields. */
void dx_mcap_put_chunk_head(struct dx_writer *w, const struct dx_mcap_chunk *c);
void dx_mcap_put_attachment_head(struct dx_writer *w, const struct dx_mcap_attachment *a);
void dx_mcap_put_metadata_head(struct dx_writer *w, const struct dx_mcap_metadata *m);

/* Lengths of what the put functions write. */
size_t dx_mcap_schema_len(const struct dx_mcap_schema *s);
size_t dx_mcap_channel_len(const struct dx_mcap_channel *c);

#endif
