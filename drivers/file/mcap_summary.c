/* The MCAP reader: footer and summary. What does not hold together is noted and not used. */
#include "drivers/file/mcap_read_priv.h"

#include <errno.h>
#include <stdlib.h>

#define TAIL       (DX_MCAP_RECORD_HEAD + DX_MCAP_FOOTER_LEN + DX_MCAP_MAGIC_LEN)
#define MAX_RECORD DX_MCAP_MAX_DEFS /* the longest record of a summary that is looked at */
#define FOOTER_CRC (DX_MCAP_FOOTER_LEN - 4)

struct footer {
    uint64_t at, summary_start, offset_start;
    uint32_t crc;
};

/* 0: there; DX_MCAP_E_END: the file does not end in a footer. */
static int read_footer(struct dx_mcap_reader *r, struct footer *f)
{
    const uint8_t *p;
    int rc;

    if (r->source.len < r->data_start + TAIL)
        return DX_MCAP_E_END;
    f->at = r->source.len - TAIL;
    rc = dx_mcap_view_get(r, f->at, TAIL, &p);
    if (rc)
        return rc == -ENOMEM ? rc : DX_MCAP_E_END;
    if (p[0] != DX_MCAP_FOOTER || dx_get_u64(p + 1) != DX_MCAP_FOOTER_LEN ||
        memcmp(p + TAIL - DX_MCAP_MAGIC_LEN, dx_mcap_magic, DX_MCAP_MAGIC_LEN) != 0)
        return DX_MCAP_E_END;
    p += DX_MCAP_RECORD_HEAD;
    f->summary_start = dx_get_u64(p);
    f->offset_start = dx_get_u64(p + 8);
    f->crc = dx_get_u32(p + FOOTER_CRC);
    r->has_footer = true;
    return 0;
}

/* 0: sound; DX_MCAP_E_END: noted; -ENOMEM. */
static int check_crc(struct dx_mcap_reader *r, const struct footer *f)
{
    uint64_t end = f->at + DX_MCAP_RECORD_HEAD + FOOTER_CRC;
    uint32_t crc = 0;
    int rc;

    if (f->summary_start < r->data_start || f->summary_start > f->at) {
        dx_mcap_note(r, f->at, 0, "footer: summary at byte %llu, expected %llu to %llu",
                     (unsigned long long)f->summary_start, (unsigned long long)r->data_start,
                     (unsigned long long)f->at);
        return DX_MCAP_E_END;
    }
    if (f->crc == 0)
        return 0;
    rc = dx_mcap_view_crc(r, f->summary_start, end - f->summary_start, &crc);
    if (rc == -ENOMEM)
        return rc;
    if (rc == 0 && crc == f->crc)
        return 0;
    dx_mcap_note(r, f->summary_start, end - f->summary_start, "summary: CRC is %08x, expected %08x",
                 crc, f->crc);
    return DX_MCAP_E_END;
}

/* ---- records ----------------------------------------------------------------------------------
 */

/* A record that an index points at lies between header and summary. */
static bool in_data(const struct dx_mcap_reader *r, const struct dx_mcap_extent *e)
{
    return e->offset >= r->data_start && e->offset <= r->summary_start &&
           e->len >= DX_MCAP_RECORD_HEAD && e->len <= r->summary_start - e->offset;
}

static int take_chunk(struct dx_mcap_reader *r, const uint8_t *body, size_t len)
{
    struct dx_mcap_chunk_index index;
    struct dx_mcap_part part = {0};
    int compression;

    if (dx_mcap_get_chunk_index(&index, body, len) < 0 || !in_data(r, &index.chunk) ||
        index.start > index.end)
        return -EBADMSG;
    compression = dx_mcap_compression_find(index.compression);
    part.at = index.chunk;
    part.start = index.start;
    part.end = index.end;
    part.compression = (uint8_t)(compression < 0 ? DX_MCAP_NONE : compression);
    return dx_mcap_parts_add(&r->parts, &part);
}

static int take_item(struct dx_mcap_reader *r, uint8_t op, const uint8_t *body, size_t len)
{
    bool is_attachment = op == DX_MCAP_ATTACHMENT_INDEX;
    struct dx_mcap_item_index index;
    int rc = is_attachment ? dx_mcap_get_attachment_index(&index, body, len)
                           : dx_mcap_get_metadata_index(&index, body, len);

    if (rc < 0 || !in_data(r, &index.record))
        return -EBADMSG;
    return dx_mcap_items_add(is_attachment ? &r->attachments : &r->metadata, &index);
}

/* The counts of channels; the view of them does not outlive the record. */
static int take_statistics(struct dx_mcap_reader *r, const uint8_t *body, size_t len)
{
    struct dx_reader counts;

    if (dx_mcap_get_statistics(&r->statistics, body, len) < 0)
        return -EBADMSG;
    r->has_statistics = true;
    counts = dx_reader_init(r->statistics.counts.p, r->statistics.counts.len);
    while (dx_reader_left(&counts) > 0) {
        uint16_t id = dx_read_u16(&counts);
        uint64_t n = dx_read_u64(&counts);
        struct dx_mcap_def *def = dx_mcap_def_find(&r->defs.channels, id);

        if (def)
            def->n_messages = n;
    }
    r->statistics.counts = (struct dx_mcap_bytes){NULL, 0};
    return 0;
}

static int take_record(struct dx_mcap_reader *r, uint8_t op, const uint8_t *body, size_t len)
{
    switch (op) {
    case DX_MCAP_SCHEMA:
    case DX_MCAP_CHANNEL:
        return dx_mcap_take_def(r, op, body, len);
    case DX_MCAP_CHUNK_INDEX:
        return take_chunk(r, body, len);
    case DX_MCAP_ATTACHMENT_INDEX:
    case DX_MCAP_METADATA_INDEX:
        return take_item(r, op, body, len);
    case DX_MCAP_STATISTICS:
        return take_statistics(r, body, len);
    default:
        return 0;
    }
}

/* Every record from the summary's start to the footer. `at` tells where it went wrong. */
static int take_records(struct dx_mcap_reader *r, const struct footer *f, uint64_t *at)
{
    int rc = 0;

    for (*at = f->summary_start; rc == 0 && *at < f->at;) {
        const uint8_t *p;
        uint64_t len;
        uint8_t op;

        rc = dx_mcap_record_at(r, *at, f->at, &op, &len);
        if (rc == 0 && len > MAX_RECORD)
            rc = -EBADMSG;
        if (rc == 0)
            rc = dx_mcap_view_get(r, *at, (size_t)len, &p);
        if (rc == 0)
            rc = take_record(r, op, p + DX_MCAP_RECORD_HEAD, (size_t)len - DX_MCAP_RECORD_HEAD);
        if (rc == 0)
            *at += len;
    }
    return rc;
}

static int by_offset(const void *a, const void *b)
{
    const struct dx_mcap_part *x = a, *y = b;

    return x->at.offset < y->at.offset ? -1 : x->at.offset > y->at.offset;
}

/* In the order of the file, and no byte in two of them: a file cannot make the reader decompress
 * more than its own length of chunks. */
static bool sort_parts(struct dx_mcap_parts *parts)
{
    if (parts->n > 1)
        qsort(parts->p, parts->n, sizeof(*parts->p), by_offset);
    for (uint32_t k = 1; k < parts->n; k++)
        if (parts->p[k].at.offset - parts->p[k - 1].at.offset < parts->p[k - 1].at.len)
            return false;
    return true;
}

static void forget_index(struct dx_mcap_reader *r)
{
    r->parts.n = 0;
    dx_mcap_items_clear(&r->attachments);
    dx_mcap_items_clear(&r->metadata);
    r->has_statistics = false;
}

static void use_summary(struct dx_mcap_reader *r)
{
    const struct dx_mcap_statistics *s = &r->statistics;

    r->has_summary = true;
    if (!r->has_statistics)
        return;
    r->n_messages = s->n_messages;
    r->start = s->start;
    r->end = s->end;
    /* messages outside of chunks are in no index; channels that it does not repeat may stand in
     * any chunk */
    r->indexed = s->n_chunks == r->parts.n && (r->parts.n > 0 || s->n_messages == 0) &&
                 s->n_channels <= r->defs.channels.n && s->n_schemas <= r->defs.schemas.n;
}

int dx_mcap_read_summary(struct dx_mcap_reader *r)
{
    struct footer f;
    uint64_t at;
    int rc = read_footer(r, &f);

    if (rc == 0 && f.summary_start == 0)
        rc = DX_MCAP_E_END;
    if (rc == 0)
        rc = check_crc(r, &f);
    if (rc)
        return rc < 0 ? rc : 0;
    r->summary_start = f.summary_start;
    rc = take_records(r, &f, &at);
    if (rc == 0 && !sort_parts(&r->parts)) {
        at = f.summary_start;
        rc = -EBADMSG;
    }
    if (rc == 0) {
        use_summary(r);
        return 0;
    }
    forget_index(r);
    if (rc == -ENOMEM)
        return rc;
    dx_mcap_note(r, at, f.at - at, "summary: %s",
                 rc == -E2BIG ? "more than this reader takes" : "damaged index");
    return 0;
}
