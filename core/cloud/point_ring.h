/*
 * Rings: for each unfinished point its neighbours in the mesh, as chains. A chain is a run of
 * neighbours to the left around the point, one triangle for each two that follow each other; its
 * first and last are the ends of boundary edges. These rings are all that is remembered of the
 * triangles (Gopi and Krishnan 2002, section 6). Owned by one thread.
 *
 * A ring is a handle into one arena; a freed one is used again for the next of its size, so that
 * the arena follows the front and not the mesh.
 */
#ifndef DX_POINT_RING_H
#define DX_POINT_RING_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define DX_RING_MAX       256 /* neighbours of a point, at most */
#define DX_RING_N_CLASSES 6   /* 8, 16 .. 256 of them */
#define DX_RING_FIRST     (1u << 31)

struct dx_rings {
    uint32_t *words;
    size_t n, cap;
    uint32_t free_list[DX_RING_N_CLASSES];
    uint32_t n_used, n_peak; /* rings */
    size_t peak_len;         /* bytes of the arena that were ever used */
};

/* Positive results of dx_ring_add. */
enum { DX_RING_OPEN = 0, DX_RING_CLOSED = 1 };

void dx_rings_init(struct dx_rings *r);
void dx_rings_fini(struct dx_rings *r);

/* Whether triangle (point, a, b) fits: its edges are not there in this direction, and the ring is
 * not closed while other triangles would remain. Handle 0 is the empty ring. */
bool dx_ring_fits(const struct dx_rings *r, uint32_t ring, uint32_t a, uint32_t b);

/* Adds triangle (point, a, b), which fits. DX_RING_CLOSED: it was the last. Errors: -ENOMEM. */
int dx_ring_add(struct dx_rings *r, uint32_t *ring, uint32_t a, uint32_t b);

/* *ring becomes 0. */
void dx_ring_free(struct dx_rings *r, uint32_t *ring);

/* Neighbours as stored, with DX_RING_FIRST set in the first of each chain. */
static inline uint32_t dx_ring_n(const struct dx_rings *r, uint32_t ring)
{
    return ring ? r->words[ring] & 0xffff : 0;
}

/* Chains: more than one are several fans of triangles that meet in the point. */
uint32_t dx_ring_n_chains(const struct dx_rings *r, uint32_t ring);

static inline const uint32_t *dx_ring_list(const struct dx_rings *r, uint32_t ring)
{
    return ring ? r->words + ring + 1 : NULL;
}

#endif
