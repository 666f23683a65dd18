/*
 * A ring of numbers between one producer and one consumer. Whoever sizes it guarantees that it is
 * never full: each number stands for a thing that is in one place at a time, and the ring has room
 * for all.
 */
#ifndef DX_RING_H
#define DX_RING_H

#include <errno.h>
#include <stdalign.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

struct dx_ring {
    uint32_t mask;
    uint32_t *slot;
    alignas(64) _Atomic uint32_t head; /* next to read; written by the consumer */
    alignas(64) _Atomic uint32_t tail; /* next to write; written by the producer */
};

static inline int dx_ring_init(struct dx_ring *r, uint32_t n_things)
{
    uint32_t size = 1;

    while (size < n_things && size < 1u << 31)
        size <<= 1;
    r->mask = size - 1;
    r->slot = calloc(size, sizeof(*r->slot));
    return r->slot ? 0 : -ENOMEM;
}

static inline void dx_ring_fini(struct dx_ring *r)
{
    free(r->slot);
}

static inline void dx_ring_push(struct dx_ring *r, uint32_t thing)
{
    uint32_t tail = atomic_load_explicit(&r->tail, memory_order_relaxed);

    r->slot[tail & r->mask] = thing;
    /* release: what the thing stands for, and the slot, are visible before the new tail */
    atomic_store_explicit(&r->tail, tail + 1, memory_order_release);
}

/* The oldest one, which stays; false when there is none. */
static inline bool dx_ring_peek(struct dx_ring *r, uint32_t *thing)
{
    uint32_t head = atomic_load_explicit(&r->head, memory_order_relaxed);

    /* acquire: pairs with the release in dx_ring_push */
    if (atomic_load_explicit(&r->tail, memory_order_acquire) == head)
        return false;
    *thing = r->slot[head & r->mask];
    return true;
}

static inline bool dx_ring_pop(struct dx_ring *r, uint32_t *thing)
{
    if (!dx_ring_peek(r, thing))
        return false;
    /* release: the slot has been read before the producer may write it again; the producer never
     * looks at head (the ring is never full), so this orders it only for whoever inspects the ring
     */
    atomic_store_explicit(&r->head, atomic_load_explicit(&r->head, memory_order_relaxed) + 1,
                          memory_order_release);
    return true;
}

#endif
