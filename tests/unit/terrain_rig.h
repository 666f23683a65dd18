/* What the tests of terrain mode share: the rule variants, scenes, random geometries and frames.
 * cmocka.h comes before. */
#ifndef DX_TERRAIN_RIG_H
#define DX_TERRAIN_RIG_H

#include "core/base/rng.h"
#include "core/grid/tile_hash.h"
#include "core/grid/tile_used.h"
#include "drivers/synth/scene.h"
#include "terrain_invariants.h"
#include "terrain_oracle.h"

#include <stdio.h>

/* A choice of rules. */
struct variant {
    enum dx_diag diag;
    bool rescue;
    enum dx_mixed mixed;
    uint8_t bridge;
    double cap_m;
    bool paper;
};

static const struct variant variants[] = {
    {.diag = DX_DIAG_FIXED},
    {.diag = DX_DIAG_SHORT},
    {.diag = DX_DIAG_SHORT, .cap_m = 0.6},
    {.paper = true, .cap_m = 0.6},
    /* the rules beyond the first order */
    {.diag = DX_DIAG_BEND, .rescue = true, .mixed = DX_MIXED_AXIS, .bridge = 1},
    {.diag = DX_DIAG_BEND, .rescue = true, .mixed = DX_MIXED_STRICT, .bridge = 2},
    {.diag = DX_DIAG_SHORT, .rescue = true, .mixed = DX_MIXED_AXIS, .bridge = 2},
    {.diag = DX_DIAG_BEND, .rescue = true, .bridge = 2, .cap_m = 0.6},
    {.diag = DX_DIAG_BEND, .mixed = DX_MIXED_AXIS, .bridge = 1},
    {.diag = DX_DIAG_FIXED, .rescue = true},
    {.diag = DX_DIAG_FIXED, .mixed = DX_MIXED_STRICT, .bridge = 2},
    {.diag = DX_DIAG_BEND, .rescue = true, .mixed = DX_MIXED_AXIS},
};

#define N_VARIANTS ((int)(sizeof(variants) / sizeof(variants[0])))

static inline void use_variant(struct dx_terrain_params *q, const struct variant *v)
{
    dx_terrain_params_default(q);
    q->diag = v->diag;
    q->rescue = v->rescue;
    q->mixed = v->mixed;
    q->bridge = v->bridge;
    q->cap_m = v->cap_m;
    q->paper = v->paper;
}

static inline bool long_run(void)
{
    return getenv("DEXEL_LONG") != NULL;
}

/* ---- meshes ---------------------------------------------------------------------------------- */

static inline struct dx_terrain *meshed(struct dx_geometry *g, const struct dx_terrain_params *q,
                                        const struct dx_plane *p, struct dx_pool *pool)
{
    struct dx_terrain *t;

    assert_int_equal(dx_terrain_new(&t, g, q, p->attr_bytes), 0);
    dx_terrain_publish(t, p, 0, p->width, pool);
    dx_terrain_commit(t, pool);
    return t;
}

/* Returns the number of triangles. */
static inline size_t assert_like_oracle(const struct dx_terrain *t)
{
    struct whole_mesh got = collect(t), want = oracle_mesh(t);
    const size_t n = want.n;

    assert_same_mesh(&got, &want);
    free(got.triangle);
    free(want.triangle);
    return n;
}

static inline size_t assert_right(const struct dx_terrain *t)
{
    check_invariants(t);
    return assert_like_oracle(t);
}

/* ---- scenes ---------------------------------------------------------------------------------- */

/* Returns the geometry; the plane holds frame 0. */
static inline struct dx_geometry *scene_frame(const struct dx_scene_config *c, struct dx_plane *p)
{
    struct dx_geometry *g;

    assert_int_equal(dx_scene_geometry(&g, c), 0);
    assert_int_equal(dx_plane_init(p, g->height, g->width, g->range_bytes, c->attr_bytes), 0);
    dx_scene_cast(p, g, c, 0, 0, g->width);
    return g;
}

/* A scene with all that rules are for: noise, drop-outs, mixed pixels. */
static inline void rough_scene(struct dx_scene_config *c, enum dx_scene scene, uint32_t height,
                               uint32_t width)
{
    dx_scene_config_default(c, scene);
    c->height = height;
    c->width = width;
    c->sigma[0] = 0.005;
    c->dropout = 0.06;
    c->mixed = 0.5;
}

/* ---- random geometries ----------------------------------------------------------------------- */

enum any_geometry {
    ANY_FULL_TURN,
    ANY_TO_THE_POLES, /* full turn */
    ANY_UNEVEN_TURN,
    ANY_PART_TURN,
    ANY_PINHOLE,
    ANY_TABLE,
    ANY_FOLDED_TABLE,
    N_ANY_GEOMETRY,
};

/* Columns whose steps differ by `uneven` of themselves, from one to the next. */
static inline void turn_unevenly(struct dx_geometry *g, double step, double uneven)
{
    double azimuth = 0;

    for (uint32_t j = 0; j < g->width; j++) {
        double s, c;

        dx_sincos(azimuth, &s, &c);
        g->table[2 * j] = (float)c;
        g->table[2 * j + 1] = (float)s;
        azimuth += step * (1 + (j & 1 ? uneven : -uneven));
    }
}

static inline void scatter_table(struct dx_geometry *g, double step_i, double step_j, double jitter,
                                 struct dx_rng *rng)
{
    for (uint32_t i = 0; i < g->height; i++)
        for (uint32_t j = 0; j < g->width; j++) {
            const double x = step_j * (j - g->width / 2.0 + jitter * (dx_rng_unit(rng) - 0.5));
            const double y = step_i * (i - g->height / 2.0 + jitter * (dx_rng_unit(rng) - 0.5));
            const double length = sqrt(x * x + y * y + 1);
            float *d = g->table + 3 * ((size_t)i * g->width + j);

            d[0] = (float)(x / length);
            d[1] = (float)(y / length);
            d[2] = (float)(1 / length);
        }
    dx_geometry_orient(g);
}

static inline struct dx_geometry *any_turn(enum any_geometry kind, uint32_t height, uint32_t width,
                                           double sign_i, double sign_j, struct dx_rng *rng)
{
    const double reach = kind == ANY_TO_THE_POLES ? 1.5 : 0.1 + dx_rng_unit(rng);
    const double turn = kind == ANY_PART_TURN ? 0.1 + 2 * dx_rng_unit(rng) : 2 * DX_PI;
    struct dx_geometry *g;

    assert_int_equal(dx_geometry_new_spinning(&g, height, width, 0.1, sign_j * turn / width,
                                              -sign_i * reach,
                                              2 * sign_i * reach / (height > 1 ? height - 1 : 1)),
                     0);
    assert_int_equal(g->wrap, kind != ANY_PART_TURN);
    if (kind == ANY_UNEVEN_TURN)
        turn_unevenly(g, sign_j * turn / width, dx_rng_below(rng, 2) ? 0.3 : 0.01);
    return g;
}

/* Of either handedness; at least 8 columns where it wraps. */
static inline struct dx_geometry *any_geometry(struct dx_rng *rng, uint32_t height, uint32_t width,
                                               uint8_t range_bytes)
{
    const enum any_geometry kind = (enum any_geometry)dx_rng_below(rng, N_ANY_GEOMETRY);
    const double sign_i = dx_rng_below(rng, 2) ? 1 : -1, sign_j = dx_rng_below(rng, 2) ? 1 : -1;
    struct dx_geometry *g;

    if (kind < ANY_PART_TURN && width < 8)
        width += 8;
    if (kind <= ANY_PART_TURN)
        g = any_turn(kind, height, width, sign_i, sign_j, rng);
    else if (kind == ANY_PINHOLE)
        assert_int_equal(dx_geometry_new_pinhole(&g, height, width, sign_j * width, sign_i * height,
                                                 width * 0.4, height * 0.6),
                         0);
    else {
        assert_int_equal(dx_geometry_new(&g, DX_MODEL_TABLE, height, width), 0);
        scatter_table(g, sign_i * 0.01, sign_j * 0.01, kind == ANY_TABLE ? 0.3 : 1, rng);
    }
    g->range_bytes = range_bytes;
    return g;
}

/* ---- random frames --------------------------------------------------------------------------- */

/* Levels of depth in blocks or at random, with and without noise, and missing dexels: edges break
 * in every pattern. */
static inline void any_frame(struct dx_plane *p, struct dx_rng *rng)
{
    const uint32_t missing = dx_rng_below(rng, 60), kind = dx_rng_below(rng, 5);
    const uint32_t spread = 1 + dx_rng_below(rng, 40), salt = dx_rng_below(rng, 1000);

    for (size_t k = 0; k < dx_plane_n_dexels(p); k++) {
        const uint64_t block = k / p->width / 3 * 65536 + k % p->width / 3;
        uint32_t range = 1000 + 1000 * (uint32_t)(dx_hash_u64(salt, block) % 3);

        if (kind == 0)
            range = 5000;
        else if (kind == 1)
            range += dx_rng_below(rng, spread);
        else if (kind == 2)
            range = 1000 * (1 + dx_rng_below(rng, 3));
        else if (kind == 3)
            range = 3000 + dx_rng_below(rng, 100 * spread);
        dx_plane_set_range(p, k, dx_rng_below(rng, 100) < missing ? 0 : range);
    }
}

/* Any rules, with gates that both join and cut such frames. */
static inline void any_rules(struct dx_terrain_params *q, const struct variant *v,
                             struct dx_rng *rng)
{
    use_variant(q, v);
    q->sigma_given = true;
    q->sigma[0] = 0.0005 * dx_rng_below(rng, 20);
    q->sigma[1] = 0.0001 * dx_rng_below(rng, 3);
    q->sigma[2] = 0.0001 * dx_rng_below(rng, 3);
    q->tilt_deg = dx_rng_below(rng, 90);
    q->noise_k = dx_rng_below(rng, 6);
    if (q->cap_m > 0)
        q->cap_m = 0.05 + 2 * dx_rng_unit(rng);
}

#endif
