/*
 * The loops of rows.h for bends. Included twice: for 16-bit ranges in f32, for 32-bit ones in f64.
 * Before: REAL, RANGE and NAME(x), the types and the loops' names; ABS; INVERSE(r) of a REAL r;
 * SLOPE(q, r), what the noise of q is in that of r, in 1/256, doubled; ROUNDING, CUTS: how far what
 * is computed can be from the integers, of itself and in all.
 */

static void NAME(inverse)(void *out, const void *range)
{
    const RANGE *from = range;
    REAL *restrict to = out;
    REAL r[N];

    for (uint32_t q = 0; q < N; q++)
        r[q] = (REAL)from[q];
    for (uint32_t q = 0; q < N; q++) {
        REAL inverse = r[q] < 16 ? (REAL)TOO_NEAR : INVERSE(r[q]);

        to[q] = r[q] > 0 ? inverse : 0;
    }
}

static inline __attribute__((always_inline)) void NAME(residual_at)(
    struct dx_row_residuals *restrict out, const void *const inverse[3], uint32_t j,
    const REAL w[4])
{
    const REAL *above = inverse[0], *here = (const REAL *)inverse[1] + 1, *below = inverse[2];
    REAL ac = above[j] * w[0] + below[j + 2] * w[1];
    REAL bd = above[j + 2] * w[2] + below[j] * w[3];

    out->NAME(ac)[j] = here[j] - ac;
    out->NAME(bd)[j] = here[j] - bd;
    out->NAME(size)[j] = here[j] + ac + bd;
}

static void NAME(residuals)(struct dx_row_residuals *restrict out, const void *const inverse[3],
                            const struct dx_row_weights *weights)
{
    const REAL w[4] = {(REAL)weights->ac[0], (REAL)weights->ac[1], (REAL)weights->bd[0],
                       (REAL)weights->bd[1]};

    for (uint32_t j = 0; j < CORNERS; j++)
        NAME(residual_at)(out, inverse, j, w);
}

static void NAME(residuals_each)(struct dx_row_residuals *restrict out,
                                 const void *const inverse[3], const struct dx_row_weights *weights)
{
    for (uint32_t j = 0; j < CORNERS; j++) {
        const REAL w[4] = {(REAL)weights[j].ac[0], (REAL)weights[j].ac[1], (REAL)weights[j].bd[0],
                           (REAL)weights[j].bd[1]};

        NAME(residual_at)(out, inverse, j, w);
    }
}

static inline REAL NAME(sigma_of)(const struct dx_row_sigma *s, REAL r)
{
    REAL sigma = (REAL)s->a0 + r * ((REAL)s->a1 + r * (REAL)s->a2), max = (REAL)s->max;

    return sigma < max ? sigma : max;
}

/* What one diagonal bends more than the other, less the bias: positive for b-d. `margin` is how far
 * it can be from what integers say. */
static inline void NAME(compare_bends)(REAL *restrict more, REAL *restrict margin,
                                       const struct dx_row_bend *row,
                                       const struct dx_row_sigma *sigma)
{
    const struct dx_row_residuals *top = row->top, *bottom = row->bottom;
    const struct dx_row_sigma s = *sigma;
    const REAL *inverse = row->inverse;
    const RANGE *range = row->range;

    for (uint32_t j = 0; j < CELLS; j++) {
        REAL ac = ABS(top->NAME(ac)[j] + bottom->NAME(ac)[j + 1]);
        REAL bd = ABS(top->NAME(bd)[j + 1] + bottom->NAME(bd)[j]);
        REAL size = top->NAME(size)[j] + top->NAME(size)[j + 1] + bottom->NAME(size)[j] +
                    bottom->NAME(size)[j + 1];
        REAL slope = SLOPE(inverse[j], (REAL)range[j]);
        REAL bias = NAME(sigma_of)(&s, (REAL)range[j]) * slope;

        more[j] = ac - bd - bias;
        margin[j] = ROUNDING * (size + bias) + (REAL)s.off * slope + CUTS;
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

static inline struct dx_row_preference NAME(tell)(const REAL *more, const REAL *margin)
{
    uint32_t prefers[CELLS], sure[CELLS];

    for (uint32_t j = 0; j < CELLS; j++) {
        prefers[j] = more[j] > 0 ? UINT32_MAX : 0;
        sure[j] = ABS(more[j]) > margin[j] ? UINT32_MAX : 0; /* not where it is no number */
    }
    return (struct dx_row_preference){(uint64_t)pack32(prefers, CELLS),
                                      (uint64_t)~pack32(sure, CELLS)};
}

static struct dx_row_preference NAME(bend)(const struct dx_row_bend *row,
                                           const struct dx_row_sigma *sigma)
{
    REAL more[CELLS], margin[CELLS];
    struct dx_row_preference lines, corners;

    NAME(compare_bends)(more, margin, row, sigma);
    lines = NAME(tell)(more, margin);
    if (row->outer == UINT64_MAX)
        return lines;
    NAME(compare_corners)(more, margin, row, sigma);
    corners = NAME(tell)(more, margin);
    return (struct dx_row_preference){(lines.bd & row->outer) | (corners.bd & ~row->outer),
                                      (lines.unsure & row->outer) | (corners.unsure & ~row->outer)};
}

#undef REAL
#undef RANGE
#undef NAME
#undef ABS
#undef INVERSE
#undef SLOPE
#undef ROUNDING
#undef CUTS
