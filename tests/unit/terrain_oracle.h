/* Terrain mode from its definition, cell by cell over the whole frame: shares no code with
 * core/grid/cells.c. */
#ifndef DX_TERRAIN_ORACLE_H
#define DX_TERRAIN_ORACLE_H

#include "core/base/trig.h"
#include "terrain_fixture.h"

#include <math.h>

struct oracle {
    const struct dx_geometry *g;
    const struct dx_plane *p;
    struct dx_terrain_params q;
};

/* The first-order rule from its definition. */
static inline bool joined(const struct oracle *o, uint32_t i0, uint32_t j0, uint32_t i1,
                          uint32_t j1)
{
    double u = (double)o->g->unit_m, k = o->q.noise_k * sqrt(2), psi, c,
           tilt = dx_rad(o->q.tilt_deg);
    double s0 = o->q.sigma[0] > 0.5 * u ? o->q.sigma[0] : 0.5 * u;
    uint64_t r0 = dx_plane_range(o->p, (size_t)i0 * o->g->width + j0);
    uint64_t r1 = dx_plane_range(o->p, (size_t)i1 * o->g->width + j1);
    uint64_t lo = r0 < r1 ? r0 : r1, hi = r0 < r1 ? r1 : r0, tau;

    if (lo == 0)
        return false;
    /* even grids have one constant a row: that of the first column */
    if (o->g->model != DX_MODEL_TABLE && i0 == i1)
        psi = dx_geometry_angle(o->g, i0, 0, i0, 1);
    else if (o->g->model != DX_MODEL_TABLE && j0 == j1)
        psi = dx_geometry_angle(o->g, i0, 0, i1, 0);
    else if (o->g->model != DX_MODEL_TABLE)
        psi = dx_geometry_angle(o->g, i0, j1 == (j0 + 1) % o->g->width ? 0 : 1, i1,
                                j1 == (j0 + 1) % o->g->width ? 1 : 0);
    else
        psi = dx_geometry_angle(o->g, i0, j0, i1, j1);
    c = tilt + psi >= dx_rad(89) ? 57 * psi : dx_cos(tilt) / dx_cos(tilt + psi) - 1;
    tau = (uint64_t)rint(k * s0 / u) + (lo * (uint64_t)rint(65536 * (c + k * o->q.sigma[1])) >> 16);
    tau += (lo * lo >> 16) * (uint64_t)rint(4294967296.0 * k * o->q.sigma[2] * u) >> 16;
    return hi - lo <= tau;
}

static inline void emit(struct whole_mesh *w, bool flip, uint32_t a, uint32_t b, uint32_t c)
{
    w->triangle[w->n++] = flip ? rotated(a, c, b) : rotated(a, b, c);
}

static inline void oracle_cell(const struct oracle *o, struct whole_mesh *w, uint32_t i, uint32_t j)
{
    uint32_t n = (j + 1) % o->g->width, width = o->g->width;
    uint32_t a = i * width + j, b = i * width + n, c = (i + 1) * width + n, d = (i + 1) * width + j;
    bool ab = joined(o, i, j, i, n), dc = joined(o, i + 1, j, i + 1, n);
    bool ad = joined(o, i, j, i + 1, j), bc = joined(o, i, n, i + 1, n);
    bool ac = joined(o, i, j, i + 1, n), bd = joined(o, i, n, i + 1, j);
    bool abc = ab && bc && ac, acd = dc && ad && ac, abd = ab && ad && bd, bcd = bc && dc && bd;
    int64_t dr_ac = (int64_t)dx_plane_range(o->p, a) - dx_plane_range(o->p, c);
    int64_t dr_bd = (int64_t)dx_plane_range(o->p, b) - dx_plane_range(o->p, d);
    bool shorter_bd = o->q.diag == DX_DIAG_SHORT && llabs(dr_bd) < llabs(dr_ac);

    if (abd + bcd > abc + acd || (abd + bcd == abc + acd && shorter_bd)) {
        if (abd)
            emit(w, o->g->flip, a, b, d);
        if (bcd)
            emit(w, o->g->flip, b, c, d);
        return;
    }
    if (abc)
        emit(w, o->g->flip, a, b, c);
    if (acd)
        emit(w, o->g->flip, a, c, d);
}

static inline struct whole_mesh oracle_mesh(const struct dx_terrain *t)
{
    struct oracle o = {dx_terrain_geometry(t), dx_terrain_published(t), *dx_terrain_params(t)};
    uint32_t cols = o.g->wrap ? o.g->width : o.g->width - 1;
    struct whole_mesh w = {malloc(2 * (size_t)o.g->height * o.g->width * sizeof(struct triangle)),
                           0};

    for (uint32_t i = 0; i + 1 < o.g->height; i++)
        for (uint32_t j = 0; j < cols; j++)
            oracle_cell(&o, &w, i, j);
    qsort(w.triangle, w.n, sizeof(struct triangle), by_vertices);
    return w;
}

static inline void assert_same_mesh(const struct whole_mesh *a, const struct whole_mesh *b)
{
    assert_int_equal(a->n, b->n);
    assert_memory_equal(a->triangle, b->triangle, a->n * sizeof(struct triangle));
}

#endif
