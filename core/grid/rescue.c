/* The rescue, on the few edges that fail the first-order rule. */
#include "core/grid/rescue.h"

#include "core/base/bytes.h"

/* How well sample x of a line goes with the neighbour before and the one after it: the departure in
 * sigmas, squared, is at most this. */
enum fit { FIT_NONE = 0, FIT_SURE = 1, FIT_FAIR = 9 };

static enum fit fit_of(const struct dx_area *a, const struct dx_gates *gates, struct dx_line line,
                       struct dx_step s, uint32_t p, uint32_t q)
{
    const uint32_t p0 = p - s.row, q0 = q - s.col, p1 = p + s.row, q1 = q + s.col;
    unsigned __int128 w0, w1, variance, off2;
    uint64_t before, here, after, off, e;
    int64_t r;

    if (p0 < a->first || p0 >= a->end || p1 >= a->end || q0 >= DX_AREA || q1 >= DX_AREA ||
        !(line.minus | line.plus))
        return FIT_NONE;
    before = dx_area_inverse(a, p0, q0);
    here = dx_area_inverse(a, p, q);
    after = dx_area_inverse(a, p1, q1);
    if (!before || !here || !after)
        return FIT_NONE;
    r = dx_line_residual(before, here, after, line);
    off = (uint64_t)(r < 0 ? -r : r) >> 16;
    e = dx_line_noise(&gates->sigma, here, dx_area_range(a, p, q));
    w0 = dx_line_noise(&gates->sigma, before, dx_area_range(a, p0, q0));
    w1 = dx_line_noise(&gates->sigma, after, dx_area_range(a, p1, q1));
    w0 = w0 * line.minus >> 24;
    w1 = w1 * line.plus >> 24;
    variance = (unsigned __int128)e * e + w0 * w0 + w1 * w1;
    off2 = (unsigned __int128)off * off;
    if (off2 > FIT_FAIR * variance)
        return FIT_NONE;
    return off2 <= FIT_SURE * variance ? FIT_SURE : FIT_FAIR;
}

static enum fit fit_at(const struct dx_area *a, const struct dx_gates *gates,
                       const struct dx_geometry *g, enum dx_edge e, uint32_t p, uint32_t q)
{
    if (p < a->first || p >= a->end || q >= DX_AREA || !a->valid[p][q])
        return FIT_NONE;
    return fit_of(a, gates,
                  dx_gates_line(gates, g->width, e, dx_area_row(a, p), dx_area_col(a, q, g->width)),
                  dx_line_step(e), p, q);
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

void dx_rescue_row(struct dx_area *a, const uint8_t failed[DX_ROWS_N], const struct dx_gates *gates,
                   const struct dx_geometry *g, enum dx_edge e, uint32_t p)
{
    uint8_t *joined = a->joined[e][p];

    for (uint32_t q = 0; q < DX_ROWS_N; q += 8)
        for (uint64_t eight = dx_get_u64(failed + q); eight; eight &= eight - 1) {
            const uint32_t k = q + (uint32_t)__builtin_ctzll(eight) / 8;

            joined[k] = rescued(a, gates, g, e, p, k + dx_edge_ends(e).q0);
        }
}
