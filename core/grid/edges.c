/* The first-order rule by rows, and the cap. */
#include "core/grid/edges.h"

#include "core/grid/rescue.h"

#include <string.h>

#define N DX_AREA_N

static inline uint16_t mul_high(uint16_t x, uint16_t y)
{
    return (uint16_t)((uint32_t)x * y >> 16);
}

/*
 * hi - lo <= noise + (lo * c >> 16) in 16 bits: the sum might not fit, so what the noise term
 * leaves of the difference is compared with the tilt term. No minimum, no maximum: SSE2 has none
 * for unsigned 16 bits, but selecting by a mask becomes vectors. The noise term does not fall with
 * range, so the nearer sample has the smaller one.
 */
static inline uint8_t joined(uint16_t x, uint16_t y, uint16_t noise_x, uint16_t noise_y, uint16_t c)
{
    uint16_t farther = (uint16_t) - (x > y), step = (uint16_t)(x - y), fall = step & farther;
    uint16_t lo = (uint16_t)(x - fall), difference = (uint16_t)(2 * fall - step);
    uint16_t noise = (uint16_t)(noise_x - ((noise_x - noise_y) & farther));

    return (lo != 0) &
           ((difference <= noise) | ((uint16_t)(difference - noise) <= mul_high(lo, c)));
}

/* Out of line: inlined, a constant is seen as part of a wider number, and products with it become
 * 32-bit ones at four times the instructions. */
static __attribute__((noinline)) void join_even(uint8_t *restrict out, const uint16_t *x,
                                                const uint16_t *y, const uint16_t *noise_x,
                                                const uint16_t *noise_y, uint16_t c)
{
    for (uint32_t q = 0; q < N; q++)
        out[q] = joined(x[q], y[q], noise_x[q], noise_y[q], c);
}

static void join_uneven(uint8_t *restrict out, const uint16_t *x, const uint16_t *y,
                        const uint16_t *noise_x, const uint16_t *noise_y, const uint16_t *c)
{
    for (uint32_t q = 0; q < N; q++)
        out[q] = joined(x[q], y[q], noise_x[q], noise_y[q], c[q]);
}

static void join_wide(uint8_t *out, const uint32_t *x, const uint32_t *y, const uint32_t *c,
                      uint32_t step, const struct dx_gates *gates)
{
    for (uint32_t q = 0; q < N; q++)
        out[q] = x[q] && y[q] && dx_gates_pass(gates, x[q], y[q], c[q * step]);
}

static void join_valid(uint8_t *out, const uint32_t *x, const uint32_t *y)
{
    for (uint32_t q = 0; q < N; q++)
        out[q] = x[q] && y[q];
}

/* A row of edges of type e: out[q] joins area dexels (p0, q + q0) and (p1, q + q1). */
static void join_row(struct dx_area *a, const struct dx_gates *gates, enum dx_edge e, uint32_t p,
                     const uint8_t end[2][2])
{
    const uint32_t p0 = p + end[0][0], q0 = end[0][1], p1 = p + end[1][0], q1 = end[1][1];
    uint8_t *out = a->joined[e][p];

    if (!gates->first_order)
        join_valid(out, a->range[p0] + q0, a->range[p1] + q1);
    else if (gates->wide)
        join_wide(out, a->range[p0] + q0, a->range[p1] + q1,
                  gates->per_dexel ? a->c[e][p] : &gates->c[e][dx_area_row(a, p)], gates->per_dexel,
                  gates);
    else if (gates->per_dexel)
        join_uneven(out, a->range16[p0] + q0, a->range16[p1] + q1, a->noise[p0] + q0,
                    a->noise[p1] + q1, a->c16[e][p]);
    else
        join_even(out, a->range16[p0] + q0, a->range16[p1] + q1, a->noise[p0] + q0,
                  a->noise[p1] + q1, (uint16_t)gates->c[e][dx_area_row(a, p)]);
}

static void cap_row(struct dx_area *a, const struct dx_gates *gates, enum dx_edge e, uint32_t p,
                    const uint8_t end[2][2])
{
    uint8_t *edge = a->joined[e][p];

    for (uint32_t q = 0; q < DX_AREA; q++)
        if (edge[q])
            edge[q] = dx_area_within_cap(a, gates, p + end[0][0], q + end[0][1], p + end[1][0],
                                         q + end[1][1]);
}

void dx_edges_join(struct dx_area *a, const struct dx_gates *gates, const struct dx_geometry *g)
{
    static const uint8_t end[DX_N_EDGES][2][2] = {
        {{0, 0}, {0, 1}}, {{0, 0}, {1, 0}}, {{0, 0}, {1, 1}}, {{0, 1}, {1, 0}}};

    for (enum dx_edge e = 0; e < DX_N_EDGES; e++)
        for (uint32_t p = a->first; p < a->end; p++) {
            int64_t row = a->row0 + p;

            /* the last row that is read has no row below it: only H edges */
            if (row < 0 || row >= g->height || (e != DX_EDGE_H && p + 1 == a->end)) {
                memset(a->joined[e][p], 0, sizeof(a->joined[e][p]));
                continue;
            }
            join_row(a, gates, e, p, end[e]);
            if (gates->rescue)
                dx_rescue_row(a, gates, g, e, p);
            if (gates->cap)
                cap_row(a, gates, e, p, end[e]);
        }
}
