/* The first-order rule by rows, the rescue of what fails it, and the cap. */
#include "core/grid/edges.h"

#include "core/grid/cap.h"
#include "core/grid/rescue.h"

#include <string.h>

/* Noise terms of the rows of a cell's upper and lower corners, by area row & 3. They are made a row
 * before they are read: a load across two stores waits until they are done. */
struct noise {
    uint16_t row[4][DX_AREA_STRIDE];
};

static void fill_noise(struct noise *n, const struct dx_area *a, const struct dx_gates *gates,
                       uint32_t p)
{
    if (gates->first_order && !gates->wide)
        gates->rows->noise(n->row[p & 3], a->range16[p], (uint16_t)gates->t0, (uint16_t)gates->n2);
}

static void join_narrow(dx_bits joined[DX_N_EDGES], const struct dx_area *a, const struct noise *n,
                        const struct dx_gates *gates, uint32_t p)
{
    const struct dx_row_pair rows = {a->range16[p], a->range16[p + 1], n->row[p & 3],
                                     n->row[(p + 1) & 3]};
    const uint16_t *each[DX_N_EDGES];
    uint16_t c[DX_N_EDGES];

    for (enum dx_edge e = 0; e < DX_N_EDGES; e++) {
        each[e] = a->c16[e][p];
        c[e] = gates->per_dexel ? 0 : (uint16_t)gates->c[e][dx_area_row(a, p)];
    }
    if (gates->per_dexel)
        gates->rows->join_each(joined, &rows, each);
    else
        gates->rows->join(joined, &rows, c);
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

static void join_wide(dx_bits joined[DX_N_EDGES], const struct dx_area *a,
                      const struct dx_gates *gates, uint32_t p)
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
        joined[e] = row[e].joined | settle_wide(a, there[e] & row[e].unsure, gates, e, p);
}

/* What the first order says of a row of edges, by their kinds: bit q is that of cell (p, q). Where
 * an end is missing, it may say either. */
static void join_row(struct dx_area *a, const struct noise *n, const struct dx_gates *gates,
                     uint32_t p)
{
    dx_bits joined[DX_N_EDGES];

    if (gates->wide)
        join_wide(joined, a, gates, p);
    else
        join_narrow(joined, a, n, gates, p);
    for (enum dx_edge e = 0; e < DX_N_EDGES; e++)
        dx_words_put(&a->joined[e], p, joined[e]);
}

static void join_first_order(struct dx_area *a, const struct dx_gates *gates,
                             const struct dx_geometry *g)
{
    struct noise noise = {0};

    fill_noise(&noise, a, gates, a->first);
    fill_noise(&noise, a, gates, a->first + 1);
    for (uint32_t p = a->first; p < a->end; p++) {
        if (p + 2 < a->end) /* the last row that is read has none below it */
            fill_noise(&noise, a, gates, p + 2);
        if (a->row0 + p >= 0 && a->row0 + p < g->height)
            join_row(a, &noise, gates, p);
    }
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
