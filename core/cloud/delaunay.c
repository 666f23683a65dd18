/* The stages of the localized Delaunay mesh. */
#include "core/cloud/delaunay.h"

#include "core/cloud/delaunay_priv.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>

void dx_delaunay_defaults(struct dx_delaunay_config *config)
{
    *config = (struct dx_delaunay_config){
        .k = 16, .widest = 2.5, .least_m = 2.5, .most_m = 5, .max_loop = 8};
}

static int check(const struct dx_delaunay_config *c, struct dx_err *err)
{
    if (c->k < 3 || c->k > DX_CLOUD_MAX_NEAREST)
        return dx_err_set(err, -EINVAL, "%u candidates, expected 3 to %d", c->k,
                          DX_CLOUD_MAX_NEAREST);
    if (!(c->widest >= 1 && c->widest <= 100))
        return dx_err_set(err, -EINVAL, "the widest radius is %g, expected 1 to 100", c->widest);
    if (!(c->least_m >= 1 && c->least_m <= c->most_m && c->most_m <= 100))
        return dx_err_set(err, -EINVAL,
                          "the paper's radius is %g to %g distances, expected 1 to 100", c->least_m,
                          c->most_m);
    if (!(c->max_edge >= 0))
        return dx_err_set(err, -EINVAL, "the longest edge is %g, expected 0 or more", c->max_edge);
    if (c->max_loop > DX_DELAUNAY_MAX_LOOP)
        return dx_err_set(err, -EINVAL, "holes of %u edges, expected at most %d", c->max_loop,
                          DX_DELAUNAY_MAX_LOOP);
    return 0;
}

static void begin(const struct dx_delaunay_run *run, enum dx_delaunay_stage stage)
{
    if (run->sink->stage)
        run->sink->stage(run->sink->ctx, stage);
}

static void count_states(struct dx_delaunay_run *run)
{
    for (uint32_t r = 0; r < run->cloud->n; r++) {
        run->stats->n_completed += run->ring[r] == DX_RING_WHOLE;
        run->stats->n_isolated += run->ring[r] == 0;
        if (run->ring[r] == DX_RING_WHOLE || run->ring[r] == 0)
            continue;
        run->stats->n_boundary++;
        run->stats->n_pinched += dx_ring_n_chains(&run->rings, run->ring[r]) > 1;
    }
}

static int run_all(struct dx_delaunay_run *run)
{
    int rc;

    begin(run, DX_DELAUNAY_STARS);
    rc = dx_stars_make(run);
    if (rc < 0)
        return rc;
    begin(run, DX_DELAUNAY_ACCEPT);
    rc = dx_delaunay_accept(run);
    if (rc < 0)
        return rc;
    dx_stars_fini(&run->stars);
    begin(run, DX_DELAUNAY_HOLES);
    rc = run->config->max_loop ? dx_delaunay_fill(run) : 0;
    if (rc == 0)
        count_states(run);
    return rc;
}

/* With an arena from the start, which also the empty ring is in. */
static int open_rings(struct dx_rings *r)
{
    uint32_t ring = 0;
    int rc;

    dx_rings_init(r);
    rc = dx_ring_add(r, &ring, 0, 1);
    dx_ring_free(r, &ring);
    return rc < 0 ? rc : 0;
}

int dx_delaunay(struct dx_delaunay_stats *stats, const struct dx_cloud *cloud,
                const struct dx_neighbours *nb, const float (*normals)[3],
                const struct dx_delaunay_config *config, const struct dx_delaunay_sink *sink,
                struct dx_pool *pool, struct dx_err *err)
{
    struct dx_delaunay_run run = {.cloud = cloud,
                                  .nb = nb,
                                  .normals = normals,
                                  .config = config,
                                  .sink = sink,
                                  .stats = stats,
                                  .pool = pool};
    int rc = check(config, err);

    *stats = (struct dx_delaunay_stats){0};
    if (rc < 0 || cloud->n == 0)
        return rc;
    run.k = nb->k < config->k ? nb->k : config->k;
    run.max_edge = config->max_edge > 0 ? config->max_edge / cloud->step : INFINITY;
    dx_star_angles(run.quarter_turns);
    rc = open_rings(&run.rings);
    run.ring = malloc(cloud->n * sizeof(*run.ring));
    if (rc == 0)
        rc = run.ring ? run_all(&run) : -ENOMEM;
    if (rc == -ENOMEM)
        dx_err_set(err, rc, "no memory for the mesh of %u points", cloud->n);
    dx_stars_fini(&run.stars);
    dx_rings_fini(&run.rings);
    free(run.ring);
    return rc;
}
