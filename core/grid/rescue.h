/*
 * The second-order rule: in inverse range a plane is linear, however steep the beam meets it. A
 * pair that the first-order rule cuts is joined after all when two samples in a row, of which at
 * least one is its own, lie on the lines of their neighbours, within the noise.
 */
#ifndef DX_RESCUE_H
#define DX_RESCUE_H

#include "core/grid/area.h"

/* Those of the pairs `failed`, of which both ends are there and the first order has cut them, that
 * are joined after all. They are of row e, p. */
dx_bits dx_rescue_row(const struct dx_area *a, dx_bits failed, const struct dx_gates *gates,
                      const struct dx_geometry *g, enum dx_edge e, uint32_t p);

/* One step along a line, in area rows and columns; a step to the left wraps, as unsigned sums do.
 */
struct dx_step {
    uint32_t row, col;
};

static inline struct dx_step dx_line_step(enum dx_edge e)
{
    static const struct dx_step step[DX_N_EDGES] = {{0, 1}, {1, 0}, {1, 1}, {1, -1u}};

    return step[e];
}

/* How far q(x) is from what its neighbours on the line say, * 2^24. All three have a q. */
static inline int64_t dx_line_residual(uint64_t before, uint64_t q, uint64_t after,
                                       struct dx_line line)
{
    return (int64_t)((q << 24) - before * line.minus - after * line.plus);
}

/* The noise of q at a range, in 1/256. */
static inline uint64_t dx_line_noise(const struct dx_sigma *sigma, uint64_t q, uint32_t range)
{
    return dx_sigma_at(sigma, range) * q / range;
}

#endif
