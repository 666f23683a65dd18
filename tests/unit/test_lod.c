/*
 * Levels of detail (docs/terrain.md): no cracks, one orientation, the whole mesh's boundary; the
 * definition; any threads; and after any change of the array, just the tiles that are told.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "lod_oracle.h"
#include "lod_rig.h"

static const struct dx_lod_level levels[] = {
    {.bound = 16}, {.bound = 40}, {.bound = 64},  {.bound = 160},
    {.stride = 2}, {.stride = 8}, {.stride = 64}, {.bound = 64, .stride = 4},
};

#define N_LEVELS ((int)(sizeof(levels) / sizeof(levels[0])))

static void use_noise(struct dx_terrain_params *q)
{
    q->sigma_given = true;
    q->sigma[0] = 0.005;
}

/* ---- scenes ---------------------------------------------------------------------------------- */

struct grid {
    uint32_t height, width;
};

static void check_levels(struct dx_geometry *g, const struct dx_plane *p,
                         const struct dx_terrain_params *q)
{
    struct dx_terrain *t = meshed(g, q, p, NULL);

    for (int k = 0; k < N_LEVELS; k++) {
        struct whole_mesh w = lod_mesh_of(t, levels[k], NULL);

        lod_check(&w, t);
        free(w.triangle);
    }
    dx_terrain_free(t);
}

/* Full turns of whole and broken numbers of tiles. */
static void scenes_have_no_cracks(void **state)
{
    static const enum dx_scene scenes[] = {DX_SCENE_HALL, DX_SCENE_OPEN, DX_SCENE_STAIRS};
    static const struct grid grids[] = {{129, 256}, {90, 300}, {70, 321}};

    (void)state;
    for (int s = 0; s < 3; s++)
        for (int rough = 0; rough < 2; rough++) {
            struct dx_terrain_params q;
            struct dx_scene_config c;
            struct dx_geometry *g;
            struct dx_plane p;

            rough_scene(&c, scenes[s], grids[s].height, grids[s].width);
            c.dropout = rough ? 0.01 : 0;
            c.mixed = rough ? 0.5 : 0;
            g = scene_frame(&c, &p);
            use_variant(&q, &variants[4 + rough]);
            use_noise(&q);
            check_levels(g, &p, &q);
            dx_plane_fini(&p);
            dx_geometry_unref(g);
        }
}

/* ---- the definition -------------------------------------------------------------------------- */

static bool same_mesh(const struct whole_mesh *a, const struct whole_mesh *b)
{
    return a->n == b->n && memcmp(a->triangle, b->triangle, a->n * sizeof(*a->triangle)) == 0;
}

/* Returns whether the definition left no choice. */
static bool check_definition(const struct dx_terrain *t, struct dx_lod_level level)
{
    const double bound = (double)level.bound / DX_LOD_PER_SIGMA;
    struct whole_mesh got = lod_mesh_of(t, level, NULL);
    /* an error is rounded down to sixteenths: what counts is whether it reaches the next one */
    struct whole_mesh finer =
        lod_oracle_mesh(t, level.bound ? bound + 1.0 / DX_LOD_PER_SIGMA : 0, level.stride, -0.01);
    struct whole_mesh coarser =
        lod_oracle_mesh(t, level.bound ? bound + 1.0 / DX_LOD_PER_SIGMA : 0, level.stride, 0.01);
    const bool sure = same_mesh(&finer, &coarser);

    if (sure)
        assert_same_mesh(&got, &finer);
    assert_true(got.n <= finer.n && got.n >= coarser.n);
    free(coarser.triangle);
    free(finer.triangle);
    free(got.triangle);
    return sure;
}

/* A smooth surface with steps, and holes here and there: levels of every size. */
static void wavy_frame(struct dx_plane *p, struct dx_rng *rng)
{
    const double wave = 20 + dx_rng_below(rng, 200), height = dx_rng_below(rng, 40);
    const uint32_t missing = dx_rng_below(rng, 2) ? dx_rng_below(rng, 40) : 0;

    for (size_t k = 0; k < dx_plane_n_dexels(p); k++) {
        const size_t row = k / p->width, col = k % p->width;
        const double x = (double)col, y = (double)row;
        const double range = 5000 + height * (dx_sin(x / wave) + dx_sin(y / wave));

        dx_plane_set_range(p, k, dx_rng_below(rng, 10000) < missing ? 0 : (uint32_t)range);
    }
}

static void any_grid_is_as_defined(void **state)
{
    const int n = long_run() ? 2000 : 40;
    struct dx_rng rng = dx_rng_init(5, 0);
    int n_sure = 0;

    (void)state;
    for (int k = 0; k < n; k++) {
        const uint32_t height = 2 + dx_rng_below(&rng, 150), width = 2 + dx_rng_below(&rng, 200);
        const struct variant *v = &variants[dx_rng_below(&rng, N_VARIANTS)];
        struct dx_geometry *g = any_geometry(&rng, height, dx_rng_below(&rng, 3) ? width : 192,
                                             dx_rng_below(&rng, 4) ? 2 : 4);
        struct dx_terrain_params q;
        struct dx_terrain *t;
        struct whole_mesh w;
        struct dx_plane p;
        const struct dx_lod_level level = levels[dx_rng_below(&rng, N_LEVELS)];

        any_rules(&q, v, &rng);
        assert_int_equal(dx_plane_init(&p, g->height, g->width, g->range_bytes, 0), 0);
        if (k % 3)
            wavy_frame(&p, &rng);
        else
            any_frame(&p, &rng);
        t = meshed(g, &q, &p, NULL);
        w = lod_mesh_of(t, level, NULL);
        lod_check(&w, t);
        free(w.triangle);
        n_sure += check_definition(t, level);
        dx_terrain_free(t);
        dx_plane_fini(&p);
        dx_geometry_unref(g);
    }
    assert_true(n_sure > n / 2);
}

/* ---- what one sees --------------------------------------------------------------------------- */

/* A camera before a wall: two triangles a tile, whatever the tile's diagonal; each sample of the
 * plane between them is left out. */
static void a_wall_is_two_triangles_a_tile(void **state)
{
    struct dx_terrain_params q;
    struct dx_geometry *g;
    struct dx_plane p;
    struct dx_terrain *t;
    struct whole_mesh w;

    (void)state;
    assert_int_equal(dx_geometry_new_pinhole(&g, 129, 193, 300, 300, 96, 64), 0);
    assert_int_equal(dx_plane_init_for(&p, g, 0), 0);
    for (size_t k = 0; k < dx_plane_n_dexels(&p); k++)
        dx_plane_set_range(&p, k, 4000);
    dx_terrain_params_default(&q);
    use_noise(&q);
    t = meshed(g, &q, &p, NULL);
    w = lod_mesh_of(t, (struct dx_lod_level){.bound = 1}, NULL);
    assert_int_equal(w.n, 2 * 2 * 3);
    lod_check(&w, t);
    free(w.triangle);
    w = lod_mesh_of(t, (struct dx_lod_level){.stride = 16}, NULL);
    assert_int_equal(w.n, 2 * 2 * 3 * 16);
    free(w.triangle);
    dx_terrain_free(t);
    dx_plane_fini(&p);
    dx_geometry_unref(g);
}

/* Tilted against a turning scanner, a plane is as plain: its samples lie on no line of a row. */
static void a_plane_keeps_no_sample_between(void **state)
{
    const double n[3] = {0.8, 0.1, 0.6}, distance = 4;
    struct dx_terrain_params q;
    struct dx_geometry *g;
    struct dx_plane p;
    struct dx_terrain *t;
    struct whole_mesh w;

    (void)state;
    assert_int_equal(dx_geometry_new_spinning(&g, 129, 129, -0.32, 0.005, 0.1, 0.005), 0);
    assert_int_equal(dx_plane_init_for(&p, g, 0), 0);
    for (uint32_t k = 0; k < 129 * 129; k++) {
        double d[3];

        dx_geometry_direction(g, k / 129, k % 129, d);
        dx_plane_set_range(
            &p, k, dx_geometry_units(g, distance / (n[0] * d[0] + n[1] * d[1] + n[2] * d[2])));
    }
    dx_terrain_params_default(&q);
    use_noise(&q);
    t = meshed(g, &q, &p, NULL);
    w = lod_mesh_of(t, (struct dx_lod_level){.bound = 8}, NULL);
    assert_int_equal(w.n, 2 * 4);
    free(w.triangle);
    dx_terrain_free(t);
    dx_plane_fini(&p);
    dx_geometry_unref(g);
}

/* Vertices bring along what they have in the whole mesh. */
static void vertices_keep_attributes_and_normals(void **state)
{
    struct dx_terrain_params q;
    struct dx_scene_config c;
    struct dx_geometry *g;
    struct dx_terrain *t;
    struct dx_plane p;
    struct dx_lod *lod;
    struct lod_tiles s;

    (void)state;
    rough_scene(&c, DX_SCENE_HALL, 130, 200);
    c.attr_bytes = 2;
    g = scene_frame(&c, &p);
    dx_terrain_params_default(&q);
    use_noise(&q);
    q.normals = true;
    t = meshed(g, &q, &p, NULL);
    lod = lod_of(t, levels[2], NULL);
    lod_tiles_init(&s, t);
    for (uint32_t n = 0; n < s.n_tiles; n++) {
        uint32_t v = 0;

        lod_tiles_set(&s, lod, levels[2], t, n);
        assert_int_equal(s.mesh->attr_bytes, 2);
        assert_true(s.mesh->has_normals);
        assert_true(s.mesh->n_vertices < s.whole->n_vertices);
        for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++)
            if (s.mesh->mask[k / 8] >> (k % 8) & 1) {
                assert_int_equal(s.mesh->attr[v], s.source->attr[k]);
                assert_memory_equal(s.mesh->normal + 2 * v, s.source->normal + 2 * k, 2);
                v++;
            }
    }
    lod_tiles_fini(&s);
    dx_lod_free(lod);
    dx_terrain_free(t);
    dx_plane_fini(&p);
    dx_geometry_unref(g);
}

/* A fan over a pole hangs on every dexel of its row. */
static void rows_under_caps_stay_whole(void **state)
{
    const struct dx_lod_level coarsest = {.stride = 64};
    struct dx_terrain_params q;
    struct dx_geometry *g;
    struct dx_plane p;
    struct dx_terrain *t;
    struct whole_mesh w;
    bool used[2][192] = {{false}};

    (void)state;
    assert_int_equal(dx_geometry_new_spinning(&g, 66, 192, 0, 2 * DX_PI / 192, -1.2, 0.02), 0);
    assert_int_equal(dx_plane_init_for(&p, g, 0), 0);
    for (size_t k = 0; k < dx_plane_n_dexels(&p); k++)
        dx_plane_set_range(&p, k, 4000);
    dx_terrain_params_default(&q);
    use_noise(&q);
    q.caps = true;
    t = meshed(g, &q, &p, NULL);
    assert_int_equal(dx_terrain_caps(t), DX_CAP_FIRST | DX_CAP_LAST);
    w = lod_mesh_of(t, coarsest, NULL);
    for (size_t k = 0; k < 3 * w.n; k++) {
        const uint32_t v = w.triangle[k / 3].v[k % 3];

        if (v / 192 == 0 || v / 192 == 65)
            used[v / 192 != 0][v % 192] = true;
    }
    for (int k = 0; k < 2 * 192; k++)
        assert_true(used[k / 192][k % 192]);
    lod_check(&w, t);
    free(w.triangle);
    dx_terrain_free(t);
    dx_plane_fini(&p);
    dx_geometry_unref(g);
}

static struct whole_mesh mesh_by(struct dx_geometry *g, struct dx_terrain_params *q,
                                 const struct dx_plane *p, struct dx_lod_level level,
                                 enum dx_simd simd)
{
    struct dx_terrain *t;
    struct whole_mesh w;

    q->simd = simd;
    t = meshed(g, q, p, NULL);
    w = lod_mesh_of(t, level, NULL);
    dx_terrain_free(t);
    return w;
}

/* A surface that bends and shakes a little, from the nearest ranges to the farthest. */
static void smooth_frame(struct dx_plane *p, struct dx_rng *rng)
{
    const uint32_t near = 40 + dx_rng_below(rng, 60000), slope = dx_rng_below(rng, 40);

    for (size_t k = 0; k < dx_plane_n_dexels(p); k++) {
        const uint32_t row = (uint32_t)(k / p->width), col = (uint32_t)(k % p->width);
        const uint32_t range = near + slope * row + row * col / 16 + dx_rng_below(rng, 4);

        dx_plane_set_range(p, k, dx_rng_below(rng, 200) && range < 65536 ? range : 0);
    }
}

/* The loops of each instruction set, on any ranges: near the least that they take, far, missing,
 * with steps. Rows and columns that end inside a tile, on it, and one beyond. */
static void every_set_cuts_alike(void **state)
{
    static const struct grid grids[] = {{129, 193}, {70, 130}, {66, 128}, {200, 65}};
    struct dx_rng rng = dx_rng_init(31, 0);

    (void)state;
    for (unsigned round = 0; round < (long_run() ? 400u : 24u); round++) {
        const struct grid grid = grids[round % 4];
        const struct dx_lod_level level = levels[round % N_LEVELS];
        struct dx_geometry *g = any_geometry(&rng, grid.height, grid.width, 2);
        struct dx_terrain_params q;
        struct whole_mesh want;
        struct dx_plane p;

        assert_int_equal(dx_plane_init(&p, g->height, g->width, 2, 0), 0);
        (round % 3 ? smooth_frame : any_frame)(&p, &rng);
        dx_terrain_params_default(&q);
        use_noise(&q);
        q.sigma[1] = 1e-4 * dx_rng_below(&rng, 20);
        q.sigma[2] = 1e-5 * dx_rng_below(&rng, 20);
        want = mesh_by(g, &q, &p, level, DX_SIMD_GENERIC);
        for (enum dx_simd simd = DX_SIMD_GENERIC + 1; simd < DX_N_SIMD; simd++) {
            struct whole_mesh got;

            if (!dx_rows_get(simd))
                continue;
            got = mesh_by(g, &q, &p, level, simd);
            assert_same_mesh(&got, &want);
            free(got.triangle);
        }
        free(want.triangle);
        dx_plane_fini(&p);
        dx_geometry_unref(g);
    }
}

static void levels_are_checked(void **state)
{
    (void)state;
    for (int k = 0; k < N_LEVELS; k++)
        assert_null(dx_lod_check(levels[k]));
    assert_null(dx_lod_check((struct dx_lod_level){0}));
    assert_non_null(dx_lod_check((struct dx_lod_level){.bound = 65535}));
    assert_non_null(dx_lod_check((struct dx_lod_level){.stride = 1}));
    assert_non_null(dx_lod_check((struct dx_lod_level){.stride = 12}));
    assert_non_null(dx_lod_check((struct dx_lod_level){.stride = 128}));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scenes_have_no_cracks),
        cmocka_unit_test(any_grid_is_as_defined),
        cmocka_unit_test(a_wall_is_two_triangles_a_tile),
        cmocka_unit_test(a_plane_keeps_no_sample_between),
        cmocka_unit_test(vertices_keep_attributes_and_normals),
        cmocka_unit_test(rows_under_caps_stay_whole),
        cmocka_unit_test(every_set_cuts_alike),
        cmocka_unit_test(levels_are_checked),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
