/* The choice of diagonals: rows of cells by the loops of core/rows, single ones in integers. */
#include "core/grid/diagonal.h"

#include "core/grid/rescue.h"

#include <math.h>
#include <string.h>

/* b-d must bend less by 4 sigma; both bends are halved here. The same bias on a difference of two
 * ranges is 4 sqrt2 sigma. */
#define BIAS_SHIFT  17   /* of the noise: from 1/256 to 2^-24, times two */
#define BIAS_RANGES 1448 /* 256 * 4 sqrt2 */

/* ---- one cell, in integers ------------------------------------------------------------------ */

static uint32_t difference(uint32_t x, uint32_t y)
{
    return x < y ? y - x : x - y;
}

static uint64_t magnitude(int64_t x)
{
    return (uint64_t)(x < 0 ? -x : x);
}

/* Adds the residual of dexel (p,q) on its line of direction e; false: it has none. */
static bool add_residual(int64_t *sum, const struct dx_area *a, const struct dx_gates *gates,
                         const struct dx_geometry *g, enum dx_edge e, uint32_t p, uint32_t q)
{
    const struct dx_step s = dx_line_step(e);
    const uint64_t before = dx_area_inverse(a, p - s.row, q - s.col);
    const uint64_t here = dx_area_inverse(a, p, q);
    const uint64_t after = dx_area_inverse(a, p + s.row, q + s.col);
    struct dx_line line;

    if (!before || !here || !after)
        return false;
    line = dx_gates_line(gates, g->width, e, dx_area_row(a, p), dx_area_col(a, q, g->width));
    *sum += dx_line_residual(before, here, after, line);
    return (line.minus | line.plus) != 0;
}

/*
 * Whether `ac` is greater than `bd` by more than noise << BIAS_SHIFT, noise = floor(product /
 * range), without the division: greater than a floor by an integer is at least one more than it.
 */
static bool bends_more(int64_t ac, int64_t bd, uint64_t product, uint32_t range)
{
    int64_t more = (int64_t)(magnitude(ac) - magnitude(bd));
    uint64_t steps = ((uint64_t)(more - 1) >> BIAS_SHIFT) + 1;

    return (more > 0) & ((unsigned __int128)steps * range > product);
}

/* Without samples beyond the corners: the ranges of the corners, with the same bias. */
static bool prefer_corners(const struct dx_area *a, const struct dx_gates *gates, uint32_t p,
                           uint32_t q)
{
    const uint32_t top[2] = {dx_area_range(a, p, q), dx_area_range(a, p, q + 1)};
    const uint32_t bottom[2] = {dx_area_range(a, p + 1, q), dx_area_range(a, p + 1, q + 1)};
    uint32_t upper = top[0] < top[1] ? top[0] : top[1];
    uint32_t lower = bottom[0] < bottom[1] ? bottom[0] : bottom[1];
    uint64_t sigma = dx_sigma_at(&gates->sigma, upper < lower ? upper : lower);

    return difference(top[0], bottom[1]) >
           difference(top[1], bottom[0]) + (sigma * BIAS_RANGES >> 16);
}

/* Whether a cell is joined to the four samples beyond its corners. */
static bool has_outer(const struct dx_area *a, uint32_t p, uint32_t q)
{
    return dx_bits_at(dx_words_at(&a->joined[DX_EDGE_AC], p - 1), q - 1) &&
           dx_bits_at(dx_words_at(&a->joined[DX_EDGE_AC], p + 1), q + 1) &&
           dx_bits_at(dx_words_at(&a->joined[DX_EDGE_BD], p - 1), q + 1) &&
           dx_bits_at(dx_words_at(&a->joined[DX_EDGE_BD], p + 1), q - 1);
}

/* The same of a row of cells. */
static uint64_t find_outer(const struct dx_area *a, uint32_t p)
{
    const dx_bits ac = dx_words_at(&a->joined[DX_EDGE_AC], p - 1) << 1 &
                       dx_words_at(&a->joined[DX_EDGE_AC], p + 1) >> 1;
    const dx_bits bd = dx_words_at(&a->joined[DX_EDGE_BD], p - 1) >> 1 &
                       dx_words_at(&a->joined[DX_EDGE_BD], p + 1) << 1;

    return dx_area_own(ac & bd);
}

/* Rows that diagonal lines go through: not the grid's first and last. */
static bool has_lines(const struct dx_area *a, const struct dx_geometry *g, uint32_t p)
{
    return a->row0 + p >= 1 && a->row0 + p + 1 < g->height;
}

bool dx_diagonal_decide(const struct dx_area *a, const struct dx_gates *gates,
                        const struct dx_geometry *g, uint32_t p, uint32_t q)
{
    const uint32_t range = dx_area_range(a, p, q);
    int64_t ac = 0, bd = 0;

    if (gates->diag == DX_DIAG_FIXED)
        return false;
    if (gates->diag == DX_DIAG_SHORT)
        return difference(dx_area_range(a, p, q + 1), dx_area_range(a, p + 1, q)) <
               difference(range, dx_area_range(a, p + 1, q + 1));
    if (has_outer(a, p, q) && has_lines(a, g, p) && has_lines(a, g, p + 1) &&
        add_residual(&ac, a, gates, g, DX_EDGE_AC, p, q) &&
        add_residual(&ac, a, gates, g, DX_EDGE_AC, p + 1, q + 1) &&
        add_residual(&bd, a, gates, g, DX_EDGE_BD, p, q + 1) &&
        add_residual(&bd, a, gates, g, DX_EDGE_BD, p + 1, q))
        return bends_more(ac, bd, dx_sigma_at(&gates->sigma, range) * dx_area_inverse(a, p, q),
                          range);
    return prefer_corners(a, gates, p, q);
}

/* ---- rows ----------------------------------------------------------------------------------- */

static const struct dx_row_bends *loops(const struct dx_area *a, const struct dx_gates *gates)
{
    return a->wide ? &gates->rows->wide : &gates->rows->narrow;
}

/* From one column before the first cell on. */
static void *inverse_of(struct dx_diagonal *d, const struct dx_area *a, uint32_t p)
{
    return a->wide ? (void *)d->inverse.wide[p & 7] : (void *)d->inverse.narrow[p & 7];
}

static const void *range_at(const struct dx_area *a, uint32_t p, uint32_t q)
{
    return a->wide ? (const void *)(a->range[p] + q) : (const void *)(a->range16[p] + q);
}

static void invert_row(struct dx_diagonal *d, const struct dx_area *a, const struct dx_gates *gates,
                       uint32_t p)
{
    loops(a, gates)->inverse(inverse_of(d, a, p), range_at(a, p, DX_MARGIN - 1));
}

static double weight(uint32_t w)
{
    return w * 0x1p-24; /* exact, in f32 too */
}

/* Where a dexel has no line, no number, and so no decision. */
static struct dx_row_weights weights_of(struct dx_line ac, struct dx_line bd)
{
    struct dx_row_weights w = {{weight(ac.minus), weight(ac.plus)},
                               {weight(bd.minus), weight(bd.plus)}};

    if (!(ac.minus | ac.plus))
        w.ac[0] = NAN;
    if (!(bd.minus | bd.plus))
        w.bd[0] = NAN;
    return w;
}

/* Of the lines through the corners in row p: of all of them, or of the row. */
static struct dx_row_weights *weigh_row(struct dx_diagonal *d, const struct dx_area *a,
                                        const struct dx_gates *gates, const struct dx_geometry *g,
                                        uint32_t p)
{
    struct dx_row_weights *out = d->weights[p & 1];
    const uint32_t row = dx_area_row(a, p), n = gates->per_dexel ? a->n_cols + 1 : 1;

    for (uint32_t j = 0; j < n; j++) {
        const size_t at = gates->per_dexel
                              ? (size_t)row * g->width + dx_area_col(a, DX_MARGIN + j, g->width)
                              : row;

        out[j] = weights_of(gates->line[DX_EDGE_AC][at], gates->line[DX_EDGE_BD][at]);
    }
    return out;
}

static struct dx_row_preference bend_row(struct dx_diagonal *d, const struct dx_area *a,
                                         const struct dx_gates *gates, const struct dx_geometry *g,
                                         uint32_t p)
{
    const bool lines = has_lines(a, g, p) && has_lines(a, g, p + 1);
    const struct dx_row_bend row = {.inverse = {inverse_of(d, a, p - 1), inverse_of(d, a, p),
                                                inverse_of(d, a, p + 1), inverse_of(d, a, p + 2)},
                                    .range = range_at(a, p, DX_MARGIN),
                                    .range_below = range_at(a, p + 1, DX_MARGIN),
                                    .top = d->weights[p & 1],
                                    .bottom = weigh_row(d, a, gates, g, p + 1),
                                    .outer = lines ? find_outer(a, p) : 0};
    const struct dx_row_bends *rows = loops(a, gates);

    return gates->per_dexel ? rows->bend_each(&row, &gates->row_sigma)
                            : rows->bend(&row, &gates->row_sigma);
}

void dx_diagonal_begin(struct dx_diagonal *d, const struct dx_area *a, const struct dx_gates *gates,
                       const struct dx_geometry *g)
{
    if (gates->diag != DX_DIAG_BEND)
        return;
    for (uint32_t p = DX_MARGIN - 1; p <= DX_MARGIN + 2; p++)
        invert_row(d, a, gates, p);
    weigh_row(d, a, gates, g, DX_MARGIN);
}

struct dx_row_preference dx_diagonal_row(struct dx_diagonal *d, const struct dx_area *a,
                                         const struct dx_gates *gates, const struct dx_geometry *g,
                                         uint32_t p)
{
    if (gates->diag != DX_DIAG_BEND)
        return (struct dx_row_preference){0, gates->diag != DX_DIAG_FIXED ? UINT64_MAX : 0};
    invert_row(d, a, gates, p + 3);
    return bend_row(d, a, gates, g, p);
}
