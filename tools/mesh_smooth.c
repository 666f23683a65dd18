/* Stages of --mode smooth, each with its time, its numbers and a line for people. */
#include "tools/mesh_smooth.h"

#include "tools/now.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

const char *const dx_smooth_stages[DX_N_SMOOTH_STAGES] = {
    [DX_STAGE_SMOOTH] = "smooth", [DX_STAGE_CLUSTER] = "cluster", [DX_STAGE_REDUCE] = "reduce",
    [DX_STAGE_GROW] = "grow",     [DX_STAGE_REFINE] = "refine",
};

struct run {
    const struct dx_mesh_job *job;
    const struct dx_smooth_job_config *config;
    struct dx_stages s;
};

/* A stage's time on the wall, and of all threads on their processors, which other work that runs
 * beside lengthens less. */
struct watch {
    uint64_t start_ns;
    double cpu_s;
};

static double cpu_now(void)
{
    struct timespec t;

    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static struct watch watch_now(void)
{
    return (struct watch){dx_now_ns(), cpu_now()};
}

static void put_stage(const struct run *r, const char *name, const struct watch *w)
{
    json_t *stats = r->job->stats;

    dx_mesh_job_stage(r->job, name, dx_seconds_since(w->start_ns));
    if (!json_object_get(stats, "processor_seconds"))
        json_object_set_new(stats, "processor_seconds", json_object());
    json_object_set_new(json_object_get(stats, "processor_seconds"), name,
                        json_real(cpu_now() - w->cpu_s));
}

static void put_count(const struct run *r, const char *name, uint64_t n)
{
    json_object_set_new(r->job->stats, name, json_integer((json_int_t)n));
}

static void put_real(const struct run *r, const char *name, double x)
{
    json_object_set_new(r->job->stats, name, json_real(x));
}

/* The name of a pass: "smooth", "smooth2". */
static const char *pass_name(char name[24], const char *stage, uint32_t pass)
{
    snprintf(name, 24, pass ? "%s%u" : "%s", stage, pass + 1);
    return name;
}

static int smooth(struct run *r, uint32_t pass, struct dx_err *err)
{
    const struct dx_smooth_job_config *c = r->config;
    const struct dx_cloud_smooth_config config = {c->sw, c->sr, c->fit == 1};
    struct dx_cloud_smooth_scale scale;
    struct dx_cloud_smooth_stats stats;
    const struct watch start = watch_now();
    const double step = r->s.cloud.step;
    char name[24];
    int rc = dx_stages_smooth(&r->s, &scale, &stats, &config, err);

    if (rc < 0)
        return rc;
    put_stage(r, pass_name(name, "smooth", pass), &start);
    dx_mesh_job_tell(r->job,
                     "spacing %.3g, noise %.3g, radius of curvature %.3g; sw %.3g, sr %.3g of "
                     "spacings, fit %s: moved by %.3g, %u points left as they were",
                     scale.spacing * step, scale.noise * step,
                     scale.curvature > 0 ? scale.spacing * step / scale.curvature : 0, scale.sw,
                     scale.sr, scale.quadric ? "quadric" : "plane", stats.rms_moved * step,
                     stats.n_unchanged);
    if (pass == 0) {
        put_real(r, "side", scale.spacing * step);
        put_real(r, "sw", scale.sw);
        put_real(r, "sr", scale.sr);
        put_real(r, "rms_moved", stats.rms_moved * step);
        put_count(r, "unchanged", stats.n_unchanged);
        put_real(r, "mean_steps", stats.mean_steps);
        put_real(r, "mean_near", stats.mean_near);
    }
    return 0;
}

static int cluster(struct run *r, struct dx_err *err)
{
    const struct dx_smooth_job_config *c = r->config;
    /* a bound below the least number of points is meant for that too */
    const uint32_t least =
        c->max_points && c->max_points < c->min_points ? c->max_points : c->min_points;
    const struct dx_cluster_config config = {(enum dx_cluster_split)c->split, c->max_variation,
                                             least, c->max_points};
    const struct watch start = watch_now();
    int rc = dx_stages_cluster(&r->s, &config, err);

    if (rc < 0)
        return rc;
    put_stage(r, "cluster", &start);
    dx_mesh_job_tell(r->job, "%u clusters of %u to %u points, variation %g, split %s",
                     r->s.clusters.n, least, c->max_points, c->max_variation,
                     c->split == DX_CLUSTER_ACROSS ? "v3" : "v1");
    put_count(r, "clusters", r->s.clusters.n);
    return 0;
}

static int reduce(struct run *r, struct dx_err *err)
{
    const struct watch start = watch_now();
    int rc = dx_stages_reduce(&r->s, err);

    if (rc < 0)
        return rc;
    put_stage(r, "reduce", &start);
    put_count(r, "representatives", r->s.reduced.n);
    put_count(r, "medoids", r->s.reduced.n_medoids);
    put_count(r, "merged", r->s.reduced.n_merged);
    return 0;
}

static int grow(struct run *r, struct dx_err *err)
{
    const struct dx_smooth_job_config *c = r->config;
    const struct watch start = watch_now();
    struct dx_grow_config config;
    struct dx_grow_stats stats;
    int rc;

    dx_grow_defaults(&config);
    config.max_bend_deg = c->max_bend_deg;
    config.max_angle_deg = c->max_angle_deg;
    config.max_ratio = c->max_ratio;
    config.max_loop = c->max_loop;
    config.viewpoint = r->job->viewpoint;
    rc = dx_stages_grow(&r->s, &stats, &config, err);
    if (rc < 0)
        return rc;
    put_stage(r, "grow", &start);
    dx_mesh_job_tell(r->job, "%u triangles of %u points, %u edges at borders; %u points left over",
                     stats.n_triangles, r->s.mesh.edges.n_vertices, stats.n_border, stats.n_unused);
    put_count(r, "grown_triangles", stats.n_triangles);
    put_count(r, "loop_triangles", stats.n_loop_triangles);
    put_count(r, "unused", stats.n_unused);
    return 0;
}

static int refine(struct run *r, uint32_t pass, struct dx_err *err)
{
    const struct watch start = watch_now();
    struct dx_refine_config config;
    struct dx_refine_stats stats;
    char name[24], counted[40];
    int rc;

    dx_refine_defaults(&config);
    config.tolerance = r->config->tolerance;
    rc = dx_stages_refine(&r->s, &stats, &config, err);
    if (rc < 0)
        return rc;
    put_stage(r, pass_name(name, "refine", pass), &start);
    dx_mesh_job_tell(r->job, "%u of %u edges were off the points: %u triangles", stats.n_off,
                     stats.n_edges, r->s.mesh.edges.n_faces);
    snprintf(counted, sizeof(counted), "%s_triangles", name);
    put_count(r, counted, r->s.mesh.edges.n_faces);
    return 0;
}

static int run_stages(struct run *r, unsigned stages, struct dx_err *err)
{
    struct dx_progress *progress = r->job->progress;
    int rc = 0;

    dx_progress_stage(progress, "smoothing");
    for (uint32_t k = 0; rc == 0 && stages & 1u << DX_STAGE_SMOOTH && k < r->config->n_passes; k++)
        rc = smooth(r, k, err);
    dx_progress_stage(progress, "clusters");
    if (rc == 0 && stages & 1u << DX_STAGE_CLUSTER)
        rc = cluster(r, err);
    if (rc == 0 && stages & 1u << DX_STAGE_REDUCE)
        rc = reduce(r, err);
    dx_progress_stage(progress, "triangles");
    if (rc == 0 && stages & 1u << DX_STAGE_GROW)
        rc = grow(r, err);
    dx_progress_stage(progress, "refining");
    for (uint32_t k = 0; rc == 0 && stages & 1u << DX_STAGE_REFINE && k < r->config->n_refine; k++)
        rc = refine(r, k, err);
    return rc;
}

/* ---- what comes out ------------------------------------------------------------------------- */

/* The mesh's vertices that have triangles; number[]: which they become. */
static void put_vertices(double *xyz, float *normal, uint32_t *number, const struct dx_stages *s,
                         const double (*of)[3])
{
    const struct dx_cloud *c = &s->cloud;
    uint32_t n = 0;

    for (uint32_t v = 0; v < s->mesh.edges.n_vertices; v++) {
        if (s->mesh.edges.out[v] == DX_NO_HALFEDGE)
            continue;
        dx_cloud_to_input(xyz + 3 * (size_t)n, c, s->mesh.at[v]);
        for (int k = 0; k < 3; k++)
            normal[3 * (size_t)n + (size_t)c->axis[k]] = (float)of[v][k];
        number[v] = n++;
    }
}

static int put_triangles(struct dx_cloud_mesh *mesh, const struct dx_halfedges *m,
                         const uint32_t *number)
{
    int rc = 0;

    for (uint32_t f = 0; f < m->n_faces && rc == 0; f++) {
        const uint32_t h = m->face[f];
        const uint32_t v[3] = {number[dx_halfedge_from(m, h)], number[m->of[h].to],
                               number[dx_halfedge_apex(m, h)]};

        rc = dx_cloud_mesh_triangle(mesh, v);
    }
    return rc;
}

static int put_mesh(struct run *r)
{
    const struct dx_halfedges *m = &r->s.mesh.edges;
    const size_t n = m->n_vertices;
    double *xyz = malloc(3 * n * sizeof(*xyz) + 1);
    float *normal = malloc(3 * n * sizeof(*normal) + 1);
    double(*of)[3] = malloc(n * sizeof(*of) + 1);
    uint32_t *number = malloc(n * sizeof(*number) + 1), n_used = 0;
    int rc = xyz && normal && of && number ? 0 : -ENOMEM;

    for (uint32_t v = 0; v < n; v++)
        n_used += m->out[v] != DX_NO_HALFEDGE;
    if (rc == 0) {
        dx_surface_normals(of, &r->s.mesh);
        put_vertices(xyz, normal, number, &r->s, (const double(*)[3])of);
        rc = put_triangles(r->job->mesh, m, number);
        dx_cloud_mesh_points(r->job->mesh, xyz, normal, n_used);
    } else {
        free(xyz);
        free(normal);
    }
    free(of);
    free(number);
    return rc;
}

/* Points without triangles: the reduced ones, or all; they are the mesh's from now on. */
static int put_points(struct run *r, struct dx_err *err)
{
    struct dx_stages *s = &r->s;
    const struct watch start = watch_now();
    const int rc = dx_stages_orient(s, r->job->viewpoint, err);

    if (rc < 0)
        return rc;
    put_stage(r, "orient", &start);
    if (s->reduced.n) {
        dx_cloud_mesh_points(r->job->mesh, s->reduced.xyz[0], s->reduced.normal[0], s->reduced.n);
        s->reduced.xyz = NULL;
        s->reduced.normal = NULL;
    } else {
        dx_cloud_mesh_points(r->job->mesh, s->xyz[0], s->normal[0], s->n);
        s->xyz = NULL;
        s->normal = NULL;
    }
    return 0;
}

int dx_smooth_job_run(const struct dx_mesh_job *job, const struct dx_smooth_job_config *config,
                      unsigned stages, struct dx_err *err)
{
    struct run r = {job, config, {0}};
    int rc = dx_stages_init(&r.s, job->xyz, job->n_input, job->pool, err);

    if (rc < 0)
        return rc;
    rc = run_stages(&r, stages, err);
    if (rc == 0 && stages & 1u << DX_STAGE_GROW) {
        rc = put_mesh(&r);
        if (rc < 0)
            dx_err_set(err, rc, "no memory for the mesh of %u points", r.s.n);
    } else if (rc == 0) {
        rc = put_points(&r, err);
    }
    dx_stages_fini(&r.s);
    return rc;
}
