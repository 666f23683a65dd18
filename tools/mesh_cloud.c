/* From a file of points to a mesh and its numbers, whatever the mode. */
#include "tools/mesh_cloud.h"

#include "core/cloud/spacing.h"
#include "tools/args.h"
#include "tools/memory_free.h"
#include "tools/now.h"
#include "tools/stats_json.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* Bytes of a point, at most but for odd inputs. */
#define READ_LEN   24 /* coordinates as read, which stay */
#define SORT_LEN   51 /* the cloud while it is made */
#define CLOUD_LEN  17 /* and then */
#define GROW_LEN   36 /* two triangles, while their number grows */
#define FINISH_LEN 40 /* and then, with the vertices and where they came from */
#define REPAIR_LEN                                                                                 \
    94 /* edges, mates and fans, where fans must be told apart; more than statistics */

#define MANY 1000000 /* points from which on the memory is told without being asked */

struct times {
    double read_s, load_s, mesh_s;
    double read_cpu_s, load_cpu_s, mesh_cpu_s;
};

struct clocks {
    uint64_t wall_ns, cpu_ns;
};

static struct clocks clocks_now(void)
{
    return (struct clocks){dx_now_ns(), dx_cpu_ns()};
}

static void add_since(double *wall_s, double *cpu_s, const struct clocks *start)
{
    *wall_s += dx_seconds_since(start->wall_ns);
    *cpu_s += (double)(dx_cpu_ns() - start->cpu_ns) * 1e-9;
}

void dx_mesh_job_tell(const struct dx_mesh_job *job, const char *fmt, ...)
{
    va_list ap;

    dx_progress_clear(job->progress);
    fprintf(stderr, "%s: %s: ", job->path, job->mode->name);
    va_start(ap, fmt);
    vfprintf(stderr, fmt, ap);
    va_end(ap);
    fputc('\n', stderr);
}

void dx_mesh_job_stage(const struct dx_mesh_job *job, const char *name, double seconds)
{
    if (!json_object_get(job->stats, "stages"))
        json_object_set_new(job->stats, "stages", json_object());
    json_object_set_new(json_object_get(job->stats, "stages"), name, json_real(seconds));
}

static uint64_t max_of(uint64_t a, uint64_t b)
{
    return a > b ? a : b;
}

/* Bytes that n points will take. */
static uint64_t need(const struct dx_mesh_cloud_args *a, size_t n)
{
    const uint64_t finish_len = FINISH_LEN + REPAIR_LEN;

    return n * (READ_LEN +
                max_of(SORT_LEN, CLOUD_LEN + max_of(finish_len, GROW_LEN + a->mode->point_len)));
}

/* Tells it before the work; more than there is would end in the middle, without a word. */
static int check_memory(const struct dx_mesh_cloud_args *a, struct dx_mesh_job *job,
                        struct dx_err *err)
{
    const uint64_t needed = need(a, job->n_input), has = job->n_input * READ_LEN;
    const uint64_t left = a->memory_mb ? a->memory_mb * 1000000 : dx_memory_free();

    if (a->memory_mb ? needed > left : needed - has > left)
        return dx_err_set(err, -ENOMEM,
                          "%s: %zu points need about %.0f MB, expected at most %.0f MB (--memory)",
                          a->source.path, job->n_input, (double)needed / 1e6,
                          (double)(a->memory_mb ? left : left + has) / 1e6);
    dx_progress_clear(job->progress);
    if (a->stats || job->n_input >= MANY)
        fprintf(stderr, "%s: needs about %.0f MB\n", a->source.path, (double)needed / 1e6);
    return 0;
}

static void tell_cloud(const struct dx_mesh_job *job)
{
    const struct dx_cloud *c = job->cloud;

    dx_progress_clear(job->progress);
    fprintf(stderr, "%s: %u points", job->path, c->n);
    if (c->n_not_finite)
        fprintf(stderr, ", %u not finite", c->n_not_finite);
    if (c->n_strays)
        fprintf(stderr, ", %u too far from the others", c->n_strays);
    if (c->n_duplicates)
        fprintf(stderr, ", %u duplicates (nearer than %.2g)", c->n_duplicates, c->step);
    fprintf(stderr, "; spacing %.3g, noise %.3g\n", job->spacing, job->noise);
}

static int print_stats(const struct dx_mesh *mesh, const struct dx_mesh_job *job,
                       const struct times *t)
{
    struct dx_mesh_stats stats;
    json_t *j, *about;
    int rc = dx_mesh_stats_compute(&stats, mesh);

    about = json_pack("{s:s, s:s, s:I, s:I, s:I, s:f, s:f, s:f, s:f, s:f, s:f}", "geometry",
                      "points", "mode", job->mode->name, "input_points", (json_int_t)job->cloud->n,
                      "duplicates", (json_int_t)job->cloud->n_duplicates, "not_finite",
                      (json_int_t)job->cloud->n_not_finite, "spacing", job->spacing, "noise",
                      job->noise, "seconds", t->read_s + t->load_s + t->mesh_s, "read_seconds",
                      t->read_s, "load_seconds", t->load_s, "mesh_seconds", t->mesh_s);
    if (rc < 0 || !about) {
        fprintf(stderr, "dexel mesh: out of memory\n");
        json_decref(about);
        return -ENOMEM;
    }
    j = dx_stats_json(&stats);
    json_object_update(j, about);
    json_object_set_new(j, "strays", json_integer(job->cloud->n_strays));
    json_object_set_new(j, "read_cpu_seconds", json_real(t->read_cpu_s));
    json_object_set_new(j, "load_cpu_seconds", json_real(t->load_cpu_s));
    json_object_set_new(j, "mesh_cpu_seconds", json_real(t->mesh_cpu_s));
    json_object_set_new(j, "peak_rss_bytes", json_integer((json_int_t)dx_memory_peak()));
    json_object_update(j, job->stats);
    json_decref(about);
    return dx_json_print(j, "dexel mesh");
}

/* A vertex for each fan of triangles: the mesh is a manifold then. */
static int split_fans(struct dx_mesh *mesh, const struct dx_mesh_job *job)
{
    struct dx_mesh_repair counts = {0};
    int rc = job->mesh->n_pinched ? dx_mesh_repair(mesh, 0, &counts) : 0;

    json_object_set_new(job->stats, "split_vertices", json_integer(counts.split));
    return rc;
}

/* What the mode made, written and counted. */
static int finish(const struct dx_mesh_cloud_args *a, const struct dx_mesh_job *job,
                  struct times *t, struct dx_err *err)
{
    struct dx_out_options write = {.ascii = a->ascii};
    const struct clocks start = clocks_now();
    struct dx_mesh_repair counts;
    struct dx_mesh mesh;
    int rc = dx_cloud_mesh_make(&mesh, job->mesh, job->xyz, job->n_input, &write);

    if (rc == 0 && !a->repair.asked) {
        rc = split_fans(&mesh, job);
        if (rc < 0)
            dx_mesh_fini(&mesh);
    }
    add_since(&t->mesh_s, &t->mesh_cpu_s, &start);
    if (rc < 0)
        return dx_err_set(err, rc, "%s: the mesh of %u points: %s", a->source.path, job->cloud->n,
                          strerror(-rc));
    if (mesh.n_triangles == 0 && mesh.n_vertices == 0)
        fprintf(stderr, "%s: no triangle\n", a->source.path);
    else if (mesh.n_triangles)
        fprintf(stderr, "%s: %u triangles of %u vertices\n", a->source.path, mesh.n_triangles,
                mesh.n_vertices);
    rc = dx_mesh_repair_run(&mesh, &counts, &a->repair, a->source.path, err);
    if (rc == 0 && a->repair.asked)
        json_object_set_new(job->stats, "repair", dx_mesh_repair_json(&counts));
    if (rc == 0 && a->out && write.world && dx_mesh_writer_for(a->out, err) == &dx_mesh_writer_stl)
        rc = dx_err_set(err, -EINVAL,
                        "%s: STL has floats, which do not tell these points apart: expected .ply "
                        "or .obj",
                        a->out);
    if (rc == 0 && a->out)
        rc = dx_out_mesh(a->out, &mesh, &write, err);
    if (rc == 0 && a->stats && print_stats(&mesh, job, t) < 0)
        rc = dx_err_set(err, -EIO, "no statistics");
    dx_mesh_fini(&mesh);
    return rc;
}

static int run_mode(const struct dx_mesh_cloud_args *a, struct dx_mesh_job *job, struct times *t,
                    struct dx_err *err)
{
    struct dx_cloud_mesh mesh = {.progress = job->progress};
    struct clocks start;
    int rc;

    job->spacing = dx_cloud_spacing(job->cloud) * job->cloud->step;
    job->noise = dx_cloud_noise(job->cloud) * job->cloud->step;
    job->viewpoint = a->has_viewpoint ? a->viewpoint : NULL;
    job->mesh = &mesh;
    job->stats = json_object();
    tell_cloud(job);
    start = clocks_now();
    rc = job->stats ? a->mode->run(job, a->config, err) : dx_err_set(err, -ENOMEM, "no memory");
    add_since(&t->mesh_s, &t->mesh_cpu_s, &start);
    dx_progress_clear(job->progress);
    if (rc < 0)
        dx_err_prefix(err, a->source.path);
    else
        rc = finish(a, job, t, err);
    json_decref(job->stats);
    dx_cloud_mesh_fini(&mesh);
    job->mesh = NULL;
    job->stats = NULL;
    return rc;
}

static int load(struct dx_cloud *c, struct dx_mesh_job *job, struct times *t, struct dx_err *err)
{
    const struct clocks start = clocks_now();
    int rc;

    dx_progress_stage(job->progress, "sorting");
    rc = dx_cloud_init(c, job->xyz, job->n_input, job->pool, err);
    add_since(&t->load_s, &t->load_cpu_s, &start);
    if (rc < 0)
        dx_err_prefix(err, job->path);
    job->cloud = c;
    return rc;
}

static int run(const struct dx_mesh_cloud_args *a, struct dx_progress *progress, struct dx_err *err)
{
    struct dx_mesh_job job = {.mode = a->mode, .path = a->source.path, .progress = progress};
    struct dx_point_list list = {0};
    struct times t = {0};
    struct dx_cloud c;
    const struct clocks start = clocks_now();
    int rc;

    dx_progress_stage(progress, "reading");
    rc = dx_cloud_read(&list, &a->source, err);
    add_since(&t.read_s, &t.read_cpu_s, &start);
    if (rc == 0 && dx_pool_new(&job.pool, a->n_threads) < 0)
        rc = dx_err_set(err, -ENOMEM, "no threads");
    job.xyz = list.xyz;
    job.n_input = list.n;
    if (rc == 0)
        rc = check_memory(a, &job, err);
    if (rc == 0 && (rc = load(&c, &job, &t, err)) == 0) {
        rc = run_mode(a, &job, &t, err);
        dx_cloud_fini(&c);
    }
    dx_pool_free(job.pool);
    dx_point_list_fini(&list);
    return rc;
}

int dx_mesh_cloud(const struct dx_mesh_mode *mode, int argc, char **argv)
{
    struct dx_mesh_cloud_args a;
    struct dx_progress progress;
    struct dx_err err = {""};
    int rc = dx_mesh_cloud_args_parse(&a, mode, argc, argv);

    if (rc != 0) {
        dx_mesh_cloud_args_fini(&a);
        return rc == DX_ARG_E_HELP ? 0 : 2;
    }
    dx_progress_init(&progress, a.progress);
    rc = run(&a, &progress, &err);
    dx_progress_clear(&progress);
    if (rc < 0)
        fprintf(stderr, "dexel mesh: %s\n", err.text);
    dx_mesh_cloud_args_fini(&a);
    return rc < 0 ? 1 : 0;
}
