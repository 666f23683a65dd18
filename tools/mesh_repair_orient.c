/* Sides spread from a triangle to its mates, breadth first. */
#include "tools/mesh_repair_priv.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

enum side { UNSEEN, AS_IT_IS, TURNED };

struct work {
    struct dx_mesh *mesh;
    uint32_t *mate;
    uint8_t *side;   /* [n_triangles] */
    uint32_t *queue; /* [n_triangles] */
};

/* The side of a mate's triangle: the same when both edges run against each other. */
static uint8_t side_across(const struct work *w, uint32_t corner)
{
    const uint32_t *index = w->mesh->index, other = w->mate[corner];
    const bool against = index[corner] == index[dx_corner_next(other)] &&
                         index[dx_corner_next(corner)] == index[other];
    const uint8_t side = w->side[corner / 3];

    return against ? side : side == TURNED ? AS_IT_IS : TURNED;
}

/* From triangle t on; returns how many there are in the queue. */
static uint32_t spread(struct work *w, uint32_t t, uint32_t *n_cut)
{
    uint32_t n = 0;

    w->queue[n++] = t;
    w->side[t] = AS_IT_IS;
    for (uint32_t at = 0; at < n; at++)
        for (uint32_t k = 0; k < 3; k++) {
            const uint32_t corner = 3 * w->queue[at] + k, other = w->mate[corner];

            if (other == DX_REPAIR_NONE)
                continue;
            if (w->side[other / 3] == UNSEEN) {
                w->side[other / 3] = side_across(w, corner);
                w->queue[n++] = other / 3;
            } else if (w->side[other / 3] != side_across(w, corner)) {
                w->mate[corner] = w->mate[other] = DX_REPAIR_NONE;
                (*n_cut)++;
            }
        }
    return n;
}

/* The fewer are to be turned; as many of both: those that do not face as the first does. */
static uint32_t settle(struct work *w, uint32_t n)
{
    uint32_t n_turned = 0;

    for (uint32_t k = 0; k < n; k++)
        n_turned += w->side[w->queue[k]] == TURNED;
    if (2 * (uint64_t)n_turned <= n)
        return n_turned;
    for (uint32_t k = 0; k < n; k++)
        w->side[w->queue[k]] = w->side[w->queue[k]] == TURNED ? AS_IT_IS : TURNED;
    return n - n_turned;
}

/* Where an edge goes when its triangle is turned: corners 0 1 2 become 0 2 1. */
static uint32_t after_turn(const struct work *w, uint32_t corner)
{
    return w->side[corner / 3] == TURNED ? corner / 3 * 3 + 2 - corner % 3 : corner;
}

static int turn(struct work *w)
{
    const uint32_t n = 3 * w->mesh->n_triangles;
    uint32_t *mate = malloc(n * sizeof(*mate) + 1);

    if (!mate)
        return -ENOMEM;
    for (uint32_t c = 0; c < n; c++)
        mate[after_turn(w, c)] =
            w->mate[c] == DX_REPAIR_NONE ? DX_REPAIR_NONE : after_turn(w, w->mate[c]);
    memcpy(w->mate, mate, n * sizeof(*mate));
    free(mate);
    for (uint32_t t = 0; t < w->mesh->n_triangles; t++) {
        uint32_t *v = w->mesh->index + 3 * (size_t)t, swap = v[1];

        if (w->side[t] != TURNED)
            continue;
        v[1] = v[2];
        v[2] = swap;
    }
    return 0;
}

int dx_repair_orient(struct dx_mesh *mesh, uint32_t *mate, struct dx_mesh_repair *counts)
{
    const uint32_t n = mesh->n_triangles;
    struct work w = {mesh, mate, calloc((size_t)n + 1, 1), malloc(n * sizeof(*w.queue) + 1)};
    uint32_t n_turned = 0;
    int rc = w.side && w.queue ? 0 : -ENOMEM;

    for (uint32_t t = 0; rc == 0 && t < n; t++)
        if (w.side[t] == UNSEEN)
            n_turned += settle(&w, spread(&w, t, &counts->cut));
    if (rc == 0 && n_turned > 0)
        rc = turn(&w);
    counts->turned += n_turned;
    free(w.side);
    free(w.queue);
    return rc;
}
