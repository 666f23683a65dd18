/*
 * The mesher's half of a feed: takes free chunks, fills them, publishes epochs, gets chunks back.
 * Called by the stream's mesher alone; never waits. feed_priv.h says what is whose.
 */
#include "daemon/feed_priv.h"

#include <assert.h>
#include <errno.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <unistd.h>

#define N_EVENTS 256u

static void stack_init(struct dx_feed_stack *s, uint32_t n)
{
    *s = (struct dx_feed_stack){DX_FEED_NONE, 0, n};
}

int dx_feed_new_sized(struct dx_feed **out, uint32_t max_tiles, uint32_t n_blocks,
                      uint32_t n_chunks, uint32_t n_events, int wake_fd, void (*kick)(void *ctx),
                      void *kick_ctx)
{
    struct dx_feed *f = aligned_alloc(64, (sizeof(*f) + 63) / 64 * 64);
    int r;

    if (!f)
        return -ENOMEM;
    memset(f, 0, sizeof(*f));
    f->max_tiles = max_tiles;
    f->n_chunks = n_chunks;
    f->n_events = n_events;
    f->kick = kick;
    f->kick_ctx = kick_ctx;
    f->own_wake_fd = wake_fd < 0;
    f->wake_fd = wake_fd < 0 ? eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC) : wake_fd;
    r = f->wake_fd < 0 ? -errno : 0;
    f->memory_len = (size_t)n_blocks * DX_FEED_BLOCK_LEN;
    f->memory = mmap(NULL, f->memory_len, PROT_READ | PROT_WRITE,
                     MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (f->memory == MAP_FAILED)
        f->memory = NULL;
    f->next_block = calloc(n_blocks, sizeof(*f->next_block));
    f->chunk = calloc(n_chunks, sizeof(*f->chunk));
    f->event = calloc(n_events, sizeof(*f->event));
    if (dx_ring_init(&f->to_loop, n_events) || dx_ring_init(&f->home, n_chunks + n_events) ||
        !f->memory || !f->next_block || !f->chunk || !f->event)
        r = -ENOMEM;
    if (r < 0) {
        dx_feed_free(f);
        return r;
    }
    stack_init(&f->free_blocks, n_blocks);
    stack_init(&f->free_chunks, n_chunks);
    stack_init(&f->free_events, n_events);
    f->out.first = f->out.last = f->out.mark = DX_FEED_NONE;
    atomic_init(&f->lossless_epoch, UINT64_MAX);
    *out = f;
    return 0;
}

int dx_feed_new(struct dx_feed **out, uint32_t max_tiles, uint32_t n_epochs, uint8_t attr_bytes,
                int wake_fd, void (*kick)(void *ctx), void *kick_ctx)
{
    size_t spare = (size_t)(2 - attr_bytes) * DX_TILE_MAX_VERTICES; /* max_len counts two */
    uint64_t n_tiles = (uint64_t)max_tiles * n_epochs;
    uint32_t tile_blocks = 0;
    int r;

    for (unsigned e = 0; e < DX_N_FORMS; e++) {
        size_t len = dx_chunk_max_len(dx_form_encoding(e)) - spare;

        tile_blocks += (uint32_t)((len + DX_FEED_BLOCK_LEN - 1) / DX_FEED_BLOCK_LEN);
    }
    if (n_tiles * tile_blocks >= DX_FEED_NONE || n_tiles * DX_N_FORMS >= 1u << 30)
        return -ENOMEM;
    r = dx_feed_new_sized(out, max_tiles, (uint32_t)n_tiles * tile_blocks,
                          (uint32_t)n_tiles * DX_N_FORMS, N_EVENTS, wake_fd, kick, kick_ctx);
    if (r < 0)
        return r;
    (*out)->tile_blocks = tile_blocks;
    (*out)->n_epochs = n_epochs;
    return 0;
}

void dx_feed_free(struct dx_feed *f)
{
    uint32_t number;

    if (!f)
        return;
    if (f->to_loop.slot && f->event)
        while (dx_ring_pop(&f->to_loop, &number))
            if (f->event[number].kind == DX_FEED_RESET)
                dx_geometry_unref(f->event[number].geometry);
    if (f->out.has_reset)
        dx_geometry_unref(f->out.reset.geometry);
    dx_ring_fini(&f->to_loop);
    dx_ring_fini(&f->home);
    free(f->event);
    free(f->chunk);
    free(f->next_block);
    if (f->memory)
        munmap(f->memory, f->memory_len);
    if (f->own_wake_fd && f->wake_fd >= 0)
        close(f->wake_fd);
    free(f);
}

static void wake(struct dx_feed *f)
{
    uint64_t one = 1;
    /* EAGAIN: the counter is full, so the loop has been woken */
    ssize_t r = write(f->wake_fd, &one, sizeof(one));

    (void)r;
}

static void starve(struct dx_feed *f)
{
    /* release: pairs with the loop's acquire; it sees all that was published before */
    atomic_store_explicit(&f->starved, true, memory_order_release);
    wake(f);
}

static void free_chunk(struct dx_feed *f, uint32_t number)
{
    struct dx_feed_chunk *c = &f->chunk[number];

    if (c->first != DX_FEED_NONE) {
        f->next_block[c->last] = f->free_blocks.head;
        f->free_blocks.head = c->first;
        f->free_blocks.n += c->n_blocks;
    }
    c->next = f->free_chunks.head;
    f->free_chunks.head = number;
    f->free_chunks.n++;
}

/* Takes in what the loop sent home. */
static void reclaim(struct dx_feed *f)
{
    uint32_t number;

    while (dx_ring_pop(&f->home, &number)) {
        if (number < f->n_chunks) {
            free_chunk(f, number);
            continue;
        }
        number -= f->n_chunks;
        f->event[number].next = f->free_events.head;
        f->free_events.head = number;
        f->free_events.n++;
    }
}

static uint32_t take_block(struct dx_feed *f)
{
    uint32_t block = f->free_blocks.head;

    f->free_blocks.n--;
    if (block == DX_FEED_NONE)
        return f->free_blocks.n_fresh++;
    f->free_blocks.head = f->next_block[block];
    return block;
}

static uint32_t take_chunk(struct dx_feed *f)
{
    uint32_t number = f->free_chunks.head;

    f->free_chunks.n--;
    if (number == DX_FEED_NONE)
        return f->free_chunks.n_fresh++;
    f->free_chunks.head = f->chunk[number].next;
    return number;
}

/* Copies the event into a free one and into the ring; false: none is free. */
static bool push_event(struct dx_feed *f, const struct dx_feed_event *e)
{
    uint32_t number = f->free_events.head;

    if (f->free_events.n == 0)
        return false;
    f->free_events.n--;
    if (number == DX_FEED_NONE)
        number = f->free_events.n_fresh++;
    else
        f->free_events.head = f->event[number].next;
    f->event[number] = *e;
    dx_ring_push(&f->to_loop, number);
    return true;
}

/*
 * Publishes what waits. Events run out only when the loop is that many behind; then what waits
 * stays, merges with what comes (an epoch with the next one), and goes out when the loop kicks.
 */
static void flush(struct dx_feed *f)
{
    struct dx_feed_outbox *o = &f->out;
    bool had = o->has_reset || o->has_epoch || o->has_state;

    if (o->open || !had)
        return;
    if (o->has_reset && push_event(f, &o->reset))
        o->has_reset = false;
    if (o->has_epoch && !o->has_reset) {
        o->epoch.first_chunk = o->first;
        if (push_event(f, &o->epoch)) {
            o->has_epoch = false;
            o->first = o->last = DX_FEED_NONE;
        }
    }
    if (o->has_state && !o->has_reset && !o->has_epoch && push_event(f, &o->state))
        o->has_state = false;
    if (o->has_reset || o->has_epoch || o->has_state)
        starve(f);
    else
        wake(f);
}

void dx_feed_wanted(struct dx_feed *f, uint32_t generation[DX_N_FORMS])
{
    reclaim(f);
    flush(f);
    /* acquire: pairs with the loop's release; a generation carries no other data */
    for (int e = 0; e < DX_N_FORMS; e++)
        generation[e] = atomic_load_explicit(&f->wanted[e], memory_order_acquire);
}

struct dx_lod_level dx_feed_level(const struct dx_feed *f, unsigned slot)
{
    /* relaxed: the generation that asks for it was read with acquire, and written after it */
    const uint32_t packed = atomic_load_explicit(&f->level[slot], memory_order_relaxed);

    return (struct dx_lod_level){(uint16_t)packed, (uint8_t)(packed >> 16)};
}

void dx_feed_begin(struct dx_feed *f, uint64_t epoch, const uint32_t generation[DX_N_FORMS])
{
    struct dx_feed_outbox *o = &f->out;

    assert(!o->open);
    reclaim(f);
    flush(f);
    o->open = true;
    o->open_epoch = epoch;
    memcpy(o->open_generation, generation, sizeof(o->open_generation));
    o->mark = o->last;
}

static void take_blocks(struct dx_feed *f, struct dx_feed_chunk *c)
{
    c->first = c->last = DX_FEED_NONE;
    for (uint32_t k = 0; k < c->n_blocks; k++) {
        uint32_t block = take_block(f);

        if (k == 0)
            c->first = block;
        else
            f->next_block[c->last] = block;
        c->last = block;
    }
}

static bool has_room(const struct dx_feed *f, size_t n_blocks)
{
    return f->free_chunks.n > f->keep_chunks && f->free_blocks.n >= f->keep_blocks + n_blocks;
}

bool dx_feed_add(struct dx_feed *f, uint32_t tile, unsigned form, size_t len, uint32_t *chunk)
{
    struct dx_feed_outbox *o = &f->out;
    bool empty = len == DX_CHUNK_HEADER_LEN;
    size_t n_blocks = empty ? 0 : (len + DX_FEED_BLOCK_LEN - 1) / DX_FEED_BLOCK_LEN;
    struct dx_feed_chunk *c;
    uint32_t number;

    assert(o->open && tile < f->max_tiles && form < DX_N_FORMS);
    if (!has_room(f, n_blocks))
        reclaim(f);
    if (!has_room(f, n_blocks))
        return false;
    number = take_chunk(f);
    c = &f->chunk[number];
    c->n_blocks = (uint32_t)n_blocks;
    c->len = (uint32_t)len;
    c->tile = tile;
    c->form = form;
    c->generation = o->open_generation[form];
    c->epoch = o->open_epoch;
    c->next = DX_FEED_NONE;
    take_blocks(f, c);
    if (o->last == DX_FEED_NONE)
        o->first = number;
    else
        f->chunk[o->last].next = number;
    o->last = number;
    *chunk = number;
    return true;
}

void dx_feed_fill(struct dx_feed *f, uint32_t chunk, const uint8_t *body)
{
    const struct dx_feed_chunk *c = &f->chunk[chunk];
    uint32_t block = c->first;

    for (uint32_t k = 0, at = 0; k < c->n_blocks; k++, at += DX_FEED_BLOCK_LEN) {
        const uint32_t left = c->len - at;

        memcpy(dx_feed_block(f, block), body + at,
               left < DX_FEED_BLOCK_LEN ? left : DX_FEED_BLOCK_LEN);
        block = f->next_block[block];
    }
}

void dx_feed_commit(struct dx_feed *f, const struct dx_msg_commit *commit,
                    const struct dx_passage *passage)
{
    struct dx_feed_outbox *o = &f->out;

    assert(o->open);
    o->open = false;
    o->has_epoch = true;
    o->epoch.kind = DX_FEED_COMMIT;
    o->epoch.epoch = o->open_epoch;
    o->epoch.commit = *commit;
    o->epoch.passage = passage ? *passage : (struct dx_passage){0};
    memcpy(o->epoch.generation, o->open_generation, sizeof(o->epoch.generation));
    flush(f);
}

/* Frees the list of chunks that begins with `number`. */
static void free_list(struct dx_feed *f, uint32_t number)
{
    while (number != DX_FEED_NONE) {
        uint32_t next = f->chunk[number].next;

        free_chunk(f, number);
        number = next;
    }
}

void dx_feed_abort(struct dx_feed *f)
{
    struct dx_feed_outbox *o = &f->out;

    assert(o->open);
    o->open = false;
    if (o->mark == DX_FEED_NONE) {
        free_list(f, o->first);
        o->first = DX_FEED_NONE;
    } else {
        free_list(f, f->chunk[o->mark].next);
        f->chunk[o->mark].next = DX_FEED_NONE;
    }
    o->last = o->mark;
    flush(f);
    starve(f);
}

/* The arena has room for the largest grid; a smaller one gets no more memory than its own n_epochs.
 */
static void set_quota(struct dx_feed *f, const struct dx_geometry *g)
{
    struct dx_tiling tiling;
    uint32_t n_tiles;

    if (!f->n_epochs)
        return;
    dx_tiling_init(&tiling, g->height, g->width, g->wrap);
    n_tiles = f->max_tiles - dx_tiling_n_tiles(&tiling);
    f->keep_blocks = n_tiles * f->n_epochs * f->tile_blocks;
    f->keep_chunks = n_tiles * f->n_epochs * DX_N_FORMS;
}

void dx_feed_reset(struct dx_feed *f, struct dx_geometry *g, const struct dx_terrain_params *params,
                   uint8_t attr_bytes, const char *reason)
{
    struct dx_feed_outbox *o = &f->out;

    assert(!o->open);
    reclaim(f);
    flush(f);
    if (o->has_reset) /* nobody has seen that one, nor the epoch after it */
        dx_geometry_unref(o->reset.geometry);
    free_list(f, o->first);
    o->first = o->last = DX_FEED_NONE;
    o->has_epoch = false;
    o->has_reset = true;
    o->reset.kind = DX_FEED_RESET;
    o->reset.geometry = dx_geometry_ref(g);
    o->reset.params = *params;
    o->reset.attr_bytes = attr_bytes;
    strncpy(o->reset.reason, reason, sizeof(o->reset.reason) - 1);
    set_quota(f, g);
    flush(f);
}

void dx_feed_state(struct dx_feed *f, enum dx_stream_state state, const char *reason)
{
    struct dx_feed_outbox *o = &f->out;

    reclaim(f);
    o->has_state = true;
    o->state.kind = DX_FEED_STATE;
    o->state.state = state;
    strncpy(o->state.reason, reason ? reason : "", sizeof(o->state.reason) - 1);
    flush(f);
}

uint64_t dx_feed_lossless_epoch(const struct dx_feed *f)
{
    /* acquire: pairs with the loop's release; the value carries no other data */
    return atomic_load_explicit(&f->lossless_epoch, memory_order_acquire);
}
