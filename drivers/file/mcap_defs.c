/* Schemas and channels by id. */
#include "drivers/file/mcap_defs.h"

#include <errno.h>
#include <stdlib.h>

static void table_fini(struct dx_mcap_def_table *t)
{
    for (uint32_t k = 0; k < t->n; k++)
        free(t->defs[k]);
    free(t->defs);
    for (int high = 0; high < 256; high++)
        free(t->place[high]);
}

void dx_mcap_defs_init(struct dx_mcap_defs *d, uint32_t max_n, size_t max_len)
{
    *d = (struct dx_mcap_defs){.max_n = max_n, .max_len = max_len};
}

void dx_mcap_defs_fini(struct dx_mcap_defs *d)
{
    table_fini(&d->schemas);
    table_fini(&d->channels);
    *d = (struct dx_mcap_defs){0};
}

struct dx_mcap_def *dx_mcap_def_find(const struct dx_mcap_def_table *t, uint16_t id)
{
    const uint32_t *places = t->place[id >> 8];
    uint32_t place = places ? places[id & 255] : 0;

    return place ? t->defs[place - 1] : NULL;
}

static int table_grow(struct dx_mcap_def_table *t, uint16_t id)
{
    uint32_t cap = t->cap ? 2 * t->cap : 16;
    struct dx_mcap_def **defs;

    if (!t->place[id >> 8])
        t->place[id >> 8] = calloc(256, sizeof(uint32_t));
    if (!t->place[id >> 8])
        return -ENOMEM;
    if (t->n < t->cap)
        return 0;
    defs = realloc(t->defs, cap * sizeof(struct dx_mcap_def *));
    if (!defs)
        return -ENOMEM;
    t->defs = defs;
    t->cap = cap;
    return 0;
}

/* A new entry with room for its record, or what is wrong. */
static int add(struct dx_mcap_defs *d, struct dx_mcap_def_table *t, uint16_t id, size_t len,
               struct dx_mcap_def **out)
{
    struct dx_mcap_def *def;

    if (t->n >= d->max_n || len > d->max_len - d->len)
        return -E2BIG;
    def = table_grow(t, id) == 0 ? calloc(1, sizeof(*def) + len) : NULL;
    if (!def)
        return -ENOMEM;
    def->order = t->n;
    def->len = len;
    t->defs[t->n++] = def;
    t->place[id >> 8][id & 255] = t->n;
    d->len += len;
    *out = def;
    return 0;
}

static bool same_text(struct dx_mcap_text a, struct dx_mcap_text b)
{
    return a.len == b.len && (a.len == 0 || memcmp(a.p, b.p, a.len) == 0);
}

static bool same_bytes(struct dx_mcap_bytes a, struct dx_mcap_bytes b)
{
    return a.len == b.len && (a.len == 0 || memcmp(a.p, b.p, a.len) == 0);
}

int dx_mcap_defs_schema(struct dx_mcap_defs *d, const struct dx_mcap_schema *s)
{
    struct dx_mcap_def *def = dx_mcap_def_find(&d->schemas, s->id);
    struct dx_writer w;
    int rc;

    if (def)
        return same_text(def->schema.name, s->name) &&
                       same_text(def->schema.encoding, s->encoding) &&
                       same_bytes(def->schema.data, s->data)
                   ? 0
                   : -EEXIST;
    rc = add(d, &d->schemas, s->id, dx_mcap_schema_len(s), &def);
    if (rc)
        return rc;
    w = dx_writer_init(def->record, def->len);
    dx_mcap_put_schema(&w, s);
    return dx_mcap_get_schema(&def->schema, def->record + DX_MCAP_RECORD_HEAD,
                              def->len - DX_MCAP_RECORD_HEAD);
}

int dx_mcap_defs_channel(struct dx_mcap_defs *d, const struct dx_mcap_channel *c)
{
    struct dx_mcap_def *def = dx_mcap_def_find(&d->channels, c->id);
    struct dx_writer w;
    int rc;

    if (def)
        return def->channel.schema_id == c->schema_id && same_text(def->channel.topic, c->topic) &&
                       same_text(def->channel.message_encoding, c->message_encoding) &&
                       same_bytes(def->channel.metadata, c->metadata)
                   ? 0
                   : -EEXIST;
    rc = add(d, &d->channels, c->id, dx_mcap_channel_len(c), &def);
    if (rc)
        return rc;
    w = dx_writer_init(def->record, def->len);
    dx_mcap_put_channel(&w, c);
    return dx_mcap_get_channel(&def->channel, def->record + DX_MCAP_RECORD_HEAD,
                               def->len - DX_MCAP_RECORD_HEAD);
}
