/*
 * Schemas and channels by their ids, kept with their records. Their number and bytes are bounded.
 * Entries stay where they are until fini. One owner, one thread.
 */
#ifndef DX_MCAP_DEFS_H
#define DX_MCAP_DEFS_H

#include "drivers/file/mcap_record.h"

struct dx_mcap_def {
    uint32_t order; /* of arrival, from 0: an index for the owner's own arrays */
    uint64_t n_messages;
    union {
        struct dx_mcap_schema schema;
        struct dx_mcap_channel channel;
    };
    size_t len;
    uint8_t record[]; /* whole, with its opcode; the views point into it */
};

struct dx_mcap_def_table {
    struct dx_mcap_def **defs;
    uint32_t n, cap;
    uint32_t *place[256]; /* of an id, by its high and its low byte: order + 1; 0 or NULL: none */
};

struct dx_mcap_defs {
    struct dx_mcap_def_table schemas, channels;
    uint32_t max_n; /* of either */
    size_t len, max_len;
};

/* `max_n`: of each kind, at most 65536; `max_len`: bytes of all records. */
void dx_mcap_defs_init(struct dx_mcap_defs *d, uint32_t max_n, size_t max_len);
void dx_mcap_defs_fini(struct dx_mcap_defs *d);

/* Copies one in; the same again is fine. Errors: -EEXIST, the id is another's; -E2BIG, a bound;
 * -ENOMEM. */
int dx_mcap_defs_schema(struct dx_mcap_defs *d, const struct dx_mcap_schema *s);
int dx_mcap_defs_channel(struct dx_mcap_defs *d, const struct dx_mcap_channel *c);

/* NULL: none of this id. */
struct dx_mcap_def *dx_mcap_def_find(const struct dx_mcap_def_table *t, uint16_t id);

#endif
