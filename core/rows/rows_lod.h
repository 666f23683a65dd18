/*
 * The loops of rows.h for levels of detail (core/grid/lod.h): errors of hypotenuse middles, and how
 * those of the finest ones go up. Included once by each rows_SET.c.
 */
#include "core/rows/rows.h"

#include <math.h>

/* sigma.h, whose products f64 holds: factors are below 2^36. */
static inline double exact_sigma(const struct dx_row_sigma *s, double r)
{
    const double linear = floor(r * s->a1),
                 square = floor(floor(r * r * 0x1p-16) * (s->a2 * 0x1p16));
    const double sigma = s->a0 + linear + square;

    return sigma < s->max ? sigma : s->max;
}

/* Nearer ones are infinite whatever comes out. Ranges have 16 bits. */
static inline void invert_row(double *restrict q, const uint32_t *range)
{
    int32_t r[DX_ROWS_MIDDLES];

    for (uint32_t k = 0; k < DX_ROWS_MIDDLES; k++)
        r[k] = (int32_t)(range[k] < DX_ROWS_LEAST_MIDDLE ? DX_ROWS_LEAST_MIDDLE : range[k]);
    for (uint32_t k = 0; k < DX_ROWS_MIDDLES; k++)
        q[k] = floor(0x1p44 / (double)r[k]);
}

/*
 * All but the products of inverse ranges and weights, and their sum, is exact in f64; those take
 * fewer than eight roundings. Errors above 65534 are that.
 */
static uint32_t errors_row(uint32_t *restrict error, const struct dx_row_middles *m)
{
    const double w0 = m->end_weight[0], w1 = m->end_weight[1], w2 = m->apex_weight;
    const uint32_t *middle = m->middle, *end0 = m->end[0], *end1 = m->end[1], *apex = m->apex;
    const struct dx_row_sigma sigma = m->sigma;
    double q[4][DX_ROWS_MIDDLES], scale[DX_ROWS_MIDDLES];
    int32_t low[DX_ROWS_MIDDLES], high[DX_ROWS_MIDDLES];
    uint32_t unsure[DX_ROWS_MIDDLES];

    invert_row(q[0], middle);
    invert_row(q[1], end0);
    invert_row(q[2], end1);
    invert_row(q[3], apex);
    for (uint32_t k = 0; k < DX_ROWS_MIDDLES; k++) {
        const double r = (double)(int32_t)middle[k];

        scale[k] = r * r * 0x1p-54 / exact_sigma(&sigma, r);
    }
    for (uint32_t k = 0; k < DX_ROWS_MIDDLES; k++) {
        const double here = q[0][k] * 0x1p22, x = q[1][k] * w0, y = q[2][k] * w1, z = q[3][k] * w2;
        const double off = fabs(here - x - y - z) * scale[k], v = off < 65534.5 ? off : 65534.5;
        const double margin = (here + fabs(x) + fabs(y) + fabs(z)) * scale[k] * 0x1p-49;

        low[k] = (int32_t)(v - margin); /* -0.3 is 0, as it should */
        high[k] = (int32_t)(v + margin);
    }
    for (uint32_t k = 0; k < DX_ROWS_MIDDLES; k++) {
        const uint32_t a = middle[k] < end0[k] ? middle[k] : end0[k];
        const uint32_t b = apex[k] < end1[k] ? apex[k] : end1[k], least = a < b ? a : b;

        unsure[k] = low[k] != high[k] ? UINT32_MAX : 0;
        error[k] = least < DX_ROWS_LEAST_MIDDLE ? UINT16_MAX : (uint32_t)low[k];
    }
    return (uint32_t)pack32(unsure, DX_ROWS_MIDDLES);
}

/* Rows without diagonals have their middles at odd columns, the others at all. */
static struct dx_row_flips raise_row(uint16_t *restrict error, const struct dx_row_finest *f)
{
    const uint16_t *own = f->own, *up = f->up, *down = f->down;
    const uint16_t n = (uint16_t)f->n, cross = f->diagonals ? UINT16_MAX : 0;
    uint16_t beside[DX_ROWS_FINEST] = {0}, raised[DX_ROWS_FINEST], flips[DX_ROWS_FINEST] = {0};
    unsigned any = 0;

    for (uint32_t j = 1; j < DX_ROWS_FINEST - 1; j++)
        beside[j] = max16(own[j - 1], own[j + 1]);
    for (uint16_t j = 0; j < DX_ROWS_FINEST; j++) {
        const uint16_t odd = j & 1 ? UINT16_MAX : 0, most = max16(max16(up[j], down[j]), beside[j]);
        const uint16_t mine = max16(own[j], most & cross & odd);

        raised[j] = (odd | cross) && j < n ? mine : error[j];
    }
    for (int s = 0; s < DX_ROWS_SLOTS; s++)
        for (uint32_t j = 0; j < DX_ROWS_FINEST; j++) {
            const uint16_t was = error[j] > f->bound[s], is = raised[j] > f->bound[s];

            flips[j] |= (uint16_t)((was ^ is) << s);
        }
    for (uint32_t j = 0; j < DX_ROWS_FINEST; j++) {
        error[j] = raised[j];
        any |= flips[j];
    }
    return (struct dx_row_flips){any, flips[0]};
}
