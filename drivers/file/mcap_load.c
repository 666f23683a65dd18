/* Parts of an MCAP file into memory: decompressed, checked, a few kept; and single items. */
#include "drivers/file/mcap_read_priv.h"

#include "drivers/file/crc32.h"

#include <errno.h>
#include <stdlib.h>

/* ---- slots ------------------------------------------------------------------------------------
 */

static struct dx_mcap_slot *find_slot(struct dx_mcap_reader *r, uint64_t offset)
{
    for (int k = 0; k < DX_MCAP_N_SLOTS; k++)
        if (r->slots[k].offset == offset)
            return &r->slots[k];
    return NULL;
}

static size_t slots_len(const struct dx_mcap_reader *r)
{
    size_t len = 0;

    for (int k = 0; k < DX_MCAP_N_SLOTS; k++)
        len += r->slots[k].cap;
    return len;
}

/* The one to give up first: an unneeded one with memory, an empty one, then the longest unused. */
static struct dx_mcap_slot *oldest_slot(struct dx_mcap_reader *r, const struct dx_mcap_slot *but)
{
    struct dx_mcap_slot *best = NULL;

    for (int k = 0; k < DX_MCAP_N_SLOTS; k++) {
        struct dx_mcap_slot *s = &r->slots[k];

        if (s == but)
            continue;
        if (!best || (s->offset == 0 && best->offset != 0) ||
            (s->offset == 0 && best->offset == 0 && s->cap > best->cap) ||
            (s->offset != 0 && best->offset != 0 && s->used < best->used))
            best = s;
    }
    return best;
}

static void empty_slot(struct dx_mcap_slot *s)
{
    free(s->bytes);
    *s = (struct dx_mcap_slot){0};
}

/* Frees others until a slot of `len` fits into the bound. */
static void make_room(struct dx_mcap_reader *r, const struct dx_mcap_slot *slot, size_t len)
{
    while (slots_len(r) - slot->cap + len > DX_MCAP_MAX_CACHE) {
        struct dx_mcap_slot *victim = NULL;

        for (int k = 0; k < DX_MCAP_N_SLOTS; k++) {
            struct dx_mcap_slot *s = &r->slots[k];

            if (s != slot && s->cap > 0 && (!victim || s->used < victim->used))
                victim = s;
        }
        if (!victim)
            return;
        empty_slot(victim);
    }
}

/* A slot with room for `len` bytes, empty. */
static struct dx_mcap_slot *take_slot(struct dx_mcap_reader *r, size_t len)
{
    struct dx_mcap_slot *s = oldest_slot(r, NULL);
    size_t cap = len + len / 4 + 64; /* so that chunks of nearly one size need no new memory */

    s->offset = 0;
    s->len = 0;
    if (s->cap >= len && s->cap > 0)
        return s;
    make_room(r, s, cap);
    empty_slot(s);
    s->bytes = malloc(cap);
    s->cap = s->bytes ? cap : 0;
    return s->bytes ? s : NULL;
}

void dx_mcap_unload(struct dx_mcap_reader *r, const struct dx_mcap_part *part)
{
    struct dx_mcap_slot *s = find_slot(r, part->at.offset);

    if (s)
        s->offset = 0;
}

/* ---- loading ----------------------------------------------------------------------------------
 */

bool dx_mcap_chunk_is_sound(const struct dx_mcap_chunk *c, uint64_t record_len)
{
    /* fields that a later version appends would be more: none has come */
    return DX_MCAP_RECORD_HEAD + 3 * 8 + 4 + 4 + (uint64_t)c->compression.len + 8 +
               c->records.len ==
           record_len;
}

/* The largest record that a chunk of at most max_chunk can be, incompressible. */
static uint64_t max_packed(const struct dx_mcap_reader *r)
{
    return r->max_chunk + r->max_chunk / 64 + 4096;
}

int dx_mcap_view_chunk(struct dx_mcap_reader *r, const struct dx_mcap_part *part,
                       struct dx_mcap_chunk *out)
{
    const uint8_t *p;
    int rc;

    if (part->at.len > max_packed(r) || part->at.len < DX_MCAP_RECORD_HEAD)
        return dx_err_set(&r->why, -EBADMSG, "chunk of %llu bytes, expected at most %llu",
                          (unsigned long long)part->at.len, (unsigned long long)max_packed(r));
    rc = dx_mcap_view_get(r, part->at.offset, (size_t)part->at.len, &p);
    if (rc)
        return dx_err_set(&r->why, rc, "chunk cannot be read: %s", strerror(-rc));
    if (p[0] != DX_MCAP_CHUNK || dx_get_u64(p + 1) != part->at.len - DX_MCAP_RECORD_HEAD ||
        dx_mcap_get_chunk(out, p + DX_MCAP_RECORD_HEAD,
                          (size_t)part->at.len - DX_MCAP_RECORD_HEAD) < 0)
        return dx_err_set(&r->why, -EBADMSG, "no whole Chunk record");
    return 0;
}

static int unpack(struct dx_mcap_reader *r, const struct dx_mcap_chunk *c, struct dx_mcap_slot *s)
{
    int compression = dx_mcap_compression_find(c->compression);
    size_t len = (size_t)c->uncompressed_len;
    uint32_t crc;
    int rc;

    rc = dx_mcap_unpacker_run(r->unpacker, (enum dx_mcap_compression)compression, s->bytes, len,
                              c->records.p, c->records.len);
    if (rc == -ENOMEM)
        return rc;
    if (rc)
        return dx_err_set(&r->why, -EBADMSG, "chunk does not decompress to %zu bytes", len);
    crc = c->crc ? dx_crc32(0, s->bytes, len) : 0;
    if (crc != c->crc)
        return dx_err_set(&r->why, -EBADMSG, "chunk: CRC is %08x, expected %08x", crc, c->crc);
    s->len = len;
    return 0;
}

static int load_chunk(struct dx_mcap_reader *r, struct dx_mcap_part *part,
                      struct dx_mcap_slot **out)
{
    struct dx_mcap_chunk c;
    char name[16];
    int rc = dx_mcap_view_chunk(r, part, &c), compression;

    if (rc)
        return rc;
    compression = dx_mcap_compression_find(c.compression);
    dx_mcap_text_copy(name, sizeof(name), c.compression);
    if (compression < 0)
        return dx_err_set(&r->why, -EBADMSG, "chunk: compression '%s', expected lz4, zstd or none",
                          name);
    if (c.uncompressed_len > r->max_chunk)
        return dx_err_set(&r->why, -EBADMSG, "chunk: %llu bytes uncompressed, expected at most %zu",
                          (unsigned long long)c.uncompressed_len, r->max_chunk);
    part->compression = (uint8_t)compression;
    *out = take_slot(r, (size_t)c.uncompressed_len);
    return *out ? unpack(r, &c, *out) : -ENOMEM;
}

static int load_run(struct dx_mcap_reader *r, const struct dx_mcap_part *part,
                    struct dx_mcap_slot **out)
{
    int rc;

    *out = take_slot(r, (size_t)part->at.len);
    if (!*out)
        return -ENOMEM;
    rc = r->source.read(r->source.ctx, part->at.offset, (*out)->bytes, (size_t)part->at.len);
    if (rc)
        return dx_err_set(&r->why, rc, "messages cannot be read: %s", strerror(-rc));
    (*out)->len = (size_t)part->at.len;
    return 0;
}

int dx_mcap_load(struct dx_mcap_reader *r, struct dx_mcap_part *part, struct dx_mcap_bytes *out)
{
    struct dx_mcap_slot *s = find_slot(r, part->at.offset);
    int rc = 0;

    if (!s) {
        rc = part->is_run ? load_run(r, part, &s) : load_chunk(r, part, &s);
        r->n_loads++;
    }
    if (rc)
        return rc;
    s->offset = part->at.offset;
    s->used = ++r->clock;
    *out = (struct dx_mcap_bytes){s->bytes, s->len};
    return 0;
}

/* ---- the messages of a part -------------------------------------------------------------------
 */

struct dx_mcap_part_walk dx_mcap_part_walk(struct dx_mcap_reader *r, struct dx_mcap_bytes records)
{
    return (struct dx_mcap_part_walk){r, dx_reader_init(records.p, records.len), records.p, 0};
}

int dx_mcap_take_def(struct dx_mcap_reader *r, uint8_t op, const uint8_t *body, size_t len)
{
    struct dx_mcap_schema schema;
    struct dx_mcap_channel channel;
    int rc = 0;

    if (op == DX_MCAP_SCHEMA) {
        rc = dx_mcap_get_schema(&schema, body, len);
        return rc ? rc : dx_mcap_defs_schema(&r->defs, &schema);
    }
    if (op == DX_MCAP_CHANNEL) {
        rc = dx_mcap_get_channel(&channel, body, len);
        return rc ? rc : dx_mcap_defs_channel(&r->defs, &channel);
    }
    return rc;
}

int dx_mcap_part_next(struct dx_mcap_part_walk *k, struct dx_mcap_message *m, size_t *offset)
{
    for (;;) {
        struct dx_mcap_record rec;
        const uint8_t *at = k->records.p;
        int rc = dx_mcap_next_record(&rec, &k->records);

        if (rc)
            return rc;
        if (rec.op != DX_MCAP_MESSAGE) {
            rc = dx_mcap_take_def(k->r, rec.op, rec.body, rec.len);
            if (rc == -ENOMEM || rc == -EBADMSG)
                return rc;
            k->n_strange += rc != 0;
            continue;
        }
        if (dx_mcap_get_message(m, rec.body, rec.len) < 0)
            return -EBADMSG;
        if (dx_mcap_def_find(&k->r->defs.channels, m->channel_id)) {
            *offset = (size_t)(at - k->start);
            return 0;
        }
        k->n_strange++;
    }
}

/* ---- attachments and metadata -----------------------------------------------------------------
 */

static int view_item(struct dx_mcap_reader *r, const struct dx_mcap_item_index *item, uint8_t op,
                     size_t max, const uint8_t **body, struct dx_err *err)
{
    unsigned long long at = item->record.offset, len = item->record.len;
    const uint8_t *p;
    int rc;

    if (len > max)
        return dx_err_set(err, -EFBIG, "byte %llu: %llu bytes, expected at most %zu", at, len, max);
    if (len < DX_MCAP_RECORD_HEAD)
        return dx_err_set(err, -EBADMSG, "byte %llu: %llu bytes, expected a record", at, len);
    rc = dx_mcap_view_get(r, at, (size_t)len, &p);
    if (rc)
        return dx_err_set(err, rc, "byte %llu: %llu bytes cannot be read: %s", at, len,
                          strerror(-rc));
    if (p[0] != op || dx_get_u64(p + 1) != len - DX_MCAP_RECORD_HEAD)
        return dx_err_set(err, -EBADMSG, "byte %llu: found a record %02x, expected %02x", at, p[0],
                          op);
    *body = p + DX_MCAP_RECORD_HEAD;
    return 0;
}

int dx_mcap_reader_read_attachment(struct dx_mcap_reader *r, const struct dx_mcap_item_index *item,
                                   struct dx_mcap_attachment *out, struct dx_err *err)
{
    unsigned long long at = item->record.offset;
    struct dx_mcap_extent data;
    const uint8_t *body = NULL;
    size_t len = (size_t)item->record.len - DX_MCAP_RECORD_HEAD;
    uint32_t crc, found;
    int rc = view_item(r, item, DX_MCAP_ATTACHMENT, DX_MCAP_MAX_CHUNK, &body, err);

    if (rc)
        return rc;
    if (dx_mcap_get_attachment_head(out, &data, body, len) < 0 || len - data.offset < 4 ||
        data.len > len - data.offset - 4)
        return dx_err_set(err, -EBADMSG, "byte %llu: no whole Attachment record", at);
    out->data = (struct dx_mcap_bytes){body + data.offset, (size_t)data.len};
    crc = dx_get_u32(body + data.offset + data.len);
    found = crc ? dx_crc32(0, body, (size_t)(data.offset + data.len)) : 0;
    if (found != crc)
        return dx_err_set(err, -EBADMSG, "byte %llu: attachment: CRC is %08x, expected %08x", at,
                          found, crc);
    return 0;
}

int dx_mcap_reader_read_metadata(struct dx_mcap_reader *r, const struct dx_mcap_item_index *item,
                                 struct dx_mcap_metadata *out, struct dx_err *err)
{
    const uint8_t *body = NULL;
    int rc = view_item(r, item, DX_MCAP_METADATA, DX_MCAP_MAX_METADATA, &body, err);

    if (rc)
        return rc;
    if (dx_mcap_get_metadata(out, body, (size_t)item->record.len - DX_MCAP_RECORD_HEAD) < 0)
        return dx_err_set(err, -EBADMSG, "byte %llu: no whole Metadata record",
                          (unsigned long long)item->record.offset);
    return 0;
}
