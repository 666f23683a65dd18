/* dexel mesh --mode project: what it is asked, what it finds, what it tells. */
#include "tools/mesh_project.h"

#include "core/cloud/spacing.h"
#include "drivers/file/points.h"
#include "tools/args.h"
#include "tools/cloud_mesh.h"
#include "tools/now.h"
#include "tools/out_mesh.h"
#include "tools/stats_json.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define NOISY    0.5 /* spacings of noise from which on more points must be looked at */
#define NOISY_MU 3.0

static const char help[] =
    "usage: dexel mesh --mode project IN -o OUT.{ply,obj,stl} [OPTIONS]\n"
    "Meshes unorganized points: XYZ, PTS, PLY, PCD, OBJ, STL, PTX, each plain or .gz.\n\n"
    "  -o OUT              the mesh; may be left out with --stats\n"
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
    "  --seed N            start at point N of the file, from 0 (the highest)\n"
    "  --viewpoint X,Y,Z   where the points were seen from: triangles face it\n"
    "  --threads N         for loading (one a processor)\n"
    "  --ascii             PLY as text\n"
    "  --stats             one JSON object on standard output\n";

enum {
    OPT_MODE = 256,
    OPT_MU,
    OPT_ALPHA,
    OPT_CHOICE,
    OPT_BETA,
    OPT_PLANE,
    OPT_MAX_EDGE,
    OPT_LOOPS,
    OPT_SEED,
    OPT_VIEWPOINT,
    OPT_THREADS,
    OPT_ASCII,
    OPT_STATS,
    OPT_HELP
};

static const struct option options[] = {
    {"mode", required_argument, NULL, OPT_MODE},
    {"mu", required_argument, NULL, OPT_MU},
    {"alpha", required_argument, NULL, OPT_ALPHA},
    {"choice", required_argument, NULL, OPT_CHOICE},
    {"beta", required_argument, NULL, OPT_BETA},
    {"plane", required_argument, NULL, OPT_PLANE},
    {"max-edge", required_argument, NULL, OPT_MAX_EDGE},
    {"loops", required_argument, NULL, OPT_LOOPS},
    {"seed", required_argument, NULL, OPT_SEED},
    {"viewpoint", required_argument, NULL, OPT_VIEWPOINT},
    {"threads", required_argument, NULL, OPT_THREADS},
    {"ascii", no_argument, NULL, OPT_ASCII},
    {"stats", no_argument, NULL, OPT_STATS},
    {"help", no_argument, NULL, OPT_HELP},
    {0},
};

struct args {
    struct dx_project_config config;
    double viewpoint[3];
    const char *path, *out;
    unsigned n_threads;
    bool has_mu, ascii, stats;
};

bool dx_mesh_project_asked(int argc, char **argv)
{
    for (int k = 1; k < argc; k++) {
        const size_t len = strcspn(argv[k], "=");
        const char *value = argv[k][len] ? argv[k] + len + 1 : k + 1 < argc ? argv[k + 1] : "";

        if (len >= 4 && strncmp(argv[k], "--mode", len) == 0 && strcmp(value, "project") == 0)
            return true;
    }
    return false;
}

static struct dx_arg arg_of(int opt, const char *text)
{
    static char name[32];

    for (size_t k = 0; options[k].name; k++)
        if (options[k].val == opt)
            snprintf(name, sizeof(name), "--%s", options[k].name);
    return (struct dx_arg){"dexel mesh", name, text};
}

static int set_choice(struct args *a, int opt, const struct dx_arg *arg)
{
    static const char *const choices[] = {"widest", "next", "beta", NULL};
    static const char *const planes[] = {"fit", "faces", "axis", NULL};
    const int k = dx_arg_choice(arg, opt == OPT_CHOICE ? choices : planes);

    if (opt == OPT_CHOICE && k >= 0)
        a->config.choice = (enum dx_project_choice)k;
    if (opt == OPT_PLANE && k >= 0)
        a->config.plane = (enum dx_project_plane)k;
    return k < 0 ? k : 0;
}

static int set_count(struct args *a, int opt, const struct dx_arg *arg)
{
    uint64_t n = 0;
    int rc;

    if (opt == OPT_THREADS) {
        rc = dx_arg_u64(&n, arg, 1, 64, "threads");
        a->n_threads = (unsigned)n;
    } else if (opt == OPT_LOOPS) {
        rc = dx_arg_u64(&n, arg, 0, DX_PROJECT_MAX_LOOP, "edges");
        a->config.max_loop = (uint32_t)n;
    } else {
        rc = dx_arg_u64(&n, arg, 0, DX_CLOUD_MAX_POINTS, "a point's number");
        a->config.has_seed = true;
        a->config.seed = (uint32_t)n;
    }
    return rc;
}

static int set_viewpoint(struct args *a, const struct dx_arg *arg)
{
    const int n = dx_arg_triple(a->viewpoint, arg, -1e12, 1e12, "coordinates");

    if (n >= 0 && n != 3)
        return dx_arg_bad(arg, "three coordinates with commas between");
    a->config.viewpoint = a->viewpoint;
    return n < 0 ? n : 0;
}

static int set_value(struct args *a, int opt, const char *text)
{
    static const char *const modes[] = {"project", NULL};
    const struct dx_arg arg = arg_of(opt, text);

    switch (opt) {
    case OPT_MODE:
        return dx_arg_choice(&arg, modes);
    case OPT_MU:
        a->has_mu = true;
        return dx_arg_double(&a->config.mu, &arg, 1, 100, "distances");
    case OPT_ALPHA:
        return dx_arg_double(&a->config.alpha_deg, &arg, 60, 180, "degrees");
    case OPT_BETA:
        return dx_arg_double(&a->config.beta_deg, &arg, 0, 60, "degrees");
    case OPT_MAX_EDGE:
        return dx_arg_double(&a->config.max_edge, &arg, 0, 1e12, "a length");
    case OPT_CHOICE:
    case OPT_PLANE:
        return set_choice(a, opt, &arg);
    case OPT_VIEWPOINT:
        return set_viewpoint(a, &arg);
    case OPT_LOOPS:
    case OPT_SEED:
    case OPT_THREADS:
        return set_count(a, opt, &arg);
    default:
        return -EINVAL; /* getopt_long has said so */
    }
}

static int parse(struct args *a, int argc, char **argv)
{
    struct dx_err err;
    int opt;

    *a = (struct args){.n_threads = 0};
    dx_project_defaults(&a->config);
    while ((opt = getopt_long(argc, argv, "o:", options, NULL)) != -1) {
        if (opt == OPT_HELP)
            return dx_arg_help(help);
        if (opt == 'o')
            a->out = optarg;
        else if (opt == OPT_ASCII)
            a->ascii = true;
        else if (opt == OPT_STATS)
            a->stats = true;
        else if (set_value(a, opt, optarg) < 0)
            return -EINVAL;
    }
    a->path = dx_arg_operand(argc, argv, "points");
    if (!a->path)
        return -EINVAL;
    if (!a->out && !a->stats) {
        fprintf(stderr, "dexel mesh: found neither -o nor --stats, expected one of them\n");
        return -EINVAL;
    }
    if (a->out && !dx_mesh_writer_for(a->out, &err)) {
        fprintf(stderr, "dexel mesh: %s\n", err.text);
        return -EINVAL;
    }
    return 0;
}

/* ---- the run -------------------------------------------------------------------------------- */

struct times {
    double read_s, load_s, mesh_s;
};

/* Parameters that were not given, from the data; all of them to standard error. */
static void find_parameters(struct args *a, const struct dx_cloud *c)
{
    static const char *const choices[] = {"widest", "next", "beta"};
    static const char *const planes[] = {"fit", "faces", "axis"};
    const double spacing = dx_cloud_spacing(c) * c->step, noise = dx_cloud_noise(c) * c->step;

    if (!a->has_mu && noise > NOISY * spacing)
        a->config.mu = NOISY_MU;
    fprintf(stderr, "%s: %u points", a->path, c->n);
    if (c->n_not_finite)
        fprintf(stderr, ", %u not finite", c->n_not_finite);
    if (c->n_duplicates)
        fprintf(stderr, ", %u duplicates", c->n_duplicates);
    fprintf(stderr,
            "; spacing %.3g, noise %.3g; mu %g, alpha %g, choice %s, plane %s; at most %.0f MB\n",
            spacing, noise, a->config.mu, a->config.alpha_deg, choices[a->config.choice],
            planes[a->config.plane], (double)dx_cloud_mesh_most_len(c->n) / 1e6);
}

static json_t *project_json(const struct dx_project_stats *s, const struct dx_cloud *c,
                            const struct args *a, const struct times *t)
{
    return json_pack(
        "{s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:f, s:f, s:f, s:f, s:f, "
        "s:f, s:f}",
        "input_points", (json_int_t)c->n, "duplicates", (json_int_t)c->n_duplicates, "not_finite",
        (json_int_t)c->n_not_finite, "completed", (json_int_t)s->n_completed, "boundary",
        (json_int_t)s->n_boundary, "isolated", (json_int_t)s->n_isolated, "loop_triangles",
        (json_int_t)s->n_loop_triangles, "peak_rings", (json_int_t)s->peak_rings, "peak_ring_bytes",
        (json_int_t)s->peak_ring_len, "looked_again", (json_int_t)s->n_again, "spacing", s->spacing,
        "noise", dx_cloud_noise(c) * c->step, "mu", a->config.mu, "alpha_deg", a->config.alpha_deg,
        "read_seconds", t->read_s, "load_seconds", t->load_s, "mesh_seconds", t->mesh_s);
}

static int print_stats(const struct dx_mesh *mesh, json_t *project, double seconds)
{
    struct dx_mesh_stats stats;
    json_t *j;
    int rc = dx_mesh_stats_compute(&stats, mesh);

    if (rc < 0 || !project) {
        fprintf(stderr, "dexel mesh: out of memory\n");
        json_decref(project);
        return -ENOMEM;
    }
    j = dx_stats_json(&stats);
    json_object_set_new(j, "seconds", json_real(seconds));
    json_object_set_new(j, "geometry", json_string("points"));
    json_object_update(j, project);
    json_decref(project);
    return dx_json_print(j, "dexel mesh");
}

static int run_cloud(struct args *a, const struct dx_cloud *c, const double *xyz, struct times *t,
                     struct dx_err *err)
{
    struct dx_out_options write = {.ascii = a->ascii};
    struct dx_project_stats stats;
    struct dx_mesh mesh = {0};
    uint64_t start;
    int rc;

    find_parameters(a, c);
    start = dx_now_ns();
    rc = dx_cloud_mesh(&mesh, &stats, c, xyz, &a->config, isatty(STDERR_FILENO), &write, err);
    t->mesh_s = dx_seconds_since(start);
    if (rc < 0) {
        dx_err_prefix(err, a->path);
        return rc;
    }
    if (mesh.n_triangles == 0)
        fprintf(stderr, "dexel mesh: %s: no triangle: no three points make one\n", a->path);
    rc = a->out ? dx_out_mesh(a->out, &mesh, &write, err) : 0;
    if (rc == 0 && a->stats &&
        print_stats(&mesh, project_json(&stats, c, a, t), t->read_s + t->load_s + t->mesh_s) < 0)
        rc = dx_err_set(err, -EIO, "no statistics");
    dx_mesh_fini(&mesh);
    return rc;
}

static int run(struct args *a, struct dx_err *err)
{
    struct dx_point_list list = {0};
    struct dx_pool *pool = NULL;
    struct times t = {0};
    struct dx_cloud c;
    uint64_t start = dx_now_ns();
    int rc = dx_point_list_read(&list, a->path, err);

    t.read_s = dx_seconds_since(start);
    if (rc == 0 && dx_pool_new(&pool, a->n_threads) < 0)
        rc = dx_err_set(err, -ENOMEM, "no threads");
    start = dx_now_ns();
    if (rc == 0) {
        rc = dx_cloud_init(&c, list.xyz, list.n, pool, err);
        if (rc < 0)
            dx_err_prefix(err, a->path);
    }
    t.load_s = dx_seconds_since(start);
    if (rc == 0) {
        rc = run_cloud(a, &c, list.xyz, &t, err);
        dx_cloud_fini(&c);
    }
    dx_pool_free(pool);
    dx_point_list_fini(&list);
    return rc;
}

int dx_mesh_project(int argc, char **argv)
{
    struct dx_err err = {""};
    struct args a;
    int rc = parse(&a, argc, argv);

    if (rc != 0)
        return rc == DX_ARG_E_HELP ? 0 : 2;
    if (run(&a, &err) < 0) {
        fprintf(stderr, "dexel mesh: %s\n", err.text);
        return 1;
    }
    return 0;
}
