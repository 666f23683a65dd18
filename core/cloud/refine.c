/* A pass: what each edge needs, then splits in the order of the edges, then flips. */
#include "core/cloud/refine_priv.h"

#include "core/base/trig.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>

#define RUN       256 /* edges of a task */
#define MAX_NEAR  64
#define MIN_NEAR  6
#define NEAR      2.0 /* spacings around a middle */
#define WIDEN     1.6
#define MAX_TRIES 4
#define SHORTEST  1.0 /* spacings: on shorter edges the points tell nothing more */
#define MAX_MOVE  2.0 /* widths of Q that a new vertex moves at most */

void dx_refine_defaults(struct dx_refine_config *config)
{
    *config = (struct dx_refine_config){
        .tolerance = 0.1, .min_ratio = 0.2, .max_turn_deg = 60, .max_sweeps = 10};
}

void dx_surface_mesh_fini(struct dx_surface_mesh *mesh)
{
    dx_halfedges_fini(&mesh->edges);
    free(mesh->at);
    *mesh = (struct dx_surface_mesh){.at = NULL};
}

void dx_refine_normal(double n[3], const double a[3], const double b[3], const double c[3])
{
    double p[3], q[3], len;

    for (int k = 0; k < 3; k++) {
        p[k] = b[k] - a[k];
        q[k] = c[k] - a[k];
    }
    for (int k = 0; k < 3; k++)
        n[k] = p[(k + 1) % 3] * q[(k + 2) % 3] - p[(k + 2) % 3] * q[(k + 1) % 3];
    len = sqrt(dx_refine_dot(n, n));
    for (int k = 0; k < 3; k++)
        n[k] = len > 0 ? n[k] / len : 0;
}

void dx_surface_normals(double (*normal)[3], const struct dx_surface_mesh *mesh)
{
    const struct dx_halfedges *m = &mesh->edges;

    for (uint32_t v = 0; v < m->n_vertices; v++)
        for (int k = 0; k < 3; k++)
            normal[v][k] = 0;
    for (uint32_t f = 0; f < m->n_faces; f++) {
        const uint32_t h = m->face[f];
        const uint32_t v[3] = {dx_halfedge_from(m, h), m->of[h].to, dx_halfedge_apex(m, h)};
        double n[3];

        dx_refine_normal(n, mesh->at[v[0]], mesh->at[v[1]], mesh->at[v[2]]);
        for (int i = 0; i < 3; i++)
            for (int k = 0; k < 3; k++)
                normal[v[i]][k] += n[k];
    }
    for (uint32_t v = 0; v < m->n_vertices; v++) {
        const double len = sqrt(dx_refine_dot(normal[v], normal[v]));

        for (int k = 0; k < 3; k++)
            normal[v][k] = len > 0 ? normal[v][k] / len : 0;
    }
}

/* ---- what edges need ------------------------------------------------------------------------ */

struct need {
    double at[3]; /* of the new vertex */
    bool is_off;
};

struct job {
    const struct dx_surface_mesh *mesh;
    const struct dx_cloud *cloud;
    const struct dx_cloud_smooth_scale *scale;
    const struct dx_refine_config *config;
    double (*normal)[3];
    struct need *need; /* [n_edges] */
    uint32_t n_edges;
};

/* How far the points near m are above it, in the mean; false: there are none. */
static bool height_above(double *a, const struct job *j, const double m[3], const double n[3])
{
    const int32_t p[3] = {(int32_t)rint(m[0]), (int32_t)rint(m[1]), (int32_t)rint(m[2])};
    struct dx_near near[MAX_NEAR];
    double radius = NEAR * j->scale->spacing, sum = 0;
    uint32_t count = 0;

    for (int try = 0; try < MAX_TRIES && count < MIN_NEAR; try++, radius *= WIDEN)
        count = radius < DX_CLOUD_LATTICE
                    ? dx_cloud_within(j->cloud, p, (int32_t)radius, near, MAX_NEAR)
                    : 0;
    if (count < MIN_NEAR)
        return false;
    count = count < MAX_NEAR ? count : MAX_NEAR;
    for (uint32_t k = 0; k < count; k++) {
        const int32_t *q = j->cloud->at[near[k].rank];

        for (int i = 0; i < 3; i++)
            sum += (q[i] - m[i]) * n[i];
    }
    *a = sum / count;
    return true;
}

static void look_at(struct need *need, const struct job *j, uint32_t h)
{
    const double *u = j->mesh->at[dx_halfedge_from(&j->mesh->edges, h)];
    const double *v = j->mesh->at[j->mesh->edges.of[h].to];
    const double *nu = j->normal[dx_halfedge_from(&j->mesh->edges, h)];
    const double *nv = j->normal[j->mesh->edges.of[h].to];
    const double limit = MAX_MOVE * j->scale->sw * j->scale->spacing;
    const double shortest = SHORTEST * j->scale->spacing;
    struct dx_cloud_smoothed q;
    double m[3], n[3], len, a;

    need->is_off = false;
    if (dx_refine_len2(u, v) < shortest * shortest)
        return;
    for (int k = 0; k < 3; k++) {
        m[k] = (u[k] + v[k]) / 2;
        n[k] = nu[k] + nv[k];
    }
    len = sqrt(dx_refine_dot(n, n));
    for (int k = 0; k < 3; k++)
        n[k] = len > 0 ? n[k] / len : 0;
    if (!(len > 0) || !height_above(&a, j, m, n) ||
        !(fabs(a) > j->config->tolerance * j->scale->spacing))
        return;
    for (int k = 0; k < 3; k++)
        m[k] += a * n[k];
    if (dx_cloud_smooth_place(&q, j->cloud, j->scale, m) == DX_CLOUD_SMOOTH_UNCHANGED ||
        dx_refine_len2(q.at, m) > limit * limit)
        return;
    for (int k = 0; k < 3; k++)
        need->at[k] = q.at[k];
    need->is_off = true;
}

static void look_run(void *ctx, uint32_t task, unsigned thread)
{
    const struct job *j = ctx;
    const uint32_t first = task * RUN, end = first + RUN;

    (void)thread;
    for (uint32_t e = first; e < end && e < j->n_edges; e++)
        look_at(&j->need[e], j, 2 * e);
}

/* ---- splits --------------------------------------------------------------------------------- */

/* Whether the triangle of half-edge h may be divided by a vertex at `at` on it; a border may. */
static bool may_divide(const struct dx_surface_mesh *mesh, uint32_t h, const double at[3],
                       const struct dx_refine_config *config, double cos_turn)
{
    const struct dx_halfedges *m = &mesh->edges;
    const double *u, *v, *a;
    double uv, va, au, least, most, n[3], n1[3], n2[3];

    if (dx_halfedge_is_border(m, h))
        return true;
    u = mesh->at[dx_halfedge_from(m, h)];
    v = mesh->at[m->of[h].to];
    a = mesh->at[dx_halfedge_apex(m, h)];
    uv = dx_refine_len2(u, v);
    va = dx_refine_len2(v, a);
    au = dx_refine_len2(a, u);
    least = uv < va ? uv : va;
    least = least < au ? least : au;
    most = uv > va ? uv : va;
    most = most > au ? most : au;
    if (!(least >= config->min_ratio * config->min_ratio * most))
        return false;
    dx_refine_normal(n, u, v, a);
    dx_refine_normal(n1, u, at, a);
    dx_refine_normal(n2, at, v, a);
    return dx_refine_dot(n, n1) >= cos_turn && dx_refine_dot(n, n2) >= cos_turn;
}

static int add_vertex(struct dx_surface_mesh *mesh, uint32_t *v, const double at[3])
{
    if (mesh->edges.n_vertices >= mesh->cap) {
        const uint32_t cap = mesh->edges.n_vertices + mesh->edges.n_vertices / 2 + 16;
        double(*room)[3] = realloc(mesh->at, cap * sizeof(*room));

        if (!room)
            return -ENOMEM;
        mesh->at = room;
        mesh->cap = cap;
    }
    if (dx_halfedges_add_vertex(&mesh->edges, v) < 0)
        return -ENOMEM;
    for (int k = 0; k < 3; k++)
        mesh->at[*v][k] = at[k];
    return 0;
}

static int split_edges(struct dx_surface_mesh *mesh, struct dx_refine_stats *stats,
                       const struct job *j)
{
    const double cos_turn = dx_cos(dx_rad(j->config->max_turn_deg));

    for (uint32_t e = 0; e < j->n_edges; e++) {
        const double *at = j->need[e].at;
        uint32_t v;

        stats->n_off += j->need[e].is_off;
        if (!j->need[e].is_off || !may_divide(mesh, 2 * e, at, j->config, cos_turn) ||
            !may_divide(mesh, 2 * e + 1, at, j->config, cos_turn))
            continue;
        if (add_vertex(mesh, &v, at) < 0 || dx_halfedges_split_edge(&mesh->edges, 2 * e, v) < 0)
            return -ENOMEM;
        stats->n_split++;
    }
    return 0;
}

static int check(const struct dx_refine_config *c, struct dx_err *err)
{
    if (!(c->tolerance >= 0 && c->tolerance <= 1000))
        return dx_err_set(err, -EINVAL, "tolerance is %g spacings, expected 0 to 1000",
                          c->tolerance);
    if (!(c->min_ratio >= 0 && c->min_ratio <= 1))
        return dx_err_set(err, -EINVAL, "ratio of edges is %g, expected 0 to 1", c->min_ratio);
    if (!(c->max_turn_deg > 0 && c->max_turn_deg < 90))
        return dx_err_set(err, -EINVAL, "turn of a normal is %g degrees, expected 0 to 90",
                          c->max_turn_deg);
    return 0;
}

int dx_refine(struct dx_surface_mesh *mesh, struct dx_refine_stats *stats,
              const struct dx_cloud *cloud, const struct dx_cloud_smooth_scale *scale,
              const struct dx_refine_config *config, struct dx_pool *pool, struct dx_err *err)
{
    struct job j = {mesh, cloud, scale, config, NULL, NULL, mesh->edges.n / 2};
    int rc = check(config, err);

    *stats = (struct dx_refine_stats){.n_edges = j.n_edges};
    if (rc < 0 || j.n_edges == 0)
        return rc;
    j.normal = malloc(mesh->edges.n_vertices * sizeof(*j.normal));
    j.need = malloc(j.n_edges * sizeof(*j.need));
    rc = j.normal && j.need ? 0 : -ENOMEM;
    if (rc == 0) {
        dx_surface_normals(j.normal, mesh);
        dx_pool_run(pool, (j.n_edges + RUN - 1) / RUN, look_run, &j);
        rc = split_edges(mesh, stats, &j);
    }
    if (rc == 0)
        dx_refine_flip(mesh, stats, config);
    else
        dx_err_set(err, rc, "no memory for the mesh of %u edges", j.n_edges);
    free(j.normal);
    free(j.need);
    return rc;
}
