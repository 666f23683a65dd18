/* MCAP records from bytes, and the framing of both directions. */
#include "drivers/file/mcap_record.h"

#include <errno.h>

int dx_mcap_next_record(struct dx_mcap_record *out, struct dx_reader *r)
{
    uint64_t len;

    if (dx_reader_left(r) == 0)
        return DX_MCAP_E_END;
    out->op = dx_read_u8(r);
    len = dx_read_u64(r);
    if (r->failed || len > dx_reader_left(r))
        return -EBADMSG;
    out->len = (size_t)len;
    out->body = dx_read_bytes(r, out->len);
    return 0;
}

uint8_t *dx_mcap_record_begin(struct dx_writer *w, enum dx_mcap_op op)
{
    uint8_t *record = w->p;

    dx_write_u8(w, (uint8_t)op);
    dx_write_u64(w, 0);
    return record;
}

void dx_mcap_record_end(struct dx_writer *w, uint8_t *record)
{
    if (!w->failed)
        dx_put_u64(record + 1, (uint64_t)(w->p - record) - DX_MCAP_RECORD_HEAD);
}

/* ---- texts and maps ---------------------------------------------------------------------------
 */

struct dx_mcap_text dx_mcap_text(const char *text)
{
    return (struct dx_mcap_text){text, text ? (uint32_t)strlen(text) : 0};
}

bool dx_mcap_text_is(struct dx_mcap_text text, const char *other)
{
    return strlen(other) == text.len && (text.len == 0 || memcmp(other, text.p, text.len) == 0);
}

void dx_mcap_text_copy(char *out, size_t cap, struct dx_mcap_text text)
{
    size_t n = text.len < cap - 1 ? text.len : cap - 1;

    for (size_t k = 0; k < n; k++) {
        uint8_t c = (uint8_t)text.p[k];

        out[k] = c < 0x20 || c >= 0x7f ? '?' : (char)c;
    }
    out[n] = 0;
}

static struct dx_mcap_text read_text(struct dx_reader *r)
{
    uint32_t len = dx_read_u32(r);
    const uint8_t *p = dx_read_bytes(r, len);

    return (struct dx_mcap_text){(const char *)p, p ? len : 0};
}

static struct dx_mcap_bytes read_bytes(struct dx_reader *r, uint64_t len)
{
    const uint8_t *p;

    if (len > dx_reader_left(r)) {
        r->failed = true;
        return (struct dx_mcap_bytes){NULL, 0};
    }
    p = dx_read_bytes(r, (size_t)len);
    return (struct dx_mcap_bytes){p, p ? (size_t)len : 0};
}

int dx_mcap_next_pair(struct dx_mcap_pair *out, struct dx_reader *r)
{
    if (dx_reader_left(r) == 0)
        return DX_MCAP_E_END;
    out->key = read_text(r);
    out->value = read_text(r);
    return r->failed ? -EBADMSG : 0;
}

/* A map of texts: its pairs fill its length. */
static struct dx_mcap_bytes read_map(struct dx_reader *r)
{
    struct dx_mcap_bytes map = read_bytes(r, dx_read_u32(r));
    struct dx_mcap_pair pair;
    struct dx_reader inner;
    int rc;

    if (r->failed)
        return map;
    inner = dx_reader_init(map.p, map.len);
    do
        rc = dx_mcap_next_pair(&pair, &inner);
    while (rc == 0);
    if (rc < 0)
        r->failed = true;
    return map;
}

static int done(const struct dx_reader *r)
{
    return r->failed ? -EBADMSG : 0;
}

/* ---- bodies -----------------------------------------------------------------------------------
 */

int dx_mcap_get_header(struct dx_mcap_text *profile, struct dx_mcap_text *library,
                       const uint8_t *body, size_t len)
{
    struct dx_reader r = dx_reader_init(body, len);

    *profile = read_text(&r);
    *library = read_text(&r);
    return done(&r);
}

int dx_mcap_get_schema(struct dx_mcap_schema *out, const uint8_t *body, size_t len)
{
    struct dx_reader r = dx_reader_init(body, len);

    out->id = dx_read_u16(&r);
    out->name = read_text(&r);
    out->encoding = read_text(&r);
    out->data = read_bytes(&r, dx_read_u32(&r));
    return out->id == 0 ? -EBADMSG : done(&r);
}

int dx_mcap_get_channel(struct dx_mcap_channel *out, const uint8_t *body, size_t len)
{
    struct dx_reader r = dx_reader_init(body, len);

    out->id = dx_read_u16(&r);
    out->schema_id = dx_read_u16(&r);
    out->topic = read_text(&r);
    out->message_encoding = read_text(&r);
    out->metadata = read_map(&r);
    return done(&r);
}

int dx_mcap_get_message(struct dx_mcap_message *out, const uint8_t *body, size_t len)
{
    struct dx_reader r = dx_reader_init(body, len);

    out->channel_id = dx_read_u16(&r);
    out->sequence = dx_read_u32(&r);
    out->log_time = dx_read_u64(&r);
    out->publish_time = dx_read_u64(&r);
    out->data = read_bytes(&r, dx_reader_left(&r));
    return done(&r);
}

int dx_mcap_get_chunk(struct dx_mcap_chunk *out, const uint8_t *body, size_t len)
{
    struct dx_reader r = dx_reader_init(body, len);

    out->start = dx_read_u64(&r);
    out->end = dx_read_u64(&r);
    out->uncompressed_len = dx_read_u64(&r);
    out->crc = dx_read_u32(&r);
    out->compression = read_text(&r);
    out->records = read_bytes(&r, dx_read_u64(&r));
    return done(&r);
}

int dx_mcap_get_metadata(struct dx_mcap_metadata *out, const uint8_t *body, size_t len)
{
    struct dx_reader r = dx_reader_init(body, len);

    out->name = read_text(&r);
    out->map = read_map(&r);
    return done(&r);
}

int dx_mcap_get_statistics(struct dx_mcap_statistics *out, const uint8_t *body, size_t len)
{
    struct dx_reader r = dx_reader_init(body, len);

    out->n_messages = dx_read_u64(&r);
    out->n_schemas = dx_read_u16(&r);
    out->n_channels = dx_read_u32(&r);
    out->n_attachments = dx_read_u32(&r);
    out->n_metadata = dx_read_u32(&r);
    out->n_chunks = dx_read_u32(&r);
    out->start = dx_read_u64(&r);
    out->end = dx_read_u64(&r);
    out->counts = read_bytes(&r, dx_read_u32(&r));
    return out->counts.len % 10 != 0 ? -EBADMSG : done(&r);
}

int dx_mcap_get_attachment_head(struct dx_mcap_attachment *out, struct dx_mcap_extent *data,
                                const uint8_t *body, size_t len)
{
    struct dx_reader r = dx_reader_init(body, len);

    out->log_time = dx_read_u64(&r);
    out->create_time = dx_read_u64(&r);
    out->name = read_text(&r);
    out->media_type = read_text(&r);
    data->len = dx_read_u64(&r);
    data->offset = (uint64_t)(r.p - body);
    out->data = (struct dx_mcap_bytes){NULL, 0};
    return done(&r);
}

int dx_mcap_get_chunk_index(struct dx_mcap_chunk_index *out, const uint8_t *body, size_t len)
{
    struct dx_reader r = dx_reader_init(body, len);

    out->start = dx_read_u64(&r);
    out->end = dx_read_u64(&r);
    out->chunk.offset = dx_read_u64(&r);
    out->chunk.len = dx_read_u64(&r);
    out->offsets = read_bytes(&r, dx_read_u32(&r));
    out->message_index_len = dx_read_u64(&r);
    out->compression = read_text(&r);
    out->compressed_len = dx_read_u64(&r);
    out->uncompressed_len = dx_read_u64(&r);
    return out->offsets.len % 10 != 0 ? -EBADMSG : done(&r);
}

int dx_mcap_get_attachment_index(struct dx_mcap_item_index *out, const uint8_t *body, size_t len)
{
    struct dx_reader r = dx_reader_init(body, len);

    out->record.offset = dx_read_u64(&r);
    out->record.len = dx_read_u64(&r);
    out->log_time = dx_read_u64(&r);
    out->create_time = dx_read_u64(&r);
    out->data_len = dx_read_u64(&r);
    out->name = read_text(&r);
    out->media_type = read_text(&r);
    return done(&r);
}

int dx_mcap_get_metadata_index(struct dx_mcap_item_index *out, const uint8_t *body, size_t len)
{
    struct dx_reader r = dx_reader_init(body, len);

    *out = (struct dx_mcap_item_index){0};
    out->record.offset = dx_read_u64(&r);
    out->record.len = dx_read_u64(&r);
    out->name = read_text(&r);
    return done(&r);
}
