/* The MCAP reader: opening, what it knows, and reading stretches of the file. */
#include "drivers/file/mcap_read_priv.h"

#include "drivers/file/crc32.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#define PIECE      ((size_t)256 << 10)
#define MAX_HEADER ((uint64_t)1 << 20)

/* ---- stretches of the file --------------------------------------------------------------------
 */

static int view_grow(struct dx_mcap_view *v, size_t len)
{
    uint8_t *bytes;

    if (len <= v->cap)
        return 0;
    v->len = 0;
    bytes = realloc(v->bytes, len);
    if (!bytes)
        return -ENOMEM;
    v->bytes = bytes;
    v->cap = len;
    return 0;
}

/* Fills the view from `offset` on: more than is asked for, since the next records follow; only that
 * where a part of it cannot be read. */
static int view_fill(struct dx_mcap_reader *r, uint64_t offset, size_t len)
{
    struct dx_mcap_view *v = &r->view;
    uint64_t left = r->source.len - offset;
    size_t n = len < PIECE ? PIECE : len;
    int rc;

    n = n < left ? n : (size_t)left;
    rc = view_grow(v, n);
    v->len = 0;
    if (rc)
        return rc;
    rc = r->source.read(r->source.ctx, offset, v->bytes, n);
    if (rc && n > len) {
        n = len;
        rc = r->source.read(r->source.ctx, offset, v->bytes, n);
    }
    v->offset = offset;
    v->len = rc ? 0 : n;
    return rc;
}

int dx_mcap_view_get(struct dx_mcap_reader *r, uint64_t offset, size_t len, const uint8_t **out)
{
    struct dx_mcap_view *v = &r->view;

    if (offset > r->source.len || len > r->source.len - offset)
        return -EBADMSG;
    if (offset < v->offset || offset - v->offset > v->len ||
        len > v->len - (size_t)(offset - v->offset)) {
        int rc = view_fill(r, offset, len);

        if (rc)
            return rc;
    }
    *out = v->bytes + (offset - v->offset);
    return 0;
}

int dx_mcap_view_crc(struct dx_mcap_reader *r, uint64_t offset, uint64_t len, uint32_t *crc)
{
    *crc = 0;
    while (len > 0) {
        size_t n = len < PIECE ? (size_t)len : PIECE;
        const uint8_t *p;
        int rc = dx_mcap_view_get(r, offset, n, &p);

        if (rc)
            return rc;
        *crc = dx_crc32(*crc, p, n);
        offset += n;
        len -= n;
    }
    return 0;
}

int dx_mcap_record_at(struct dx_mcap_reader *r, uint64_t offset, uint64_t end, uint8_t *op,
                      uint64_t *len)
{
    const uint8_t *p;
    uint64_t body_len;
    int rc;

    if (offset > end || end - offset < DX_MCAP_RECORD_HEAD)
        return -EBADMSG;
    rc = dx_mcap_view_get(r, offset, DX_MCAP_RECORD_HEAD, &p);
    if (rc)
        return rc;
    body_len = dx_get_u64(p + 1);
    if (p[0] == 0 || body_len > end - offset - DX_MCAP_RECORD_HEAD)
        return -EBADMSG;
    *op = p[0];
    *len = DX_MCAP_RECORD_HEAD + body_len;
    return 0;
}

uint64_t dx_mcap_true_len(struct dx_mcap_reader *r, uint64_t offset, uint64_t claimed,
                          uint64_t known)
{
    uint64_t next_len;
    uint8_t op = 0;

    if (known == claimed ||
        dx_mcap_record_at(r, offset + known, r->source.len, &op, &next_len) < 0 ||
        op > DX_MCAP_DATA_END)
        return claimed;
    dx_mcap_note(r, offset, known, "record claims %llu bytes more than it has",
                 (unsigned long long)(claimed - known));
    return known;
}

/* ---- what was found ---------------------------------------------------------------------------
 */

void dx_mcap_note(struct dx_mcap_reader *r, uint64_t offset, uint64_t len, const char *fmt, ...)
{
    struct dx_mcap_damage *d;
    va_list ap;

    if (r->n_damages++ >= DX_MCAP_MAX_DAMAGES)
        return;
    d = &r->damages[r->n_damages - 1];
    d->offset = offset;
    d->len = len;
    va_start(ap, fmt);
    vsnprintf(d->text, sizeof(d->text), fmt, ap);
    va_end(ap);
}

uint64_t dx_mcap_reader_damages(const struct dx_mcap_reader *r)
{
    return r->n_damages;
}

const struct dx_mcap_damage *dx_mcap_reader_damage(const struct dx_mcap_reader *r, uint64_t k)
{
    return k < r->n_damages && k < DX_MCAP_MAX_DAMAGES ? &r->damages[k] : NULL;
}

/* Room for one more of `size` bytes; the new address, or NULL. */
static void *grown(void *p, uint32_t n, uint32_t *cap, size_t size)
{
    uint32_t more = *cap ? 2 * *cap : 64;
    void *q;

    if (n < *cap)
        return p;
    q = realloc(p, more * size);
    if (q)
        *cap = more;
    return q;
}

int dx_mcap_parts_add(struct dx_mcap_parts *parts, const struct dx_mcap_part *part)
{
    struct dx_mcap_part *p;

    if (parts->n >= DX_MCAP_MAX_CHUNKS)
        return -E2BIG;
    p = grown(parts->p, parts->n, &parts->cap, sizeof(*p));
    if (!p)
        return -ENOMEM;
    parts->p = p;
    p[parts->n++] = *part;
    return 0;
}

/* Name and media type in one block; a view without bytes is not NULL for memcpy's sake. */
static int copy_names(struct dx_mcap_item_index *out, const struct dx_mcap_item_index *in)
{
    char *names = malloc((size_t)in->name.len + in->media_type.len + 1);

    if (!names)
        return -ENOMEM;
    if (in->name.len)
        memcpy(names, in->name.p, in->name.len);
    if (in->media_type.len)
        memcpy(names + in->name.len, in->media_type.p, in->media_type.len);
    *out = *in;
    out->name.p = names;
    out->media_type.p = names + in->name.len;
    return 0;
}

int dx_mcap_items_add(struct dx_mcap_items *items, const struct dx_mcap_item_index *item)
{
    size_t len = (size_t)item->name.len + item->media_type.len;
    struct dx_mcap_item_index *p;

    if (items->n >= DX_MCAP_MAX_ITEMS || len > DX_MCAP_MAX_NAMES - items->names_len)
        return -E2BIG;
    p = grown(items->p, items->n, &items->cap, sizeof(*p));
    if (!p)
        return -ENOMEM;
    items->p = p;
    if (copy_names(&p[items->n], item) < 0)
        return -ENOMEM;
    items->n++;
    items->names_len += len;
    return 0;
}

void dx_mcap_items_clear(struct dx_mcap_items *items)
{
    for (uint32_t k = 0; k < items->n; k++)
        free((char *)items->p[k].name.p);
    items->n = 0;
    items->names_len = 0;
}

/* ---- opening ----------------------------------------------------------------------------------
 */

/* Magic and header. A file is an MCAP file by its magic; a damaged header is noted. */
static int read_start(struct dx_mcap_reader *r, struct dx_err *err)
{
    struct dx_mcap_text profile, library;
    const uint8_t *p;
    uint64_t len;
    uint8_t op;
    int rc = dx_mcap_view_get(r, 0, DX_MCAP_MAGIC_LEN, &p);

    if (rc == 0 && !dx_mcap_probe(p, DX_MCAP_MAGIC_LEN))
        rc = -EBADMSG;
    if (rc)
        return dx_err_set(err, rc, "byte 0: %s",
                          rc == -EBADMSG ? "no MCAP file, expected its magic" : strerror(-rc));
    r->data_start = DX_MCAP_MAGIC_LEN;
    rc = dx_mcap_record_at(r, DX_MCAP_MAGIC_LEN, r->source.len, &op, &len);
    if (rc == 0 && (op != DX_MCAP_HEADER || len > MAX_HEADER))
        rc = -EBADMSG;
    if (rc == 0)
        rc = dx_mcap_view_get(r, DX_MCAP_MAGIC_LEN + DX_MCAP_RECORD_HEAD,
                              (size_t)len - DX_MCAP_RECORD_HEAD, &p);
    if (rc == 0)
        rc = dx_mcap_get_header(&profile, &library, p, (size_t)len - DX_MCAP_RECORD_HEAD);
    if (rc == -ENOMEM)
        return dx_err_set(err, rc, "no memory to read");
    if (rc) {
        dx_mcap_note(r, DX_MCAP_MAGIC_LEN, 0, "no whole Header record");
        return 0;
    }
    dx_mcap_text_copy(r->profile, sizeof(r->profile), profile);
    dx_mcap_text_copy(r->library, sizeof(r->library), library);
    r->data_start += dx_mcap_true_len(
        r, DX_MCAP_MAGIC_LEN, len, DX_MCAP_RECORD_HEAD + 8 + (uint64_t)profile.len + library.len);
    return 0;
}

static int read_all(struct dx_mcap_reader *r, bool scan, struct dx_err *err)
{
    int rc = read_start(r, err);

    if (rc)
        return rc;
    rc = dx_mcap_read_summary(r);
    if (rc == 0 && (scan || !r->indexed))
        rc = dx_mcap_scan(r);
    return rc ? dx_err_set(err, rc, "no memory to read") : 0;
}

int dx_mcap_reader_open(struct dx_mcap_reader **out, const struct dx_mcap_source *source,
                        const struct dx_mcap_read_options *options, struct dx_err *err)
{
    static const struct dx_mcap_read_options defaults = {0};
    const struct dx_mcap_read_options *o = options ? options : &defaults;
    struct dx_mcap_reader *r = calloc(1, sizeof(*r));
    int rc;

    if (!r)
        return dx_err_set(err, -ENOMEM, "no memory for a reader");
    r->source = *source;
    r->on_message = o->on_message;
    r->on_message_ctx = o->ctx;
    r->max_chunk =
        o->max_chunk && o->max_chunk < DX_MCAP_MAX_CHUNK ? o->max_chunk : DX_MCAP_MAX_CHUNK;
    dx_mcap_defs_init(&r->defs, 65536, DX_MCAP_MAX_DEFS);
    rc = dx_mcap_unpacker_new(&r->unpacker);
    if (rc == 0)
        rc = read_all(r, o->scan, err);
    else
        dx_err_set(err, rc, "no memory for a reader");
    if (rc) {
        dx_mcap_reader_free(r);
        return rc;
    }
    *out = r;
    return 0;
}

void dx_mcap_reader_free(struct dx_mcap_reader *r)
{
    if (!r)
        return;
    dx_mcap_defs_fini(&r->defs);
    dx_mcap_unpacker_free(r->unpacker);
    dx_mcap_items_clear(&r->attachments);
    dx_mcap_items_clear(&r->metadata);
    for (int k = 0; k < DX_MCAP_N_SLOTS; k++)
        free(r->slots[k].bytes);
    free(r->attachments.p);
    free(r->metadata.p);
    free(r->parts.p);
    free(r->view.bytes);
    free(r);
}

/* ---- what it knows ----------------------------------------------------------------------------
 */

void dx_mcap_reader_info(const struct dx_mcap_reader *r, struct dx_mcap_info *out)
{
    *out = (struct dx_mcap_info){.profile = r->profile,
                                 .library = r->library,
                                 .indexed = r->indexed,
                                 .len = r->source.len,
                                 .n_messages = r->n_messages,
                                 .start = r->start,
                                 .end = r->end};
    for (uint32_t k = 0; k < r->parts.n; k++) {
        if (r->parts.p[k].is_run)
            continue;
        out->n_chunks++;
        out->n_of[r->parts.p[k].compression]++;
    }
}

const struct dx_mcap_channel *dx_mcap_reader_channel(const struct dx_mcap_reader *r, uint32_t k)
{
    return k < r->defs.channels.n ? &r->defs.channels.defs[k]->channel : NULL;
}

const struct dx_mcap_channel *dx_mcap_reader_find(const struct dx_mcap_reader *r, uint16_t id)
{
    const struct dx_mcap_def *def = dx_mcap_def_find(&r->defs.channels, id);

    return def ? &def->channel : NULL;
}

const struct dx_mcap_channel *dx_mcap_reader_topic(const struct dx_mcap_reader *r,
                                                   const char *topic)
{
    for (uint32_t k = 0; k < r->defs.channels.n; k++)
        if (dx_mcap_text_is(r->defs.channels.defs[k]->channel.topic, topic))
            return &r->defs.channels.defs[k]->channel;
    return NULL;
}

const struct dx_mcap_schema *dx_mcap_reader_schema(const struct dx_mcap_reader *r, uint32_t k)
{
    return k < r->defs.schemas.n ? &r->defs.schemas.defs[k]->schema : NULL;
}

const struct dx_mcap_schema *dx_mcap_reader_find_schema(const struct dx_mcap_reader *r, uint16_t id)
{
    const struct dx_mcap_def *def = dx_mcap_def_find(&r->defs.schemas, id);

    return def ? &def->schema : NULL;
}

uint64_t dx_mcap_reader_count(const struct dx_mcap_reader *r, uint16_t id)
{
    const struct dx_mcap_def *def = dx_mcap_def_find(&r->defs.channels, id);

    return def ? def->n_messages : 0;
}

const struct dx_mcap_item_index *dx_mcap_reader_attachment(const struct dx_mcap_reader *r,
                                                           uint32_t k)
{
    return k < r->attachments.n ? &r->attachments.p[k] : NULL;
}

const struct dx_mcap_item_index *dx_mcap_reader_metadata(const struct dx_mcap_reader *r, uint32_t k)
{
    return k < r->metadata.n ? &r->metadata.p[k] : NULL;
}
