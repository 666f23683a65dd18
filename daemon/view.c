/* Views: dirty tiles and pinned batches. Loop thread. */
#include "daemon/view.h"

#include <errno.h>
#include <string.h>

static size_t n_words(const struct dx_feed_loop *l)
{
    return (l->feed->max_tiles + 63) / 64;
}

size_t dx_view_len(const struct dx_feed_loop *l)
{
    const struct dx_view *v = NULL;

    return n_words(l) * sizeof(*v->dirty) + l->feed->max_tiles * sizeof(*v->entry);
}

int dx_view_join(struct dx_view *v)
{
    struct dx_feed_loop *l = v->loop;

    v->dirty = calloc(n_words(v->loop), sizeof(*v->dirty));
    v->entry = malloc(l->feed->max_tiles * sizeof(*v->entry));
    if (!v->dirty || !v->entry) {
        free(v->dirty);
        free(v->entry);
        v->dirty = NULL;
        v->entry = NULL;
        return -ENOMEM;
    }
    v->snapshot = true;
    v->late = true; /* a snapshot is long; it does not take a pin from others */
    v->next = l->views;
    v->prev = NULL;
    if (v->next)
        v->next->prev = v;
    l->views = v;
    l->n_views[v->form]++;
    dx_feed_loop_want(l, v->form);
    return 0;
}

void dx_view_leave(struct dx_view *v, uint64_t now_ns)
{
    struct dx_feed_loop *l = v->loop;

    if (!v->entry)
        return;
    dx_view_drop(v);
    if (v->prev)
        v->prev->next = v->next;
    else
        l->views = v->next;
    if (v->next)
        v->next->prev = v->prev;
    if (--l->n_views[v->form] == 0)
        l->unused_since_ns[v->form] = now_ns;
    free(v->dirty);
    free(v->entry);
    v->dirty = NULL;
    v->entry = NULL;
}

bool dx_view_ready(const struct dx_view *v)
{
    const struct dx_feed_loop *l = v->loop;

    return !v->in_batch && l->has_epoch && l->whole[v->form] &&
           (v->snapshot || v->done_seq != l->seq);
}

static bool in_region(const struct dx_view *v, uint32_t tile)
{
    uint32_t row = tile / v->loop->tiling.cols, col = tile % v->loop->tiling.cols;
    const struct dx_view_region *r = &v->region;

    return r->rows == 0 || (row - r->row0 < r->rows && col - r->col0 < r->cols);
}

static void take(struct dx_view *v, uint32_t tile)
{
    uint32_t chunk = v->loop->current[v->form][tile];

    if (!in_region(v, tile))
        return;
    v->entry[v->n_entries++] = (struct dx_view_entry){tile, chunk};
    if (chunk != DX_FEED_NONE) {
        v->loop->feed->chunk[chunk].refs++;
        v->n_held++;
    }
}

static void take_all(struct dx_view *v)
{
    uint32_t n_tiles = dx_tiling_n_tiles(&v->loop->tiling);

    for (uint32_t t = 0; t < n_tiles; t++)
        if (v->loop->current[v->form][t] != DX_FEED_NONE)
            take(v, t);
}

static void take_dirty(struct dx_view *v)
{
    for (size_t w = 0; w < n_words(v->loop); w++)
        for (uint64_t bits = v->dirty[w]; bits; bits &= bits - 1)
            take(v, (uint32_t)(w * 64) + (uint32_t)__builtin_ctzll(bits));
}

static void pin(struct dx_view *v, uint64_t now_ns)
{
    struct dx_feed_loop *l = v->loop;

    if (l->n_pins && l->pin[l->n_pins - 1].seq == v->batch_seq) {
        l->pin[l->n_pins - 1].n_views++;
        return;
    }
    /* Room for it: dx_feed_loop_turn leaves at most DX_FEED_MAX_PINS of older epochs. */
    l->pin[l->n_pins++] = (struct dx_feed_pin){v->batch_seq, now_ns, 1};
}

/* A view that was late would likely keep its pin: it waits for a free one, but not for ever. */
static bool may_pin(struct dx_view *v, uint64_t now_ns)
{
    struct dx_feed_loop *l = v->loop;

    if (!v->late || l->n_pins < DX_FEED_MAX_PINS || l->pin[l->n_pins - 1].seq == l->seq)
        return true;
    return now_ns >= dx_view_patience(v) && dx_feed_loop_revoke_oldest(l);
}

uint64_t dx_view_patience(const struct dx_view *v)
{
    return v->loop->n_pins ? v->loop->pin[0].since_ns + DX_FEED_PIN_GRACE_NS : 0;
}

bool dx_view_begin(struct dx_view *v, uint64_t now_ns)
{
    struct dx_feed_loop *l = v->loop;

    if (!may_pin(v, now_ns))
        return false;
    v->in_batch = true;
    v->batch_is_snapshot = v->snapshot;
    v->batch_seq = l->seq;
    v->batch_epoch = l->epoch;
    v->n_entries = v->n_held = 0;
    if (v->snapshot)
        take_all(v);
    else
        take_dirty(v);
    memset(v->dirty, 0, n_words(v->loop) * sizeof(*v->dirty));
    v->snapshot = false;
    v->commit = l->commit;
    v->published_ns = l->passage.published_ns;
    v->commit.n_tiles = v->n_entries;
    if (v->n_held)
        pin(v, now_ns);
    return true;
}

void dx_view_release(struct dx_view *v, uint32_t k)
{
    uint32_t chunk = v->entry[k].chunk;

    if (chunk == DX_FEED_NONE)
        return;
    v->entry[k].chunk = DX_FEED_NONE;
    dx_feed_loop_unref(v->loop, chunk);
    if (--v->n_held == 0)
        dx_feed_loop_unpin(v->loop, v->batch_seq);
}

void dx_view_end(struct dx_view *v)
{
    v->in_batch = false;
    v->late = v->batch_seq != v->loop->seq;
    v->done_seq = v->batch_seq;
    v->done_epoch = v->batch_epoch;
}

void dx_view_drop(struct dx_view *v)
{
    if (v->in_batch) {
        v->in_batch = false;
        v->late = true;
        for (uint32_t k = 0; k < v->n_entries && v->n_held; k++)
            dx_view_release(v, k);
    }
    v->snapshot = true;
}
