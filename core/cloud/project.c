/* The main loop: seeds, the queue of the front, states. */
#include "core/cloud/project_priv.h"

#include "core/base/trig.h"
#include "core/cloud/pages.h"
#include "core/cloud/spacing.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>

#define WIDEN     1.6
#define MAX_TRIES 3
/* Neighbours of a point that has waited for: the rest is made by others, as a rule, and what a
 * reference point costs is saved. */
#define NEARLY_CLOSED 5

void dx_project_defaults(struct dx_project_config *config)
{
    *config =
        (struct dx_project_config){.mu = 2.5, .alpha_deg = 120, .beta_deg = 10, .max_loop = 8};
}

/* All triangles of one reference point. */
static int process(struct dx_project_run *run, uint32_t r)
{
    double factor = 1;
    int rc = 0;

    run->r = r;
    for (int try = 0; try < MAX_TRIES; try++, factor *= run->widen) {
        bool may_widen;

        dx_project_gather(run, factor);
        may_widen = try + 1 < MAX_TRIES && run->radius < run->widest;
        run->stats->n_again += try > 0;
        if (!dx_project_set_plane(run) || !dx_project_look(run))
            break;
        run->widen = WIDEN;
        rc = dx_project_star(run, may_widen);
        if (rc != DX_STAR_NARROW || run->state[r] == DX_COMPLETED)
            break;
    }
    if (rc < 0)
        return rc;
    if (run->state[r] == DX_FRINGE || run->state[r] == DX_WAITED)
        run->state[r] = DX_BOUNDARY;
    return 0;
}

static int grow(struct dx_project_run *run, uint32_t seed)
{
    const uint64_t before = run->stats->n_triangles;
    int rc = process(run, seed);

    while (rc == 0 && run->n_queued > 0) {
        const uint32_t r = dx_project_pop(run);

        if (run->state[r] == DX_FRINGE &&
            dx_ring_n(&run->rings, run->point[r].ring) >= NEARLY_CLOSED) {
            run->state[r] = DX_WAITED;
            dx_project_push(run, r);
        } else if (run->state[r] == DX_FRINGE || run->state[r] == DX_WAITED) {
            rc = process(run, r);
        }
    }
    run->stats->n_components += run->stats->n_triangles > before;
    return rc;
}

/* The highest point, whose surface has its outside above if it is closed. */
static uint32_t first_seed(const struct dx_project_run *run)
{
    const struct dx_cloud *c = run->cloud;
    uint32_t best = 0;

    for (uint32_t k = 0; k < c->n; k++) {
        if (run->config->has_seed && c->index[k] == run->config->seed)
            return k;
        if (!run->config->has_seed && c->at[k][2] > c->at[best][2])
            best = k;
    }
    return best;
}

static int by_key(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;

    return (x > y) - (x < y);
}

/* What the first seed has not reached, from the highest down. */
static int grow_others(struct dx_project_run *run)
{
    uint32_t n = 0;
    uint64_t *keys;
    int rc = 0;

    for (uint32_t k = 0; k < run->cloud->n; k++)
        n += run->state[k] == DX_FREE;
    if (n == 0)
        return 0;
    keys = malloc(n * sizeof(*keys));
    if (!keys)
        return -ENOMEM;
    n = 0;
    for (uint32_t k = 0; k < run->cloud->n; k++)
        if (run->state[k] == DX_FREE)
            keys[n++] = (uint64_t)(DX_CLOUD_LATTICE - run->cloud->at[k][2]) << 32 | k;
    qsort(keys, n, sizeof(*keys), by_key);
    for (uint32_t k = 0; k < n && rc == 0; k++)
        if (run->state[(uint32_t)keys[k]] == DX_FREE)
            rc = grow(run, (uint32_t)keys[k]);
    free(keys);
    return rc;
}

/* Points that had gaps, once more: their neighbours may have filled them from their planes, or made
 * what was in the way. */
static int look_again(struct dx_project_run *run, enum dx_project_plane plane)
{
    int rc = 0;

    run->plane = plane;
    for (uint32_t k = 0; k < run->cloud->n && rc == 0; k++)
        if (run->state[k] == DX_BOUNDARY || run->state[k] == DX_FRINGE)
            rc = process(run, k);
    /* what that has found */
    while (rc == 0 && run->n_queued > 0) {
        const uint32_t r = dx_project_pop(run);

        if (run->state[r] == DX_FRINGE)
            rc = process(run, r);
    }
    return rc;
}

static void count_states(struct dx_project_run *run)
{
    for (uint32_t k = 0; k < run->cloud->n; k++) {
        run->stats->n_completed += run->state[k] == DX_COMPLETED;
        run->stats->n_boundary += run->state[k] == DX_BOUNDARY;
        run->stats->n_isolated += run->state[k] == DX_FREE;
        run->stats->n_pinched += dx_ring_n_chains(&run->rings, run->point[k].ring) > 1;
    }
    run->stats->peak_rings = run->rings.n_peak;
    run->stats->peak_ring_len = run->rings.peak_len;
}

static int check(const struct dx_project_config *c, struct dx_err *err)
{
    if (!(c->mu >= 1 && c->mu <= 100))
        return dx_err_set(err, -EINVAL, "mu is %g, expected 1 to 100", c->mu);
    if (!(c->alpha_deg >= 60 && c->alpha_deg <= 180))
        return dx_err_set(err, -EINVAL, "alpha is %g degrees, expected 60 to 180", c->alpha_deg);
    if (!(c->beta_deg >= 0 && c->beta_deg <= 60))
        return dx_err_set(err, -EINVAL, "beta is %g degrees, expected 0 to 60", c->beta_deg);
    if (!(c->max_edge >= 0))
        return dx_err_set(err, -EINVAL, "the longest edge is %g, expected 0 or more", c->max_edge);
    if (c->max_loop > DX_PROJECT_MAX_LOOP)
        return dx_err_set(err, -EINVAL, "holes of %u edges, expected at most %d", c->max_loop,
                          DX_PROJECT_MAX_LOOP);
    return 0;
}

static int run_all(struct dx_project_run *run)
{
    int rc = grow(run, first_seed(run));

    if (rc == 0)
        rc = grow_others(run);
    if (rc == 0)
        rc = look_again(run, run->plane);
    /* where the points are no help, the planes of those who made the triangles there may be */
    if (rc == 0 && run->plane == DX_PROJECT_FIT)
        rc = look_again(run, DX_PROJECT_FACES);
    if (rc == 0 && run->config->max_loop)
        rc = dx_project_close_loops(run);
    return rc;
}

int dx_project(struct dx_project_stats *stats, const struct dx_cloud *c,
               const struct dx_project_config *config, const struct dx_project_sink *sink,
               struct dx_err *err)
{
    struct dx_project_run *run;
    int rc = check(config, err);

    *stats = (struct dx_project_stats){0};
    if (rc < 0 || c->n == 0)
        return rc;
    run = calloc(1, sizeof(*run));
    if (!run)
        return dx_err_set(err, -ENOMEM, "no memory for the mesh");
    run->cloud = c;
    run->config = config;
    run->sink = sink;
    run->plane = config->plane;
    run->stats = stats;
    run->cos_alpha = dx_cos(dx_rad(config->alpha_deg));
    run->cos_beta = dx_cos(dx_rad(config->beta_deg));
    run->spacing = dx_cloud_spacing(c);
    run->max_edge = config->max_edge / c->step;
    dx_rings_init(&run->rings);
    run->point = dx_pages_new_zeroed(c->n * sizeof(*run->point));
    run->state = dx_pages_new_zeroed(c->n * sizeof(*run->state));
    run->queue = dx_pages_new(c->n * sizeof(*run->queue));
    if (run->point && run->state && run->queue)
        rc = run_all(run);
    else
        rc = -ENOMEM;
    if (rc == 0)
        count_states(run);
    else if (rc == -ENOMEM)
        dx_err_set(err, rc, "no memory for the mesh of %u points", c->n);
    stats->spacing = run->spacing * c->step;
    dx_rings_fini(&run->rings);
    free(run->point);
    free(run->state);
    free(run->queue);
    free(run);
    return rc;
}
