/* A still scene through terrain mode, frame after frame. */
#include "tools/quality_static.h"

#include "tools/now.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>

/* Truth is cast without noise in a unit so much finer that its rounding does not count. */
#define FINER 128

struct run {
    const struct dx_quality_static_config *config;
    struct dx_geometry *geometry;
    struct dx_terrain *terrain;
    struct dx_plane frame, truth;
    double *seconds; /* of each frame */
};

void dx_quality_static_default(struct dx_quality_static_config *c)
{
    *c = (struct dx_quality_static_config){.warm = 16, .settled = 64, .n_frames = 150};
    dx_scene_config_default(&c->scene, DX_SCENE_HALL);
    c->scene.height = 1000;
    c->scene.width = 1500;
    c->scene.sigma[0] = 0.005;
    dx_terrain_params_default(&c->params);
    c->params.ingest.filter = DX_FILTER_MEAN;
}

static int cast_truth(struct dx_plane *truth, const struct dx_scene_config *scene)
{
    struct dx_scene_config c = *scene;
    struct dx_geometry *g;
    int r;

    c.sigma[0] = c.sigma[1] = c.sigma[2] = c.dropout = c.mixed = 0;
    c.unit_m /= FINER;
    c.attr_bytes = 0;
    r = dx_scene_geometry(&g, &c);
    if (r < 0)
        return r;
    r = dx_plane_init(truth, g->height, g->width, g->range_bytes, 0);
    if (r == 0)
        dx_scene_cast(truth, g, &c, 0, 0, g->width);
    dx_geometry_unref(g);
    return r;
}

static int run_init(struct run *run, const struct dx_quality_static_config *c)
{
    int r;

    *run = (struct run){.config = c};
    if (c->settled <= c->warm || c->n_frames <= c->settled)
        return -EINVAL;
    run->seconds = calloc(c->n_frames, sizeof(*run->seconds));
    if (!run->seconds)
        return -ENOMEM;
    r = dx_scene_geometry(&run->geometry, &c->scene);
    if (r == 0)
        r = dx_terrain_new(&run->terrain, run->geometry, &c->params, c->scene.attr_bytes);
    if (r == 0)
        r = dx_plane_init(&run->frame, c->scene.height, c->scene.width, run->geometry->range_bytes,
                          c->scene.attr_bytes);
    return r == 0 ? cast_truth(&run->truth, &c->scene) : r;
}

static void run_fini(struct run *run)
{
    free(run->seconds);
    dx_plane_fini(&run->truth);
    dx_plane_fini(&run->frame);
    dx_terrain_free(run->terrain);
    dx_geometry_unref(run->geometry);
}

/* Of (published - truth) / sigma, over dexels that have both. */
static double rms_sigma(const struct run *run)
{
    const struct dx_plane *published = dx_terrain_published(run->terrain);
    const double *s = run->config->scene.sigma, u = run->config->scene.unit_m;
    double sum = 0, n = 0;

    for (size_t k = 0; k < dx_plane_n_dexels(published); k++) {
        uint32_t range = dx_plane_range(published, k), truth = dx_plane_range(&run->truth, k);
        double r = truth * u / FINER, e = (range * u - r) / (s[0] + r * (s[1] + r * s[2]));

        if (range && truth) {
            sum += e * e;
            n++;
        }
    }
    return n > 0 ? sqrt(sum / n) : 0;
}

static uint32_t take_frame(struct run *run, uint32_t number, struct dx_pool *pool)
{
    const struct dx_scene_config *scene = &run->config->scene;
    uint64_t start;

    dx_scene_cast(&run->frame, run->geometry, scene, number, 0, scene->width);
    start = dx_now_ns();
    dx_terrain_publish(run->terrain, &run->frame, 0, scene->width);
    run->seconds[number] = dx_seconds_since(start);
    return dx_terrain_commit(run->terrain, pool);
}

static int by_value(const void *x, const void *y)
{
    const double *a = x, *b = y;

    return *a < *b ? -1 : *a > *b;
}

static void measure(struct dx_quality_static *q, struct run *run, struct dx_pool *pool)
{
    const struct dx_quality_static_config *c = run->config;
    double settling = 0, settled = 0;

    q->n_tiles = dx_tiling_n_tiles(dx_terrain_tiling(run->terrain));
    for (uint32_t k = 0; k < c->n_frames; k++) {
        uint32_t n = take_frame(run, k, pool);

        settling += k >= c->warm && k < c->settled ? n : 0;
        settled += k >= c->settled ? n : 0;
        if (k + 1 == c->settled)
            q->rms_sigma = rms_sigma(run);
    }
    q->rms_end = rms_sigma(run);
    q->settling = settling / (c->settled - c->warm) / q->n_tiles;
    q->settled = settled / (c->n_frames - c->settled) / q->n_tiles;
    qsort(run->seconds, c->n_frames, sizeof(*run->seconds), by_value);
    q->publish_s = run->seconds[c->n_frames / 2];
}

int dx_quality_static_run(struct dx_quality_static *q, const struct dx_quality_static_config *c,
                          struct dx_pool *pool)
{
    struct run run;
    int r = run_init(&run, c);

    *q = (struct dx_quality_static){0};
    if (r == 0)
        measure(q, &run, pool);
    run_fini(&run);
    return r;
}
