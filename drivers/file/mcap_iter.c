/*
 * The MCAP reader: messages in turn. In order of log time, the chunks that overlap are merged by a
 * heap: each open chunk has the list of its messages, 16 bytes each; their bytes are loaded again
 * when the cache has let go of them.
 */
#include "drivers/file/mcap_read_priv.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

struct entry {
    uint64_t log_time;
    uint32_t offset; /* of the record in the part */
};

/* An open part. */
struct cursor {
    uint32_t part;
    struct entry *entries;
    uint32_t n, next, cap;
};

struct dx_mcap_iter {
    struct dx_mcap_reader *r;
    enum dx_mcap_order order;
    uint64_t start, end; /* log times, end exclusive; UINT64_MAX: none */
    uint8_t *wanted;     /* bits of channels; NULL: all */
    uint32_t *parts;     /* in the order of opening */
    uint32_t n_parts, next_part;
    struct cursor *heap;
    uint32_t n, cap;
    uint32_t n_pending;  /* room for messages in open cursors */
    struct cursor spare; /* the memory of one that is done */
    uint64_t opened_len; /* of parts, as they were opened */
    uint64_t again_len;  /* of parts that were loaded a second time and more */
    const char *why;     /* of -E2BIG */
};

static const struct dx_mcap_part *part_of(const struct dx_mcap_iter *it, uint32_t k)
{
    return &it->r->parts.p[k];
}

/* ---- making one -------------------------------------------------------------------------------
 */

static int by_start(const void *a, const void *b, void *parts)
{
    const struct dx_mcap_part *p = parts;
    uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;

    if (p[x].start != p[y].start)
        return p[x].start < p[y].start ? -1 : 1;
    return x < y ? -1 : x > y;
}

static int choose_channels(struct dx_mcap_iter *it, const struct dx_mcap_query *q)
{
    if (!q->channels)
        return 0;
    it->wanted = calloc(65536 / 8, 1);
    if (!it->wanted)
        return -ENOMEM;
    for (size_t k = 0; k < q->n_channels; k++)
        it->wanted[q->channels[k] / 8] |= (uint8_t)(1u << q->channels[k] % 8);
    return 0;
}

int dx_mcap_iter_new(struct dx_mcap_iter **out, struct dx_mcap_reader *r,
                     const struct dx_mcap_query *query)
{
    static const struct dx_mcap_query all = {.order = DX_MCAP_LOG_TIME};
    const struct dx_mcap_query *q = query ? query : &all;
    struct dx_mcap_iter *it = calloc(1, sizeof(*it));

    if (!it)
        return -ENOMEM;
    it->r = r;
    it->order = q->order;
    it->start = q->start;
    it->end = q->end ? q->end : UINT64_MAX;
    it->n_parts = r->parts.n;
    it->parts = calloc(r->parts.n + 1, sizeof(*it->parts));
    if (!it->parts || choose_channels(it, q) < 0) {
        dx_mcap_iter_free(it);
        return -ENOMEM;
    }
    for (uint32_t k = 0; k < r->parts.n; k++)
        it->parts[k] = k;
    if (q->order == DX_MCAP_LOG_TIME)
        qsort_r(it->parts, it->n_parts, sizeof(*it->parts), by_start, r->parts.p);
    *out = it;
    return 0;
}

void dx_mcap_iter_free(struct dx_mcap_iter *it)
{
    if (!it)
        return;
    for (uint32_t k = 0; k < it->n; k++)
        free(it->heap[k].entries);
    free(it->heap);
    free(it->spare.entries);
    free(it->parts);
    free(it->wanted);
    free(it);
}

/* ---- the heap of open parts -------------------------------------------------------------------
 */

static bool is_before(const struct cursor *a, const struct cursor *b)
{
    uint64_t ta = a->entries[a->next].log_time, tb = b->entries[b->next].log_time;

    return ta != tb ? ta < tb : a->part < b->part;
}

static void swap(struct cursor *a, struct cursor *b)
{
    struct cursor c = *a;

    *a = *b;
    *b = c;
}

static void sift_down(struct dx_mcap_iter *it)
{
    uint32_t k = 0;

    for (;;) {
        uint32_t first = k;

        for (uint32_t child = 2 * k + 1; child <= 2 * k + 2 && child < it->n; child++)
            if (is_before(&it->heap[child], &it->heap[first]))
                first = child;
        if (first == k)
            return;
        swap(&it->heap[k], &it->heap[first]);
        k = first;
    }
}

static int push(struct dx_mcap_iter *it, const struct cursor *c)
{
    if (it->n == it->cap) {
        uint32_t cap = it->cap ? 2 * it->cap : 8;
        struct cursor *heap = realloc(it->heap, cap * sizeof(*heap));

        if (!heap)
            return -ENOMEM;
        it->heap = heap;
        it->cap = cap;
    }
    it->heap[it->n] = *c;
    for (uint32_t k = it->n++; k > 0 && is_before(&it->heap[k], &it->heap[(k - 1) / 2]);
         k = (k - 1) / 2)
        swap(&it->heap[k], &it->heap[(k - 1) / 2]);
    return 0;
}

/* The memory of a cursor that is done serves the next one. */
static void retire(struct dx_mcap_iter *it, struct cursor *c)
{
    it->n_pending -= c->cap;
    dx_mcap_unload(it->r, part_of(it, c->part));
    if (c->cap > it->spare.cap)
        swap(c, &it->spare);
    free(c->entries);
    *c = (struct cursor){0};
}

/* ---- opening a part ---------------------------------------------------------------------------
 */

static bool is_before_end(const struct dx_mcap_iter *it, uint64_t log_time)
{
    return log_time < it->end || it->end == UINT64_MAX;
}

static bool is_wanted(const struct dx_mcap_iter *it, const struct dx_mcap_message *m)
{
    return m->log_time >= it->start && is_before_end(it, m->log_time) &&
           (!it->wanted || (it->wanted[m->channel_id / 8] >> m->channel_id % 8 & 1));
}

static int by_time(const void *a, const void *b)
{
    const struct entry *x = a, *y = b;

    if (x->log_time != y->log_time)
        return x->log_time < y->log_time ? -1 : 1;
    return x->offset < y->offset ? -1 : x->offset > y->offset;
}

static int give_up(struct dx_mcap_iter *it, const char *why)
{
    it->why = why;
    return -E2BIG;
}

static int add_entry(struct dx_mcap_iter *it, struct cursor *c, const struct dx_mcap_message *m,
                     size_t offset)
{
    if (c->n == c->cap) {
        uint32_t cap = c->cap ? 2 * c->cap : 256;
        struct entry *entries;

        if (cap > DX_MCAP_MAX_PENDING - it->n_pending)
            return give_up(it, "more messages in chunks that overlap than are taken");
        entries = realloc(c->entries, cap * sizeof(*entries));
        if (!entries)
            return -ENOMEM;
        c->entries = entries;
        c->cap = cap;
    }
    c->entries[c->n++] = (struct entry){m->log_time, (uint32_t)offset};
    return 0;
}

/* An index that tells other times than the chunk has can put it into the wrong place. */
static void check_times(struct dx_mcap_iter *it, const struct dx_mcap_part *part,
                        const struct dx_mcap_message *m, bool *is_told)
{
    if (*is_told || (m->log_time >= part->start && m->log_time <= part->end))
        return;
    dx_mcap_note(it->r, part->at.offset, part->at.len,
                 "chunk index: log times %llu to %llu, found %llu", (unsigned long long)part->start,
                 (unsigned long long)part->end, (unsigned long long)m->log_time);
    *is_told = true;
}

static int list_messages(struct dx_mcap_iter *it, struct cursor *c, struct dx_mcap_part *part,
                         struct dx_mcap_bytes records)
{
    struct dx_mcap_part_walk walk = dx_mcap_part_walk(it->r, records);
    bool is_told = part->is_odd, is_sorted = true;
    struct dx_mcap_message m;
    size_t offset;
    int rc;

    while ((rc = dx_mcap_part_next(&walk, &m, &offset)) == 0) {
        check_times(it, part, &m, &is_told);
        if (!is_wanted(it, &m))
            continue;
        is_sorted = is_sorted && (c->n == 0 || c->entries[c->n - 1].log_time <= m.log_time);
        rc = add_entry(it, c, &m, offset);
        if (rc)
            return rc;
    }
    if (rc == -ENOMEM)
        return rc;
    if ((rc == -EBADMSG || walk.n_strange) && !part->is_odd)
        dx_mcap_note(it->r, part->at.offset, part->at.len,
                     "chunk: damaged records, or some of unknown channels");
    part->is_odd = part->is_odd || rc == -EBADMSG || walk.n_strange || is_told;
    if (it->order == DX_MCAP_LOG_TIME && !is_sorted)
        qsort(c->entries, c->n, sizeof(*c->entries), by_time);
    return 0;
}

/* Where many parts are open at once, none keeps memory that it does not use. */
static void shrink(struct cursor *c)
{
    struct entry *entries = c->n ? realloc(c->entries, c->n * sizeof(*entries)) : NULL;

    if (entries) {
        c->entries = entries;
        c->cap = c->n;
    }
}

/* Opens a part that may hold a wanted message. */
static int open_part(struct dx_mcap_iter *it, uint32_t k)
{
    struct dx_mcap_part *part = &it->r->parts.p[k];
    struct dx_mcap_bytes records;
    struct cursor c = {.part = k, .entries = it->spare.entries, .cap = it->spare.cap};
    int rc;

    if (part->is_bad)
        return 0;
    rc = dx_mcap_load(it->r, part, &records);
    if (rc == -ENOMEM)
        return rc;
    if (rc) {
        part->is_bad = true;
        dx_mcap_note(it->r, part->at.offset, part->at.len, "%s", it->r->why.text);
        return 0;
    }
    it->opened_len += records.len;
    it->spare = (struct cursor){0};
    rc = list_messages(it, &c, part, records);
    if (it->n >= 8)
        shrink(&c);
    it->n_pending += c.cap;
    if (rc == 0 && c.n > 0)
        rc = push(it, &c);
    if (rc || c.n == 0)
        retire(it, &c);
    return rc;
}

/* The next part is to be opened before the message on top can be given out. Of equal times the one
 * that lies first in the file comes first, and so the others can wait. */
static bool must_open(const struct dx_mcap_iter *it)
{
    const struct cursor *top;
    uint64_t time, start;

    if (it->next_part == it->n_parts)
        return false;
    if (it->n == 0)
        return true;
    if (it->order != DX_MCAP_LOG_TIME)
        return false;
    top = &it->heap[0];
    time = top->entries[top->next].log_time;
    start = part_of(it, it->parts[it->next_part])->start;
    return start < time || (start == time && it->parts[it->next_part] < top->part);
}

static int open_parts(struct dx_mcap_iter *it)
{
    int rc = 0;

    while (rc == 0 && must_open(it)) {
        uint32_t k = it->parts[it->next_part];
        const struct dx_mcap_part *part = part_of(it, k);

        if (part->end >= it->start && is_before_end(it, part->start))
            rc = open_part(it, k);
        if (rc == 0)
            it->next_part++;
    }
    return rc;
}

/* ---- messages ---------------------------------------------------------------------------------
 */

/* Loads the part on top. One that the cache has let go of is decompressed again, for a single
 * message perhaps: that has a bound, or a small file could keep a reader busy for hours. */
static int load_top(struct dx_mcap_iter *it, struct dx_mcap_part *part, struct dx_mcap_bytes *out)
{
    uint64_t before = it->r->n_loads;
    int rc;

    if (it->again_len > 3 * it->opened_len + DX_MCAP_MAX_AGAIN)
        return give_up(it, "its chunks overlap so much that they would be decompressed again and "
                           "again");
    rc = dx_mcap_load(it->r, part, out);
    if (rc == 0 && it->r->n_loads != before)
        it->again_len += out->len;
    return rc;
}

/* The message on top. Its part may have left the cache, and the file may have changed since. */
static int read_top(struct dx_mcap_iter *it, struct dx_mcap_message *out)
{
    struct cursor *c = &it->heap[0];
    struct dx_mcap_part *part = &it->r->parts.p[c->part];
    uint32_t offset = c->entries[c->next].offset;
    struct dx_mcap_record rec;
    struct dx_mcap_bytes records;
    struct dx_reader r;
    int rc = load_top(it, part, &records);

    if (rc)
        return rc;
    if (offset > records.len)
        return -EBADMSG;
    r = dx_reader_init(records.p + offset, records.len - offset);
    rc = dx_mcap_next_record(&rec, &r);
    if (rc || rec.op != DX_MCAP_MESSAGE)
        return -EBADMSG;
    return dx_mcap_get_message(out, rec.body, rec.len);
}

static void advance(struct dx_mcap_iter *it, bool skip_part)
{
    struct cursor *top = &it->heap[0];

    top->next = skip_part ? top->n : top->next + 1;
    if (top->next == top->n) {
        swap(top, &it->heap[--it->n]);
        retire(it, &it->heap[it->n]);
    }
    if (it->n > 1)
        sift_down(it);
}

int dx_mcap_iter_next(struct dx_mcap_iter *it, struct dx_mcap_message *out)
{
    for (;;) {
        int rc = open_parts(it);
        struct dx_mcap_part *part;

        if (rc)
            return rc;
        if (it->n == 0)
            return DX_MCAP_E_END;
        rc = read_top(it, out);
        if (rc == -ENOMEM || rc == -E2BIG)
            return rc;
        part = &it->r->parts.p[it->heap[0].part];
        if (rc) {
            part->is_bad = true;
            dx_mcap_note(it->r, part->at.offset, part->at.len,
                         "chunk cannot be read a second time");
        }
        advance(it, rc != 0);
        if (rc == 0)
            return 0;
    }
}

const char *dx_mcap_iter_why(const struct dx_mcap_iter *it, int rc)
{
    return rc == -E2BIG && it->why ? it->why : strerror(-rc);
}

void dx_mcap_iter_seek(struct dx_mcap_iter *it, uint64_t start)
{
    while (it->n > 0)
        retire(it, &it->heap[--it->n]);
    it->next_part = 0;
    it->start = start;
}
