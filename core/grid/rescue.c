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
    const int64_t r = dx_line_residual(a->q[p0][q0], a->q[p][q], a->q[p1][q1], line);
    const uint64_t off = (uint64_t)(r < 0 ? -r : r) >> 16;
    const uint64_t e = dx_line_noise(&gates->sigma, a->q[p][q], a->range[p][q]);
    const uint64_t before = dx_line_noise(&gates->sigma, a->q[p0][q0], a->range[p0][q0]);
    const uint64_t after = dx_line_noise(&gates->sigma, a->q[p1][q1], a->range[p1][q1]);
    unsigned __int128 w0 = (unsigned __int128)before * line.minus >> 24;
    unsigned __int128 w1 = (unsigned __int128)after * line.plus >> 24;
    unsigned __int128 variance = (unsigned __int128)e * e + w0 * w0 + w1 * w1;
    unsigned __int128 off2 = (unsigned __int128)off * off;

    if (!(line.minus | line.plus) || off2 > FIT_FAIR * variance)
        return FIT_NONE;
    return off2 <= FIT_SURE * variance ? FIT_SURE : FIT_FAIR;
}

/* The pair (p, q), (p, q) + s has a sample before and one after it. */
static bool has_four(const struct dx_area *a, struct dx_step s, uint32_t p, uint32_t q)
{
    const uint32_t row0 = p - s.row, row1 = p + 2 * s.row, col0 = q - s.col, col1 = q + 2 * s.col;

    if (row0 < a->first || row0 >= a->end || row1 >= a->end || col0 >= DX_AREA || col1 >= DX_AREA)
        return false;
    return a->q[row0][col0] && a->q[p][q] && a->q[p + s.row][q + s.col] && a->q[row1][col1];
}

static bool rescued(const struct dx_area *a, const struct dx_gates *gates,
                    const struct dx_geometry *g, enum dx_edge e, uint32_t p, uint32_t q)
{
    const struct dx_step s = dx_line_step(e);
    const uint32_t cell = e == DX_EDGE_BD ? q - 1 : q; /* of the edge's constants */
    const uint32_t p1 = p + s.row, q1 = q + s.col;
    uint32_t row = dx_area_row(a, p), col, col1;
    enum fit here, there;

    if (!has_four(a, s, p, q))
        return false;
    col = dx_area_col(a, q, g->width);
    col1 = dx_area_col(a, q1, g->width);
    if (!dx_gates_pass(gates, a->range[p][q], a->range[p1][q1],
                       dx_gates_steep(gates, g, e, row, dx_area_col(a, cell, g->width))))
        return false;
    here = fit_of(a, gates, dx_gates_line(gates, g->width, e, row, col), s, p, q);
    there = fit_of(a, gates, dx_gates_line(gates, g->width, e, row + s.row, col1), s, p1, q1);
    return here == FIT_SURE || there == FIT_SURE || (here && there);
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
