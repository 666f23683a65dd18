/* The gates' constants from geometry and parameters. */
#include "core/grid/gates.h"

#include "core/base/trig.h"
#include "core/grid/faces.h"
#include "core/grid/lines.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>

#define SQRT2  1.41421356237309504880
#define TAN_89 57.0
#define UNEVEN 1.04 /* column steps that differ by more make the grid uneven */

/* Dexels beyond a tile's own that the rules read: two for a rescue and the mixed pixels that follow
 * from it, one more for struts over one dexel, two more over two. */
#define MARGIN_RESCUE 3
#define MARGIN_STRUT  1

static uint32_t constant(double c)
{
    c = rint(65536 * c);
    return c < 4294967295.0 ? (uint32_t)c : UINT32_MAX;
}

/* Range growth a unit range of a plane hit at incidence `g`, one step of `psi` further away. */
static double tilt_factor(double g, double psi)
{
    if (g + psi >= dx_rad(89))
        return TAN_89 * psi;
    return dx_cos(g) / dx_cos(g + psi) - 1;
}

/* Below the last row of cells there is one more row of H edges; right of an open grid's last column
 * of cells, one more column of V edges. */
static bool has_edge(const struct dx_geometry *g, enum dx_edge e, uint32_t i, uint32_t j)
{
    return (i + 1 < g->height || e == DX_EDGE_H) && (j + 1 < g->width || g->wrap || e == DX_EDGE_V);
}

/* Angle of an edge of cell (i,j). */
static double edge_angle(const struct dx_geometry *g, enum dx_edge e, uint32_t i, uint32_t j)
{
    uint32_t next = (j + 1) % g->width;

    switch (e) {
    case DX_EDGE_H:
        return dx_geometry_angle(g, i, j, i, next);
    case DX_EDGE_V:
        return dx_geometry_angle(g, i, j, i + 1, j);
    case DX_EDGE_AC:
        return dx_geometry_angle(g, i, j, i + 1, next);
    default:
        return dx_geometry_angle(g, i, next, i + 1, j);
    }
}

/* Angle between the ends of a strut whose first missing dexel is (i,j); 0 when it has no two ends.
 */
static double span_angle(const struct dx_geometry *g, bool across, uint8_t len, uint32_t i,
                         uint32_t j)
{
    if (!across)
        return i > 0 && i + len < g->height ? dx_geometry_angle(g, i - 1, j, i + len, j) : 0;
    if (!g->wrap && (j == 0 || j + len >= g->width))
        return 0;
    return dx_geometry_angle(g, i, (j + g->width - 1) % g->width, i, (j + len) % g->width);
}

/* Whether one constant a row will not do: a table of directions, or columns with uneven steps. */
static bool is_uneven(const struct dx_geometry *g)
{
    uint32_t steps = g->wrap ? g->width : g->width - 1;
    double lo = INFINITY, hi = 0;

    if (g->model == DX_MODEL_TABLE)
        return true;
    for (uint32_t j = 0; j < steps; j++) {
        double psi = dx_geometry_angle(g, g->height / 2, j, g->height / 2, (j + 1) % g->width);

        lo = psi < lo ? psi : lo;
        hi = psi > hi ? psi : hi;
    }
    return hi > lo * UNEVEN;
}

static size_t n_constants(const struct dx_gates *gates, const struct dx_geometry *g)
{
    return (size_t)g->height * (gates->per_dexel ? g->width : 1);
}

static bool allocate(struct dx_gates *gates, const struct dx_geometry *g)
{
    size_t n = n_constants(gates, g);
    bool ok = true;

    for (int e = 0; e < DX_N_EDGES; e++) {
        gates->c[e] = calloc(n, sizeof(uint32_t));
        gates->line[e] = calloc(n, sizeof(struct dx_line));
        gates->steep[e] = gates->per_dexel ? NULL : calloc(n, sizeof(uint32_t));
        ok &= gates->c[e] && gates->line[e] && (gates->per_dexel || gates->steep[e]);
    }
    for (int s = 0; s < DX_N_SPANS; s++) {
        gates->span[s] = gates->per_dexel ? NULL : calloc(n, sizeof(uint32_t));
        ok &= gates->per_dexel || gates->span[s];
    }
    gates->faces = gates->per_dexel ? NULL : calloc(n, 1);
    return ok && (gates->per_dexel || gates->faces);
}

static void fill_faces(struct dx_gates *gates, const struct dx_geometry *g)
{
    for (uint32_t i = 0; !gates->per_dexel && i < g->height; i++)
        for (uint8_t len = 1; len <= 2; len++)
            for (unsigned across = 0; across < 2; across++)
                gates->faces[i] |=
                    (uint8_t)(dx_faces_span(g, across, len, i, 1) << DX_SPAN(across, len));
}

int dx_gates_init(struct dx_gates *gates, const struct dx_geometry *g)
{
    int r = 0;

    *gates = (struct dx_gates){.per_dexel = is_uneven(g)};
    if (!allocate(gates, g))
        r = -ENOMEM;
    if (r == 0)
        r = dx_faces_find_folds(&gates->folded, g);
    if (r < 0) {
        dx_gates_fini(gates);
        return r;
    }
    for (enum dx_edge e = 0; e < DX_N_EDGES; e++)
        dx_lines_fill(gates->line[e], g, e, gates->per_dexel);
    fill_faces(gates, g);
    return 0;
}

void dx_gates_fini(struct dx_gates *gates)
{
    for (int e = 0; e < DX_N_EDGES; e++) {
        free(gates->c[e]);
        free(gates->steep[e]);
        free(gates->line[e]);
    }
    for (int s = 0; s < DX_N_SPANS; s++)
        free(gates->span[s]);
    free(gates->faces);
    free(gates->folded);
    *gates = (struct dx_gates){0};
}

static uint32_t steep_constant(const struct dx_gates *gates, double psi)
{
    return constant(TAN_89 * psi + gates->noise_slope);
}

static uint32_t tilt_constant(const struct dx_gates *gates, double psi)
{
    return constant(tilt_factor(gates->tilt_rad, psi) + gates->noise_slope);
}

/* Whether every constant fits 16 bits, as the narrow arithmetic wants. */
static bool fill_edges(struct dx_gates *gates, const struct dx_geometry *g)
{
    uint32_t cols = gates->per_dexel ? g->width : 1;
    bool narrow = true;

    for (enum dx_edge e = 0; e < DX_N_EDGES; e++)
        for (uint32_t i = 0; i < g->height; i++)
            for (uint32_t j = 0; j < cols; j++) {
                bool there = has_edge(g, e, i, j);
                double psi = there ? edge_angle(g, e, i, j) : 0;
                uint32_t c = there ? tilt_constant(gates, psi) : 0;

                gates->c[e][(size_t)i * cols + j] = c;
                if (!gates->per_dexel)
                    gates->steep[e][i] = there ? steep_constant(gates, psi) : 0;
                narrow &= c <= 65535;
            }
    return narrow;
}

static void fill_spans(struct dx_gates *gates, const struct dx_geometry *g)
{
    for (uint32_t i = 0; !gates->per_dexel && i < g->height; i++)
        for (uint8_t len = 1; len <= 2; len++)
            for (int across = 0; across < 2; across++) /* an even grid's columns begin at 0 */
                gates->span[DX_SPAN(across, len)][i] =
                    tilt_constant(gates, span_angle(g, across, len, i, across ? 1 : 0));
}

uint32_t dx_gates_steep(const struct dx_gates *gates, const struct dx_geometry *g, enum dx_edge e,
                        uint32_t i, uint32_t j)
{
    return gates->per_dexel ? steep_constant(gates, edge_angle(g, e, i, j)) : gates->steep[e][i];
}

uint32_t dx_gates_span(const struct dx_gates *gates, const struct dx_geometry *g, bool across,
                       uint8_t len, uint32_t i, uint32_t j)
{
    return gates->per_dexel ? tilt_constant(gates, span_angle(g, across, len, i, j))
                            : gates->span[DX_SPAN(across, len)][i];
}

bool dx_gates_faces(const struct dx_gates *gates, const struct dx_geometry *g, bool across,
                    uint8_t len, uint32_t i, uint32_t j)
{
    /* at column 1, as the lines, no triangle is left out that another column of the row has */
    return gates->per_dexel || g->width < 3 ? dx_faces_span(g, across, len, i, j)
                                            : gates->faces[i] >> DX_SPAN(across, len) & 1;
}

static void set_rules(struct dx_gates *gates, const struct dx_terrain_params *p)
{
    gates->first_order = !p->paper;
    gates->rescue = p->rescue && !p->paper;
    gates->mixed = p->paper ? DX_MIXED_OFF : p->mixed;
    gates->diag = p->paper ? DX_DIAG_FIXED : p->diag;
    gates->bridge = p->paper ? 0 : p->bridge;
    gates->margin = MARGIN_RESCUE + MARGIN_STRUT * (2u * gates->bridge - (gates->bridge > 0));
    if (p->paper)
        gates->margin = 0; /* a cell's own corners alone */
}

void dx_gates_set(struct dx_gates *gates, const struct dx_geometry *g,
                  const struct dx_terrain_params *p)
{
    double u = (double)g->unit_m, k = p->noise_k * SQRT2;
    double s0 = p->sigma[0] > 0.5 * u ? p->sigma[0] : 0.5 * u; /* quantisation floor */
    double t0 = rint(k * s0 / u), n2 = rint(4294967296.0 * k * p->sigma[2] * u);
    double cap = rint(4096 * p->cap_m / u);

    set_rules(gates, p);
    gates->rows = dx_rows_get(p->simd);
    dx_sigma_init(&gates->sigma, p->sigma, u);
    gates->row_sigma = dx_sigma_rows(&gates->sigma);
    gates->tilt_rad = dx_rad(p->tilt_deg);
    gates->noise_slope = k * p->sigma[1];
    gates->t0 = t0 < 4294967295.0 ? (uint32_t)t0 : UINT32_MAX;
    gates->n2 = n2 < 1e18 ? (uint64_t)n2 : (uint64_t)1e18;
    gates->cap = cap < 1e18 ? (uint64_t)cap : (uint64_t)1e18;
    if (p->cap_m > 0 && gates->cap == 0)
        gates->cap = 1; /* 0 is none, and the least one joins nothing */
    fill_spans(gates, g);
    /* narrow: each constant and the noise term of the farthest range fit 16 bits */
    gates->wide = !fill_edges(gates, g) || g->range_bytes == 4 || gates->t0 + gates->n2 > 65535;
}
