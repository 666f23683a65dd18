/* The edge rule's constants from geometry and parameters. */
#include "core/grid/gates.h"

#include "core/base/trig.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>

#define SQRT2  1.41421356237309504880
#define TAN_89 57.0
#define UNEVEN 0.1 /* a column step that departs from the mean by more makes the grid uneven */

/* Range growth a unit range of a plane hit at incidence `g`, one step of `psi` further away. */
static double tilt_factor(double g, double psi)
{
    if (g + psi >= dx_rad(89))
        return TAN_89 * psi;
    return dx_cos(g) / dx_cos(g + psi) - 1;
}

static uint32_t edge_constant(const struct dx_terrain_params *p, double psi)
{
    double c = tilt_factor(dx_rad(p->tilt_deg), psi) + p->noise_k * SQRT2 * p->sigma[1];

    c = rint(65536 * c);
    return c < 4294967295.0 ? (uint32_t)c : UINT32_MAX;
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
    return hi > lo * (1 + 2 * UNEVEN);
}

/* Whether every constant fits 16 bits, as the narrow arithmetic wants. */
static bool fill_constants(struct dx_gates *gates, const struct dx_geometry *g,
                           const struct dx_terrain_params *p)
{
    uint32_t cols = gates->per_dexel ? g->width : 1;
    bool narrow = true;

    for (enum dx_edge e = 0; e < DX_N_EDGES; e++)
        for (uint32_t i = 0; i < g->height; i++)
            for (uint32_t j = 0; j < cols; j++) {
                uint32_t c = has_edge(g, e, i, j) ? edge_constant(p, edge_angle(g, e, i, j)) : 0;

                gates->c[e][(size_t)i * cols + j] = c;
                narrow &= c <= 65535;
            }
    return narrow;
}

static int find_folds(struct dx_gates *gates, const struct dx_geometry *g)
{
    struct dx_tiling t;
    size_t n;

    if (g->model != DX_MODEL_TABLE)
        return 0;
    dx_tiling_init(&t, g->height, g->width, g->wrap);
    n = (size_t)t.cell_rows * t.cell_cols;
    gates->folded = calloc(n / 64 + 1, sizeof(uint64_t));
    if (!gates->folded)
        return -ENOMEM;
    for (size_t k = 0; k < n; k++) {
        int sign =
            dx_geometry_cell_sign(g, (uint32_t)(k / t.cell_cols), (uint32_t)(k % t.cell_cols));

        if (sign != (g->flip ? 1 : -1))
            gates->folded[k / 64] |= 1ull << (k % 64);
    }
    return 0;
}

int dx_gates_init(struct dx_gates *gates, const struct dx_geometry *g)
{
    int r;

    *gates = (struct dx_gates){.per_dexel = is_uneven(g)};
    for (int e = 0; e < DX_N_EDGES; e++) {
        gates->c[e] =
            calloc((size_t)g->height * (gates->per_dexel ? g->width : 1), sizeof(uint32_t));
        if (!gates->c[e]) {
            dx_gates_fini(gates);
            return -ENOMEM;
        }
    }
    r = find_folds(gates, g);
    if (r < 0)
        dx_gates_fini(gates);
    return r;
}

void dx_gates_fini(struct dx_gates *gates)
{
    for (int e = 0; e < DX_N_EDGES; e++)
        free(gates->c[e]);
    free(gates->folded);
    *gates = (struct dx_gates){0};
}

void dx_gates_set(struct dx_gates *gates, const struct dx_geometry *g,
                  const struct dx_terrain_params *p)
{
    double u = (double)g->unit_m, k = p->noise_k * SQRT2;
    double s0 = p->sigma[0] > 0.5 * u ? p->sigma[0] : 0.5 * u; /* quantisation floor */
    double t0 = rint(k * s0 / u), n2 = rint(4294967296.0 * k * p->sigma[2] * u);
    double cap = rint(4096 * p->cap_m / u);

    gates->first_order = !p->paper;
    gates->t0 = t0 < 4294967295.0 ? (uint32_t)t0 : UINT32_MAX;
    gates->n2 = n2 < 1e18 ? (uint64_t)n2 : (uint64_t)1e18;
    gates->cap = cap < 1e18 ? (uint64_t)cap : (uint64_t)1e18;
    /* narrow: each constant and the noise term of the farthest range fit 16 bits */
    gates->wide =
        !fill_constants(gates, g, p) || g->range_bytes == 4 || gates->t0 + gates->n2 > 65535;
}
