/* The rescue, on the few edges that fail the first-order rule. */
#include "core/grid/rescue.h"

#include <string.h>

/* How well sample x of a line goes with the neighbour before and the one after it: the departure in
 * sigmas, squared, is at most this. */
enum fit { FIT_NONE = 0, FIT_SURE = 1, FIT_FAIR = 9 };

static enum fit fit_of(const struct dx_area *a, const struct dx_gates *gates, struct dx_line line,
                       struct dx_step s, uint32_t p, uint32_t q)
{
    const uint32_t p0 = p - s.row, q0 = q - s.col, p1 = p + s.row, q1 = q + s.col;
    unsigned __int128 w0, w1, variance, off2;
    uint64_t off, e;
    int64_t r;

    if (p0 < a->first || p0 >= a->end || p1 >= a->end || q0 >= DX_AREA || q1 >= DX_AREA ||
        !a->q[p0][q0] || !a->q[p1][q1] || !(line.minus | line.plus))
        return FIT_NONE;
    r = dx_line_residual(a->q[p0][q0], a->q[p][q], a->q[p1][q1], line);
    off = (uint64_t)(r < 0 ? -r : r) >> 16;
    e = dx_line_noise(&gates->sigma, a->q[p][q], a->range[p][q]);
    w0 = dx_line_noise(&gates->sigma, a->q[p0][q0], a->range[p0][q0]);
    w1 = dx_line_noise(&gates->sigma, a->q[p1][q1], a->range[p1][q1]);
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
    if (p < a->first || p >= a->end || q >= DX_AREA || !a->q[p][q])
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

    if (!a->q[p][q] || !a->q[p1][q1])
        return false;
    if (!dx_gates_pass(
            gates, a->range[p][q], a->range[p1][q1],
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

void dx_rescue_row(struct dx_area *a, const struct dx_gates *gates, const struct dx_geometry *g,
                   enum dx_edge e, uint32_t p)
{
    static const uint8_t all[8] = {1, 1, 1, 1, 1, 1, 1, 1};
    const uint32_t first = e == DX_EDGE_BD; /* the pair begins at corner b */
    const struct dx_step s = dx_line_step(e);
    uint8_t *joined = a->joined[e][p];

    for (uint32_t q = 0; q + 1 < DX_AREA; q++) {
        if (q % 8 == 0 && memcmp(joined + q, all, sizeof(all)) == 0) {
            q += 7; /* few edges fail: look at eight at once */
            continue;
        }
        if (!joined[q] && a->range[p][q + first] && a->range[p + s.row][q + first + s.col])
            joined[q] = rescued(a, gates, g, e, p, q + first);
    }
}
