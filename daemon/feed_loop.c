/* Adoption of published epochs, current tables, pins and revocation. Loop thread. */
#include "daemon/feed_loop.h"

#include <assert.h>
#include <errno.h>
#include <string.h>

#include "daemon/view.h"

int dx_feed_loop_new(struct dx_feed_loop **out, struct dx_feed *f)
{
    struct dx_feed_loop *l = calloc(1, sizeof(*l));

    if (!l)
        return -ENOMEM;
    l->feed = f;
    for (int e = 0; e < DX_N_FORMS; e++) {
        l->current[e] = malloc(f->max_tiles * sizeof(*l->current[e]));
        if (!l->current[e]) {
            dx_feed_loop_free(l);
            return -ENOMEM;
        }
        memset(l->current[e], 0xff, f->max_tiles * sizeof(*l->current[e]));
    }
    *out = l;
    return 0;
}

static void send_home(struct dx_feed_loop *l, uint32_t number)
{
    dx_ring_push(&l->feed->home, number);
    l->n_home++;
}

void dx_feed_loop_unref(struct dx_feed_loop *l, uint32_t chunk)
{
    if (chunk != DX_FEED_NONE && --l->feed->chunk[chunk].refs == 0)
        send_home(l, chunk);
}

static void clear_table(struct dx_feed_loop *l, int e)
{
    for (uint32_t t = 0; t < l->feed->max_tiles; t++) {
        dx_feed_loop_unref(l, l->current[e][t]);
        l->current[e][t] = DX_FEED_NONE;
    }
    l->whole[e] = false;
}

void dx_feed_loop_free(struct dx_feed_loop *l)
{
    if (!l)
        return;
    assert(!l->views);
    for (int e = 0; e < DX_N_FORMS; e++) {
        if (l->current[e])
            clear_table(l, e);
        free(l->current[e]);
    }
    dx_geometry_unref(l->geometry);
    free(l);
}

/* ---- pins
 * ---------------------------------------------------------------------------------------- */

void dx_feed_loop_unpin(struct dx_feed_loop *l, uint64_t seq)
{
    uint32_t k = 0;

    while (l->pin[k].seq != seq)
        k++;
    if (--l->pin[k].n_views)
        return;
    memmove(&l->pin[k], &l->pin[k + 1], (l->n_pins - k - 1) * sizeof(l->pin[0]));
    l->n_pins--;
}

bool dx_feed_loop_revoke_oldest(struct dx_feed_loop *l)
{
    uint64_t seq = l->n_pins ? l->pin[0].seq : l->seq;

    if (seq == l->seq) /* chunks of the newest epoch are current: taking them back frees nothing */
        return false;
    for (struct dx_view *v = l->views; v; v = v->next) {
        if (!v->in_batch || v->batch_seq != seq || v->n_held == 0)
            continue;
        v->dropped(v, true);
        dx_view_drop(v);
    }
    return true;
}

/* ---- adoption
 * ------------------------------------------------------------------------------------ */

/* True when `chunk` has replaced what was there; false: nobody wants it any more. */
static bool place_chunk(struct dx_feed_loop *l, uint32_t number)
{
    struct dx_feed_chunk *c = &l->feed->chunk[number];
    uint32_t *slot = &l->current[c->form][c->tile];

    if (c->generation == 0 || c->generation != l->generation[c->form]) {
        send_home(l, number);
        return false;
    }
    dx_feed_loop_unref(l, *slot);
    if (c->first == DX_FEED_NONE) {
        *slot = DX_FEED_NONE;
        send_home(l, number);
    } else {
        *slot = number;
        c->refs = 1;
    }
    return true;
}

static void mark_dirty(struct dx_feed_loop *l, uint32_t form, uint32_t tile)
{
    for (struct dx_view *v = l->views; v; v = v->next)
        if (v->form == form)
            v->dirty[tile / 64] |= (uint64_t)1 << tile % 64;
}

static void adopt_commit(struct dx_feed_loop *l, const struct dx_feed_event *e)
{
    uint32_t number = e->first_chunk;

    while (number != DX_FEED_NONE) {
        const struct dx_feed_chunk *c = &l->feed->chunk[number];
        uint32_t next = c->next, tile = c->tile, form = c->form;

        /* once home, the chunk is the mesher's: nothing of it is read after this */
        if (place_chunk(l, number))
            mark_dirty(l, form, tile);
        number = next;
    }
    for (int k = 0; k < DX_N_FORMS; k++)
        l->whole[k] = l->generation[k] && e->generation[k] == l->generation[k];
    l->seq++;
    l->epoch = e->epoch;
    l->commit = e->commit;
    l->passage = e->passage;
    l->has_epoch = true;
}

static void adopt_reset(struct dx_feed_loop *l, struct dx_feed_event *e)
{
    memcpy(l->reset_reason, e->reason, sizeof(l->reset_reason)); /* `dropped` reads it */
    for (struct dx_view *v = l->views; v; v = v->next) {
        v->dropped(v, false);
        dx_view_drop(v);
    }
    for (int k = 0; k < DX_N_FORMS; k++)
        clear_table(l, k);
    dx_geometry_unref(l->geometry);
    l->geometry = e->geometry;
    dx_tiling_init(&l->tiling, l->geometry->height, l->geometry->width, l->geometry->wrap);
    assert(dx_tiling_n_tiles(&l->tiling) <= l->feed->max_tiles);
    l->params = e->params;
    l->attr_bytes = e->attr_bytes;
    l->has_epoch = false;
}

static unsigned adopt(struct dx_feed_loop *l, struct dx_feed_event *e)
{
    switch (e->kind) {
    case DX_FEED_COMMIT:
        adopt_commit(l, e);
        return DX_FEED_NEW_EPOCH;
    case DX_FEED_RESET:
        adopt_reset(l, e);
        return DX_FEED_NEW_RESET;
    case DX_FEED_STATE:
        l->state = e->state;
        memcpy(l->state_reason, e->reason, sizeof(l->state_reason));
        return DX_FEED_NEW_STATE;
    }
    return 0;
}

/* Every epoch goes to a lossless view: nothing is adopted over one it has not had. */
static bool must_hold(const struct dx_feed_loop *l)
{
    for (const struct dx_view *v = l->views; v; v = v->next)
        if (v->lossless && l->has_epoch && l->whole[v->form] && v->done_seq != l->seq)
            return true;
    return false;
}

static bool next_event(struct dx_feed_loop *l, uint32_t *number)
{
    return dx_ring_peek(&l->feed->to_loop, number) &&
           (l->feed->event[*number].kind == DX_FEED_STATE || !must_hold(l));
}

static bool starved(const struct dx_feed_loop *l)
{
    /* acquire: pairs with the mesher's release in starve() */
    return atomic_load_explicit(&l->feed->starved, memory_order_acquire);
}

static void kick(struct dx_feed_loop *l)
{
    l->n_home = 0;
    l->feed->kick(l->feed->kick_ctx);
}

/* The flag is cleared before the kick: a mesher still short after it sets the flag anew. */
static void relieve(struct dx_feed_loop *l)
{
    if (l->n_home == 0 || !starved(l))
        return;
    atomic_store_explicit(&l->feed->starved, false, memory_order_release);
    kick(l);
}

unsigned dx_feed_loop_turn(struct dx_feed_loop *l)
{
    unsigned found = 0;
    uint32_t number;
    bool short_of_chunks =
        starved(l); /* before adopting: what it asked for comes after what it sent */

    while (next_event(l, &number)) {
        dx_ring_pop(&l->feed->to_loop, &number);
        found |= adopt(l, &l->feed->event[number]);
        send_home(l, l->feed->n_chunks + number);
    }
    while (l->n_pins > DX_FEED_MAX_PINS && dx_feed_loop_revoke_oldest(l))
        ;
    /* What adoption just freed may be enough; the mesher asks again when it is not. */
    if (short_of_chunks && (!(found & DX_FEED_NEW_EPOCH) || l->n_home == 0))
        dx_feed_loop_revoke_oldest(l);
    relieve(l);
    return found;
}

static void publish_lossless(struct dx_feed_loop *l)
{
    uint64_t epoch = UINT64_MAX;

    for (const struct dx_view *v = l->views; v; v = v->next)
        if (v->lossless && v->done_epoch < epoch)
            epoch = v->done_epoch;
    /* relaxed: this thread alone writes it */
    if (atomic_load_explicit(&l->feed->lossless_epoch, memory_order_relaxed) == epoch)
        return;
    /* release: as all we publish; pairs with dx_feed_lossless_epoch */
    atomic_store_explicit(&l->feed->lossless_epoch, epoch, memory_order_release);
    kick(l);
}

bool dx_feed_loop_settle(struct dx_feed_loop *l)
{
    uint32_t number;

    publish_lossless(l);
    relieve(l);
    return next_event(l, &number);
}

/* ---- forms wanted
 * ---------------------------------------------------------------------------- */

static void set_wanted(struct dx_feed_loop *l, int e, uint32_t generation)
{
    l->generation[e] = generation;
    /* release: as all we publish; pairs with dx_feed_wanted */
    atomic_store_explicit(&l->feed->wanted[e], generation, memory_order_release);
    kick(l);
}

void dx_feed_loop_want(struct dx_feed_loop *l, unsigned form)
{
    if (l->generation[form])
        return;
    if (++l->last_generation[form] == 0)
        l->last_generation[form] = 1;
    set_wanted(l, (int)form, l->last_generation[form]);
}

/* Nobody wants it any more; what is under way in it goes home when it comes. */
static void drop_form(struct dx_feed_loop *l, int e)
{
    clear_table(l, e);
    set_wanted(l, e, 0);
}

/* Slot of a level that others have, else of one that nobody has: rather one that is not even
 * lingering. DX_LOD_SLOTS: none. */
static unsigned find_slot(const struct dx_feed_loop *l, struct dx_lod_level level)
{
    unsigned found = DX_LOD_SLOTS;

    for (unsigned s = 0; s < DX_LOD_SLOTS; s++) {
        const unsigned form = DX_N_ENCODINGS + s;

        if (l->generation[form] && dx_lod_same(l->level[s], level))
            return s;
        if (!l->n_views[form] && (found == DX_LOD_SLOTS || !l->generation[form]))
            found = s;
    }
    return found;
}

unsigned dx_feed_loop_form(struct dx_feed_loop *l, struct dx_lod_level level)
{
    const unsigned slot = find_slot(l, level), form = DX_N_ENCODINGS + slot;

    if (slot == DX_LOD_SLOTS || (l->generation[form] && dx_lod_same(l->level[slot], level)))
        return form;
    if (l->generation[form])
        drop_form(l, (int)form);
    l->level[slot] = level;
    /* relaxed: the generation that will ask for it is stored with release */
    atomic_store_explicit(&l->feed->level[slot], dx_feed_pack_level(level), memory_order_relaxed);
    return form;
}

void dx_feed_loop_expire(struct dx_feed_loop *l, uint64_t now_ns)
{
    for (int e = 0; e < DX_N_FORMS; e++) {
        if (!l->generation[e] || l->n_views[e] ||
            now_ns - l->unused_since_ns[e] < DX_FEED_LINGER_NS)
            continue;
        drop_form(l, e);
    }
}
