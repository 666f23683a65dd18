/* MCAP records to bytes. */
#include "drivers/file/mcap_record.h"

static void put_text(struct dx_writer *w, struct dx_mcap_text t)
{
    dx_write_u32(w, t.len);
    dx_write_bytes(w, t.p, t.len);
}

static void put_bytes32(struct dx_writer *w, struct dx_mcap_bytes b)
{
    dx_write_u32(w, (uint32_t)b.len);
    dx_write_bytes(w, b.p, b.len);
}

void dx_mcap_put_pairs(struct dx_writer *w, const struct dx_mcap_pair *pairs, size_t n)
{
    for (size_t k = 0; k < n; k++) {
        put_text(w, pairs[k].key);
        put_text(w, pairs[k].value);
    }
}

void dx_mcap_put_header(struct dx_writer *w, const char *profile, const char *library)
{
    uint8_t *record = dx_mcap_record_begin(w, DX_MCAP_HEADER);

    put_text(w, dx_mcap_text(profile));
    put_text(w, dx_mcap_text(library));
    dx_mcap_record_end(w, record);
}

size_t dx_mcap_schema_len(const struct dx_mcap_schema *s)
{
    return DX_MCAP_RECORD_HEAD + 2 + 3 * 4 + (size_t)s->name.len + s->encoding.len + s->data.len;
}

void dx_mcap_put_schema(struct dx_writer *w, const struct dx_mcap_schema *s)
{
    uint8_t *record = dx_mcap_record_begin(w, DX_MCAP_SCHEMA);

    dx_write_u16(w, s->id);
    put_text(w, s->name);
    put_text(w, s->encoding);
    put_bytes32(w, s->data);
    dx_mcap_record_end(w, record);
}

size_t dx_mcap_channel_len(const struct dx_mcap_channel *c)
{
    return DX_MCAP_RECORD_HEAD + 2 + 2 + 3 * 4 + (size_t)c->topic.len + c->message_encoding.len +
           c->metadata.len;
}

void dx_mcap_put_channel(struct dx_writer *w, const struct dx_mcap_channel *c)
{
    uint8_t *record = dx_mcap_record_begin(w, DX_MCAP_CHANNEL);

    dx_write_u16(w, c->id);
    dx_write_u16(w, c->schema_id);
    put_text(w, c->topic);
    put_text(w, c->message_encoding);
    put_bytes32(w, c->metadata);
    dx_mcap_record_end(w, record);
}

void dx_mcap_put_message(struct dx_writer *w, const struct dx_mcap_message *m)
{
    uint8_t *record = dx_mcap_record_begin(w, DX_MCAP_MESSAGE);

    dx_write_u16(w, m->channel_id);
    dx_write_u32(w, m->sequence);
    dx_write_u64(w, m->log_time);
    dx_write_u64(w, m->publish_time);
    dx_write_bytes(w, m->data.p, m->data.len);
    dx_mcap_record_end(w, record);
}

void dx_mcap_put_attachment_index(struct dx_writer *w, const struct dx_mcap_item_index *i)
{
    uint8_t *record = dx_mcap_record_begin(w, DX_MCAP_ATTACHMENT_INDEX);

    dx_write_u64(w, i->record.offset);
    dx_write_u64(w, i->record.len);
    dx_write_u64(w, i->log_time);
    dx_write_u64(w, i->create_time);
    dx_write_u64(w, i->data_len);
    put_text(w, i->name);
    put_text(w, i->media_type);
    dx_mcap_record_end(w, record);
}

void dx_mcap_put_metadata_index(struct dx_writer *w, const struct dx_mcap_item_index *i)
{
    uint8_t *record = dx_mcap_record_begin(w, DX_MCAP_METADATA_INDEX);

    dx_write_u64(w, i->record.offset);
    dx_write_u64(w, i->record.len);
    put_text(w, i->name);
    dx_mcap_record_end(w, record);
}

void dx_mcap_put_summary_offset(struct dx_writer *w, uint8_t op, const struct dx_mcap_extent *e)
{
    uint8_t *record = dx_mcap_record_begin(w, DX_MCAP_SUMMARY_OFFSET);

    dx_write_u8(w, op);
    dx_write_u64(w, e->offset);
    dx_write_u64(w, e->len);
    dx_mcap_record_end(w, record);
}

/* end() for a record whose last `more` bytes the caller writes. */
static void end_before(struct dx_writer *w, uint8_t *record, uint64_t more)
{
    if (!w->failed)
        dx_put_u64(record + 1, (uint64_t)(w->p - record) - DX_MCAP_RECORD_HEAD + more);
}

void dx_mcap_put_chunk_head(struct dx_writer *w, const struct dx_mcap_chunk *c)
{
    uint8_t *record = dx_mcap_record_begin(w, DX_MCAP_CHUNK);

    dx_write_u64(w, c->start);
    dx_write_u64(w, c->end);
    dx_write_u64(w, c->uncompressed_len);
    dx_write_u32(w, c->crc);
    put_text(w, c->compression);
    dx_write_u64(w, c->records.len);
    end_before(w, record, c->records.len);
}

void dx_mcap_put_attachment_head(struct dx_writer *w, const struct dx_mcap_attachment *a)
{
    uint8_t *record = dx_mcap_record_begin(w, DX_MCAP_ATTACHMENT);

    dx_write_u64(w, a->log_time);
    dx_write_u64(w, a->create_time);
    put_text(w, a->name);
    put_text(w, a->media_type);
    dx_write_u64(w, a->data.len);
    end_before(w, record, (uint64_t)a->data.len + 4); /* and the CRC */
}

void dx_mcap_put_metadata_head(struct dx_writer *w, const struct dx_mcap_metadata *m)
{
    uint8_t *record = dx_mcap_record_begin(w, DX_MCAP_METADATA);

    put_text(w, m->name);
    dx_write_u32(w, (uint32_t)m->map.len);
    end_before(w, record, m->map.len);
}
