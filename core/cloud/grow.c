/* The main loop: seeds, the queue of border edges, rounds. */
#include "core/cloud/grow_priv.h"

#include "core/base/trig.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>

void dx_grow_defaults(struct dx_grow_config *config)
{
    *config = (struct dx_grow_config){.bend_deg = 20,
                                      .bend_step_deg = 10,
                                      .max_bend_deg = 100,
                                      .max_angle_deg = 140,
                                      .max_ratio = 3,
                                      .max_lean_deg = 65,
                                      .n_rounds = 3,
                                      .max_loop = 16};
}

void dx_grow_face_normal(double n[3], const struct dx_grow_run *run, uint32_t a, uint32_t b,
                         uint32_t c)
{
    double p[3], q[3], len;

    dx_grow_between(p, run, a, b);
    dx_grow_between(q, run, a, c);
    dx_grow_cross(n, p, q);
    len = sqrt(dx_grow_dot(n, n));
    for (int k = 0; k < 3; k++)
        n[k] = len > 0 ? n[k] / len : 0;
}

static int push(struct dx_grow_run *run, uint32_t h)
{
    if (run->tail == run->cap) {
        const uint32_t cap = run->cap + run->cap / 2 + 256;
        uint32_t *queue = realloc(run->queue, cap * sizeof(*queue));

        if (!queue)
            return -ENOMEM;
        run->queue = queue;
        run->cap = cap;
    }
    run->queue[run->tail++] = h;
    return 0;
}

static void add_normal(struct dx_grow_run *run, uint32_t a, uint32_t b, uint32_t c)
{
    const uint32_t v[3] = {a, b, c};
    double n[3];

    dx_grow_face_normal(n, run, a, b, c);
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            run->normal[v[i]][k] += n[k];
    run->stats->n_triangles++;
}

/* The borders of the triangle of half-edge h. */
static int push_borders(struct dx_grow_run *run, uint32_t h)
{
    for (int k = 0; k < 3; k++) {
        if (dx_halfedge_is_border(run->mesh, h ^ 1) && push(run, h ^ 1) < 0)
            return -ENOMEM;
        h = run->mesh->of[h].next;
    }
    return 0;
}

int dx_grow_add(struct dx_grow_run *run, uint32_t b, uint32_t q, uint32_t corner)
{
    if (dx_halfedges_glue(run->mesh, b, q, corner) < 0)
        return -ENOMEM;
    add_normal(run, dx_halfedge_from(run->mesh, b), run->mesh->of[b].to, q);
    return push_borders(run, b);
}

/* All that the queue leads to. */
static int follow(struct dx_grow_run *run)
{
    while (run->head < run->tail) {
        const uint32_t b = run->queue[run->head++];
        uint32_t q, corner;

        if (!dx_halfedge_is_border(run->mesh, b))
            continue;
        q = dx_grow_point(run, b, &corner);
        if (q != DX_NO_HALFEDGE && dx_grow_add(run, b, q, corner) < 0)
            return -ENOMEM;
    }
    run->head = run->tail = 0;
    return 0;
}

static int by_key(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;

    return (x > y) - (x < y);
}

/* Components from the highest point down. */
static int grow_components(struct dx_grow_run *run)
{
    const struct dx_cloud *c = run->cloud;
    uint64_t *keys = malloc(c->n * sizeof(*keys));
    int rc = keys ? 0 : -ENOMEM;

    for (uint32_t k = 0; rc == 0 && k < c->n; k++)
        keys[k] = (uint64_t)(DX_CLOUD_LATTICE - c->at[k][2]) << 32 | k;
    if (rc == 0)
        qsort(keys, c->n, sizeof(*keys), by_key);
    for (uint32_t k = 0; rc == 0 && k < c->n; k++) {
        uint32_t v[3];

        if (dx_grow_is_used(run, (uint32_t)keys[k]) || !dx_grow_seed(run, v, (uint32_t)keys[k]))
            continue;
        rc = dx_halfedges_add_triangle(run->mesh, v[0], v[1], v[2]);
        if (rc < 0)
            break;
        add_normal(run, v[0], v[1], v[2]);
        run->stats->n_components++;
        rc = push_borders(run, run->mesh->out[v[0]]);
        rc = rc == 0 ? follow(run) : rc;
    }
    free(keys);
    return rc;
}

static int push_all_borders(struct dx_grow_run *run)
{
    for (uint32_t h = 0; h < run->mesh->n; h++)
        if (dx_halfedge_is_border(run->mesh, h) && push(run, h) < 0)
            return -ENOMEM;
    return 0;
}

static void count(struct dx_grow_run *run)
{
    for (uint32_t v = 0; v < run->cloud->n; v++)
        run->stats->n_unused += !dx_grow_is_used(run, v);
    for (uint32_t h = 0; h < run->mesh->n; h++)
        run->stats->n_border += dx_halfedge_is_border(run->mesh, h);
}

static int run_all(struct dx_grow_run *run)
{
    int rc = grow_components(run);

    for (run->round = 1; rc == 0 && run->round < run->config->n_rounds; run->round++) {
        rc = push_all_borders(run);
        rc = rc == 0 ? follow(run) : rc;
    }
    if (rc == 0 && run->config->max_loop)
        rc = dx_grow_close_loops(run);
    return rc;
}

static int check(const struct dx_grow_config *c, struct dx_err *err)
{
    if (!(c->bend_deg > 0 && c->bend_step_deg > 0 && c->max_bend_deg >= c->bend_deg &&
          c->max_bend_deg <= 180 &&
          (c->max_bend_deg - c->bend_deg) / c->bend_step_deg < DX_GROW_MAX_BENDS - 1))
        return dx_err_set(err, -EINVAL,
                          "bends from %g by %g to %g degrees, expected at most %d of them to 180",
                          c->bend_deg, c->bend_step_deg, c->max_bend_deg, DX_GROW_MAX_BENDS);
    if (!(c->max_angle_deg > 60 && c->max_angle_deg <= 180))
        return dx_err_set(err, -EINVAL, "the widest angle is %g degrees, expected 60 to 180",
                          c->max_angle_deg);
    if (!(c->max_ratio > 1 && c->max_ratio <= 100))
        return dx_err_set(err, -EINVAL,
                          "an edge is %g times the nearest distance, expected 1 to 100",
                          c->max_ratio);
    if (!(c->max_lean_deg > 0 && c->max_lean_deg <= 90))
        return dx_err_set(err, -EINVAL, "a lean is %g degrees, expected 0 to 90", c->max_lean_deg);
    if (c->max_loop > DX_GROW_MAX_LOOP)
        return dx_err_set(err, -EINVAL, "holes of %u edges, expected at most %d", c->max_loop,
                          DX_GROW_MAX_LOOP);
    return 0;
}

static void set_angles(struct dx_grow_run *run)
{
    const struct dx_grow_config *c = run->config;

    for (double bend = c->bend_deg; bend < c->max_bend_deg + 1e-9; bend += c->bend_step_deg)
        run->cos_bend[run->n_bends++] = dx_cos(dx_rad(bend));
    run->cos_angle = dx_cos(dx_rad(c->max_angle_deg));
    run->cos_lean = dx_cos(dx_rad(c->max_lean_deg));
}

int dx_grow(struct dx_halfedges *m, struct dx_grow_stats *stats, const struct dx_cloud *cloud,
            const struct dx_neighbours *nb, const struct dx_grow_config *config, struct dx_err *err)
{
    struct dx_grow_run run = {.cloud = cloud, .nb = nb, .config = config, .mesh = m};
    int rc = check(config, err);

    *stats = (struct dx_grow_stats){0};
    *m = (struct dx_halfedges){0};
    if (rc < 0)
        return rc;
    run.stats = stats;
    set_angles(&run);
    run.normal = calloc((size_t)cloud->n + 1, sizeof(*run.normal));
    rc = run.normal ? dx_halfedges_init(m, cloud->n) : -ENOMEM;
    if (rc == 0 && cloud->n >= 3)
        rc = run_all(&run);
    if (rc == 0)
        count(&run);
    else
        dx_err_set(err, rc, "no memory for the mesh of %u points", cloud->n);
    if (rc < 0)
        dx_halfedges_fini(m);
    free(run.normal);
    free(run.queue);
    return rc;
}
