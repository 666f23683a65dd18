/* The stages in turn, and what each hands to the next. */
#include "core/cloud/smooth_stages.h"

#include "core/cloud/cloud_normals.h"
#include "core/cloud/orient.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#define K_ORIENT 12 /* neighbours along which normals are turned */

static int no_memory(const struct dx_stages *s, struct dx_err *err)
{
    return dx_err_set(err, -ENOMEM, "no memory for %u points", s->n);
}

/* Leaves what the cloud has kept, in its order; the cloud then names places here. */
static int keep_points(struct dx_stages *s)
{
    uint32_t *rank = malloc(((size_t)s->n + 1) * sizeof(*rank)), n_kept = 0;

    if (!rank)
        return -ENOMEM;
    for (uint32_t k = 0; k < s->n; k++)
        rank[k] = UINT32_MAX;
    for (uint32_t r = 0; r < s->cloud.n; r++)
        rank[s->cloud.index[r]] = r;
    for (uint32_t k = 0; k < s->n; k++) {
        if (rank[k] == UINT32_MAX)
            continue;
        memmove(s->xyz[n_kept], s->xyz[k], sizeof(*s->xyz));
        memmove(s->normal[n_kept], s->normal[k], sizeof(*s->normal));
        s->cloud.index[rank[k]] = n_kept++;
    }
    s->n = n_kept;
    free(rank);
    return 0;
}

int dx_stages_init(struct dx_stages *s, const double *xyz, size_t n, struct dx_pool *pool,
                   struct dx_err *err)
{
    int rc;

    *s = (struct dx_stages){.pool = pool};
    rc = dx_cloud_init(&s->cloud, xyz, n, pool, err);
    if (rc < 0)
        return rc;
    s->n_not_finite = s->cloud.n_not_finite;
    s->n_duplicates = s->cloud.n_duplicates;
    s->n = (uint32_t)n;
    s->xyz = malloc((n + 1) * sizeof(*s->xyz));
    s->normal = calloc(n + 1, sizeof(*s->normal));
    if (s->xyz && n)
        memcpy(s->xyz, xyz, n * sizeof(*s->xyz));
    if (!s->xyz || !s->normal || keep_points(s) < 0) {
        rc = no_memory(s, err);
        dx_stages_fini(s);
    }
    return rc;
}

void dx_stages_fini(struct dx_stages *s)
{
    dx_surface_mesh_fini(&s->mesh);
    dx_reduced_fini(&s->reduced);
    dx_clusters_fini(&s->clusters);
    dx_cloud_fini(&s->cloud);
    free(s->xyz);
    free(s->normal);
    *s = (struct dx_stages){.pool = NULL};
}

/* What is found from here on: Q of points that are smooth already. Paraboloids, for a plane would
 * shrink them once more. */
static void set_q(struct dx_stages *s, double sw)
{
    s->q = (struct dx_cloud_smooth_scale){
        .spacing = dx_cloud_side(&s->cloud), .sw = sw, .sr = 1, .quadric = true};
}

static int need_q(struct dx_stages *s, struct dx_err *err)
{
    const struct dx_cloud_smooth_config found = {.quadric = true};
    struct dx_cloud_smooth_scale scale;
    int rc;

    if (s->q.sw > 0)
        return 0;
    rc = dx_cloud_smooth_find(&scale, &s->cloud, &found, err);
    if (rc == 0)
        s->q = scale;
    return rc;
}

int dx_stages_smooth(struct dx_stages *s, struct dx_cloud_smooth_scale *scale,
                     struct dx_cloud_smooth_stats *stats,
                     const struct dx_cloud_smooth_config *config, struct dx_err *err)
{
    struct dx_cloud_smoothed *out;
    struct dx_cloud smooth;
    int rc = dx_cloud_smooth_find(scale, &s->cloud, config, err);

    if (rc < 0)
        return rc;
    out = malloc(((size_t)s->cloud.n + 1) * sizeof(*out));
    if (!out)
        return no_memory(s, err);
    dx_cloud_smooth(out, stats, &s->cloud, scale, s->pool);
    for (uint32_t r = 0; r < s->cloud.n; r++) {
        dx_cloud_to_input(s->xyz[s->cloud.index[r]], &s->cloud, out[r].at);
        dx_cloud_normal_out(s->normal[s->cloud.index[r]], &s->cloud, out[r].normal);
    }
    free(out);
    rc = dx_cloud_init(&smooth, s->xyz[0], s->n, s->pool, err);
    if (rc < 0)
        return rc;
    dx_cloud_fini(&s->cloud);
    s->cloud = smooth;
    set_q(s, scale->sw);
    return keep_points(s) < 0 ? no_memory(s, err) : 0;
}

int dx_stages_cluster(struct dx_stages *s, const struct dx_cluster_config *config,
                      struct dx_err *err)
{
    dx_clusters_fini(&s->clusters);
    return dx_clusters_init(&s->clusters, &s->cloud, config, s->pool, err);
}

int dx_stages_reduce(struct dx_stages *s, struct dx_err *err)
{
    const int rc = need_q(s, err);

    dx_reduced_fini(&s->reduced);
    return rc < 0 ? rc : dx_reduce(&s->reduced, &s->cloud, &s->clusters, &s->q, s->pool, err);
}

/* A vertex at the same place. */
static int copy_vertex(void *ctx, uint32_t old, uint32_t made)
{
    struct dx_surface_mesh *mesh = ctx;

    if (made >= mesh->cap) {
        const uint32_t cap = made + made / 2 + 16;
        double(*at)[3] = realloc(mesh->at, cap * sizeof(*at));

        if (!at)
            return -ENOMEM;
        mesh->at = at;
        mesh->cap = cap;
    }
    memcpy(mesh->at[made], mesh->at[old], sizeof(*mesh->at));
    return 0;
}

/* Places of the vertices, which are the ranks of `points`. */
static int place_vertices(struct dx_stages *s, const struct dx_cloud *points,
                          const double (*xyz)[3])
{
    const struct dx_cloud *c = &s->cloud;
    struct dx_surface_mesh *mesh = &s->mesh;

    mesh->cap = points->n;
    mesh->at = malloc(((size_t)points->n + 1) * sizeof(*mesh->at));
    if (!mesh->at)
        return -ENOMEM;
    for (uint32_t r = 0; r < points->n; r++)
        for (int k = 0; k < 3; k++)
            mesh->at[r][k] = (xyz[points->index[r]][c->axis[k]] - c->origin[k]) / c->step;
    return dx_halfedges_split_fans(&mesh->edges, copy_vertex, mesh);
}

/* Points, by rank in `c`, with the normals that Q found. */
struct grow_input {
    const struct dx_cloud *c;
    const double (*xyz)[3];
    const float (*normal)[3];
};

static int grow_with(struct dx_stages *s, struct dx_grow_stats *stats,
                     const struct dx_grow_config *config, const struct grow_input *in,
                     float (*normal)[3], struct dx_err *err)
{
    struct dx_grow_config with = *config;
    struct dx_neighbours nb;
    int rc = dx_neighbours_init(&nb, in->c, DX_GROW_K, s->pool, err);

    if (rc < 0)
        return rc;
    for (uint32_t r = 0; r < in->c->n; r++)
        for (int k = 0; k < 3; k++)
            normal[r][k] = in->normal[in->c->index[r]][in->c->axis[k]];
    with.normal = (const float(*)[3])normal;
    rc = dx_grow(&s->mesh.edges, stats, in->c, &nb, &with, err);
    dx_neighbours_fini(&nb);
    if (rc == 0 && place_vertices(s, in->c, in->xyz) < 0)
        rc = no_memory(s, err);
    if (rc < 0)
        dx_surface_mesh_fini(&s->mesh);
    return rc;
}

static int grow_from(struct dx_stages *s, struct dx_grow_stats *stats,
                     const struct dx_grow_config *config, const struct grow_input *in,
                     struct dx_err *err)
{
    float(*normal)[3] = malloc(((size_t)in->c->n + 1) * sizeof(*normal));
    const int rc = normal ? grow_with(s, stats, config, in, normal, err) : no_memory(s, err);

    free(normal);
    return rc;
}

int dx_stages_grow(struct dx_stages *s, struct dx_grow_stats *stats,
                   const struct dx_grow_config *config, struct dx_err *err)
{
    struct grow_input in = {&s->cloud, (const double(*)[3])s->xyz, (const float(*)[3])s->normal};
    struct dx_cloud points;
    int rc;

    *stats = (struct dx_grow_stats){0};
    dx_surface_mesh_fini(&s->mesh);
    if (s->reduced.n == 0)
        return grow_from(s, stats, config, &in, err);
    rc = dx_cloud_init(&points, s->reduced.xyz[0], s->reduced.n, s->pool, err);
    if (rc < 0)
        return rc;
    in = (struct grow_input){&points, (const double(*)[3])s->reduced.xyz,
                             (const float(*)[3])s->reduced.normal};
    rc = grow_from(s, stats, config, &in, err);
    dx_cloud_fini(&points);
    return rc;
}

int dx_stages_refine(struct dx_stages *s, struct dx_refine_stats *stats,
                     const struct dx_refine_config *config, struct dx_err *err)
{
    const int rc = need_q(s, err);

    return rc < 0 ? rc : dx_refine(&s->mesh, stats, &s->cloud, &s->q, config, s->pool, err);
}

/* ---- normals -------------------------------------------------------------------------------- */

/* By rank, those that a stage has found; false: some are missing. */
static bool take_normals(float (*of)[3], const struct dx_cloud *c, const float (*normal)[3])
{
    bool all = true;

    for (uint32_t r = 0; r < c->n; r++) {
        const float *n = normal[c->index[r]];
        const bool has = n[0] != 0 || n[1] != 0 || n[2] != 0;

        for (int k = 0; k < 3 && has; k++)
            of[r][k] = n[c->axis[k]];
        all &= has;
    }
    return all;
}

static int turn(float (*of)[3], const struct dx_cloud *c, const float (*normal)[3],
                const double *viewpoint, struct dx_pool *pool, struct dx_err *err)
{
    struct dx_cloud_normals_config config;
    struct dx_cloud_normals_stats stats;
    struct dx_neighbours nb;
    uint32_t n_parts;
    int rc = dx_neighbours_init(&nb, c, DX_GROW_K, pool, err);

    dx_cloud_normals_defaults(&config);
    config.k = config.k < DX_GROW_K ? config.k : DX_GROW_K;
    if (rc == 0 && !take_normals(of, c, normal)) {
        rc = dx_cloud_normals(of, NULL, &stats, c, &nb, &config, pool, err);
        take_normals(of, c, normal);
    }
    if (rc == 0 &&
        dx_orient(of, &n_parts, c, &nb, nb.k < K_ORIENT ? nb.k : K_ORIENT, viewpoint, pool) < 0)
        rc = dx_err_set(err, -ENOMEM, "no memory for %u normals", c->n);
    dx_neighbours_fini(&nb);
    return rc;
}

static int orient(float (*normal)[3], const struct dx_cloud *c, const double *viewpoint,
                  struct dx_pool *pool, struct dx_err *err)
{
    float(*of)[3] = calloc((size_t)c->n + 1, sizeof(*of));
    int rc = of ? turn(of, c, (const float(*)[3])normal, viewpoint, pool, err)
                : dx_err_set(err, -ENOMEM, "no memory for %u normals", c->n);

    for (uint32_t r = 0; rc == 0 && r < c->n; r++)
        dx_cloud_normal_out(normal[c->index[r]], c, of[r]);
    free(of);
    return rc;
}

int dx_stages_orient(struct dx_stages *s, const double *viewpoint, struct dx_err *err)
{
    struct dx_cloud points;
    int rc;

    if (s->n < 3 || s->reduced.n == 1 || s->reduced.n == 2)
        return 0;
    if (s->reduced.n == 0)
        return orient(s->normal, &s->cloud, viewpoint, s->pool, err);
    rc = dx_cloud_init(&points, s->reduced.xyz[0], s->reduced.n, s->pool, err);
    if (rc < 0)
        return rc;
    rc = orient(s->reduced.normal, &points, viewpoint, s->pool, err);
    dx_cloud_fini(&points);
    return rc;
}
