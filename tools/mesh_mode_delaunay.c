/* dexel mesh --mode delaunay: normals and the parameters of core/cloud/delaunay.h as options. */
#include "core/cloud/cloud_normals.h"
#include "core/cloud/delaunay.h"
#include "tools/mesh_mode.h"
#include "tools/now.h"

#include <errno.h>
#include <stdlib.h>

static const char help[] =
    "  --fit N             neighbours that a normal is fitted to: 3 to 64 (16 to 64 by the noise)\n"
    "  --near N            candidates of a point at first: 3 to 64 (16; more where it is noisy)\n"
    "  --flatten auto|turn|shadow\n"
    "                      how they come into its tangent plane: turned about the point, at their\n"
    "                      distance, or straight down (shadow where the points are noisy)\n"
    "  --reach circles|paper\n"
    "                      how far candidates are: as far as empty circles reach, or by curvature\n"
    "                      alone (circles)\n"
    "  --widest N          no larger circles, in radii of the first candidates: 1 to 100 (2.5)\n"
    "  --max-edge M        no longer edge\n"
    "  --loops N           fill holes of at most N edges, 0 to 32 (8)\n";

enum flatten { BY_NOISE, TURN, SHADOW };
enum reach { CIRCLES, PAPER };

struct config {
    uint32_t fit, near; /* 0: found */
    int flatten, reach;
    double widest, max_edge;
    uint32_t max_loop;
};

static const char *const flattens[] = {"auto", "turn", "shadow", NULL};
static const char *const reaches[] = {"circles", "paper", NULL};

#define AT(member) offsetof(struct config, member)

static const struct dx_mesh_option options[] = {
    {"fit", DX_MESH_COUNT, AT(fit), 3, DX_CLOUD_MAX_NEAREST, "neighbours", NULL},
    {"near", DX_MESH_COUNT, AT(near), 3, DX_CLOUD_MAX_NEAREST, "neighbours", NULL},
    {"flatten", DX_MESH_CHOICE, AT(flatten), 0, 0, NULL, flattens},
    {"reach", DX_MESH_CHOICE, AT(reach), 0, 0, NULL, reaches},
    {"widest", DX_MESH_NUMBER, AT(widest), 1, 100, "radii", NULL},
    {"max-edge", DX_MESH_NUMBER, AT(max_edge), 0, 1e12, "a length", NULL},
    {"loops", DX_MESH_COUNT, AT(max_loop), 0, DX_DELAUNAY_MAX_LOOP, "edges", NULL},
    {0},
};

static void defaults(void *config)
{
    struct dx_delaunay_config d;

    dx_delaunay_defaults(&d);
    *(struct config *)config =
        (struct config){.widest = d.widest, .max_edge = d.max_edge, .max_loop = d.max_loop};
}

/* By how noisy the points are: normals of neighbours must agree better than the heights. */
struct found {
    double noise; /* spacings, up to here */
    uint32_t fit, near;
    enum flatten flatten;
};

static const struct found by_noise[] = {
    {0.15, 16, 16, TURN}, {0.25, 24, 16, SHADOW}, {0.7, 48, 32, SHADOW}, {1e300, 64, 64, SHADOW}};

static void find_parameters(struct config *c, const struct dx_mesh_job *job)
{
    const struct found *f = by_noise;

    while (job->noise > f->noise * job->spacing)
        f++;
    c->fit = c->fit ? c->fit : f->fit;
    c->near = c->near ? c->near : f->near;
    c->flatten = c->flatten != BY_NOISE ? c->flatten : (int)f->flatten;
}

/* What run() does, and when what it does began. */
struct work {
    const struct dx_mesh_job *job;
    const char *stage; /* NULL: none yet */
    uint64_t start_ns;
    struct dx_neighbours nb;
    float (*normals)[3];
};

static void begin(struct work *w, const char *stage)
{
    if (w->stage)
        dx_mesh_job_stage(w->job, w->stage, dx_seconds_since(w->start_ns));
    w->stage = stage;
    w->start_ns = dx_now_ns();
    if (stage)
        dx_progress_stage(w->job->progress, stage);
}

static void take_stage(void *ctx, enum dx_delaunay_stage stage)
{
    static const char *const names[] = {[DX_DELAUNAY_STARS] = "stars",
                                        [DX_DELAUNAY_ACCEPT] = "accept",
                                        [DX_DELAUNAY_HOLES] = "holes"};

    begin(ctx, names[stage]);
}

static int take_triangle(void *ctx, const uint32_t v[3])
{
    struct work *w = ctx;

    return dx_cloud_mesh_triangle(w->job->mesh, v);
}

static int find_normals(struct work *w, const struct config *c, struct dx_err *err)
{
    const struct dx_mesh_job *job = w->job;
    const struct dx_cloud_normals_config config = {c->fit, job->viewpoint};
    struct dx_cloud_normals_stats stats;
    int rc;

    begin(w, "neighbours");
    rc =
        dx_neighbours_init(&w->nb, job->cloud, c->fit > c->near ? c->fit : c->near, job->pool, err);
    if (rc < 0)
        return rc;
    begin(w, "normals");
    w->normals = malloc(job->cloud->n * sizeof(*w->normals) + 1);
    if (!w->normals)
        return dx_err_set(err, -ENOMEM, "no memory for %u normals", job->cloud->n);
    rc = dx_cloud_normals(w->normals, NULL, &stats, job->cloud, &w->nb, &config, job->pool, err);
    json_object_set_new(job->stats, "parts", json_integer(stats.n_parts));
    json_object_set_new(job->stats, "without_normal", json_integer(stats.n_undefined));
    return rc;
}

static void put_stats(json_t *to, const struct dx_delaunay_stats *s, const struct config *c)
{
    static const char *const votes[] = {NULL, "by_one_corner", "by_two_corners", "by_all_corners"};

    for (int k = 3; k > 0; k--)
        json_object_set_new(to, votes[k], json_integer((json_int_t)s->n_by_votes[k]));
    json_object_set_new(to, "loop_triangles", json_integer(s->n_loop_triangles));
    json_object_set_new(to, "completed", json_integer(s->n_completed));
    json_object_set_new(to, "boundary", json_integer(s->n_boundary));
    json_object_set_new(to, "isolated", json_integer(s->n_isolated));
    json_object_set_new(to, "widened", json_integer(s->n_widened));
    json_object_set_new(to, "open", json_integer(s->n_open));
    json_object_set_new(to, "fit", json_integer(c->fit));
    json_object_set_new(to, "near", json_integer(c->near));
    json_object_set_new(to, "flatten", json_string(flattens[c->flatten]));
    json_object_set_new(to, "reach", json_string(reaches[c->reach]));
    json_object_set_new(to, "widest", json_real(c->widest));
}

static int run(const struct dx_mesh_job *job, void *config, struct dx_err *err)
{
    struct work w = {.job = job};
    struct config *c = config;
    struct dx_delaunay_config d;
    struct dx_delaunay_stats stats;
    const struct dx_delaunay_sink sink = {take_triangle, take_stage, &w};
    int rc;

    find_parameters(c, job);
    dx_mesh_job_tell(job, "fit %u, near %u, flatten %s, reach %s, widest %g", c->fit, c->near,
                     flattens[c->flatten], reaches[c->reach], c->widest);
    dx_delaunay_defaults(&d);
    d.k = c->near;
    d.shadow = c->flatten == SHADOW;
    d.paper_radius = c->reach == PAPER;
    d.widest = c->widest;
    d.max_edge = c->max_edge;
    d.max_loop = c->max_loop;
    job->mesh->expected = 2 * (size_t)job->cloud->n;
    rc = find_normals(&w, c, err);
    if (rc == 0)
        rc = dx_delaunay(&stats, job->cloud, &w.nb, (const float(*)[3])w.normals, &d, &sink,
                         job->pool, err);
    begin(&w, NULL);
    if (rc == 0)
        put_stats(job->stats, &stats, c);
    job->mesh->n_pinched = rc == 0 ? stats.n_pinched : 0;
    dx_neighbours_fini(&w.nb);
    free(w.normals);
    return rc;
}

const struct dx_mesh_mode dx_mesh_mode_delaunay = {
    .name = "delaunay",
    .about = "by a Delaunay triangulation around each point: Gopi, Krishnan and Silva 2000.\n",
    .help = help,
    .options = options,
    .config_len = sizeof(struct config),
    .point_len = 352, /* normals, stars, 64 neighbours: where there is noise */
    .defaults = defaults,
    .run = run,
};
