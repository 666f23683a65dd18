/*
 * A line scanner on a turning stage, in a room whose walls are known: where do the points of the
 * frames lie, and what is delivered when? A point stands at its column's middle, so it may be off
 * by half a column's way; with `exact` it stands where the stage was.
 */
#include "stage_rig.h"

#include <errno.h>

/* ---- whole turns ------------------------------------------------------------------------------
 */

/* One half sees everything: a row for each of its steps, a column for each angle. */
static void full_turn(void **state)
{
    (void)state;
    for (int clockwise = 0; clockwise < 2; clockwise++) {
        struct dx_stage_config c = {.angle = {.rpm = 10, .clockwise = clockwise != 0}};
        struct rig r;

        rig_init(&r, &c);
        turn(&r, 15.2);
        assert_int_equal(r.watch.geometry->width, 234);  /* 240 scans in a turn */
        assert_int_equal(r.watch.geometry->height, 719); /* of 721 steps, two look along the axis */
        assert_true(r.watch.geometry->wrap);
        assert_string_equal(dx_stage_layout_text(r.stage), "front half");
        expect_frames(&r, 2, 1);
        assert_int_equal(r.watch.n_cols[1], 234);
        assert_int_equal(dx_stage_counts(r.stage).n_late, 0);
        rig_fini(&r);
    }
}

/* A mount beside the axis, askew: carried exactly by the spinning model. */
static void offset_mount(void **state)
{
    struct dx_stage_config c = {.angle = {.rpm = 10, .start_deg = 33},
                                .offset_m = {0.12, -0.07, 0.3},
                                .angles_deg = {7, 12, 25}};
    struct rig r;

    (void)state;
    rig_init(&r, &c);
    turn(&r, 13);
    expect_frames(&r, 2, 1);
    rig_fini(&r);
    c.halves = DX_STAGE_HALVES_BOTH; /* the same, and the other half as a second layer */
    rig_init(&r, &c);
    turn(&r, 13);
    assert_string_equal(dx_stage_layout_text(r.stage), "both halves in layers");
    expect_frames(&r, 2, 0.74); /* the other half sees half of its circle, either end of it */
    rig_fini(&r);
}

/* Columns come as the stage leaves them. */
static void parts_as_it_turns(void **state)
{
    struct dx_stage_config c = {.angle = {.rpm = 6}, .columns = 100};
    struct rig r;

    (void)state;
    rig_init(&r, &c);
    turn(&r, 10); /* a whole turn: the frame that began in it is at its start */
    turn(&r, 5);
    assert_in_range(r.watch.n_columns, 48, 50);
    assert_true(r.watch.n_parts >= 98); /* each as soon as it was left, and the last of the turn */
    rig_fini(&r);
}

/* A stage too fast for its columns: what it skips is delivered empty. */
static void skipped_columns(void **state)
{
    struct dx_stage_config c = {.angle = {.rpm = 10}, .columns = 960};
    struct rig r;

    (void)state;
    rig_init(&r, &c);
    turn(&r, 13);
    assert_int_equal(r.watch.n_cols[1], 960);
    assert_true(r.watch.filled[1] > 0.2 && r.watch.filled[1] < 0.3);
    assert_true(r.watch.worst_m[1] <= 0);
    rig_fini(&r);
}

/* ---- half turns -------------------------------------------------------------------------------
 */

/* It looks up: each scan paints two columns, and half a turn is a whole frame. */
static void half_turns(void **state)
{
    struct dx_stage_config c = {.angle = {.rpm = 10},
                                .sweep = DX_STAGE_HALF,
                                .angles_deg = {0, 90, 0},
                                .offset_m = {0, 0, 0.25}};
    struct rig r;

    (void)state;
    rig_init(&r, &c);
    turn(&r, 13);
    assert_string_equal(dx_stage_layout_text(r.stage), "both halves joined");
    assert_int_equal(r.watch.geometry->height, 540);
    expect_frames(&r, 4, 1);
    assert_int_equal(r.watch.n_cols[1], 234);
    rig_fini(&r);
    c.offset_m[0] = 0.1; /* beside the axis one row cannot be both: two layers */
    rig_init(&r, &c);
    turn(&r, 13);
    assert_string_equal(dx_stage_layout_text(r.stage), "both halves in layers");
    expect_frames(&r, 4, 0.49);
    rig_fini(&r);
    c.exact = true; /* points of their own: joined, and no column's width counts */
    c.angles_deg[0] = 3;
    rig_init(&r, &c);
    turn(&r, 13);
    assert_string_equal(dx_stage_layout_text(r.stage), "both halves joined");
    expect_frames(&r, 4, 0.99);
    rig_fini(&r);
}

/* ---- back and forth ---------------------------------------------------------------------------
 */

static void back_and_forth(void **state)
{
    (void)state;
    for (int clockwise = 0; clockwise < 2; clockwise++) {
        struct dx_stage_config c = {
            .angle = {.rpm = 10, .start_deg = 20, .swing_deg = 120, .clockwise = clockwise != 0},
            .sweep = DX_STAGE_SWING,
            .halves = DX_STAGE_HALVES_FRONT};
        struct rig r;

        rig_init(&r, &c);
        turn(&r, 13); /* two seconds a way */
        assert_int_equal(r.watch.geometry->width, 78);
        assert_false(r.watch.geometry->wrap);
        expect_frames(&r, 5, 0.97); /* a column may be missed where it turns back */
        assert_int_equal(dx_stage_counts(r.stage).n_outside, 0);
        rig_fini(&r);
        c.halves = DX_STAGE_HALVES_BOTH; /* what looks back, in columns of its own */
        c.angles_deg[1] = 90;
        rig_init(&r, &c);
        turn(&r, 13);
        assert_int_equal(r.watch.geometry->width, 234);
        assert_string_equal(dx_stage_layout_text(r.stage), "both halves joined");
        expect_frames(&r, 5, 0.97 * 2 / 3);
        rig_fini(&r);
    }
}

/* ---- several values, doubtful angles, new stays -----------------------------------------------
 */

static void mean_of_several(void **state)
{
    struct dx_stage_config c = {.angle = {.rpm = 10}, .columns = 24, .mean = true};
    const struct dx_angle_sample still = {0, 0.1, false};
    uint32_t row = 360, want = 0, n = 0;
    struct rig r;

    (void)state;
    rig_init(&r, &c);
    r.sim.pose = (struct scip_pose){.start_deg = dx_deg(0.1)};
    for (int k = 0; k < 5; k++) { /* the same column; ranges differ by 4 mm */
        r.sim.room[3] = 4 + 0.004 * k;
        assert_int_equal(scan_with(&r, &still, 1), 0);
    }
    for (uint32_t i = 0; i < r.watch.geometry->height; i++)
        n += dx_plane_range(&r.watch.plane, (size_t)i * 24) > 0;
    assert_int_equal(n, 719);
    want = dx_plane_range(&r.watch.plane, (size_t)row * 24);
    assert_true(want > 4000); /* it looks at that wall */
    rig_fini(&r);
    c.mean = false;
    rig_init(&r, &c);
    r.sim.pose = (struct scip_pose){.start_deg = dx_deg(0.1)};
    r.sim.room[3] = 4.008;
    assert_int_equal(scan_with(&r, &still, 1), 0);
    assert_in_range(want, dx_plane_range(&r.watch.plane, (size_t)row * 24) - 1,
                    dx_plane_range(&r.watch.plane, (size_t)row * 24) + 1);
    rig_fini(&r);
}

static void doubtful_angles(void **state)
{
    struct dx_stage_config c = {.angle = {.rpm = 10}, .columns = 100};
    struct dx_angle_sample angle[3];
    struct rig r;

    (void)state;
    rig_init(&r, &c);
    for (uint64_t k = 0; k < 3; k++)
        angle[k] =
            (struct dx_angle_sample){r.now + k * PERIOD_NS / 4, 0.01 + 0.001 * (double)k, k == 2};
    assert_int_equal(scan_with(&r, angle, 3), 0);
    assert_in_range(dx_stage_counts(r.stage).n_uncertain, 700, 740); /* the second stretch */
    angle[2] = (struct dx_angle_sample){r.now + PERIOD_NS, 100, false};
    angle[1].host_ns = r.now + 1;
    angle[0].host_ns = r.now;
    assert_int_equal(scan_with(&r, angle, 3), 0); /* no stage turns so fast */
    assert_true(dx_stage_counts(r.stage).n_uncertain > N_STEPS + 600);
    assert_int_equal(scan_with(&r, NULL, 0), 0);
    assert_int_equal(r.watch.n_ended, 0);
    rig_fini(&r);
}

/* An encoder trembles: no frame ends, and no column is written again. */
static void trembling(void **state)
{
    struct dx_stage_config c = {.angle = {.rpm = 10}, .columns = 100};
    struct rig r;

    (void)state;
    rig_init(&r, &c);
    for (int k = 0; k < 400; k++) {
        double at = 0.02 * k + (k % 2 ? 0.04 : -0.04);
        struct dx_angle_sample a = {r.now, at < 0 ? 0 : at, false};

        r.sim.pose = (struct scip_pose){.start_deg = dx_deg(a.angle_rad)};
        assert_int_equal(scan_with(&r, &a, 1), 0);
    }
    assert_int_equal(r.watch.n_ended, 1); /* 8 radians */
    assert_int_equal(r.watch.n_cols[0], 100);
    assert_true(dx_stage_counts(r.stage).n_late > 0);
    rig_fini(&r);
}

static void new_stay(void **state)
{
    struct dx_stage_config c = {.angle = {.rpm = 10}, .columns = 100};
    struct dx_err err;
    uint64_t frame;
    struct rig r;

    (void)state;
    rig_init(&r, &c);
    turn(&r, 2);
    frame = r.watch.frame;
    dx_stage_restart(r.stage);
    assert_int_equal(scan(&r), 0);
    assert_true(r.watch.frame > frame);
    r.shape.n = 541; /* another scanner: another geometry */
    assert_int_equal(dx_stage_shape(r.stage, &r.shape, &r.sink, &err), 0);
    assert_int_equal(r.watch.n_geometry, 2);
    assert_int_equal(scan(&r), 0);
    assert_int_equal(dx_stage_shape(r.stage, &r.shape, &r.sink, &err), 0);
    assert_int_equal(r.watch.n_geometry, 2); /* told when it changes, only */
    r.watch.closing = true;
    assert_int_equal(scan(&r), DX_DRIVER_E_AGAIN);
    rig_fini(&r);
}

static void what_cannot_be(void **state)
{
    const struct dx_line_shape shape = {
        .n = 100, .angle0_rad = -0.5, .step_rad = 0.01, .max_m = 10, .lines_s = 40};
    const struct dx_line_shape one = {
        .n = 1, .angle0_rad = -0.5, .step_rad = 0.01, .max_m = 10, .lines_s = 40};
    struct dx_stage_config c = {.angle = {.rpm = 10}, .angles_deg = {90, 0, 0}};
    struct watch w = {0};
    struct dx_frame_sink sink = {&w, on_geometry, on_plane, on_deliver};
    struct dx_turning_stage *st;
    const char *key;
    struct dx_err err;

    (void)state;
    assert_non_null(strstr(dx_stage_check(&c, &key), "level"));
    assert_string_equal(key, "stage.angles");
    assert_int_equal(dx_stage_new(&st, &c, &err), -EINVAL);
    c.angles_deg[0] = 0;
    assert_int_equal(dx_stage_new(&st, &c, &err), 0);
    for (int k = 0; k < 3; k++) { /* however many scans of it come */
        err.text[0] = 0;
        assert_int_equal(dx_stage_shape(st, &one, &sink, &err), -EINVAL);
        assert_string_equal(err.text, "stage: a grid of 1 rows and 234 columns is not possible");
    }
    assert_int_equal(dx_stage_shape(st, &shape, &sink, &err), 0);
    dx_geometry_unref(w.geometry);
    dx_plane_fini(&w.plane);
    free(w.delivered);
    free(w.kept);
    dx_stage_free(st);
    c.columns = 101;
    assert_non_null(dx_stage_check(&c, &key));
    c = (struct dx_stage_config){.angle = {.rpm = 10}, .exact = true, .mean = true};
    assert_non_null(dx_stage_check(&c, &key));
    c = (struct dx_stage_config){.angle = {.rpm = 10}, .sweep = DX_STAGE_SWING};
    assert_non_null(dx_stage_check(&c, &key));
    assert_int_equal(dx_stage_new(&st, &c, &err), -EINVAL);
}

/* How far the stage goes on between two scans, in columns. */
static void strides(void **state)
{
    const struct dx_line_shape shape = {
        .n = 100, .angle0_rad = -0.5, .step_rad = 0.01, .max_m = 10, .lines_s = 40};
    struct dx_stage_config c = {.angle = {.rpm = 10}};
    double turn_s = 2 * DX_PI / 6;
    uint32_t turn;

    (void)state;
    assert_true(dx_stage_stride(&c, &shape, turn_s, &turn) < 1); /* 240 scans a turn */
    assert_int_equal(turn, 234);
    c.columns = 2400;
    assert_true(fabs(dx_stage_stride(&c, &shape, -turn_s, &turn) - 10) < 1e-9);
    assert_int_equal(turn, 2400);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(full_turn),         cmocka_unit_test(offset_mount),
        cmocka_unit_test(parts_as_it_turns), cmocka_unit_test(skipped_columns),
        cmocka_unit_test(half_turns),        cmocka_unit_test(back_and_forth),
        cmocka_unit_test(mean_of_several),   cmocka_unit_test(doubtful_angles),
        cmocka_unit_test(trembling),         cmocka_unit_test(new_stay),
        cmocka_unit_test(what_cannot_be),    cmocka_unit_test(strides),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
