/*
 * The ring of raw blocks. head and tail count bytes for ever; an entry starts at a multiple of
 * ALIGN and never wraps: what is left at the end of the memory is skipped by an entry of kind SKIP.
 */
#include "daemon/block_ring.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#define ALIGN 32
#define PAGE  4096
#define SKIP  0

/* Before each entry. */
struct lead {
    uint64_t len; /* of all of it, with this and padding */
    uint64_t host_ns;
    uint32_t n_bytes;
    uint16_t kind;
    uint8_t starts_block, starts_frame;
    uint64_t reserved;
};

_Static_assert(sizeof(struct lead) == ALIGN, "a skip of one unit must hold its lead");

/* A put under way: nothing of it is seen before publish(). */
struct put {
    struct dx_block_ring *r;
    uint64_t tail, end; /* up to where there is room */
};

int dx_block_ring_init(struct dx_block_ring *r, size_t cap)
{
    size_t size = PAGE;

    *r = (struct dx_block_ring){0};
    while (size < cap && size < SIZE_MAX / 4)
        size <<= 1;
    if (posix_memalign((void **)&r->bytes, PAGE, size) != 0)
        return -ENOMEM;
    r->cap = size;
    return 0;
}

void dx_block_ring_populate(struct dx_block_ring *r)
{
    (void)madvise(r->bytes, r->cap, MADV_POPULATE_WRITE);
}

void dx_block_ring_fini(struct dx_block_ring *r)
{
    struct dx_ring_entry e;

    while (r->bytes && dx_block_ring_peek(r, &e)) {
        struct dx_ring_geometry g;

        if (e.kind == DX_RING_GEOMETRY) {
            memcpy(&g, e.bytes, sizeof(g));
            dx_geometry_unref(g.geometry);
        }
        dx_block_ring_pop(r);
    }
    dx_geometry_unref(r->waits.geometry);
    free(r->bytes);
    *r = (struct dx_block_ring){0};
}

/* ---- producer --------------------------------------------------------------------------------
 */

static struct put put_begin(struct dx_block_ring *r)
{
    /* acquire: the consumer has read what it popped before it is written again */
    uint64_t head = atomic_load_explicit(&r->head, memory_order_acquire);

    return (struct put){r, atomic_load_explicit(&r->tail, memory_order_relaxed), head + r->cap};
}

/* Room for an entry of n bytes, its lead written; NULL: none. */
static uint8_t *put_room(struct put *p, const struct lead *lead)
{
    uint64_t len = (sizeof(*lead) + lead->n_bytes + ALIGN - 1) / ALIGN * ALIGN;
    size_t at = (size_t)(p->tail & (p->r->cap - 1)), left = p->r->cap - at;
    uint64_t skip = len > left ? left : 0;
    struct lead whole = *lead;
    uint8_t *to;

    if (skip + len > p->end - p->tail)
        return NULL;
    if (skip) {
        const struct lead skipped = {.len = skip, .kind = SKIP};

        memcpy(p->r->bytes + at, &skipped, sizeof(skipped));
        at = 0;
    }
    whole.len = len;
    to = p->r->bytes + at;
    memcpy(to, &whole, sizeof(whole));
    p->tail += skip + len;
    return to + sizeof(whole);
}

static bool put_small(struct put *p, enum dx_ring_kind kind, const void *bytes, size_t len)
{
    const struct lead lead = {.kind = (uint16_t)kind, .n_bytes = (uint32_t)len};
    uint8_t *to = put_room(p, &lead);

    if (to)
        memcpy(to, bytes, len);
    return to != NULL;
}

static void publish(struct put *p)
{
    /* release: the entries are visible before the tail */
    atomic_store_explicit(&p->r->tail, p->tail, memory_order_release);
}

static bool put_pieces(struct put *p, const struct dx_block *block, bool starts_frame)
{
    size_t offset = 0;

    do {
        struct dx_recording_piece piece = dx_recording_piece_of(block, starts_frame, offset);
        const struct lead lead = {.host_ns = block->stamp.host_ns,
                                  .n_bytes = (uint32_t)dx_recording_piece_len(&piece),
                                  .kind = DX_RING_PIECE,
                                  .starts_block = offset == 0,
                                  .starts_frame = starts_frame};
        uint8_t *to = put_room(p, &lead);

        if (!to)
            return false;
        dx_recording_put_piece(to, &piece);
        offset += piece.len;
    } while (offset < block->len);
    return true;
}

bool dx_block_ring_put(struct dx_block_ring *r, const struct dx_block *block, bool starts_frame)
{
    struct put p = put_begin(r);
    bool fits = block->len <= r->cap && block->len <= DX_RECORDING_MAX_BLOCK;

    if (fits && r->waits.geometry)
        fits = put_small(&p, DX_RING_GEOMETRY, &r->waits, sizeof(r->waits));
    if (fits && r->gap.n)
        fits = put_small(&p, DX_RING_GAP, &r->gap, sizeof(r->gap));
    if (fits && put_pieces(&p, block, starts_frame)) {
        publish(&p);
        r->gap.n = 0;
        r->waits.geometry = NULL;
        return true;
    }
    if (r->gap.n++ == 0) {
        r->gap.first = block->number;
        r->gap.from_ns = block->stamp.host_ns;
    }
    r->gap.to_ns = block->stamp.host_ns;
    return false;
}

void dx_block_ring_put_geometry(struct dx_block_ring *r, const struct dx_ring_geometry *told)
{
    struct put p = put_begin(r);

    dx_geometry_ref(told->geometry);
    dx_geometry_unref(r->waits.geometry); /* it was in force for no block that was put */
    r->waits.geometry = NULL;
    if (put_small(&p, DX_RING_GEOMETRY, told, sizeof(*told)))
        publish(&p);
    else
        r->waits = *told;
}

/* ---- consumer --------------------------------------------------------------------------------
 */

bool dx_block_ring_peek(struct dx_block_ring *r, struct dx_ring_entry *out)
{
    uint64_t head = atomic_load_explicit(&r->head, memory_order_relaxed);
    const uint8_t *at;
    struct lead lead;

    /* acquire: pairs with publish() */
    if (atomic_load_explicit(&r->tail, memory_order_acquire) == head)
        return false;
    at = r->bytes + (head & (r->cap - 1));
    memcpy(&lead, at, sizeof(lead));
    if (lead.kind == SKIP) { /* what was published ends in a real entry: one follows */
        dx_block_ring_pop(r);
        at = r->bytes;
        memcpy(&lead, at, sizeof(lead));
    }
    *out = (struct dx_ring_entry){.kind = (enum dx_ring_kind)lead.kind,
                                  .starts_block = lead.starts_block,
                                  .starts_frame = lead.starts_frame,
                                  .host_ns = lead.host_ns,
                                  .bytes = at + sizeof(lead),
                                  .len = lead.n_bytes};
    return true;
}

void dx_block_ring_pop(struct dx_block_ring *r)
{
    uint64_t head = atomic_load_explicit(&r->head, memory_order_relaxed);
    struct lead lead;

    memcpy(&lead, r->bytes + (head & (r->cap - 1)), sizeof(lead));
    /* release: the entry has been read before the producer may write there again */
    atomic_store_explicit(&r->head, head + lead.len, memory_order_release);
}

size_t dx_block_ring_used(const struct dx_block_ring *r)
{
    /* head first: it never passes the tail that is read after it */
    uint64_t head = atomic_load_explicit(&r->head, memory_order_acquire);

    return (size_t)(atomic_load_explicit(&r->tail, memory_order_acquire) - head);
}
