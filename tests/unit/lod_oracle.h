/*
 * Levels of detail from their definition (docs/terrain.md): the triangles of each tile halved one
 * by one, in doubles, and whatever must be cut cut until nothing more follows. Shares no code with
 * core/grid/lod*.c. Errors within a hundredth of the bound may be taken either way: `slack` says
 * which. cmocka.h comes before.
 */
#ifndef DX_LOD_ORACLE_H
#define DX_LOD_ORACLE_H

#include "core/grid/faces.h"
#include "core/grid/sigma.h"
#include "terrain_fixture.h"

#include <math.h>

struct lod_oracle {
    const struct dx_terrain *t;
    const struct dx_tiling *tiling;
    const struct dx_geometry *g;
    double bound, slack; /* sigmas */
    struct dx_sigma sigma;
    uint32_t stride; /* 0: none */
    uint8_t *code;   /* of all cells */
    bool *active;    /* by dexel */
    bool changed;
    struct whole_mesh mesh;
    uint8_t *halves; /* by cell: how many of its halves are there */
};

/* Of one tile's lattice: rows and columns of the grid, the seam not undone. */
struct lod_place {
    int32_t row, col;
};

static inline uint32_t lod_id(const struct lod_oracle *o, struct lod_place p)
{
    return (uint32_t)p.row * o->tiling->width + (uint32_t)p.col % o->tiling->width;
}

static inline bool lod_in_grid(const struct lod_oracle *o, struct lod_place p)
{
    return p.row <= (int32_t)o->tiling->cell_rows && p.col <= (int32_t)o->tiling->cell_cols;
}

static inline void lod_box(const struct lod_place c[3], int32_t low[2], int32_t high[2])
{
    low[0] = high[0] = c[0].row;
    low[1] = high[1] = c[0].col;
    for (int k = 1; k < 3; k++) {
        low[0] = c[k].row < low[0] ? c[k].row : low[0];
        high[0] = c[k].row > high[0] ? c[k].row : high[0];
        low[1] = c[k].col < low[1] ? c[k].col : low[1];
        high[1] = c[k].col > high[1] ? c[k].col : high[1];
    }
}

static inline bool lod_is_outside(const struct lod_oracle *o, const struct lod_place c[3])
{
    int32_t low[2], high[2];

    lod_box(c, low, high);
    return low[0] >= (int32_t)o->tiling->cell_rows || low[1] >= (int32_t)o->tiling->cell_cols;
}

/* ---- what must be cut ------------------------------------------------------------------------ */

static inline bool lod_is_full(const struct lod_oracle *o, int32_t row, int32_t col)
{
    const uint8_t code = o->code[(size_t)row * o->tiling->cell_cols + (size_t)col];

    return code == DX_CELL_ABC_ACD || code == DX_CELL_ABD_BCD;
}

/* Whether the triangle covers some of a cell: the middle of the cell, or of one of its sides that
 * the triangle ends at, would be inside. Twice the coordinates. */
static inline bool lod_covers(const struct lod_place c[3], int32_t row, int32_t col)
{
    static const double inside[4][2] = {{0.5, 0.2}, {0.5, 0.8}, {0.2, 0.5}, {0.8, 0.5}};

    for (int n = 0; n < 4; n++) {
        const double y = row + inside[n][0], x = col + inside[n][1];
        int sides = 0;

        for (int m = 0; m < 3; m++) {
            const struct lod_place a = c[m], b = c[(m + 1) % 3];

            sides += (b.col - a.col) * (y - a.row) - (b.row - a.row) * (x - a.col) > 0 ? 1 : -1;
        }
        if (sides == 3 || sides == -3)
            return true;
    }
    return false;
}

static inline bool lod_has_gap(const struct lod_oracle *o, const struct lod_place c[3])
{
    int32_t low[2], high[2];

    lod_box(c, low, high);
    for (int32_t i = low[0]; i < high[0]; i++)
        for (int32_t j = low[1]; j < high[1]; j++)
            if (!lod_is_full(o, i, j) && lod_covers(c, i, j))
                return true;
    return false;
}

static inline void lod_direction(const struct lod_oracle *o, struct lod_place p, double d[3])
{
    const uint32_t col = (uint32_t)p.col % o->tiling->width;

    if (o->g->model == DX_MODEL_PINHOLE) {
        d[0] = (double)o->g->table[col];
        d[1] = (double)o->g->table[(size_t)o->g->width + (size_t)p.row];
        d[2] = 1;
    } else {
        dx_geometry_direction(o->g, (uint32_t)p.row, col, d);
    }
}

static inline double lod_det(double a[3], double b[3], double c[3])
{
    return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
           a[2] * (b[0] * c[1] - b[1] * c[0]);
}

/* Error of the middle of c[1] and c[2] from the triangle's plane, which a thin triangle of a
 * crooked table does not tell; `beyond`: its beam does not meet the triangle. */
static inline double lod_error(const struct lod_oracle *o, const struct lod_place c[3],
                               struct lod_place m, bool *beyond)
{
    const struct dx_plane *plane = dx_terrain_published(o->t);
    double d[3][3], dm[3], whole, q = 0, r;
    double share[3];

    for (int k = 0; k < 3; k++)
        lod_direction(o, c[k], d[k]);
    lod_direction(o, m, dm);
    whole = lod_det(d[0], d[1], d[2]);
    share[0] = lod_det(dm, d[1], d[2]) / whole;
    share[1] = lod_det(d[0], dm, d[2]) / whole;
    share[2] = lod_det(d[0], d[1], dm) / whole;
    *beyond = share[0] < -1e-9;
    for (int k = 0; k < 3; k++)
        if (fabs(share[k]) > 2)
            return INFINITY;
    for (int k = 0; k < 3; k++)
        q += share[k] / dx_plane_range(plane, lod_id(o, c[k]));
    r = dx_plane_range(plane, lod_id(o, m));
    return fabs(1 / r - q) * r * r / (dx_sigma_at(&o->sigma, (uint32_t)r) / 256.0);
}

static inline bool lod_must_cut(const struct lod_oracle *o, const struct lod_place c[3],
                                struct lod_place m, bool has_twin)
{
    uint32_t at[3][2];
    int32_t low[2], high[2];
    double error;
    bool beyond;

    lod_box(c, low, high);
    if (high[0] > (int32_t)o->tiling->cell_rows || high[1] > (int32_t)o->tiling->cell_cols ||
        lod_has_gap(o, c))
        return true;
    for (int k = 0; k < 3; k++) {
        at[k][0] = (uint32_t)c[k].row;
        at[k][1] = (uint32_t)c[k].col % o->tiling->width;
    }
    if (o->g->model != DX_MODEL_PINHOLE && !dx_faces_triangle(o->g, (const uint32_t(*)[2])at))
        return true;
    if (o->stride &&
        (high[0] - low[0] > (int32_t)o->stride || high[1] - low[1] > (int32_t)o->stride))
        return true;
    error = lod_error(o, c, m, &beyond);
    return isinf(error) ||
           (o->bound > 0 && !(beyond && has_twin) && error > o->bound * (1 + o->slack));
}

/* ---- cutting --------------------------------------------------------------------------------- */

static inline void lod_activate(struct lod_oracle *o, struct lod_place p)
{
    bool *a;

    if (!lod_in_grid(o, p))
        return;
    a = &o->active[lod_id(o, p)];
    o->changed |= !*a;
    *a = true;
}

static inline bool lod_is_leaf(const struct lod_place c[3])
{
    return abs(c[0].row - c[1].row) + abs(c[0].col - c[1].col) == 1;
}

/* Whether there is a triangle of the grid on the hypotenuse's other side. */
static inline bool lod_has_twin(const struct lod_oracle *o, const struct lod_place c[3],
                                struct lod_place m)
{
    const int64_t row = 2 * (int64_t)m.row - c[0].row, col = 2 * (int64_t)m.col - c[0].col;

    return row >= 0 && row <= o->tiling->cell_rows &&
           (o->tiling->wrap || (col >= 0 && col <= o->tiling->cell_cols));
}

typedef void lod_visit(struct lod_oracle *o, const struct lod_place c[3], struct lod_place m);

/* Every triangle of the halving, whether it will be there or not (all), or those that are. */
static inline void lod_walk(struct lod_oracle *o, const struct lod_place c[3], bool all,
                            lod_visit *visit)
{
    const struct lod_place m = {(c[1].row + c[2].row) / 2, (c[1].col + c[2].col) / 2};
    const bool outside = lod_is_outside(o, c);

    if (outside)
        return;
    if (lod_is_leaf(c) || all || (lod_in_grid(o, m) && !o->active[lod_id(o, m)]))
        visit(o, c, m);
    if (lod_is_leaf(c))
        return;
    if (all || !lod_in_grid(o, m) || o->active[lod_id(o, m)]) {
        lod_walk(o, (const struct lod_place[3]){m, c[0], c[1]}, all, visit);
        lod_walk(o, (const struct lod_place[3]){m, c[2], c[0]}, all, visit);
    }
}

static inline void lod_walk_tiles(struct lod_oracle *o, bool all, lod_visit *visit)
{
    for (uint32_t n = 0; n < dx_tiling_n_tiles(o->tiling); n++) {
        const int32_t i = (int32_t)(n / o->tiling->cols), j = (int32_t)(n % o->tiling->cols);
        const struct lod_place a = {64 * i, 64 * j}, b = {64 * i, 64 * j + 64};
        const struct lod_place c = {64 * i + 64, 64 * j + 64}, d = {64 * i + 64, 64 * j};
        const bool main = (i + j) % 2 == 0;

        lod_walk(o,
                 main ? (const struct lod_place[3]){b, c, a} : (const struct lod_place[3]){a, b, d},
                 all, visit);
        lod_walk(o,
                 main ? (const struct lod_place[3]){d, a, c} : (const struct lod_place[3]){c, d, b},
                 all, visit);
    }
}

/* A leaf is cut no further, but a gap in it, or at its other half, asks for both. */
static inline void lod_visit_must(struct lod_oracle *o, const struct lod_place c[3],
                                  struct lod_place m)
{
    if (lod_is_leaf(c)) {
        const int32_t row = c[1].row < c[2].row ? c[1].row : c[2].row;
        const int32_t col = c[1].col < c[2].col ? c[1].col : c[2].col;

        if (!lod_is_full(o, row, col))
            lod_activate(o, c[0]);
    } else if (lod_must_cut(o, c, m, lod_has_twin(o, c, m))) {
        lod_activate(o, m);
    }
}

/* A triangle that is cut must be there: its right angle is where the larger one was cut. */
static inline void lod_visit_parents(struct lod_oracle *o, const struct lod_place c[3],
                                     struct lod_place m)
{
    if (!lod_is_leaf(c) && lod_in_grid(o, m) && o->active[lod_id(o, m)])
        lod_activate(o, c[0]);
}

/* ---- the mesh -------------------------------------------------------------------------------- */

static inline void lod_put(struct lod_oracle *o, struct lod_place a, struct lod_place b,
                           struct lod_place c)
{
    const uint32_t x = lod_id(o, a), y = lod_id(o, b), z = lod_id(o, c);

    o->mesh.triangle[o->mesh.n++] = o->g->flip ? rotated(x, z, y) : rotated(x, y, z);
}

static inline void lod_visit_put(struct lod_oracle *o, const struct lod_place c[3],
                                 struct lod_place m)
{
    const int32_t row = c[1].row < c[2].row ? c[1].row : c[2].row;
    const int32_t col = c[1].col < c[2].col ? c[1].col : c[2].col;
    const struct lod_place a = {row, col}, b = {row, col + 1}, e = {row + 1, col + 1},
                           d = {row + 1, col};
    uint8_t *halves;

    (void)m;
    if (!lod_is_leaf(c)) {
        lod_put(o, c[0], c[1], c[2]);
        return;
    }
    /* in the first walk halves are counted, in the second put */
    halves = &o->halves[(size_t)row * o->tiling->cell_cols + (size_t)col];
    if (*halves < 0x10) {
        ++*halves;
        return;
    }
    if (*halves == 0x11) {
        lod_put(o, c[0], c[1], c[2]);
    } else if (*halves == 0x12) {
        const uint8_t code = o->code[(size_t)row * o->tiling->cell_cols + (size_t)col];

        if (code == DX_CELL_ABC || code == DX_CELL_ABC_ACD)
            lod_put(o, a, b, e);
        if (code == DX_CELL_ACD || code == DX_CELL_ABC_ACD)
            lod_put(o, a, e, d);
        if (code == DX_CELL_ABD || code == DX_CELL_ABD_BCD)
            lod_put(o, a, b, d);
        if (code == DX_CELL_BCD || code == DX_CELL_ABD_BCD)
            lod_put(o, b, e, d);
        *halves = 0x13;
    }
}

static inline void lod_put_struts(struct lod_oracle *o, const struct dx_tile *tile)
{
    for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++) {
        struct dx_strut_corner p[DX_STRUT_MAX_TRIANGLES][3];
        const unsigned n = dx_strut_triangles(p, tile->strut[k]);

        for (unsigned t = 0; t < n; t++) {
            uint32_t v[3];

            for (int m = 0; m < 3; m++)
                v[m] = (uint32_t)dx_tile_vertex_id(o->tiling, tile->row, tile->col,
                                                   dx_tile_strut_corner(k, p[t][m]));
            o->mesh.triangle[o->mesh.n++] =
                o->g->flip ? rotated(v[0], v[2], v[1]) : rotated(v[0], v[1], v[2]);
        }
    }
}

static inline void lod_oracle_codes(struct lod_oracle *o, bool put_struts)
{
    struct dx_tile *tile = malloc(sizeof(*tile));

    assert_non_null(tile);
    for (uint32_t n = 0; n < dx_tiling_n_tiles(o->tiling); n++) {
        const bool some = dx_terrain_tile(o->t, n, tile);

        for (uint32_t i = 0; i < tile->cell_rows; i++)
            for (uint32_t j = 0; j < tile->cell_cols; j++)
                o->code[((size_t)tile->row * 64 + i) * o->tiling->cell_cols +
                        (size_t)tile->col * 64 + j] = some ? tile->code[i * 64 + j] : 0;
        if (some && put_struts)
            lod_put_struts(o, tile);
    }
    free(tile);
}

/* The mesh of a terrain without caps. The caller frees `mesh.triangle`. */
static inline struct whole_mesh lod_oracle_mesh(const struct dx_terrain *t, double bound,
                                                uint32_t stride, double slack)
{
    const struct dx_tiling *tiling = dx_terrain_tiling(t);
    const size_t n_cells = (size_t)tiling->cell_rows * tiling->cell_cols;
    struct lod_oracle o = {.t = t,
                           .tiling = tiling,
                           .g = dx_terrain_geometry(t),
                           .bound = bound,
                           .slack = slack,
                           .stride = stride};

    dx_sigma_init(&o.sigma, dx_terrain_params(t)->sigma, (double)o.g->unit_m);
    o.code = malloc(n_cells);
    o.halves = calloc(n_cells, 1);
    o.active = calloc((size_t)tiling->height * tiling->width, sizeof(*o.active));
    o.mesh.triangle = malloc((2 * n_cells + 1) * sizeof(struct triangle));
    assert_true(o.code && o.halves && o.active && o.mesh.triangle);
    lod_oracle_codes(&o, false);
    lod_walk_tiles(&o, true, lod_visit_must);
    do {
        o.changed = false;
        lod_walk_tiles(&o, true, lod_visit_parents);
    } while (o.changed);
    lod_walk_tiles(&o, false, lod_visit_put);
    o.mesh.n = 0;
    for (size_t k = 0; k < n_cells; k++)
        o.halves[k] |= 0x10;
    lod_walk_tiles(&o, false, lod_visit_put);
    lod_oracle_codes(&o, true);
    qsort(o.mesh.triangle, o.mesh.n, sizeof(struct triangle), by_vertices);
    free(o.active);
    free(o.halves);
    free(o.code);
    return o.mesh;
}

#endif
