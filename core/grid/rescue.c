/* The rescue, on the few edges that fail the first-order rule. */
#include "core/grid/rescue.h"

#include <math.h>

/* How well sample x of a line goes with the neighbour before and the one after it: the departure in
 * sigmas, squared, is at most this. */
enum fit { FIT_NONE = 0, FIT_SURE = 1, FIT_FAIR = 9 };

/* In integers: the inverse ranges before, here and after, and the ranges. */
static enum fit fit_exactly(const struct dx_sigma *sigma, struct dx_line line,
                            const uint32_t range[3])
{
    const uint64_t before = dx_area_invert(range[0]), here = dx_area_invert(range[1]);
    const uint64_t after = dx_area_invert(range[2]);
    const int64_t r = dx_line_residual(before, here, after, line);
    const uint64_t off = (uint64_t)(r < 0 ? -r : r) >> 16;
    const uint64_t e = dx_line_noise(sigma, here, range[1]);
    const unsigned __int128 w0 =
        (unsigned __int128)dx_line_noise(sigma, before, range[0]) * line.minus >> 24;
    const unsigned __int128 w1 =
        (unsigned __int128)dx_line_noise(sigma, after, range[2]) * line.plus >> 24;
    const unsigned __int128 variance = (unsigned __int128)e * e + w0 * w0 + w1 * w1;
    const unsigned __int128 off2 = (unsigned __int128)off * off;

    if (off2 > FIT_FAIR * variance)
        return FIT_NONE;
    return off2 <= FIT_SURE * variance ? FIT_SURE : FIT_FAIR;
}

/*
 * The same in doubles, where that decides. The integers cut inverse ranges to whole numbers, which
 * moves a residual by less than 3 (768 in 1/256), and noise to whole 1/256; inverse ranges are not
 * below 2^8, where 16 bits of range make them 2^24 and more.
 */
#define CUT      770.0
#define ROUNDING 1e-6

static enum fit fit_of(const struct dx_sigma *sigma, struct dx_line line, const uint32_t range[3])
{
    const double weight[3] = {line.minus * 0x1p-24, 1, line.plus * 0x1p-24};
    double q[3], off, variance = 0, sum = 0, least, most;

    for (int k = 0; k < 3; k++) {
        const double inverse = 1 / (double)range[k];
        double noise;

        q[k] = weight[k] * 0x1p40 * inverse;
        noise = (double)dx_sigma_at(sigma, range[k]) * q[k] * inverse;
        variance += noise * noise;
        sum += noise;
    }
    off = fabs(q[1] - q[0] - q[2]) * 256;
    least = off > CUT ? (off - CUT) * (off - CUT) : 0;
    most = (off + CUT) * (off + CUT);
    sum = 4 * sum + 12 + ROUNDING * variance; /* what cutting and rounding do to the variance */
    if (range[0] > UINT16_MAX || range[1] > UINT16_MAX || range[2] > UINT16_MAX)
        return fit_exactly(sigma, line, range);
    if (least > FIT_FAIR * (variance + sum))
        return FIT_NONE;
    if (most <= FIT_SURE * (variance - sum))
        return FIT_SURE;
    if (least > FIT_SURE * (variance + sum) && most <= FIT_FAIR * (variance - sum))
        return FIT_FAIR;
    return fit_exactly(sigma, line, range);
}

/* Of dexel (p,q) on its line of direction e. */
static enum fit fit_at(const struct dx_area *a, const struct dx_gates *gates,
                       const struct dx_geometry *g, enum dx_edge e, uint32_t p, uint32_t q)
{
    const struct dx_step s = dx_line_step(e);
    const uint32_t p0 = p - s.row, q0 = q - s.col, p1 = p + s.row, q1 = q + s.col;
    struct dx_line line;
    uint32_t range[3];

    if (p0 < a->first || p0 >= a->end || p >= a->end || p1 >= a->end || q0 >= DX_AREA ||
        q >= DX_AREA || q1 >= DX_AREA)
        return FIT_NONE;
    range[0] = dx_area_range(a, p0, q0);
    range[1] = dx_area_range(a, p, q);
    range[2] = dx_area_range(a, p1, q1);
    if (range[0] < DX_INVERSE_LEAST || range[1] < DX_INVERSE_LEAST || range[2] < DX_INVERSE_LEAST)
        return FIT_NONE;
    line = dx_gates_line(gates, g->width, e, dx_area_row(a, p), dx_area_col(a, q, g->width));
    return line.minus | line.plus ? fit_of(&gates->sigma, line, range) : FIT_NONE;
}

static bool rescued(const struct dx_area *a, const struct dx_gates *gates,
                    const struct dx_geometry *g, enum dx_edge e, uint32_t p, uint32_t q)
{
    const struct dx_step s = dx_line_step(e);
    const uint32_t cell = e == DX_EDGE_BD ? q - 1 : q; /* of the edge's constants */
    const uint32_t p1 = p + s.row, q1 = q + s.col;
    enum fit here, there;

    if (!dx_gates_pass(
            gates, dx_area_range(a, p, q), dx_area_range(a, p1, q1),
            dx_gates_steep(gates, g, e, dx_area_row(a, p), dx_area_col(a, cell, g->width))))
        return false;
    /* One fit alone proves nothing: a mixed sample half-way between two surfaces has it too. */
    here = fit_at(a, gates, g, e, p, q);
    there = fit_at(a, gates, g, e, p1, q1);
    if (here && there)
        return true;
    if (here == FIT_SURE)
        return fit_at(a, gates, g, e, p - s.row, q - s.col);
    return there == FIT_SURE && fit_at(a, gates, g, e, p1 + s.row, q1 + s.col);
}

dx_bits dx_rescue_row(const struct dx_area *a, dx_bits failed, const struct dx_gates *gates,
                      const struct dx_geometry *g, enum dx_edge e, uint32_t p)
{
    dx_bits joined = 0;

    for (; failed; failed &= failed - 1) {
        const uint32_t q = dx_bits_first(failed);

        joined |= (dx_bits)rescued(a, gates, g, e, p, q + dx_edge_ends(e).q0) << q;
    }
    return joined;
}
