/* dexel mesh --mode project: the parameters of core/cloud/project.h as options. */
#include "core/cloud/project.h"
#include "tools/mesh_mode.h"

#include <errno.h>
#include <math.h>

#define NOISY    0.5 /* spacings of noise from which on more points must be looked at */
#define MU       2.5
#define NOISY_MU 3.0

#define NO_SEED  UINT32_MAX

static const char help[] =
    "  --mu N              points looked at, by the distance of the nearest: 1 to 100 (2.5; 3 "
    "where\n"
    "                      the points are noisy)\n"
    "  --alpha DEG         no wider angle at the point that makes a triangle: 60 to 180 (120)\n"
    "  --choice widest|next|beta\n"
    "                      which of the points it sees is joined (widest)\n"
    "  --beta DEG          with --choice beta: angles to be avoided, 0 to 60 (10)\n"
    "  --plane fit|faces|axis\n"
    "                      what points are projected on: fitted to them, by the triangles so far, "
    "or\n"
    "                      the nearest of XY, YZ, ZX (fit)\n"
    "  --max-edge M        no longer edge\n"
    "  --loops N           close holes of at most N edges, 0 to 32 (8)\n"
    "  --seed N            start at point N of the file, from 0 (the highest)\n";

struct config {
    double mu; /* 0: found */
    double alpha_deg, max_edge;
    double beta_deg; /* NAN: not given */
    int choice, plane;
    uint32_t max_loop, seed;
};

static const char *const choices[] = {
    [DX_PROJECT_WIDEST] = "widest", [DX_PROJECT_NEXT] = "next", [DX_PROJECT_BETA] = "beta", NULL};
static const char *const planes[] = {
    [DX_PROJECT_FIT] = "fit", [DX_PROJECT_FACES] = "faces", [DX_PROJECT_AXIS] = "axis", NULL};

#define AT(member) offsetof(struct config, member)

static const struct dx_mesh_option options[] = {
    {"mu", DX_MESH_NUMBER, AT(mu), 1, 100, "distances", NULL},
    {"alpha", DX_MESH_NUMBER, AT(alpha_deg), 60, 180, "degrees", NULL},
    {"choice", DX_MESH_CHOICE, AT(choice), 0, 0, NULL, choices},
    {"beta", DX_MESH_NUMBER, AT(beta_deg), 0, 60, "degrees", NULL},
    {"plane", DX_MESH_CHOICE, AT(plane), 0, 0, NULL, planes},
    {"max-edge", DX_MESH_NUMBER, AT(max_edge), 0, 1e12, "a length", NULL},
    {"loops", DX_MESH_COUNT, AT(max_loop), 0, DX_PROJECT_MAX_LOOP, "edges", NULL},
    {"seed", DX_MESH_COUNT, AT(seed), 0, DX_CLOUD_MAX_POINTS, "a point's number", NULL},
    {0},
};

static void defaults(void *config)
{
    struct dx_project_config d;

    dx_project_defaults(&d);
    *(struct config *)config = (struct config){.alpha_deg = d.alpha_deg,
                                               .beta_deg = NAN,
                                               .max_edge = d.max_edge,
                                               .choice = (int)d.choice,
                                               .plane = (int)d.plane,
                                               .max_loop = d.max_loop,
                                               .seed = NO_SEED};
}

static struct dx_project_config make_config(const struct dx_mesh_job *job, const struct config *c)
{
    const double found = job->noise > NOISY * job->spacing ? NOISY_MU : MU;
    struct dx_project_config p;

    dx_project_defaults(&p);
    p.mu = c->mu > 0 ? c->mu : found;
    p.alpha_deg = c->alpha_deg;
    p.beta_deg = isnan(c->beta_deg) ? p.beta_deg : c->beta_deg;
    p.max_edge = c->max_edge;
    p.choice = (enum dx_project_choice)c->choice;
    p.plane = (enum dx_project_plane)c->plane;
    p.max_loop = c->max_loop;
    p.has_seed = c->seed != NO_SEED;
    p.seed = c->seed;
    p.viewpoint = job->viewpoint;
    return p;
}

static void put_stats(json_t *to, const struct dx_project_stats *s,
                      const struct dx_project_config *p)
{
    json_object_set_new(to, "completed", json_integer(s->n_completed));
    json_object_set_new(to, "boundary", json_integer(s->n_boundary));
    json_object_set_new(to, "isolated", json_integer(s->n_isolated));
    json_object_set_new(to, "loop_triangles", json_integer(s->n_loop_triangles));
    json_object_set_new(to, "peak_rings", json_integer(s->peak_rings));
    json_object_set_new(to, "peak_ring_bytes", json_integer((json_int_t)s->peak_ring_len));
    json_object_set_new(to, "looked_again", json_integer(s->n_again));
    json_object_set_new(to, "mu", json_real(p->mu));
    json_object_set_new(to, "alpha_deg", json_real(p->alpha_deg));
}

static int run(const struct dx_mesh_job *job, void *config, struct dx_err *err)
{
    const struct config *c = config;
    const struct dx_project_config p = make_config(job, c);
    const struct dx_project_sink sink = {dx_cloud_mesh_triangle, job->mesh};
    struct dx_project_stats stats;
    int rc;

    if (!isnan(c->beta_deg) && p.choice != DX_PROJECT_BETA)
        return dx_err_set(err, -EINVAL, "--beta: is for --choice beta, found --choice %s",
                          choices[c->choice]);
    if (p.has_seed && p.seed >= job->n_input)
        return dx_err_set(err, -EINVAL, "--seed: found %u, expected less than %zu points", p.seed,
                          job->n_input);
    dx_mesh_job_tell(job, "mu %g, alpha %g, choice %s, plane %s", p.mu, p.alpha_deg,
                     choices[c->choice], planes[c->plane]);
    job->mesh->expected = 2 * (size_t)job->cloud->n;
    dx_progress_stage(job->progress, "triangles");
    rc = dx_project(&stats, job->cloud, &p, &sink, err);
    if (rc == 0)
        put_stats(job->stats, &stats, &p);
    job->mesh->n_pinched = rc == 0 ? stats.n_pinched : 0;
    return rc;
}

const struct dx_mesh_mode dx_mesh_mode_project = {
    .name = "project",
    .about = "by projection on tangent planes: Gopi and Krishnan 2002.\n",
    .help = help,
    .options = options,
    .config_len = sizeof(struct config),
    .point_len = 40, /* states, queue and rings */
    .defaults = defaults,
    .run = run,
};
