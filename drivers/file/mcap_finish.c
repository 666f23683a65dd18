/* The MCAP writer: chunks, attachments and metadata into the file, and the summary behind them. */
#include "drivers/file/mcap_write_priv.h"

#include "drivers/file/crc32.h"

#include <errno.h>

#define CHUNK_INDEX_FIXED (DX_MCAP_RECORD_HEAD + 4 * 8 + 4 + 8 + 4 + 2 * 8 + 8) /* with a name */

static struct dx_writer group_room(const struct dx_mcap_group *g)
{
    return dx_writer_init(g->bytes + g->len, g->cap - g->len);
}

static void group_take(struct dx_mcap_group *g, const struct dx_writer *w)
{
    g->len = (size_t)(w->p - g->bytes);
    g->n++;
}

bool dx_mcap_writer_has_room(const struct dx_mcap_writer *w)
{
    return w->chunks.cap - w->chunks.len >=
               CHUNK_INDEX_FIXED + 10 * (size_t)w->config.max_channels &&
           w->chunks.n < DX_MCAP_MAX_CHUNKS;
}

/* ---- a chunk ----------------------------------------------------------------------------------
 */

static void put_message_index(struct dx_mcap_piece *p, const struct dx_mcap_writer *w,
                              uint16_t channel, const struct dx_mcap_list *list)
{
    uint8_t bytes[DX_MCAP_RECORD_HEAD + 2 + 4];
    struct dx_writer out = dx_writer_init(bytes, sizeof(bytes));

    dx_write_u8(&out, DX_MCAP_MESSAGE_INDEX);
    dx_write_u64(&out, 2 + 4 + 16 * (uint64_t)list->n);
    dx_write_u16(&out, channel);
    dx_write_u32(&out, 16 * list->n);
    dx_mcap_piece_put(p, bytes, sizeof(bytes));
    for (uint32_t k = list->first; k != DX_MCAP_NONE_LEFT; k = w->entries[k].next) {
        uint8_t pair[16];

        dx_put_u64(pair, w->entries[k].log_time);
        dx_put_u64(pair + 8, w->entries[k].offset);
        dx_mcap_piece_put(p, pair, sizeof(pair));
    }
}

/* The message indexes, and on the way the map of their places in the chunk's own index. */
static void put_message_indexes(struct dx_mcap_piece *p, const struct dx_mcap_writer *w,
                                struct dx_writer *index)
{
    uint8_t *map_len = dx_write_room(index, 4);
    uint8_t *map = index->p;

    for (uint32_t k = 0; k < w->defs.channels.n; k++) {
        uint16_t id = w->defs.channels.defs[k]->channel.id;

        if (w->lists[k].n == 0)
            continue;
        dx_write_u16(index, id);
        dx_write_u64(index, dx_mcap_piece_at(p));
        put_message_index(p, w, id, &w->lists[k]);
    }
    if (map_len)
        dx_put_u32(map_len, (uint32_t)(index->p - map));
}

static void put_chunk(struct dx_mcap_piece *p, const struct dx_mcap_chunk *chunk)
{
    uint8_t head[DX_MCAP_RECORD_HEAD + 3 * 8 + 4 + 4 + 8 + 8];
    struct dx_writer out = dx_writer_init(head, sizeof(head));

    dx_mcap_put_chunk_head(&out, chunk);
    dx_mcap_piece_put(p, head, (size_t)(out.p - head));
    dx_mcap_piece_put(p, chunk->records.p, chunk->records.len);
}

static void count_chunk(struct dx_mcap_writer *w)
{
    struct dx_mcap_statistics *s = &w->stats;

    if (w->n_entries > 0) {
        s->start = s->n_messages == 0 || w->start < s->start ? w->start : s->start;
        s->end = s->n_messages == 0 || w->end > s->end ? w->end : s->end;
    }
    s->n_messages += w->n_entries;
    s->n_chunks++;
    for (uint32_t k = 0; k < w->defs.channels.n; k++)
        w->defs.channels.defs[k]->n_messages += w->lists[k].n;
}

int dx_mcap_writer_put_chunk(struct dx_mcap_writer *w, const struct dx_mcap_chunk *chunk)
{
    struct dx_mcap_piece piece = dx_mcap_piece_begin(w);
    struct dx_writer index = group_room(&w->chunks);
    uint8_t *record = dx_mcap_record_begin(&index, DX_MCAP_CHUNK_INDEX);
    uint64_t offset = dx_mcap_piece_at(&piece), indexes;
    int rc;

    put_chunk(&piece, chunk);
    indexes = dx_mcap_piece_at(&piece);
    dx_write_u64(&index, chunk->start);
    dx_write_u64(&index, chunk->end);
    dx_write_u64(&index, offset);
    dx_write_u64(&index, indexes - offset);
    put_message_indexes(&piece, w, &index);
    dx_write_u64(&index, dx_mcap_piece_at(&piece) - indexes);
    dx_write_u32(&index, chunk->compression.len);
    dx_write_bytes(&index, chunk->compression.p, chunk->compression.len);
    dx_write_u64(&index, chunk->records.len);
    dx_write_u64(&index, chunk->uncompressed_len);
    dx_mcap_record_end(&index, record);
    if (index.failed)
        return DX_MCAP_E_FULL;
    rc = dx_mcap_piece_commit(&piece);
    if (rc)
        return rc;
    group_take(&w->chunks, &index);
    count_chunk(w);
    dx_mcap_writer_clear_chunk(w);
    return 0;
}

int dx_mcap_writer_recover(struct dx_mcap_writer *w)
{
    return w->sink.truncate(w->sink.ctx, w->file_len);
}

/* ---- attachments and metadata -----------------------------------------------------------------
 */

static bool name_fits(struct dx_mcap_text name)
{
    return name.len <= DX_MCAP_MAX_NAME;
}

int dx_mcap_writer_attachment(struct dx_mcap_writer *w, const struct dx_mcap_attachment *a)
{
    uint8_t head[64 + 2 * DX_MCAP_MAX_NAME], crc[4];
    struct dx_writer out = dx_writer_init(head, sizeof(head)), index = group_room(&w->attachments);
    struct dx_mcap_piece piece = dx_mcap_piece_begin(w);
    struct dx_mcap_item_index item = {{dx_mcap_piece_at(&piece), 0},
                                      a->log_time,
                                      a->create_time,
                                      a->data.len,
                                      a->name,
                                      a->media_type};
    size_t head_len;
    int rc;

    if (!name_fits(a->name) || !name_fits(a->media_type))
        return -EINVAL;
    dx_mcap_put_attachment_head(&out, a);
    head_len = (size_t)(out.p - head);
    dx_put_u32(crc,
               dx_crc32(dx_crc32(0, head + DX_MCAP_RECORD_HEAD, head_len - DX_MCAP_RECORD_HEAD),
                        a->data.p, a->data.len));
    item.record.len = head_len + a->data.len + sizeof(crc);
    dx_mcap_put_attachment_index(&index, &item);
    if (index.failed)
        return DX_MCAP_E_FULL;
    dx_mcap_piece_put(&piece, head, head_len);
    dx_mcap_piece_put(&piece, a->data.p, a->data.len);
    dx_mcap_piece_put(&piece, crc, sizeof(crc));
    rc = dx_mcap_piece_commit(&piece);
    if (rc)
        return rc;
    group_take(&w->attachments, &index);
    w->stats.n_attachments++;
    return 0;
}

int dx_mcap_writer_metadata(struct dx_mcap_writer *w, const struct dx_mcap_metadata *m)
{
    uint8_t head[32 + DX_MCAP_MAX_NAME];
    struct dx_writer out = dx_writer_init(head, sizeof(head)), index = group_room(&w->metadata);
    struct dx_mcap_piece piece = dx_mcap_piece_begin(w);
    struct dx_mcap_item_index item = {.record = {dx_mcap_piece_at(&piece), 0}, .name = m->name};
    int rc;

    if (!name_fits(m->name) || m->map.len > DX_MCAP_MAX_METADATA)
        return -EINVAL;
    dx_mcap_put_metadata_head(&out, m);
    item.record.len = (size_t)(out.p - head) + m->map.len;
    dx_mcap_put_metadata_index(&index, &item);
    if (index.failed)
        return DX_MCAP_E_FULL;
    dx_mcap_piece_put(&piece, head, (size_t)(out.p - head));
    dx_mcap_piece_put(&piece, m->map.p, m->map.len);
    rc = dx_mcap_piece_commit(&piece);
    if (rc)
        return rc;
    group_take(&w->metadata, &index);
    w->stats.n_metadata++;
    return 0;
}

/* ---- the end ----------------------------------------------------------------------------------
 */

/* Groups of the summary with their places, for the summary offsets. */
struct summary {
    struct dx_mcap_piece piece;
    uint8_t ops[6];
    struct dx_mcap_extent groups[6];
    unsigned n_groups;
};

static void end_group(struct summary *s, enum dx_mcap_op op, uint64_t start)
{
    uint64_t len = dx_mcap_piece_at(&s->piece) - start;

    if (len == 0)
        return;
    s->ops[s->n_groups] = (uint8_t)op;
    s->groups[s->n_groups++] = (struct dx_mcap_extent){start, len};
}

static void put_defs(struct summary *s, enum dx_mcap_op op, const struct dx_mcap_def_table *t)
{
    uint64_t start = dx_mcap_piece_at(&s->piece);

    for (uint32_t k = 0; k < t->n; k++)
        dx_mcap_piece_put(&s->piece, t->defs[k]->record, t->defs[k]->len);
    end_group(s, op, start);
}

static void put_group(struct summary *s, enum dx_mcap_op op, const struct dx_mcap_group *g)
{
    uint64_t start = dx_mcap_piece_at(&s->piece);

    dx_mcap_piece_put(&s->piece, g->bytes, g->len);
    end_group(s, op, start);
}

static void put_statistics(struct summary *s, const struct dx_mcap_writer *w)
{
    const struct dx_mcap_def_table *channels = &w->defs.channels;
    const struct dx_mcap_statistics *st = &w->stats;
    uint64_t start = dx_mcap_piece_at(&s->piece);
    uint8_t bytes[DX_MCAP_RECORD_HEAD + 46];
    struct dx_writer out = dx_writer_init(bytes, sizeof(bytes));
    uint32_t n = 0;

    for (uint32_t k = 0; k < channels->n; k++)
        n += channels->defs[k]->n_messages > 0;
    dx_write_u8(&out, DX_MCAP_STATISTICS);
    dx_write_u64(&out, sizeof(bytes) - DX_MCAP_RECORD_HEAD + 10 * (uint64_t)n);
    dx_write_u64(&out, st->n_messages);
    dx_write_u16(&out, (uint16_t)w->defs.schemas.n);
    dx_write_u32(&out, channels->n);
    dx_write_u32(&out, st->n_attachments);
    dx_write_u32(&out, st->n_metadata);
    dx_write_u32(&out, st->n_chunks);
    dx_write_u64(&out, st->start);
    dx_write_u64(&out, st->end);
    dx_write_u32(&out, 10 * n);
    dx_mcap_piece_put(&s->piece, bytes, sizeof(bytes));
    for (uint32_t k = 0; k < channels->n; k++) {
        uint8_t pair[10];

        dx_put_u16(pair, channels->defs[k]->channel.id);
        dx_put_u64(pair + 2, channels->defs[k]->n_messages);
        if (channels->defs[k]->n_messages > 0)
            dx_mcap_piece_put(&s->piece, pair, sizeof(pair));
    }
    end_group(s, DX_MCAP_STATISTICS, start);
}

static void put_data_end(struct dx_mcap_piece *p)
{
    uint8_t bytes[DX_MCAP_RECORD_HEAD + 4];
    struct dx_writer out = dx_writer_init(bytes, sizeof(bytes));

    dx_write_u8(&out, DX_MCAP_DATA_END);
    dx_write_u64(&out, 4);
    dx_write_u32(&out, p->crc);
    dx_mcap_piece_put(p, bytes, sizeof(bytes));
}

static void put_offsets(struct summary *s)
{
    for (unsigned k = 0; k < s->n_groups; k++) {
        uint8_t bytes[DX_MCAP_RECORD_HEAD + 17];
        struct dx_writer out = dx_writer_init(bytes, sizeof(bytes));

        dx_mcap_put_summary_offset(&out, s->ops[k], &s->groups[k]);
        dx_mcap_piece_put(&s->piece, bytes, sizeof(bytes));
    }
}

/* The CRC of the summary covers the footer up to itself. */
static void put_footer(struct dx_mcap_piece *p, uint64_t summary, uint64_t offsets)
{
    uint8_t bytes[DX_MCAP_RECORD_HEAD + DX_MCAP_FOOTER_LEN - 4], crc[4];
    struct dx_writer out = dx_writer_init(bytes, sizeof(bytes));

    dx_write_u8(&out, DX_MCAP_FOOTER);
    dx_write_u64(&out, DX_MCAP_FOOTER_LEN);
    dx_write_u64(&out, summary);
    dx_write_u64(&out, offsets);
    dx_mcap_piece_put(p, bytes, sizeof(bytes));
    dx_put_u32(crc, p->crc);
    dx_mcap_piece_put(p, crc, sizeof(crc));
    dx_mcap_piece_put(p, dx_mcap_magic, DX_MCAP_MAGIC_LEN);
}

int dx_mcap_writer_finish(struct dx_mcap_writer *w)
{
    struct summary s = {0};
    uint64_t start, offsets;
    int rc = dx_mcap_writer_flush(w);

    if (rc)
        return rc;
    s.piece = dx_mcap_piece_begin(w);
    put_data_end(&s.piece);
    start = dx_mcap_piece_at(&s.piece);
    s.piece.crc = 0;
    put_defs(&s, DX_MCAP_SCHEMA, &w->defs.schemas);
    put_defs(&s, DX_MCAP_CHANNEL, &w->defs.channels);
    put_statistics(&s, w);
    put_group(&s, DX_MCAP_CHUNK_INDEX, &w->chunks);
    put_group(&s, DX_MCAP_ATTACHMENT_INDEX, &w->attachments);
    put_group(&s, DX_MCAP_METADATA_INDEX, &w->metadata);
    offsets = dx_mcap_piece_at(&s.piece);
    put_offsets(&s);
    put_footer(&s.piece, start, offsets);
    return dx_mcap_piece_commit(&s.piece);
}
