/* The quality figures: that they count what they say, and what every mesh must reach at a small
 * size. */
#include "tools/quality.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

static struct dx_quality_rig *rig_of(enum dx_scene scene, uint32_t height, uint32_t width)
{
    struct dx_quality_rig *rig;
    struct dx_scene_config c;

    dx_scene_config_default(&c, scene);
    c.height = height;
    c.width = width;
    assert_int_equal(dx_quality_rig_new(&rig, &c), 0);
    return rig;
}

static void draw(struct dx_quality_rig *rig, double sigma, double dropout, double mixed)
{
    const struct dx_quality_draw d = {
        .sigma = {sigma}, .dropout = dropout, .mixed = mixed, .seed = 1};

    dx_quality_rig_draw(rig, &d);
}

static void mesh(struct dx_quality_rig *rig)
{
    struct dx_terrain_params p = dx_quality_rig_params(rig);

    assert_int_equal(dx_quality_rig_mesh(rig, &p), 0);
}

static size_t n_cells(const struct dx_quality_rig *rig)
{
    return (size_t)rig->tiling.cell_rows * rig->tiling.cell_cols;
}

/* ---- the truth ------------------------------------------------------------------------------- */

static void surfaces_without_edges_are_smooth(void **state)
{
    static const enum dx_scene scenes[] = {DX_SCENE_SPHERE, DX_SCENE_CREASE};

    (void)state;
    for (int s = 0; s < 2; s++) {
        struct dx_quality_rig *rig = rig_of(scenes[s], 60, 90);
        size_t crossed = 0;

        for (size_t k = 0; k < n_cells(rig); k++) {
            assert_true(rig->class[k] & DX_QUALITY_SMOOTH);
            crossed += (rig->class[k] & DX_QUALITY_CROSSED) != 0;
        }
        /* the crease runs from the first row to the last, and over into some columns */
        assert_in_range(crossed, s ? rig->tiling.cell_rows : 0, s ? 120 : 0);
        dx_quality_rig_free(rig);
    }
}

/* Pickets and what is between them take turns: across a row of them no edge is surface. */
static void a_fence_is_all_discontinuity(void **state)
{
    struct dx_quality_rig *rig = rig_of(DX_SCENE_FENCE, 80, 120);
    size_t row = (size_t)40 * rig->tiling.cell_cols, width = rig->geometry->width;

    (void)state;
    for (size_t j = 0; j < rig->tiling.cell_cols; j++) {
        assert_int_equal(rig->class[row + j], DX_QUALITY_SEEN);
        assert_true(rig->rough[40 * width + j] & 1 << DX_EDGE_H);
        assert_false(rig->rough[40 * width + j] & 1 << DX_EDGE_V);
    }
    dx_quality_rig_free(rig);
}

/* Without noise a dexel that is not its true range to a unit is a mixed one. */
static void mixed_dexels_are_those_that_are_off(void **state)
{
    struct dx_quality_rig *rig = rig_of(DX_SCENE_HALL, 120, 180);
    size_t n = 0, n_off = 0;

    (void)state;
    draw(rig, 0, 0, 0.7);
    for (uint32_t i = 0; i < 120; i++)
        for (uint32_t j = 0; j < 180; j++) {
            double unit = (double)rig->geometry->unit_m;
            double range = unit * dx_plane_range(&rig->frame, (size_t)i * 180 + j);
            bool off = fabs(range - dx_quality_sight(rig, i, j)->range) > 0.51 * unit;
            bool mixed = dx_quality_rig_mixed(rig, i, j);

            assert_true(mixed || !off);
            n += mixed;
            n_off += off;
        }
    assert_true(n > 100 && n_off > n - n / 50); /* a weight near 0 mixes nothing */
    dx_quality_rig_free(rig);
}

/* ---- what is counted ------------------------------------------------------------------------- */

static void coverage_and_veil_count_cells(void **state)
{
    struct dx_quality_rig *rig = rig_of(DX_SCENE_HALL, 100, 150);
    struct dx_quality_coverage c;

    (void)state;
    draw(rig, 0, 0, 0);
    memset(rig->code, DX_CELL_ABC_ACD, n_cells(rig)); /* everything, over every edge of a box */
    c = dx_quality_coverage(rig);
    assert_true(c.full == c.smooth && c.smooth < n_cells(rig));
    assert_in_range(dx_quality_veil(rig).triangles, 1, 2 * (n_cells(rig) - c.smooth));
    memset(rig->code, DX_CELL_ABC, n_cells(rig)); /* half of it covers no cell */
    assert_int_equal(dx_quality_coverage(rig).full, 0);
    memset(rig->code, DX_CELL_NONE, n_cells(rig));
    assert_int_equal(dx_quality_veil(rig).triangles, 0);
    assert_int_equal(dx_quality_veil(rig).discontinuities, n_cells(rig) - c.smooth);
    dx_quality_rig_free(rig);
}

static void turned_faces_are_counted(void **state)
{
    struct dx_quality_rig *rig = rig_of(DX_SCENE_CREASE, 40, 60);
    struct dx_quality_topology t;

    (void)state;
    draw(rig, 0, 0, 0);
    mesh(rig);
    assert_int_equal(dx_quality_topology(&t, rig), 0);
    assert_int_equal(t.triangles, 2 * n_cells(rig));
    assert_int_equal(t.flipped, 0);
    rig->geometry->flip = !rig->geometry->flip;
    assert_int_equal(dx_quality_topology(&t, rig), 0);
    assert_int_equal(t.flipped, t.triangles);
    dx_quality_rig_free(rig);
}

static void area_is_that_of_the_cells(void **state)
{
    struct dx_quality_rig *rig = rig_of(DX_SCENE_CREASE, 100, 150);
    struct dx_terrain_params p;
    uint64_t area[3];

    (void)state;
    draw(rig, 0, 0, 0);
    mesh(rig);
    assert_int_equal(dx_quality_area(&area[0], rig), 0);
    assert_int_equal(area[0], 2 * n_cells(rig));
    draw(rig, 0, 0.05, 0);
    p = dx_quality_rig_params(rig);
    for (uint8_t k = 0; k < 3; k++) {
        p.bridge = k;
        assert_int_equal(dx_quality_rig_mesh(rig, &p), 0);
        assert_int_equal(dx_quality_area(&area[k], rig), 0);
        assert_true(area[k] < 2 * n_cells(rig) && area[k] >= area[0]);
    }
    assert_in_range(100 * area[0] / n_cells(rig), 175, 185); /* two half cells a missing dexel */
    dx_quality_rig_free(rig);
}

static void flicker_counts_cells_that_turn(void **state)
{
    struct dx_quality_rig *rig = rig_of(DX_SCENE_CREASE, 40, 60);
    uint8_t *other = malloc(n_cells(rig));

    (void)state;
    memset(rig->code, DX_CELL_ABC_ACD, n_cells(rig));
    memset(other, DX_CELL_ABC_ACD, n_cells(rig));
    assert_true(dx_quality_flicker(rig, rig->code, other) == 0);
    memset(other, DX_CELL_ABD_BCD, n_cells(rig) / 3);
    assert_true(fabs(dx_quality_flicker(rig, rig->code, other) - 1 / 3.0) < 0.01);
    free(other);
    dx_quality_rig_free(rig);
}

static void unfiltered_frames_are_as_far_off_as_their_noise(void **state)
{
    struct dx_quality_rig *rig = rig_of(DX_SCENE_HALL, 100, 150);
    const struct dx_quality_draw quiet = {.seed = 1}, noisy = {.sigma = {0.01}, .seed = 1};
    struct dx_terrain_params p;
    struct dx_quality_static s;

    (void)state;
    p = dx_quality_rig_params(rig);
    assert_int_equal(dx_quality_static(&s, rig, &p, &quiet, 1, 3), 0);
    assert_true(s.changed == 0);
    assert_int_equal(dx_quality_static(&s, rig, &p, &quiet, 0, 1), 0);
    assert_true(s.changed == 1);
    assert_int_equal(dx_quality_static(&s, rig, &p, &noisy, 1, 3), 0);
    assert_true(s.changed == 1 && fabs(s.rms_sigma - 1) < 0.05);
    dx_quality_rig_free(rig);
}

/* ---- bars at a small size -------------------------------------------------------------------- */

static void topology_is_clean_in_every_scene(void **state)
{
    (void)state;
    for (int scene = 0; scene < DX_N_SCENES; scene++) {
        struct dx_quality_rig *rig = rig_of((enum dx_scene)scene, 100, 150);
        struct dx_terrain_params p;

        draw(rig, 0.01, 0.1, 0.5);
        p = dx_quality_rig_params(rig);
        for (uint8_t bridge = 0; bridge < 3; bridge++) {
            struct dx_quality_topology t;

            p.bridge = bridge;
            p.mixed = (enum dx_mixed)bridge;
            assert_int_equal(dx_quality_rig_mesh(rig, &p), 0);
            assert_int_equal(dx_quality_topology(&t, rig), 0);
            assert_true(t.triangles > 1000);
            assert_int_equal(t.nonmanifold_edges + t.duplicate_directed_edges, 0);
            assert_int_equal(t.flipped, 0);
            assert_int_equal(t.covered_twice, 0);
        }
        dx_quality_rig_free(rig);
    }
}

static void smooth_surface_is_covered(void **state)
{
    static const double sigma[] = {0, 0.002, 0.01, 0.05};
    struct dx_quality_rig *rig = rig_of(DX_SCENE_HALL, 200, 300);

    (void)state;
    for (int k = 0; k < 4; k++) {
        struct dx_quality_coverage c;

        draw(rig, sigma[k], 0, 0);
        mesh(rig);
        c = dx_quality_coverage(rig);
        assert_true((double)c.full > 0.995 * (double)c.smooth);
    }
    dx_quality_rig_free(rig);
}

static void noise_is_told_within_a_fifth(void **state)
{
    static const struct dx_quality_draw draws[] = {{.sigma = {0.002}, .seed = 1},
                                                   {.sigma = {0.02}, .seed = 1},
                                                   {.sigma = {0.002, 0, 5e-4}, .seed = 1}};

    (void)state;
    for (int scene = 0; scene < DX_N_SCENES; scene++) {
        struct dx_quality_rig *rig;

        if (scene == DX_SCENE_FENCE) /* no four samples of one surface in a row */
            continue;
        rig = rig_of((enum dx_scene)scene, 200, 300);
        for (int k = 0; k < 3; k++) {
            struct dx_quality_noise n;

            dx_quality_rig_draw(rig, &draws[k]);
            assert_int_equal(dx_quality_noise(&n, rig), 0);
            assert_true(n.known);
            for (int m = 0; m < 3; m++)
                assert_true(fabs(n.ratio[m] - 1) <= 0.2);
        }
        dx_quality_rig_free(rig);
    }
}

static void walls_are_met_within_their_noise(void **state)
{
    struct dx_quality_rig *rig = rig_of(DX_SCENE_HALL, 200, 300);
    struct dx_quality_walls w;

    (void)state;
    draw(rig, 0.01, 0, 0);
    mesh(rig);
    w = dx_quality_walls(rig, 20);
    assert_true(w.cells > 1000);
    assert_true(w.rms_sigma > 0.6 && w.rms_sigma <= 0.75);
    dx_quality_rig_free(rig);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(surfaces_without_edges_are_smooth),
        cmocka_unit_test(a_fence_is_all_discontinuity),
        cmocka_unit_test(mixed_dexels_are_those_that_are_off),
        cmocka_unit_test(coverage_and_veil_count_cells),
        cmocka_unit_test(turned_faces_are_counted),
        cmocka_unit_test(area_is_that_of_the_cells),
        cmocka_unit_test(flicker_counts_cells_that_turn),
        cmocka_unit_test(unfiltered_frames_are_as_far_off_as_their_noise),
        cmocka_unit_test(topology_is_clean_in_every_scene),
        cmocka_unit_test(smooth_surface_is_covered),
        cmocka_unit_test(noise_is_told_within_a_fifth),
        cmocka_unit_test(walls_are_met_within_their_noise),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
