/* The first-order rule by rows, the rescue of what fails it, and the cap. */
#include "core/grid/edges.h"

#include "core/grid/cap.h"
#include "core/grid/rescue.h"

#include <string.h>

static void join_narrow(struct dx_area *a, const struct dx_gates *gates, struct dx_row_run run)
{
    const uint16_t *each[DX_AREA][DX_N_EDGES];
    uint16_t c[DX_AREA][DX_N_EDGES];
    const struct dx_row_first_order rows = {.run = run,
                                            .range = a->range16,
                                            .t0 = (uint16_t)gates->t0,
                                            .n2 = (uint16_t)gates->n2,
                                            .c = c,
                                            .each = gates->per_dexel ? each : NULL};

    for (uint32_t p = run.first; p < run.end; p++)
        for (enum dx_edge e = 0; e < DX_N_EDGES; e++) {
            each[p][e] = a->c16[e][p];
            c[p][e] = gates->per_dexel ? 0 : (uint16_t)gates->c[e][dx_area_row(a, p)];
        }
    gates->rows->join(a->joined, &rows);
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

static void join_wide_row(struct dx_area *a, const struct dx_gates *gates, uint32_t p)
{
    const dx_bits here = dx_words_at(&a->valid, p), below = dx_words_at(&a->valid, p + 1);
    const struct dx_row_wide_pair rows = {a->range[p], a->range[p + 1], gates->t0,
                                          (double)gates->n2};
    struct dx_row_joined row[DX_N_EDGES];
    const uint32_t *each[DX_N_EDGES];
    uint32_t c[DX_N_EDGES];
    dx_bits there[DX_N_EDGES];

    dx_edges_both(there, here, below);
    for (enum dx_edge e = 0; e < DX_N_EDGES; e++) {
        each[e] = a->c[e][p];
        c[e] = gates->per_dexel ? 0 : gates->c[e][dx_area_row(a, p)];
    }
    if (gates->per_dexel)
        gates->rows->join_wide_each(row, &rows, each);
    else
        gates->rows->join_wide(row, &rows, c);
    for (enum dx_edge e = 0; e < DX_N_EDGES; e++)
        dx_words_put(&a->joined[e], p,
                     row[e].joined | settle_wide(a, there[e] & row[e].unsure, gates, e, p));
}

/* What the first order says of the edges of the rows that are in the grid, by their kinds: bit q is
 * that of cell (p, q). Where an end is missing, it may say either. */
static void join_first_order(struct dx_area *a, const struct dx_gates *gates,
                             const struct dx_geometry *g)
{
    struct dx_row_run run = {a->first, a->end};

    run.first = a->row0 + run.first < 0 ? (uint32_t)-a->row0 : run.first;
    run.end = a->row0 + run.end > g->height ? (uint32_t)(g->height - a->row0) : run.end;
    if (!gates->wide)
        join_narrow(a, gates, run);
    for (uint32_t p = run.first; gates->wide && p < run.end; p++)
        join_wide_row(a, gates, p);
}

static void rescue_row(struct dx_area *a, const struct dx_row_words failed[DX_N_EDGES],
                       const struct dx_gates *gates, const struct dx_geometry *g, uint32_t p)
{
    for (enum dx_edge e = 0; e < DX_N_EDGES; e++) {
        const dx_bits row = dx_words_at(&failed[e], p);

        if (row)
            dx_words_put(&a->joined[e], p,
                         dx_words_at(&a->joined[e], p) | dx_rescue_row(a, row, gates, g, e, p));
    }
}

void dx_edges_join(struct dx_area *a, const struct dx_gates *gates, const struct dx_geometry *g)
{
    struct dx_row_words failed[DX_N_EDGES];
    uint64_t some_failed[DX_WORDS_ROWS];

    if (gates->first_order)
        join_first_order(a, gates, g);
    else /* in the paper's mode whatever is there is joined */
        memset(a->joined, 0xff, sizeof(a->joined));
    gates->rows->rules.join_there(a->joined, failed, some_failed, &a->valid);
    for (uint32_t p = a->first; gates->rescue && p < a->end; p++)
        if (some_failed[p])
            rescue_row(a, failed, gates, g, p);
    for (uint32_t p = a->first; gates->cap && p < a->end; p++)
        for (enum dx_edge e = 0; e < DX_N_EDGES; e++)
            if (dx_words_at(&a->joined[e], p))
                dx_cap_row(a, gates, e, p);
}
