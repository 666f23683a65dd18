/*
 * The oracle of terrain mode, first part: what is known of single dexels and of pairs
 * (docs/terrain.md: the edge rule, its second-order rescue, the cap, mixed pixels). Written from
 * the definitions over the whole frame, simple and slow; shares no code with core/grid/cells.c and
 * gates.c. Everything in 128 bits, so that no bound needs an argument. cmocka.h comes before.
 *
 * An edge is named by its line (H, V, AC, BD) and its first dexel x1: the second is one step of the
 * line further.
 */
#ifndef DX_TERRAIN_ORACLE_FRAME_H
#define DX_TERRAIN_ORACLE_FRAME_H

#include "core/base/trig.h"
#include "core/grid/terrain.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef __int128 wide;

enum line { LINE_H, LINE_V, LINE_AC, LINE_BD, N_LINES };

static const int line_step[N_LINES][2] = {{0, 1}, {1, 0}, {1, 1}, {1, -1}};

struct oracle {
    const struct dx_geometry *g;
    struct dx_terrain_params q;
    bool uneven; /* constants for each dexel; else for each row */
    size_t n;    /* dexels; the arrays below have one entry each */
    uint32_t *range;
    uint64_t *inverse;             /* 0: none */
    wide *noise8, *inverse_noise8; /* of range and of inverse range, in 1/256 */
    int64_t *gate[N_LINES], *gate89[N_LINES], (*weight[N_LINES])[2];
    int64_t (*direction)[3]; /* for the cap; NULL without one */
    bool *joined[N_LINES], *dead;
    uint8_t *choice; /* of a strut's direction: enum strut_choice */
};

/* Dexel (i,j) as an element of the arrays, or -1 outside the grid. */
static inline int64_t dexel(const struct oracle *o, int64_t i, int64_t j)
{
    const int64_t width = o->g->width;

    if (i < 0 || i >= o->g->height || (!o->g->wrap && (j < 0 || j >= width)))
        return -1;
    return i * width + ((j % width) + width) % width;
}

/* n steps along a line. */
static inline int64_t along(const struct oracle *o, enum line e, int64_t i, int64_t j, int n)
{
    return dexel(o, i + n * line_step[e][0], j + n * line_step[e][1]);
}

static inline uint64_t range_at(const struct oracle *o, int64_t k)
{
    return k < 0 ? 0 : o->range[k];
}

static inline wide absolute(wide x)
{
    return x < 0 ? -x : x;
}

static inline wide apart(const struct oracle *o, int64_t k0, int64_t k1)
{
    return absolute((wide)range_at(o, k0) - (wide)range_at(o, k1));
}

/* ---- constants ------------------------------------------------------------------------------- */

static inline double oracle_psi(const struct oracle *o, int64_t k0, int64_t k1)
{
    const uint32_t w = o->g->width;

    return dx_geometry_angle(o->g, (uint32_t)(k0 / w), (uint32_t)(k0 % w), (uint32_t)(k1 / w),
                             (uint32_t)(k1 % w));
}

static inline double floor_s0(const struct oracle *o)
{
    const double half = 0.5 * (double)o->g->unit_m;

    return o->q.sigma[0] > half ? o->q.sigma[0] : half;
}

static inline int64_t gate_constant(const struct oracle *o, double psi, double tilt_deg)
{
    const double tilt = dx_rad(tilt_deg), k = o->q.noise_k * sqrt(2);
    const double growth =
        tilt + psi >= dx_rad(89) ? 57 * psi : dx_cos(tilt) / dx_cos(tilt + psi) - 1;
    const double c = rint(65536 * (growth + k * o->q.sigma[1]));

    return c < 4294967295.0 ? (int64_t)c : 4294967295;
}

static inline bool within_gate(const struct oracle *o, int64_t k0, int64_t k1, int64_t c)
{
    const double u = (double)o->g->unit_m, k = o->q.noise_k * sqrt(2);
    const wide x = (wide)range_at(o, k0), y = (wide)range_at(o, k1), lo = x < y ? x : y;
    const wide t0 = (wide)rint(k * floor_s0(o) / u);
    const wide n2 = (wide)rint(4294967296.0 * k * o->q.sigma[2] * u);

    return apart(o, k0, k1) <= t0 + (lo * c >> 16) + ((lo * lo >> 16) * n2 >> 16);
}

static inline bool columns_are_uneven(const struct dx_geometry *g)
{
    const uint32_t steps = g->wrap ? g->width : g->width - 1;
    double lo = INFINITY, hi = 0;

    if (g->model == DX_MODEL_TABLE)
        return true;
    for (uint32_t j = 0; j < steps; j++) {
        const double psi =
            dx_geometry_angle(g, g->height / 2, j, g->height / 2, (j + 1) % g->width);

        lo = psi < lo ? psi : lo;
        hi = psi > hi ? psi : hi;
    }
    return hi > lo * 1.04;
}

/* Unit directions; for depths, whose inverse is affine in the image, (X, Y, 1). */
static inline void linear_direction(const struct dx_geometry *g, int64_t k, double d[3])
{
    const uint32_t i = (uint32_t)(k / g->width), j = (uint32_t)(k % g->width);

    if (g->model != DX_MODEL_PINHOLE) {
        dx_geometry_direction(g, i, j, d);
        return;
    }
    d[0] = (double)g->table[j];
    d[1] = (double)g->table[g->width + i];
    d[2] = 1;
}

static inline double dot(const double x[3], const double y[3])
{
    return x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
}

static inline int64_t weight_of(double w)
{
    w = rint(16777216 * w);
    return w < 0 ? 0 : w > 16777216 ? 16777216 : (int64_t)w; /* a residual fits 62 bits */
}

/* The least squares of d0 by its neighbours on the line; 0, 0 where it has not both. */
static inline void line_weights(const struct oracle *o, enum line e, int64_t i, int64_t j,
                                int64_t w[2])
{
    const int64_t before = along(o, e, i, j, -1), after = along(o, e, i, j, 1);
    double d[3], dm[3], dp[3], a, b, c, p, s, det;

    w[0] = w[1] = 0;
    if (before < 0 || after < 0 || o->g->width < 3)
        return;
    linear_direction(o->g, dexel(o, i, j), d);
    linear_direction(o->g, before, dm);
    linear_direction(o->g, after, dp);
    a = dot(dm, dm), b = dot(dm, dp), c = dot(dp, dp), p = dot(d, dm), s = dot(d, dp);
    det = a * c - b * b;
    if (!(det > 0))
        return;
    w[0] = weight_of((p * c - s * b) / det);
    w[1] = weight_of((s * a - p * b) / det);
}

/* Constants of dexel (i,j): its own, or on even grids those of its row, taken at one column. */
static inline void set_constants(struct oracle *o, enum line e, int64_t i, int64_t j)
{
    const int64_t col = o->uneven ? j : e == LINE_BD ? 1 : 0, k = dexel(o, i, j);
    const int64_t x1 = dexel(o, i, col), x2 = along(o, e, i, col, 1);

    if (!o->uneven && j > 0) {
        o->gate[e][k] = o->gate[e][k - 1];
        o->gate89[e][k] = o->gate89[e][k - 1];
        memcpy(o->weight[e][k], o->weight[e][k - 1], sizeof(o->weight[e][k]));
        return;
    }
    if (x1 >= 0 && x2 >= 0) {
        o->gate[e][k] = gate_constant(o, oracle_psi(o, x1, x2), o->q.tilt_deg);
        o->gate89[e][k] = gate_constant(o, oracle_psi(o, x1, x2), 89);
    }
    line_weights(o, e, i, o->uneven ? j : 1, o->weight[e][k]);
}

/* ---- what a single dexel gives -------------------------------------------------------------- */

static inline void set_dexel(struct oracle *o, const struct dx_plane *p, size_t k)
{
    const double u = (double)o->g->unit_m;
    const wide r = (wide)dx_plane_range(p, k), most = (1 << 27) - 1;
    const wide noise = (wide)rint(256 * floor_s0(o) / u) +
                       (r * (wide)rint(16777216.0 * o->q.sigma[1]) >> 16) +
                       ((r * r >> 16) * (wide)rint(1099511627776.0 * o->q.sigma[2] * u) >> 16);

    o->range[k] = (uint32_t)r;
    o->noise8[k] = noise < most ? noise : most;
    if (r < 16)
        return;
    o->inverse[k] = (1ull << 40) / (uint64_t)r;
    o->inverse_noise8[k] = o->noise8[k] * (wide)o->inverse[k] / r;
}

static inline void set_direction(struct oracle *o, size_t k)
{
    double d[3], z;

    dx_geometry_direction(o->g, (uint32_t)(k / o->g->width), (uint32_t)(k % o->g->width), d);
    z = o->g->model == DX_MODEL_PINHOLE ? d[2] : 1; /* depths: scaled to depth 1 */
    for (int x = 0; x < 3; x++)
        o->direction[k][x] = (int64_t)rint(d[x] / z * 16777216);
}

/* ---- pairs ----------------------------------------------------------------------------------- */

static inline bool within_cap(const struct oracle *o, int64_t k0, int64_t k1)
{
    const wide cap = (wide)rint(4096 * o->q.cap_m / (double)o->g->unit_m);
    wide length2 = 0;

    if (!o->direction)
        return true;
    for (int x = 0; x < 3; x++) {
        const wide d = ((wide)range_at(o, k0) * o->direction[k0][x] -
                        (wide)range_at(o, k1) * o->direction[k1][x]) >>
                       12;

        length2 += d * d;
    }
    return length2 <= cap * cap;
}

/* How far the inverse range departs from the plane of its neighbours on the line. False: unknown.
 */
static inline bool departure(wide *r, const struct oracle *o, enum line e, int64_t i, int64_t j)
{
    const int64_t x = dexel(o, i, j), m = along(o, e, i, j, -1), p = along(o, e, i, j, 1);
    const int64_t *w;

    if (x < 0 || m < 0 || p < 0 || !o->inverse[x] || !o->inverse[m] || !o->inverse[p])
        return false;
    w = o->weight[e][x];
    *r = ((wide)o->inverse[x] << 24) - w[0] * (wide)o->inverse[m] - w[1] * (wide)o->inverse[p];
    return w[0] != 0 || w[1] != 0;
}

/* Whether a dexel and its neighbours on the line are in one plane, to `k2` = the square of so many
 * sigmas. */
static inline bool fits(const struct oracle *o, enum line e, int64_t i, int64_t j, int k2)
{
    const int64_t x = dexel(o, i, j), m = along(o, e, i, j, -1), p = along(o, e, i, j, 1);
    wide r, d8, e0, em, ep;

    if (!departure(&r, o, e, i, j))
        return false;
    d8 = absolute(r) >> 16;
    e0 = o->inverse_noise8[x];
    em = o->inverse_noise8[m] * o->weight[e][x][0] >> 24;
    ep = o->inverse_noise8[p] * o->weight[e][x][1] >> 24;
    return d8 * d8 <= k2 * (e0 * e0 + em * em + ep * ep);
}

/* The second-order rule: two that follow each other fit, and an end of the pair is one of them; it
 * alone of the pair must do so surely. */
static inline bool is_rescued(const struct oracle *o, enum line e, int64_t i, int64_t j)
{
    const int64_t di = line_step[e][0], dj = line_step[e][1], x1 = dexel(o, i, j);
    const int64_t x2 = dexel(o, i + di, j + dj);
    bool before, first, second, after;

    if (!within_gate(o, x1, x2, o->gate89[e][x1]))
        return false;
    before = fits(o, e, i - di, j - dj, 9);
    first = fits(o, e, i, j, 9);
    second = fits(o, e, i + di, j + dj, 9);
    after = fits(o, e, i + 2 * di, j + 2 * dj, 9);
    return (first && second) || (before && fits(o, e, i, j, 1)) ||
           (after && fits(o, e, i + di, j + dj, 1));
}

static inline bool decide_joined(const struct oracle *o, enum line e, int64_t i, int64_t j)
{
    const int64_t x1 = dexel(o, i, j), x2 = along(o, e, i, j, 1);

    if (!range_at(o, x1) || !range_at(o, x2) || !within_cap(o, x1, x2))
        return false;
    if (o->q.paper || within_gate(o, x1, x2, o->gate[e][x1]))
        return true;
    return o->q.rescue && is_rescued(o, e, i, j);
}

/* The pair of (i,j) and the dexel n = +1 or -1 steps along the line. */
static inline bool is_joined(const struct oracle *o, enum line e, int64_t i, int64_t j, int n)
{
    const int64_t first = n > 0 ? dexel(o, i, j) : along(o, e, i, j, -1);

    return first >= 0 && o->joined[e][first];
}

/* ---- mixed pixels ---------------------------------------------------------------------------- */

static inline bool cut_off(const struct oracle *o, enum line e, int64_t i, int64_t j)
{
    return range_at(o, along(o, e, i, j, -1)) && range_at(o, along(o, e, i, j, 1)) &&
           !is_joined(o, e, i, j, -1) && !is_joined(o, e, i, j, 1);
}

static inline bool decide_dead(const struct oracle *o, int64_t i, int64_t j)
{
    int n = 0;

    if (o->q.mixed == DX_MIXED_OFF || !range_at(o, dexel(o, i, j)))
        return false;
    for (enum line e = 0; e < N_LINES; e++)
        n += is_joined(o, e, i, j, -1) + is_joined(o, e, i, j, 1);
    return cut_off(o, LINE_H, i, j) || cut_off(o, LINE_V, i, j) ||
           (o->q.mixed == DX_MIXED_STRICT && n <= 3);
}

/* Between neighbours in the order of the line, or the other way round: an edge of the mesh. */
static inline bool is_edge(const struct oracle *o, int64_t i0, int64_t j0, int64_t i1, int64_t j1)
{
    const int64_t k0 = dexel(o, i0, j0), k1 = dexel(o, i1, j1);

    if (k0 < 0 || k1 < 0 || o->dead[k0] || o->dead[k1])
        return false;
    for (enum line e = 0; e < N_LINES; e++)
        for (int n = -1; n <= 1; n += 2)
            if (i0 + n * line_step[e][0] == i1 && j0 + n * line_step[e][1] == j1)
                return is_joined(o, e, i0, j0, n);
    return false;
}

/* ---- the frame ------------------------------------------------------------------------------- */

static inline void *cleared(size_t n, size_t size)
{
    void *p = calloc(n, size);

    assert_non_null(p);
    return p;
}

static inline void oracle_alloc(struct oracle *o)
{
    o->range = cleared(o->n, sizeof(*o->range));
    o->inverse = cleared(o->n, sizeof(*o->inverse));
    o->noise8 = cleared(o->n, sizeof(*o->noise8));
    o->inverse_noise8 = cleared(o->n, sizeof(*o->inverse_noise8));
    o->dead = cleared(o->n, sizeof(*o->dead));
    o->choice = cleared(o->n, sizeof(*o->choice));
    if (o->q.cap_m > 0)
        o->direction = cleared(o->n, sizeof(*o->direction));
    for (enum line e = 0; e < N_LINES; e++) {
        o->gate[e] = cleared(o->n, sizeof(*o->gate[e]));
        o->gate89[e] = cleared(o->n, sizeof(*o->gate89[e]));
        o->weight[e] = cleared(o->n, sizeof(*o->weight[e]));
        o->joined[e] = cleared(o->n, sizeof(*o->joined[e]));
    }
}

static inline void oracle_fini(struct oracle *o)
{
    free(o->range);
    free(o->inverse);
    free(o->noise8);
    free(o->inverse_noise8);
    free(o->dead);
    free(o->choice);
    free(o->direction);
    for (enum line e = 0; e < N_LINES; e++) {
        free(o->gate[e]);
        free(o->gate89[e]);
        free(o->weight[e]);
        free(o->joined[e]);
    }
}

static inline void oracle_init(struct oracle *o, const struct dx_geometry *g,
                               const struct dx_plane *p, const struct dx_terrain_params *params)
{
    const uint32_t w = g->width;

    *o = (struct oracle){.g = g, .q = *params, .uneven = columns_are_uneven(g)};
    o->n = dx_plane_n_dexels(p);
    if (params->paper) {
        o->q.rescue = false;
        o->q.mixed = DX_MIXED_OFF;
        o->q.bridge = 0;
        o->q.diag = DX_DIAG_FIXED;
    }
    oracle_alloc(o);
    for (size_t k = 0; k < o->n; k++) {
        set_dexel(o, p, k);
        if (o->direction)
            set_direction(o, k);
        for (enum line e = 0; e < N_LINES; e++)
            set_constants(o, e, (int64_t)k / w, (int64_t)k % w);
    }
    for (enum line e = 0; e < N_LINES; e++)
        for (size_t k = 0; k < o->n; k++)
            o->joined[e][k] = decide_joined(o, e, (int64_t)k / w, (int64_t)k % w);
    for (size_t k = 0; k < o->n; k++)
        o->dead[k] = decide_dead(o, (int64_t)k / w, (int64_t)k % w);
}

#endif
