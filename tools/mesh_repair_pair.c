/* Which two triangles at an edge are one surface. */
#include "tools/mesh_repair_priv.h"

#include <math.h>
#include <string.h>

#define MAX_FAN 64 /* triangles at an edge whose pairs are compared; of more, in their order */

/* The part of a triangle's third vertex, seen from the edge a-b, that is across it; unit length. */
static void across(double u[3], const float *a, const float *b, const float *c)
{
    double e[3], len2 = 0, dot = 0, len = 0;

    for (int k = 0; k < 3; k++) {
        e[k] = (double)b[k] - (double)a[k];
        u[k] = (double)c[k] - (double)a[k];
        len2 += e[k] * e[k];
        dot += e[k] * u[k];
    }
    for (int k = 0; k < 3; k++) {
        u[k] -= len2 > 0 ? dot / len2 * e[k] : 0;
        len += u[k] * u[k];
    }
    len = sqrt(len);
    for (int k = 0; k < 3; k++)
        u[k] = len > 0 ? u[k] / len : 0;
}

static void marry(uint32_t *mate, uint32_t a, uint32_t b)
{
    mate[a] = b;
    mate[b] = a;
}

/* The best pair first, then of what is left: those that run against each other before others, then
 * the straightest (the least cosine of the angle between them), then the lowest numbers. */
static void pair_fan(uint32_t *mate, const struct dx_mesh *mesh, const struct dx_edge_run *run)
{
    const uint32_t ends[2] = {run->low, run->edge->high};
    double u[MAX_FAN][3];

    for (uint32_t k = 0; k < run->n; k++) {
        const uint32_t c = run->edge[k].corner,
                       third = mesh->index[dx_corner_next(dx_corner_next(c))];

        across(u[k], mesh->xyz + 3 * (size_t)ends[0], mesh->xyz + 3 * (size_t)ends[1],
               mesh->xyz + 3 * (size_t)third);
    }
    for (uint32_t left = run->n; left > 1; left -= 2) {
        uint32_t best[2] = {0, 0};
        double least = INFINITY;

        for (uint32_t i = 0; i < run->n; i++)
            for (uint32_t j = i + 1; j < run->n; j++) {
                const uint32_t a = run->edge[i].corner, b = run->edge[j].corner;
                const double cosine = u[i][0] * u[j][0] + u[i][1] * u[j][1] + u[i][2] * u[j][2];
                const double cost = mesh->index[a] == mesh->index[b] ? cosine + 4 : cosine;

                if (mate[a] != DX_REPAIR_NONE || mate[b] != DX_REPAIR_NONE || !(cost < least))
                    continue;
                least = cost;
                best[0] = a;
                best[1] = b;
            }
        if (isinf(least)) /* no number, of coordinates too large to be squared */
            return;
        marry(mate, best[0], best[1]);
    }
}

uint32_t dx_repair_pair(uint32_t *mate, const struct dx_mesh *mesh,
                        const struct dx_mesh_edges *edges)
{
    struct dx_edge_run run = {0};
    uint32_t n_nonmanifold = 0;

    memset(mate, 0xff, 3 * (size_t)mesh->n_triangles * sizeof(*mate));
    while (dx_mesh_edges_next(edges, &run)) {
        n_nonmanifold += run.n > 2;
        if (run.n == 2)
            marry(mate, run.edge[0].corner, run.edge[1].corner);
        else if (run.n > MAX_FAN)
            for (uint32_t k = 1; k < run.n; k += 2)
                marry(mate, run.edge[k - 1].corner, run.edge[k].corner);
        else if (run.n > 2)
            pair_fan(mate, mesh, &run);
    }
    return n_nonmanifold;
}
