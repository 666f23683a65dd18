/*
 * A stage, a scanner on it and a room around them; and a sink that watches how frames come and
 * measures how far from the walls their points lie.
 */
#ifndef STAGE_RIG_H
#define STAGE_RIG_H

#include "drivers/stage.h"
#include "tests/hil/scip_device.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#define S          1000000000ull
#define N_STEPS    1081
#define PERIOD_NS  25000000ull
#define MAX_FRAMES 64

/* A sink that watches: no column comes twice in a frame, none changes once it was delivered. */
struct watch {
    struct dx_geometry *geometry;
    struct dx_plane plane;
    uint64_t frame;
    bool filling;
    uint8_t *delivered; /* [width] */
    uint32_t *kept;     /* what a delivered column held: [height * width] */
    uint32_t n_geometry, n_parts, n_ended, n_columns; /* columns of this frame */
    double filled[MAX_FRAMES];                        /* share of the dexels, of ended frames */
    double worst_m[MAX_FRAMES]; /* from the walls, beyond what the column's width explains */
    uint32_t n_cols[MAX_FRAMES];
    const double *room;
    bool closing;
    bool between; /* the part before ended a frame */
};

static inline int on_geometry(void *ctx, struct dx_geometry *g, uint8_t attr_bytes)
{
    struct watch *w = ctx;

    dx_geometry_unref(w->geometry);
    dx_plane_fini(&w->plane);
    free(w->delivered);
    free(w->kept);
    w->geometry = dx_geometry_ref(g);
    assert_int_equal(dx_plane_init_for(&w->plane, g, attr_bytes), 0);
    w->delivered = calloc(g->width, 1);
    w->kept = calloc((size_t)g->width * g->height, sizeof(*w->kept));
    assert_true(w->delivered && w->kept);
    w->n_geometry++;
    w->filling = false;
    return 0;
}

static inline struct dx_plane *on_plane(void *ctx, uint64_t number)
{
    struct watch *w = ctx;

    if (w->closing)
        return NULL;
    if (!w->filling || number != w->frame) {
        assert_true(w->n_ended == 0 || number > w->frame);
        dx_plane_clear(&w->plane);
        memset(w->delivered, 0, w->geometry->width);
        w->frame = number;
        w->filling = true;
        w->n_columns = 0;
    }
    return &w->plane;
}

static inline double from_walls(const double room[6], const float p[3])
{
    double best = INFINITY;

    for (int k = 0; k < 6; k++) {
        double d = fabs((double)p[k % 3] - room[k]);

        best = d < best ? d : best;
    }
    return best;
}

static inline void end_frame(struct watch *w)
{
    const struct dx_geometry *g = w->geometry;
    double column_rad = 2 * DX_PI / g->width; /* where the columns are a whole turn */
    size_t n = 0;
    double worst = 0;

    if (!g->wrap)
        column_rad = acos((double)g->table[0] * g->table[2] + (double)g->table[1] * g->table[3]);
    for (size_t k = 0; k < dx_plane_n_dexels(&w->plane); k++) {
        uint32_t range = dx_plane_range(&w->plane, k), col = (uint32_t)(k % g->width);
        double slack = 0.001;
        float p[3];

        if (w->delivered[col])
            assert_int_equal(w->kept[k], range);
        else
            assert_int_equal(range, 0);
        if (!range)
            continue;
        n++;
        if (g->exact)
            memcpy(p, w->plane.xyz + 3 * k, sizeof(p));
        else
            dx_geometry_point(g, (uint32_t)(k / g->width), col, range, p);
        if (!g->exact)
            slack += 0.5 * column_rad * sqrt((double)p[0] * p[0] + (double)p[1] * p[1]);
        worst = fmax(worst, from_walls(w->room, p) - slack);
    }
    assert_true(w->n_ended < MAX_FRAMES);
    w->filled[w->n_ended] = (double)n / (double)dx_plane_n_dexels(&w->plane);
    w->worst_m[w->n_ended] = worst;
    w->n_cols[w->n_ended++] = w->n_columns;
    w->filling = false;
}

static inline void on_deliver(void *ctx, const struct dx_frame_part *part)
{
    struct watch *w = ctx;

    assert_true(w->filling && part->frame == w->frame);
    assert_true(part->n_cols > 0 && part->col0 + part->n_cols <= w->geometry->width);
    for (uint32_t j = part->col0; j < part->col0 + part->n_cols; j++) {
        assert_false(w->delivered[j]);
        w->delivered[j] = 1;
        for (size_t i = 0; i < w->geometry->height; i++)
            w->kept[i * w->geometry->width + j] =
                dx_plane_range(&w->plane, i * w->geometry->width + j);
    }
    w->n_columns += part->n_cols;
    w->n_parts++;
    w->between = part->last;
    if (part->last)
        end_frame(w);
}

/* ---- a scanner in a room ----------------------------------------------------------------------
 */

struct rig {
    struct watch watch;
    struct dx_frame_sink sink;
    struct dx_turning_stage *stage;
    struct dx_angle_source *source;
    struct scip_sim sim;
    struct dx_line_shape shape;
    uint64_t now;
};

static inline void rig_init(struct rig *r, const struct dx_stage_config *c)
{
    struct dx_err err = {""};

    memset(r, 0, sizeof(*r));
    scip_sim_init(&r->sim, &scip_models[2], 0);
    r->sim.pose = (struct scip_pose){.rpm = c->angle.rpm,
                                     .start_deg = c->angle.start_deg,
                                     .swing_deg = c->angle.swing_deg,
                                     .clockwise = c->angle.clockwise};
    memcpy(r->sim.pose.offset, c->offset_m, sizeof(c->offset_m));
    memcpy(r->sim.pose.angles_deg, c->angles_deg, sizeof(c->angles_deg));
    r->watch.room = r->sim.room;
    r->sink = (struct dx_frame_sink){&r->watch, on_geometry, on_plane, on_deliver};
    r->shape = (struct dx_line_shape){.n = N_STEPS,
                                      .angle0_rad = -0.75 * DX_PI,
                                      .step_rad = DX_PI / 720,
                                      .max_m = 60,
                                      .lines_s = 40};
    r->now = 100 * S;
    assert_int_equal(dx_stage_new(&r->stage, c, &err), 0);
    assert_int_equal(dx_angle_open(&r->source, &c->angle, &err), 0);
    assert_int_equal(dx_stage_shape(r->stage, &r->shape, &r->sink, &err), 0);
}

static inline void rig_fini(struct rig *r)
{
    dx_stage_free(r->stage);
    dx_angle_close(r->source);
    dx_geometry_unref(r->watch.geometry);
    dx_plane_fini(&r->watch.plane);
    free(r->watch.delivered);
    free(r->watch.kept);
}

/* The scan that begins now; its ranges. */
static inline int scan_with(struct rig *r, const struct dx_angle_sample *angle, size_t n_angles)
{
    static uint32_t range[N_STEPS];
    double step_ns = (double)PERIOD_NS / 1440;
    struct dx_line line = {.host_ns = r->now,
                           .step_ns = step_ns,
                           .range = range,
                           .angle = angle,
                           .n_angles = n_angles};
    uint32_t n_ended = r->watch.n_ended;
    int result;

    for (uint32_t i = 0; i < r->shape.n; i++) {
        double psi = scip_sim_stage(&r->sim.pose, r->now + (uint64_t)(i * step_ns));
        double a = r->shape.angle0_rad + i * r->shape.step_rad;

        range[i] = (uint32_t)rint(scip_sim_range(&r->sim, a, psi) * 1000);
    }
    result = dx_stage_put(r->stage, &line, &r->sink);
    if (r->watch.n_ended > n_ended) /* a recording may begin behind it */
        assert_true(r->watch.between);
    r->now += PERIOD_NS;
    return result;
}

static inline int scan(struct rig *r)
{
    struct dx_angle_sample angle[8];
    size_t n = r->source->ops->samples(r->source, r->now, r->now + PERIOD_NS * 3 / 4, angle, 8);

    return scan_with(r, angle, n);
}

static inline void turn(struct rig *r, double seconds)
{
    for (uint64_t until = r->now + (uint64_t)(seconds * 1e9); r->now < until;)
        assert_int_equal(scan(r), 0);
}

/* All ended frames but the first, which began where the stage happened to be. */
static inline void expect_frames(const struct rig *r, uint32_t least, double filled)
{
    assert_true(r->watch.n_ended >= least);
    for (uint32_t k = 0; k < r->watch.n_ended; k++) {
        assert_true(r->watch.worst_m[k] <= 0);
        assert_true(k == 0 || r->watch.filled[k] >= filled);
    }
    assert_int_equal(r->watch.n_geometry, 1);
}

#endif
