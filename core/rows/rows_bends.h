/*
 * The loops of rows.h for bends. Included twice: for 16-bit ranges in f32, for 32-bit ones in f64.
 * Before: REAL, RANGE and NAME(x), the types and the loops' names; ABS; INVERSE(r) of a REAL r;
 * SLOPE(q, r), what the noise of q is in that of r, in 1/256, doubled; ROUNDING, CUTS: how far what
 * is computed can be from the integers, of itself and in all; TELL(more, margin), of a row of cells
 * which are positive, and which not beyond the margin.
 */

static void NAME(inverse)(void *out, const void *range)
{
    const RANGE *from = range;
    REAL *restrict to = out;
    REAL r[CORNERS];

    for (uint32_t q = 0; q < CORNERS; q++)
        r[q] = (REAL)from[q];
    for (uint32_t q = 0; q < CORNERS; q++) {
        REAL inverse = r[q] < 16 ? (REAL)TOO_NEAR : INVERSE(r[q]);

        to[q] = r[q] > 0 ? inverse : 0;
    }
}

static inline REAL NAME(sigma_of)(const struct dx_row_sigma *s, REAL r)
{
    REAL sigma = (REAL)s->a0 + r * ((REAL)s->a1 + r * (REAL)s->a2), max = (REAL)s->max;

    return sigma < max ? sigma : max;
}

/* Weights of the lines through a cell's corners: of their ends beyond the cell, and what those
 * inside leave of the corners' own. */
struct NAME(weights) {
    REAL nw, se, a, c, ne, sw, b, d;
};

static inline __attribute__((always_inline)) struct NAME(weights)
    NAME(weights_of)(const struct dx_row_bend *row, uint32_t j, uint32_t step)
{
    const struct dx_row_weights *a = row->top + j * step, *d = row->bottom + j * step;
    const struct dx_row_weights *b = a + step, *c = d + step;

    return (struct NAME(weights)){.nw = (REAL)a->ac[0],
                                  .se = (REAL)c->ac[1],
                                  .a = (REAL)(1 - c->ac[0]),
                                  .c = (REAL)(1 - a->ac[1]),
                                  .ne = (REAL)b->bd[0],
                                  .sw = (REAL)d->bd[1],
                                  .b = (REAL)(1 - d->bd[0]),
                                  .d = (REAL)(1 - b->bd[1])};
}

/* What one diagonal bends more than the other, less the bias: positive for b-d. `margin` is how far
 * it can be from what integers say. */
static inline __attribute__((always_inline)) void NAME(compare_bends)(
    REAL *restrict more, REAL *restrict margin, const struct dx_row_bend *row,
    const struct dx_row_sigma *sigma, uint32_t step)
{
    const REAL *north = row->inverse[0], *top = row->inverse[1], *bottom = row->inverse[2];
    const REAL *south = row->inverse[3];
    const struct dx_row_sigma s = *sigma;
    const RANGE *range = row->range;

    for (uint32_t j = 0; j < CELLS; j++) {
        const struct NAME(weights) w = NAME(weights_of)(row, j, step);
        REAL a = top[j + 1];
        REAL ac = a * w.a + bottom[j + 2] * w.c, ac_beyond = north[j] * w.nw + south[j + 3] * w.se;
        REAL bd = top[j + 2] * w.b + bottom[j + 1] * w.d;
        REAL bd_beyond = north[j + 3] * w.ne + south[j] * w.sw;
        REAL slope = SLOPE(a, (REAL)range[j]);
        REAL bias = NAME(sigma_of)(&s, (REAL)range[j]) * slope;

        more[j] = ABS(ac - ac_beyond) - ABS(bd - bd_beyond) - bias;
        margin[j] =
            ROUNDING * (ac + ac_beyond + bd + bd_beyond + bias) + (REAL)s.off * slope + CUTS;
    }
}

static inline RANGE NAME(least)(RANGE x, RANGE y)
{
    return x < y ? x : y;
}

static inline RANGE NAME(distance)(RANGE x, RANGE y)
{
    return (RANGE)((x > y ? x : y) - (x < y ? x : y));
}

/* The same of the ranges of the corners; 4 sqrt2 sigma. */
static inline void NAME(compare_corners)(REAL *restrict more, REAL *restrict margin,
                                         const struct dx_row_bend *row,
                                         const struct dx_row_sigma *sigma)
{
    const RANGE *top = row->range, *bottom = row->range_below;
    const struct dx_row_sigma s = *sigma;
    const REAL scale = (REAL)(1448 / 65536.0);
    RANGE nearest[CELLS], ac[CELLS], bd[CELLS];

    for (uint32_t j = 0; j < CELLS; j++) {
        RANGE a = top[j], b = top[j + 1], c = bottom[j + 1], d = bottom[j];

        nearest[j] = NAME(least)(NAME(least)(a, c), NAME(least)(b, d));
        ac[j] = NAME(distance)(a, c);
        bd[j] = NAME(distance)(b, d);
    }
    for (uint32_t j = 0; j < CELLS; j++) {
        REAL bias = NAME(sigma_of)(&s, (REAL)nearest[j]) * scale;

        more[j] = (REAL)ac[j] - (REAL)bd[j] - bias;
        margin[j] = ROUNDING * bias + (REAL)s.off * scale;
    }
}

static inline __attribute__((always_inline)) struct dx_row_preference NAME(bend_by)(
    const struct dx_row_bend *row, const struct dx_row_sigma *sigma, uint32_t step)
{
    REAL more[CELLS], margin[CELLS];
    struct dx_row_preference lines, corners;

    NAME(compare_bends)(more, margin, row, sigma, step);
    lines = TELL(more, margin);
    if (row->outer == UINT64_MAX)
        return lines;
    NAME(compare_corners)(more, margin, row, sigma);
    corners = TELL(more, margin);
    return (struct dx_row_preference){(lines.bd & row->outer) | (corners.bd & ~row->outer),
                                      (lines.unsure & row->outer) | (corners.unsure & ~row->outer)};
}

static struct dx_row_preference NAME(bend)(const struct dx_row_bend *row,
                                           const struct dx_row_sigma *sigma)
{
    return NAME(bend_by)(row, sigma, 0);
}

static struct dx_row_preference NAME(bend_each)(const struct dx_row_bend *row,
                                                const struct dx_row_sigma *sigma)
{
    return NAME(bend_by)(row, sigma, 1);
}

#undef REAL
#undef RANGE
#undef NAME
#undef ABS
#undef INVERSE
#undef SLOPE
#undef ROUNDING
#undef CUTS
#undef TELL
