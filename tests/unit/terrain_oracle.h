/*
 * The oracle of terrain mode, second part: cells and polar caps, and the whole mesh of a frame from
 * its definition, cell by cell. Shares no code with core/grid/cells.c. cmocka.h comes before.
 */
#ifndef DX_TERRAIN_ORACLE_H
#define DX_TERRAIN_ORACLE_H

#include "terrain_oracle_frame.h"
#include "terrain_oracle_struts.h"

/* ---- the diagonal ---------------------------------------------------------------------------- */

/* How much the surface bends along the line of a diagonal that begins at (i,j). False: unknown. */
static inline bool bend_along(wide *bend, const struct oracle *o, enum line e, int64_t i, int64_t j)
{
    wide first, second;

    if (!is_joined(o, e, i, j, -1) ||
        !is_joined(o, e, i + line_step[e][0], j + line_step[e][1], 1) ||
        !departure(&first, o, e, i, j) ||
        !departure(&second, o, e, i + line_step[e][0], j + line_step[e][1]))
        return false;
    *bend = absolute(first + second);
    return true;
}

static inline bool bend_prefers_bd(const struct oracle *o, int64_t i, int64_t j)
{
    const int64_t corner[4] = {dexel(o, i, j), dexel(o, i, j + 1), dexel(o, i + 1, j + 1),
                               dexel(o, i + 1, j)};
    int64_t nearest = corner[0];
    wide ac, bd;

    if (bend_along(&ac, o, LINE_AC, i, j) && bend_along(&bd, o, LINE_BD, i, j + 1))
        return ac > bd + (o->inverse_noise8[corner[0]] << 17);
    for (int k = 1; k < 4; k++)
        nearest = o->range[corner[k]] < o->range[nearest] ? corner[k] : nearest;
    return apart(o, corner[0], corner[2]) >
           apart(o, corner[1], corner[3]) + (o->noise8[nearest] * 1448 >> 16);
}

static inline bool prefers_bd(const struct oracle *o, int64_t i, int64_t j)
{
    switch (o->q.diag) {
    case DX_DIAG_SHORT:
        return apart(o, dexel(o, i, j + 1), dexel(o, i + 1, j)) <
               apart(o, dexel(o, i, j), dexel(o, i + 1, j + 1));
    case DX_DIAG_BEND:
        return bend_prefers_bd(o, i, j);
    default:
        return false;
    }
}

/* ---- cells ----------------------------------------------------------------------------------- */

/* The triangles of a cell. */
struct cell {
    bool abc, acd, abd, bcd;
};

static inline struct cell oracle_cell(const struct oracle *o, int64_t i, int64_t j)
{
    const bool ab = is_edge(o, i, j, i, j + 1), dc = is_edge(o, i + 1, j, i + 1, j + 1);
    const bool ad = is_edge(o, i, j, i + 1, j), bc = is_edge(o, i, j + 1, i + 1, j + 1);
    const bool ac = is_edge(o, i, j, i + 1, j + 1), bd = is_edge(o, i, j + 1, i + 1, j);
    const struct cell by_ac = {.abc = ab && bc && ac, .acd = dc && ad && ac};
    const struct cell by_bd = {.abd = ab && ad && bd, .bcd = bc && dc && bd};
    const int n_ac = by_ac.abc + by_ac.acd, n_bd = by_bd.abd + by_bd.bcd;

    if (o->g->model == DX_MODEL_TABLE &&
        dx_geometry_cell_sign(o->g, (uint32_t)i, (uint32_t)j) != (o->g->flip ? 1 : -1))
        return (struct cell){false};
    if (n_ac == n_bd && n_ac > 0)
        return prefers_bd(o, i, j) ? by_bd : by_ac;
    return n_bd > n_ac ? by_bd : by_ac;
}

static inline void emit(const struct oracle *o, struct whole_mesh *w, int64_t a, int64_t b,
                        int64_t c)
{
    w->triangle[w->n++] = o->g->flip ? rotated((uint32_t)a, (uint32_t)c, (uint32_t)b)
                                     : rotated((uint32_t)a, (uint32_t)b, (uint32_t)c);
}

static inline void emit_cell(const struct oracle *o, struct whole_mesh *w, int64_t i, int64_t j)
{
    const int64_t a = dexel(o, i, j), b = dexel(o, i, j + 1), c = dexel(o, i + 1, j + 1),
                  d = dexel(o, i + 1, j);
    const struct cell cell = oracle_cell(o, i, j);

    if (cell.abc)
        emit(o, w, a, b, c);
    if (cell.acd)
        emit(o, w, a, c, d);
    if (cell.abd)
        emit(o, w, a, b, d);
    if (cell.bcd)
        emit(o, w, b, c, d);
}

/* ---- polar caps ------------------------------------------------------------------------------ */

/* Triangle j of the fan over the first or the last row, before flip. */
static inline void cap_triangle(const struct oracle *o, bool last, int64_t j, int64_t v[3])
{
    const int64_t i = last ? o->g->height - 1 : 0;

    v[0] = dexel(o, i, 0);
    v[1] = dexel(o, i, last ? j : j + 1);
    v[2] = dexel(o, i, last ? j + 1 : j);
}

static inline bool is_capped(const struct oracle *o, bool last)
{
    const int64_t i = last ? o->g->height - 1 : 0, width = o->g->width;

    if (o->g->model != DX_MODEL_SPINNING || !o->g->wrap)
        return false;
    for (int64_t j = 0; j < width; j++) {
        const struct cell c = oracle_cell(o, last ? i - 1 : 0, j);

        if (!range_at(o, dexel(o, i, j)) || o->dead[dexel(o, i, j)] ||
            !is_edge(o, i, j, i, j + 1) || !(last ? c.acd || c.bcd : c.abc || c.abd))
            return false;
    }
    for (int64_t j = 1; j + 1 < width; j++) {
        int64_t v[3];

        cap_triangle(o, last, j, v);
        if (!sees_scanner(o, v, 0)) /* one plane: the sign is the row's own */
            return false;
    }
    return true;
}

/* Bit 0: the first row, bit 1: the last. */
static inline unsigned oracle_caps(const struct dx_geometry *g, const struct dx_plane *p,
                                   const struct dx_terrain_params *params)
{
    unsigned caps = 0;
    struct oracle o;

    oracle_init(&o, g, p, params);
    for (unsigned last = 0; last < 2; last++)
        if (params->caps && is_capped(&o, last))
            caps |= 1u << last;
    oracle_fini(&o);
    return caps;
}

/* ---- the whole frame ------------------------------------------------------------------------- */

static inline struct whole_mesh oracle_mesh_of(const struct dx_geometry *g,
                                               const struct dx_plane *p,
                                               const struct dx_terrain_params *params)
{
    const int64_t height = g->height, width = g->width, cols = g->wrap ? width : width - 1;
    struct whole_mesh w = {malloc((2 * (size_t)(height * width) + 1) * sizeof(struct triangle)), 0};
    struct oracle o;

    assert_non_null(w.triangle);
    oracle_init(&o, g, p, params);
    oracle_choose(&o);
    for (int64_t i = 0; i + 1 < height; i++)
        for (int64_t j = 0; j < cols; j++)
            emit_cell(&o, &w, i, j);
    for (int64_t i = 0; o.q.bridge && i < height; i++)
        for (int64_t j = 0; j < width; j++)
            emit_strut(&o, &w, i, j);
    oracle_fini(&o);
    qsort(w.triangle, w.n, sizeof(struct triangle), by_vertices);
    return w;
}

/* Adds the fans of `caps` to a mesh. */
static inline void add_caps(struct whole_mesh *w, const struct dx_geometry *g, unsigned caps)
{
    const struct oracle o = {.g = g};

    w->triangle = realloc(w->triangle, (w->n + 2 * (size_t)g->width + 1) * sizeof(struct triangle));
    assert_non_null(w->triangle);
    for (unsigned last = 0; last < 2; last++)
        for (int64_t j = 1; (caps >> last & 1) && j + 1 < g->width; j++) {
            int64_t v[3];

            cap_triangle(&o, last, j, v);
            emit(&o, w, v[0], v[1], v[2]);
        }
    qsort(w->triangle, w->n, sizeof(struct triangle), by_vertices);
}

static inline struct whole_mesh oracle_mesh(const struct dx_terrain *t)
{
    return oracle_mesh_of(dx_terrain_geometry(t), dx_terrain_published(t), dx_terrain_params(t));
}

static inline void assert_same_mesh(const struct whole_mesh *a, const struct whole_mesh *b)
{
    assert_int_equal(a->n, b->n);
    assert_memory_equal(a->triangle, b->triangle, a->n * sizeof(struct triangle));
}

#endif
