/* What the files of the MCAP reader share. */
#ifndef DX_MCAP_READ_PRIV_H
#define DX_MCAP_READ_PRIV_H

#include "drivers/file/mcap_defs.h"
#include "drivers/file/mcap_read.h"

#define DX_MCAP_MAX_DAMAGES 64
#define DX_MCAP_N_SLOTS     16

/* A chunk, or a run of messages outside of chunks (which is read as a chunk of its own). */
struct dx_mcap_part {
    struct dx_mcap_extent at;
    uint64_t start, end;  /* log times */
    uint32_t records_len; /* decompressed; known once it was scanned */
    uint8_t compression;
    bool is_run;
    bool is_bad; /* could not be read, and that was noted */
    bool has_messages;
    bool is_odd; /* its records are not all good: its bytes are not to be copied as they are */
};

struct dx_mcap_parts {
    struct dx_mcap_part *p;
    uint32_t n, cap;
};

/* Attachments, or metadata records; each name is copied. */
struct dx_mcap_items {
    struct dx_mcap_item_index *p;
    uint32_t n, cap;
    size_t names_len;
};

/* The records of a part, decompressed. */
struct dx_mcap_slot {
    uint8_t *bytes;
    size_t len, cap;
    uint64_t offset; /* of the part; 0: none */
    uint64_t used;   /* when */
};

/* A stretch of the file in memory, for records of any length. */
struct dx_mcap_view {
    uint8_t *bytes;
    size_t len, cap;
    uint64_t offset;
};

struct dx_mcap_reader {
    struct dx_mcap_source source;
    size_t max_chunk;
    void (*on_message)(void *ctx, const struct dx_mcap_message *m); /* or NULL */
    void *on_message_ctx;
    char profile[64], library[128];
    uint64_t data_start; /* of the first record after the header */
    bool indexed;

    struct dx_mcap_defs defs;
    struct dx_mcap_parts parts;
    struct dx_mcap_items attachments, metadata;
    uint64_t n_messages, start, end;

    /* what the summary says; has_summary: its CRC and records are good */
    bool has_footer, has_summary, has_statistics;
    uint64_t summary_start;
    struct dx_mcap_statistics statistics;

    struct dx_mcap_view view;
    struct dx_mcap_slot slots[DX_MCAP_N_SLOTS];
    uint64_t clock;   /* of slot use */
    uint64_t n_loads; /* of parts that were in no slot */
    struct dx_mcap_unpacker *unpacker;
    struct dx_err why; /* of the last failed load */

    struct dx_mcap_damage damages[DX_MCAP_MAX_DAMAGES];
    uint64_t n_damages;
};

/* ---- mcap_read.c ------------------------------------------------------------------------------
 */

/* The bytes at an offset; they hold until the next call. -EBADMSG: the file ends before; -ENOMEM;
 * the source's. */
int dx_mcap_view_get(struct dx_mcap_reader *r, uint64_t offset, size_t len, const uint8_t **out);
/* CRC of a stretch of the file. */
int dx_mcap_view_crc(struct dx_mcap_reader *r, uint64_t offset, uint64_t len, uint32_t *crc);

__attribute__((format(printf, 4, 5))) void dx_mcap_note(struct dx_mcap_reader *r, uint64_t offset,
                                                        uint64_t len, const char *fmt, ...);

/* A record's head; `len` of the whole record. -EBADMSG: it reaches beyond `end`, or is no record.
 */
int dx_mcap_record_at(struct dx_mcap_reader *r, uint64_t offset, uint64_t end, uint8_t *op,
                      uint64_t *len);

/* Of a good record that claims to be longer than its fields: these are of a later version, or its
 * length is damaged. It is that (and noted) when another record begins behind the known fields. */
uint64_t dx_mcap_true_len(struct dx_mcap_reader *r, uint64_t offset, uint64_t claimed,
                          uint64_t known);

/* -ENOMEM, -E2BIG: more than a file may have. */
int dx_mcap_parts_add(struct dx_mcap_parts *parts, const struct dx_mcap_part *part);
int dx_mcap_items_add(struct dx_mcap_items *items, const struct dx_mcap_item_index *item);
void dx_mcap_items_clear(struct dx_mcap_items *items);

/* ---- mcap_summary.c, mcap_scan.c --------------------------------------------------------------
 */

/* Reads footer and summary where they are there and good. 0 (see has_...), or -ENOMEM. */
int dx_mcap_read_summary(struct dx_mcap_reader *r);
/* Reads everything, from the first byte to the last. 0 or -ENOMEM. */
int dx_mcap_scan(struct dx_mcap_reader *r);

/* ---- mcap_load.c ------------------------------------------------------------------------------
 */

/* A part's records, decompressed and checked; they hold until the next load. -EBADMSG, the
 * source's error: r->why tells; -ENOMEM. */
int dx_mcap_load(struct dx_mcap_reader *r, struct dx_mcap_part *part, struct dx_mcap_bytes *out);
/* A chunk's record as it lies in the file; the views hold until the next reading. Errors as load's.
 */
int dx_mcap_view_chunk(struct dx_mcap_reader *r, const struct dx_mcap_part *part,
                       struct dx_mcap_chunk *out);
/* Nobody needs this part for now. */
void dx_mcap_unload(struct dx_mcap_reader *r, const struct dx_mcap_part *part);
/* A chunk's fields; the structure is good when the lengths in it agree with each other. */
bool dx_mcap_chunk_is_sound(const struct dx_mcap_chunk *c, uint64_t record_len);

/* The messages of a loaded part in turn. Declarations on the way are taken in. */
struct dx_mcap_part_walk {
    struct dx_mcap_reader *r;
    struct dx_reader records;
    const uint8_t *start;
    uint64_t n_strange; /* messages of no channel, declarations of a taken id */
};

struct dx_mcap_part_walk dx_mcap_part_walk(struct dx_mcap_reader *r, struct dx_mcap_bytes records);
/* 0: `m` and the offset of its record; DX_MCAP_E_END; -EBADMSG: the rest is no records; -ENOMEM. */
int dx_mcap_part_next(struct dx_mcap_part_walk *k, struct dx_mcap_message *m, size_t *offset);
/* Takes in a Schema or Channel; others are fine. -EBADMSG, -EEXIST, -E2BIG, -ENOMEM. */
int dx_mcap_take_def(struct dx_mcap_reader *r, uint8_t op, const uint8_t *body, size_t len);

#endif
