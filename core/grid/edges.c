/* The first-order rule by rows, the rescue of what fails it, and the cap. */
#include "core/grid/edges.h"

#include "core/grid/cap.h"
#include "core/grid/rescue.h"

#include <string.h>

/* Where the loop is not sure: the integers. Returns whether any has failed. */
static bool settle_wide(struct dx_area *a, uint8_t failed[DX_ROWS_N], const uint8_t *unsure,
                        const struct dx_gates *gates, enum dx_edge e, uint32_t p)
{
    const struct dx_ends end = dx_edge_ends(e);
    const uint32_t *x = a->range[p + end.p0] + end.q0, *y = a->range[p + end.p1] + end.q1;
    const uint32_t *c = gates->per_dexel ? a->c[e][p] : &gates->c[e][dx_area_row(a, p)];
    bool any = false;

    for (uint32_t q = 0; q < DX_AREA; q++)
        if (unsure[q]) {
            a->joined[e][p][q] = dx_gates_pass(gates, x[q], y[q], c[gates->per_dexel ? q : 0]);
            failed[q] = !a->joined[e][p][q];
            any |= failed[q];
        }
    return any;
}

static bool join_wide(struct dx_area *a, uint8_t failed[DX_ROWS_N], const struct dx_gates *gates,
                      enum dx_edge e, uint32_t p)
{
    const struct dx_ends end = dx_edge_ends(e);
    const struct dx_row_wide_pair pair = {.x = a->range[p + end.p0] + end.q0,
                                          .y = a->range[p + end.p1] + end.q1,
                                          .t0 = gates->t0,
                                          .n2 = (double)gates->n2};
    uint8_t unsure[DX_ROWS_N];
    struct dx_row_joined any;

    if (gates->per_dexel)
        any = gates->rows->join_wide_each(a->joined[e][p], failed, unsure, &pair, a->c[e][p]);
    else
        any = gates->rows->join_wide(a->joined[e][p], failed, unsure, &pair,
                                     gates->c[e][dx_area_row(a, p)]);
    if (any.unsure)
        any.failed |= settle_wide(a, failed, unsure, gates, e, p);
    return any.failed;
}

static bool join_narrow(struct dx_area *a, uint8_t failed[DX_ROWS_N], const struct dx_gates *gates,
                        enum dx_edge e, uint32_t p)
{
    const struct dx_ends end = dx_edge_ends(e);
    const struct dx_row_pair pair = {.x = a->range16[p + end.p0] + end.q0,
                                     .y = a->range16[p + end.p1] + end.q1,
                                     .noise_x = a->noise[p + end.p0] + end.q0,
                                     .noise_y = a->noise[p + end.p1] + end.q1};

    if (gates->per_dexel)
        return gates->rows->join_each(a->joined[e][p], failed, &pair, a->c16[e][p]);
    return gates->rows->join(a->joined[e][p], failed, &pair,
                             (uint16_t)gates->c[e][dx_area_row(a, p)]);
}

/* The paper's rule: whatever is there. */
static void join_valid(struct dx_area *a, enum dx_edge e, uint32_t p)
{
    const struct dx_ends end = dx_edge_ends(e);
    const uint8_t *x = a->valid[p + end.p0] + end.q0, *y = a->valid[p + end.p1] + end.q1;

    for (uint32_t q = 0; q < DX_AREA; q++)
        a->joined[e][p][q] = x[q] & y[q];
}

/* A row of edges: joined[e][p][q] is that of cell (p, q). */
static void join_row(struct dx_area *a, const struct dx_gates *gates, const struct dx_geometry *g,
                     enum dx_edge e, uint32_t p)
{
    uint8_t failed[DX_ROWS_N] = {0};

    if (!gates->first_order)
        join_valid(a, e, p);
    else if ((gates->wide ? join_wide : join_narrow)(a, failed, gates, e, p) && gates->rescue)
        dx_rescue_row(a, failed, gates, g, e, p);
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
            join_row(a, gates, g, e, p);
            if (gates->cap)
                dx_cap_row(a, gates, e, p);
        }
}
