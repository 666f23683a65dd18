/*
 * When a held tile is published: by the first dexel that moves, comes or goes, by a keyframe; and
 * what holds at the beginning of a stream and after an interruption.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "publish_fixture.h"

static void a_dexel_that_moves_takes_its_tile_along(void **state)
{
    struct dx_terrain_params params = params_of(DX_FILTER_OFF, 1.5); /* 7.5 units */
    static const struct {
        uint32_t row, col, row0, row1, col0, col1; /* the dexel, and its tile */
    } cases[] = {
        {0, 0, 0, 64, 0, 64},
        {63, 64, 0, 64, 64, 128},
        {64, 128, 64, 129, 128, 193},
        {128, 192, 64, 129, 128, 193},
    };

    (void)state;
    for (size_t c = 0; c < sizeof(cases) / sizeof(cases[0]); c++) {
        struct dx_terrain *t;
        struct rig r;

        flat(&r, 2);
        t = terrain_of(&r, &params);
        assert_int_equal(commit_columns(t, &r, 0, FLAT_WIDTH), 6);
        set_all(&r, 5007);
        assert_int_equal(commit_columns(t, &r, 0, FLAT_WIDTH), 0);
        dx_plane_set_range(&r.plane, (size_t)cases[c].row * FLAT_WIDTH + cases[c].col, 5008);
        assert_true(commit_columns(t, &r, 0, FLAT_WIDTH) > 0);
        for (uint32_t i = 0; i < FLAT_HEIGHT; i++)
            for (uint32_t j = 0; j < FLAT_WIDTH; j++) {
                size_t k = (size_t)i * FLAT_WIDTH + j;
                bool same_tile = i >= cases[c].row0 && i < cases[c].row1 && j >= cases[c].col0 &&
                                 j < cases[c].col1;

                assert_int_equal(dx_plane_range(dx_terrain_published(t), k),
                                 same_tile ? dx_plane_range(&r.plane, k) : 5000);
            }
        dx_terrain_free(t);
        rig_close(&r);
    }
}

static void what_comes_or_goes_is_not_held(void **state)
{
    struct dx_terrain_params params = params_of(DX_FILTER_OFF, 100);
    struct dx_terrain *t;
    struct rig r;

    (void)state;
    flat(&r, 2);
    t = terrain_of(&r, &params);
    commit_columns(t, &r, 0, FLAT_WIDTH);
    for (int k = 0; k < 2; k++) {
        dx_plane_set_range(&r.plane, 20 * FLAT_WIDTH + 20, k ? 1 : 0); /* as near to 0 as can be */
        commit_columns(t, &r, 0, FLAT_WIDTH);
        assert_int_equal(dx_plane_range(dx_terrain_published(t), 20 * FLAT_WIDTH + 20), k);
    }
    dx_terrain_free(t);
    rig_close(&r);
}

/* The intensity's noise alone sends nothing; where nothing is held it does. */
static void an_attribute_does_not_end_a_hold(void **state)
{
    (void)state;
    for (int hold = 0; hold < 2; hold++) {
        struct dx_terrain_params params = params_of(DX_FILTER_MEAN, hold);
        struct dx_terrain *t;
        struct rig r;

        flat(&r, 2);
        t = terrain_of(&r, &params);
        commit_columns(t, &r, 0, FLAT_WIDTH);
        dx_plane_set_attr(&r.plane, 20 * FLAT_WIDTH + 20, 9);
        assert_int_equal(commit_columns(t, &r, 0, FLAT_WIDTH), hold ? 0 : 1);
        set_all(&r, 5030); /* twice: the estimate follows, and takes the attributes along */
        commit_columns(t, &r, 0, FLAT_WIDTH);
        commit_columns(t, &r, 0, FLAT_WIDTH);
        assert_int_equal(dx_plane_attr(dx_terrain_published(t), 20 * FLAT_WIDTH + 20), 9);
        dx_terrain_free(t);
        rig_close(&r);
    }
}

static void keyframes_publish_all(void **state)
{
    struct dx_terrain_params params = params_of(DX_FILTER_OFF, 1.5);
    struct dx_terrain *t;
    struct rig r;

    (void)state;
    flat(&r, 2);
    params.ingest.keyframe = 3;
    t = terrain_of(&r, &params);
    commit_columns(t, &r, 0, FLAT_WIDTH);
    for (uint32_t frame = 2; frame < 11; frame++) {
        set_all(&r, 5000 + frame % 4);
        for (uint32_t col = 0; col < FLAT_WIDTH; col += 50)
            commit_columns(t, &r, col, col + 50 < FLAT_WIDTH ? 50 : FLAT_WIDTH - col);
        assert_int_equal(dx_plane_range(dx_terrain_published(t), 0),
                         frame < 3 ? 5000 : 5000 + frame / 3 * 3 % 4);
        assert_int_equal(dx_plane_range(dx_terrain_published(t), FLAT_HEIGHT * FLAT_WIDTH - 1),
                         frame < 3 ? 5000 : 5000 + frame / 3 * 3 % 4);
    }
    dx_terrain_free(t);
    rig_close(&r);
}

/* ---- beginnings ----------------------------------------------------------------------------- */

/* Before a frame has told the noise nothing is averaged and nothing is held. */
static void until_the_noise_is_known_all_is_published(void **state)
{
    struct dx_terrain_params params = params_of(DX_FILTER_MEAN, 100);
    struct dx_terrain *t;
    struct rig r;

    (void)state;
    params.sigma_given = false;
    still_hall(&r, 130, 200);
    t = terrain_of(&r, &params);
    for (uint32_t frame = 0; frame < 3; frame++) { /* too few returns to tell */
        for (uint32_t k = 0; k < 600; k += 4)
            dx_plane_set_range(&r.plane, k, 3000 + frame);
        commit_columns(t, &r, 0, r.g->width);
        assert_false(dx_terrain_params(t)->sigma_given);
        assert_int_equal(dx_plane_range(dx_terrain_published(t), 4), 3000 + frame);
    }
    r.config.dropout = 0;
    rig_cast(&r, 0); /* tells it */
    assert_true(commit_columns(t, &r, 0, r.g->width) > 0);
    assert_true(dx_terrain_params(t)->sigma_given);
    rig_cast(&r, 1);
    assert_int_equal(commit_columns(t, &r, 0, r.g->width), 0);
    dx_terrain_free(t);
    rig_close(&r);
}

static void an_interruption_is_forgotten(void **state)
{
    struct dx_terrain_params params = params_of(DX_FILTER_MEAN, 0);
    struct dx_terrain *t;
    struct rig r;

    (void)state;
    flat(&r, 2);
    t = terrain_of(&r, &params);
    for (int frame = 0; frame < 5; frame++)
        commit_columns(t, &r, 0, FLAT_WIDTH);
    dx_terrain_forget(t);
    assert_int_equal(dx_plane_range(dx_terrain_published(t), 0), 5000);
    set_all(&r, 5010);
    dx_plane_set_range(&r.plane, 7, 0);
    commit_columns(t, &r, 0, FLAT_WIDTH);
    assert_int_equal(dx_plane_range(dx_terrain_published(t), 0), 5010);
    assert_int_equal(dx_plane_range(dx_terrain_published(t), 7), 0);
    dx_terrain_free(t);
    rig_close(&r);
}

static void bad_parameters_are_named(void **state)
{
    struct dx_terrain_params p = params_of(DX_FILTER_MEAN, -1);

    (void)state;
    assert_null(dx_terrain_params_check(&p));
    p.ingest.n_max = 0;
    assert_non_null(dx_terrain_params_check(&p));
    p.ingest.n_max = 256;
    assert_non_null(dx_terrain_params_check(&p));
    p = params_of(DX_FILTER_MEAN, 0.0 / 0.0);
    assert_non_null(dx_terrain_params_check(&p));
    p = params_of(DX_FILTER_OFF, 101);
    assert_non_null(dx_terrain_params_check(&p));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_dexel_that_moves_takes_its_tile_along),
        cmocka_unit_test(what_comes_or_goes_is_not_held),
        cmocka_unit_test(an_attribute_does_not_end_a_hold),
        cmocka_unit_test(keyframes_publish_all),
        cmocka_unit_test(until_the_noise_is_known_all_is_published),
        cmocka_unit_test(an_interruption_is_forgotten),
        cmocka_unit_test(bad_parameters_are_named),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
