/*
 * The MCAP reader: a whole file, record by record, without trust in its index. Behind what is
 * damaged the scan goes on where the next chunk is recognised.
 */
#include "drivers/file/mcap_scan.h"

#include <errno.h>
#include <stdlib.h>

#define SECTOR     512
#define CHUNK_HEAD (DX_MCAP_RECORD_HEAD + 3 * 8 + 4 + 4) /* up to the name of the compression */

/* The bytes are a chunk's head: a known compression, and lengths that agree with each other and
 * with the file. Chance alone does not make that. */
static bool looks_like_chunk(struct dx_mcap_reader *r, uint64_t at, const uint8_t *p)
{
    uint32_t name_len = dx_get_u32(p + CHUNK_HEAD - 4);
    uint64_t len = dx_get_u64(p + 1), fixed;

    if (p[0] != DX_MCAP_CHUNK || name_len > 4)
        return false;
    fixed = CHUNK_HEAD - DX_MCAP_RECORD_HEAD + name_len + 8;
    return dx_mcap_compression_find(
               (struct dx_mcap_text){(const char *)p + CHUNK_HEAD, name_len}) >= 0 &&
           len >= fixed && dx_get_u64(p + CHUNK_HEAD + name_len) == len - fixed &&
           len <= r->source.len - at - DX_MCAP_RECORD_HEAD;
}

/* Finds the next chunk from `from` on. A chunk is longer than what is looked at here: it has at
 * least the head of a record in it. */
static bool find_chunk(struct dx_mcap_reader *r, uint64_t from, uint64_t *found)
{
    const size_t seen = CHUNK_HEAD + 4 + 8;

    for (uint64_t at = from; at < r->source.len && r->source.len - at >= seen; at++) {
        const uint8_t *p;

        if (dx_mcap_view_get(r, at, seen, &p) < 0) {
            at |= SECTOR - 1; /* what cannot be read fails by the sector, and slowly */
            continue;
        }
        if (p[0] == DX_MCAP_CHUNK && looks_like_chunk(r, at, p)) {
            *found = at;
            return true;
        }
    }
    return false;
}

/* Goes on behind damage, or to the end. `is_noted`: what is wrong has been told. */
static void resync(struct dx_mcap_scan *s, bool is_noted)
{
    uint64_t found = s->r->source.len;
    bool is_there = find_chunk(s->r, s->at + 1, &found);

    if (is_noted)
        ;
    else if (is_there)
        dx_mcap_note(s->r, s->at, found - s->at, "no records; the next chunk follows");
    else
        dx_mcap_note(s->r, s->at, found - s->at,
                     "no whole record: the file was cut or overwritten");
    s->at = found;
}

static int scan_all(struct dx_mcap_scan *s)
{
    const uint64_t end = s->r->source.len;

    while (!s->ended && s->at < end) {
        int rc = dx_mcap_record_at(s->r, s->at, end, &s->op, &s->len);
        bool is_record = rc == 0;

        if (is_record)
            rc = dx_mcap_scan_record(s);
        if (rc == -ENOMEM || rc == -E2BIG)
            return rc;
        if (rc == 0)
            s->at += s->len;
        else
            resync(s, is_record);
    }
    return dx_mcap_scan_close_run(s);
}

/* Where the index that was read before departs from what the scan found. Told only of a file that
 * is whole otherwise: of another one it is no news. */
static void compare(const struct dx_mcap_scan *s, const struct dx_mcap_parts *index)
{
    struct dx_mcap_reader *r = s->r;
    uint32_t k = 0;

    if (!r->has_summary || r->n_damages > 0)
        return;
    if (r->has_statistics && r->statistics.n_messages != s->n_messages)
        dx_mcap_note(r, r->summary_start, 0, "statistics: %llu messages, found %llu",
                     (unsigned long long)r->statistics.n_messages,
                     (unsigned long long)s->n_messages);
    if (index->n == 0)
        return;
    for (uint32_t i = 0; i < r->parts.n; i++) {
        const struct dx_mcap_part *part = &r->parts.p[i];

        while (k < index->n && index->p[k].at.offset < part->at.offset)
            k++;
        if (part->is_run)
            continue;
        if (k == index->n || index->p[k].at.offset != part->at.offset ||
            index->p[k].at.len != part->at.len)
            dx_mcap_note(r, part->at.offset, part->at.len, "chunk that is not in the index");
        else if (part->has_messages &&
                 (index->p[k].start != part->start || index->p[k].end != part->end))
            dx_mcap_note(r, part->at.offset, part->at.len,
                         "chunk index: log times %llu to %llu, found %llu to %llu",
                         (unsigned long long)index->p[k].start, (unsigned long long)index->p[k].end,
                         (unsigned long long)part->start, (unsigned long long)part->end);
    }
}

/* The end of the file: whether it was finished. */
static void check_end(const struct dx_mcap_scan *s)
{
    struct dx_mcap_reader *r = s->r;

    if (!s->ended && s->at == r->source.len && r->n_damages == 0)
        dx_mcap_note(r, s->at, 0, "no end of data: the file was cut here, or is being written");
    else if (s->ended && !r->has_footer)
        dx_mcap_note(r, s->at, r->source.len - s->at, "no whole summary and footer");
}

int dx_mcap_scan(struct dx_mcap_reader *r)
{
    struct dx_mcap_scan s = {.r = r, .at = r->data_start};
    struct dx_mcap_parts index = r->parts;
    int rc;

    r->parts = (struct dx_mcap_parts){0};
    r->indexed = false;
    dx_mcap_items_clear(&r->attachments);
    dx_mcap_items_clear(&r->metadata);
    for (uint32_t k = 0; k < r->defs.channels.n; k++)
        r->defs.channels.defs[k]->n_messages = 0;
    rc = scan_all(&s);
    if (rc == -E2BIG) { /* what was found can be read */
        dx_mcap_note(r, s.at, r->source.len - s.at, "more chunks than this reader takes");
        rc = 0;
    }
    if (rc == 0) {
        check_end(&s);
        compare(&s, &index);
    }
    r->n_messages = s.n_messages;
    r->start = s.start;
    r->end = s.end;
    free(index.p);
    return rc;
}
