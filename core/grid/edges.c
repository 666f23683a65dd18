/* The first-order rule by rows, the rescue of what fails it, and the cap. */
#include "core/grid/edges.h"

#include "core/grid/rescue.h"

#include <string.h>

static void join_wide(uint8_t *out, const uint32_t *x, const uint32_t *y, const uint32_t *c,
                      uint32_t step, const struct dx_gates *gates)
{
    for (uint32_t q = 0; q < DX_AREA; q++)
        out[q] = x[q] && y[q] && dx_gates_pass(gates, x[q], y[q], c[q * step]);
}

static void join_narrow(struct dx_area *a, const struct dx_gates *gates, enum dx_edge e, uint32_t p)
{
    const struct dx_ends end = dx_edge_ends(e);
    const struct dx_row_pair pair = {.x = a->range16[p + end.p0] + end.q0,
                                     .y = a->range16[p + end.p1] + end.q1,
                                     .noise_x = a->noise[p + end.p0] + end.q0,
                                     .noise_y = a->noise[p + end.p1] + end.q1};

    if (gates->per_dexel)
        gates->rows->join_each(a->joined[e][p], &pair, a->c16[e][p]);
    else
        gates->rows->join(a->joined[e][p], &pair, (uint16_t)gates->c[e][dx_area_row(a, p)]);
}

static void join_valid(uint8_t *out, const uint8_t *x, const uint8_t *y)
{
    for (uint32_t q = 0; q < DX_AREA; q++)
        out[q] = x[q] & y[q];
}

/* A row of edges: joined[e][p][q] is that of cell (p, q). */
static void join_row(struct dx_area *a, const struct dx_gates *gates, enum dx_edge e, uint32_t p)
{
    const struct dx_ends end = dx_edge_ends(e);

    if (!gates->first_order)
        join_valid(a->joined[e][p], a->valid[p + end.p0] + end.q0, a->valid[p + end.p1] + end.q1);
    else if (gates->wide)
        join_wide(a->joined[e][p], a->range[p + end.p0] + end.q0, a->range[p + end.p1] + end.q1,
                  gates->per_dexel ? a->c[e][p] : &gates->c[e][dx_area_row(a, p)], gates->per_dexel,
                  gates);
    else
        join_narrow(a, gates, e, p);
}

static void cap_row(struct dx_area *a, const struct dx_gates *gates, enum dx_edge e, uint32_t p)
{
    const struct dx_ends end = dx_edge_ends(e);
    uint8_t *edge = a->joined[e][p];

    for (uint32_t q = 0; q < DX_AREA; q++)
        if (edge[q])
            edge[q] = dx_area_within_cap(a, gates, p + end.p0, q + end.q0, p + end.p1, q + end.q1);
}

void dx_edges_join(struct dx_area *a, const struct dx_gates *gates, const struct dx_geometry *g)
{
    for (uint32_t p = a->first; p < a->end; p++)
        for (enum dx_edge e = 0; e < DX_N_EDGES; e++) {
            int64_t row = a->row0 + p;

            /* the last row that is read has no row below it: only H edges */
            if (row < 0 || row >= g->height || (e != DX_EDGE_H && p + 1 == a->end)) {
                memset(a->joined[e][p], 0, sizeof(a->joined[e][p]));
                continue;
            }
            join_row(a, gates, e, p);
            if (gates->rescue)
                dx_rescue_row(a, gates, g, e, p);
            if (gates->cap)
                cap_row(a, gates, e, p);
        }
}
