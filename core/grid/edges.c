/* The first-order rule by rows, the rescue of what fails it, and the cap. */
#include "core/grid/edges.h"

#include "core/grid/cap.h"
#include "core/grid/rescue.h"

/* Noise terms of the row of a cell's upper corners and of the one below, by area row & 1. */
struct noise {
    uint16_t row[2][DX_AREA_STRIDE];
};

static void fill_noise(struct noise *n, const struct dx_area *a, const struct dx_gates *gates,
                       uint32_t p)
{
    if (gates->first_order && !gates->wide)
        gates->rows->noise(n->row[p & 1], a->range16[p], (uint16_t)gates->t0, (uint16_t)gates->n2);
}

/* Where the loop is not sure of a pair that is there: the integers. */
static dx_bits settle_wide(const struct dx_area *a, dx_bits unsure, const struct dx_gates *gates,
                           enum dx_edge e, uint32_t p)
{
    const struct dx_ends end = dx_edge_ends(e);
    const uint32_t *x = a->range[p + end.p0] + end.q0, *y = a->range[p + end.p1] + end.q1;
    const uint32_t *c = gates->per_dexel ? a->c[e][p] : &gates->c[e][dx_area_row(a, p)];
    dx_bits joined = 0;

    for (; unsure; unsure &= unsure - 1) {
        const uint32_t q = dx_bits_first(unsure);

        joined |= (dx_bits)dx_gates_pass(gates, x[q], y[q], c[gates->per_dexel ? q : 0]) << q;
    }
    return joined;
}

static dx_bits join_wide(const struct dx_area *a, dx_bits there, const struct dx_gates *gates,
                         enum dx_edge e, uint32_t p)
{
    const struct dx_ends end = dx_edge_ends(e);
    const struct dx_row_wide_pair pair = {.x = a->range[p + end.p0] + end.q0,
                                          .y = a->range[p + end.p1] + end.q1,
                                          .t0 = gates->t0,
                                          .n2 = (double)gates->n2};
    struct dx_row_joined row;

    if (gates->per_dexel)
        row = gates->rows->join_wide_each(&pair, a->c[e][p]);
    else
        row = gates->rows->join_wide(&pair, gates->c[e][dx_area_row(a, p)]);
    return row.joined | settle_wide(a, there & row.unsure, gates, e, p);
}

static dx_bits join_narrow(const struct dx_area *a, const struct noise *n,
                           const struct dx_gates *gates, enum dx_edge e, uint32_t p)
{
    const struct dx_ends end = dx_edge_ends(e);
    const struct dx_row_pair pair = {.x = a->range16[p + end.p0] + end.q0,
                                     .y = a->range16[p + end.p1] + end.q1,
                                     .noise_x = n->row[(p + end.p0) & 1] + end.q0,
                                     .noise_y = n->row[(p + end.p1) & 1] + end.q1};

    if (gates->per_dexel)
        return gates->rows->join_each(&pair, a->c16[e][p]);
    return gates->rows->join(&pair, (uint16_t)gates->c[e][dx_area_row(a, p)]);
}

/* A row of edges: bit q is that of cell (p, q). In the paper's mode whatever is there is joined. */
static dx_bits join_row(const struct dx_area *a, const struct noise *n,
                        const struct dx_gates *gates, const struct dx_geometry *g, enum dx_edge e,
                        uint32_t p)
{
    const dx_bits there = dx_edge_both(e, a->valid[p], p + 1 < a->end ? a->valid[p + 1] : 0);
    dx_bits joined = there;

    if (gates->first_order)
        joined &= gates->wide ? join_wide(a, there, gates, e, p) : join_narrow(a, n, gates, e, p);
    if (joined != there && gates->rescue)
        joined |= dx_rescue_row(a, there & ~joined, gates, g, e, p);
    return joined;
}

void dx_edges_join(struct dx_area *a, const struct dx_gates *gates, const struct dx_geometry *g)
{
    struct noise noise = {0};

    fill_noise(&noise, a, gates, a->first);
    for (uint32_t p = a->first; p < a->end; p++) {
        const bool in_grid = a->row0 + p >= 0 && a->row0 + p < g->height;

        if (p + 1 < a->end) /* the last row that is read has none below it */
            fill_noise(&noise, a, gates, p + 1);
        for (enum dx_edge e = 0; e < DX_N_EDGES; e++) {
            a->joined[e][p] = in_grid ? join_row(a, &noise, gates, g, e, p) : 0;
            if (gates->cap && a->joined[e][p])
                dx_cap_row(a, gates, e, p);
        }
    }
}
