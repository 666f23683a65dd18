/* The choice of diagonals, a row of cells at a time. */
#include "core/grid/diagonal.h"

#include "core/grid/rescue.h"

#include <string.h>

/* b-d must bend less by 4 sigma; both bends are halved here. The same bias on a difference of two
 * ranges is 4 sqrt2 sigma. */
#define BIAS_SHIFT  17   /* of the noise: from 1/256 to 2^-24, times two */
#define BIAS_RANGES 1448 /* 256 * 4 sqrt2 */

static uint32_t difference(uint32_t x, uint32_t y)
{
    return x < y ? y - x : x - y;
}

static void prefer_short(uint8_t *restrict out, const struct dx_area *a, uint32_t p)
{
    const uint32_t *top = a->range[p], *bottom = a->range[p + 1];

    for (uint32_t q = DX_MARGIN; q < DX_MARGIN + DX_TILE_CELLS; q++)
        out[q] = difference(top[q + 1], bottom[q]) < difference(top[q], bottom[q + 1]);
}

/* Residuals of the two diagonal lines through dexel q of area row p. */
static inline void residual_at(struct dx_residuals *r, const struct dx_area *a, uint32_t p,
                               uint32_t q, struct dx_line ac, struct dx_line bd)
{
    const uint64_t *above = a->q[p - 1], *here = a->q[p], *below = a->q[p + 1];

    r->ac[q] = dx_line_residual(above[q - 1], here[q], below[q + 1], ac);
    r->bd[q] = dx_line_residual(above[q + 1], here[q], below[q - 1], bd);
    r->has_ac[q] =
        ((ac.minus | ac.plus) != 0) & (above[q - 1] != 0) & (here[q] != 0) & (below[q + 1] != 0);
    r->has_bd[q] =
        ((bd.minus | bd.plus) != 0) & (above[q + 1] != 0) & (here[q] != 0) & (below[q - 1] != 0);
}

static void residual_row(struct dx_residuals *r, const struct dx_area *a,
                         const struct dx_gates *gates, const struct dx_geometry *g, uint32_t p)
{
    const uint32_t first = DX_MARGIN, end = DX_MARGIN + a->n_cols + 1;
    const int64_t row = a->row0 + p;

    if (row < 1 || row + 1 >= g->height) {
        memset(r, 0, sizeof(*r));
    } else if (gates->per_dexel) {
        for (uint32_t q = first; q < end; q++) {
            size_t at = (size_t)row * g->width + dx_area_col(a, q, g->width);

            residual_at(r, a, p, q, gates->line[DX_EDGE_AC][at], gates->line[DX_EDGE_BD][at]);
        }
    } else {
        const struct dx_line ac = gates->line[DX_EDGE_AC][row], bd = gates->line[DX_EDGE_BD][row];

        for (uint32_t q = first; q < end; q++)
            residual_at(r, a, p, q, ac, bd);
    }
}

/* Without samples beyond the corners: the ranges of the corners, with the same bias. */
static bool prefer_corners(const uint32_t *top, const uint32_t *bottom,
                           const struct dx_sigma *sigma)
{
    uint32_t upper = top[0] < top[1] ? top[0] : top[1];
    uint32_t lower = bottom[0] < bottom[1] ? bottom[0] : bottom[1];
    uint64_t bias = (uint64_t)dx_sigma_at(sigma, upper < lower ? upper : lower) * BIAS_RANGES >> 16;

    return difference(top[0], bottom[1]) > difference(top[1], bottom[0]) + bias;
}

static uint64_t magnitude(int64_t x)
{
    return (uint64_t)(x < 0 ? -x : x);
}

/*
 * Whether `ac` is greater than `bd` by more than noise << BIAS_SHIFT, noise = floor(product /
 * range): with a multiplication for the division, and no branch, since on flat surfaces either
 * answer is as likely.
 */
static inline bool bends_more(int64_t ac, int64_t bd, uint64_t product, uint32_t range)
{
    int64_t more = (int64_t)(magnitude(ac) - magnitude(bd));
    uint64_t steps = ((uint64_t)(more - 1) >> BIAS_SHIFT) + 1;

    return (more > 0) & ((unsigned __int128)steps * range > product);
}

static void prefer_bend(uint8_t *out, const struct dx_diagonal *d, const struct dx_area *a,
                        const struct dx_gates *gates, uint32_t p)
{
    const struct dx_residuals *top = &d->line[p & 1], *bottom = &d->line[~p & 1];
    const uint8_t(*ac)[DX_AREA_STRIDE] = a->joined[DX_EDGE_AC] + p;
    const uint8_t(*bd)[DX_AREA_STRIDE] = a->joined[DX_EDGE_BD] + p;

    for (uint32_t q = DX_MARGIN; q < DX_MARGIN + a->n_cols; q++) {
        uint8_t outer = ac[-1][q - 1] & ac[1][q + 1] & bd[-1][q + 1] & bd[1][q - 1];
        uint8_t has =
            top->has_ac[q] & bottom->has_ac[q + 1] & top->has_bd[q + 1] & bottom->has_bd[q] & outer;

        if (has)
            out[q] =
                bends_more(top->ac[q] + bottom->ac[q + 1], top->bd[q + 1] + bottom->bd[q],
                           dx_sigma_at(&gates->sigma, a->range[p][q]) * a->q[p][q], a->range[p][q]);
        else
            out[q] = prefer_corners(a->range[p] + q, a->range[p + 1] + q, &gates->sigma);
    }
}

void dx_diagonal_begin(struct dx_diagonal *d, const struct dx_area *a, const struct dx_gates *gates,
                       const struct dx_geometry *g)
{
    if (gates->diag == DX_DIAG_BEND)
        residual_row(&d->line[DX_MARGIN & 1], a, gates, g, DX_MARGIN);
}

void dx_diagonal_row(uint8_t prefer_bd[DX_AREA_STRIDE], struct dx_diagonal *d,
                     const struct dx_area *a, const struct dx_gates *gates,
                     const struct dx_geometry *g, uint32_t p)
{
    switch (gates->diag) {
    case DX_DIAG_FIXED:
        memset(prefer_bd, 0, DX_AREA_STRIDE);
        break;
    case DX_DIAG_SHORT:
        prefer_short(prefer_bd, a, p);
        break;
    case DX_DIAG_BEND:
        residual_row(&d->line[~p & 1], a, gates, g, p + 1);
        prefer_bend(prefer_bd, d, a, gates, p);
        break;
    }
}
