/* What dexel convert --smooth is asked, and the stages it takes. */
#include "tools/convert_smooth.h"

#include "core/cloud/smooth_stages.h"
#include "tools/cloud_args.h"
#include "tools/out_points.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

static const char help[] =
    "usage: dexel convert --smooth IN OUT.{ply,pcd,xyz} [OPTIONS]\n"
    "Takes the noise from unorganized points and writes them with normals, in their order. IN is\n"
    "what dexel mesh --mode smooth reads.\n\n"
    "  --passes N          of smoothing, 1 to 16 (1)\n"
    "  --fit plane|quadric what points are put on: quadric is better where the surface is curved,\n"
    "                      and takes twice as long (plane)\n"
    "  --sw N              width of the neighbourhood, spacings: 0.5 to 4 (from noise and "
    "curvature)\n"
    "  --sr N              height from which on points do not count, spacings: 0.1 to 10 (from "
    "noise)\n"
    "  --thin N            one point for each cluster of at most N, 1 to 1e6 (all points)\n"
    "  --frame N|all       of recordings, MCAP, folders and globs: which frame, from 0 (the last)\n"
    "  --topic TOPIC       of the clouds in an MCAP file (the only one)\n"
    "  --viewpoint X,Y,Z   where the points were seen from: normals face it (the outside)\n"
    "  --threads N         (one a processor)\n"
    "  --ascii             PLY and PCD as text\n";

enum {
    OPT_SMOOTH = 256,
    OPT_PASSES,
    OPT_FIT,
    OPT_SW,
    OPT_SR,
    OPT_THIN,
    OPT_FRAME,
    OPT_TOPIC,
    OPT_VIEWPOINT,
    OPT_THREADS,
    OPT_ASCII,
    OPT_HELP
};

static const struct option options[] = {
    {"smooth", no_argument, NULL, OPT_SMOOTH},
    {"passes", required_argument, NULL, OPT_PASSES},
    {"fit", required_argument, NULL, OPT_FIT},
    {"sw", required_argument, NULL, OPT_SW},
    {"sr", required_argument, NULL, OPT_SR},
    {"thin", required_argument, NULL, OPT_THIN},
    {"frame", required_argument, NULL, OPT_FRAME},
    {"topic", required_argument, NULL, OPT_TOPIC},
    {"viewpoint", required_argument, NULL, OPT_VIEWPOINT},
    {"threads", required_argument, NULL, OPT_THREADS},
    {"ascii", no_argument, NULL, OPT_ASCII},
    {"help", no_argument, NULL, OPT_HELP},
    {0},
};

struct args {
    struct dx_cloud_source source;
    const char *out;
    struct dx_cloud_smooth_config smooth;
    uint64_t n_passes, max_points; /* max_points 0: all points */
    uint64_t n_threads;
    double viewpoint[3];
    bool has_viewpoint, ascii;
};

bool dx_convert_smooth_asked(int argc, char **argv)
{
    for (int k = 1; k < argc; k++)
        if (strcmp(argv[k], "--smooth") == 0)
            return true;
    return false;
}

static int set_choice(struct args *a, const struct dx_arg *arg)
{
    static const char *const fits[] = {"plane", "quadric", NULL};
    const int k = dx_arg_choice(arg, fits);

    a->smooth.quadric = k == 1;
    return k < 0 ? k : 0;
}

static int set_option(void *args, int opt, const char *name, const char *text)
{
    struct args *a = args;
    const struct dx_arg arg = {"dexel convert", name, text};

    switch (opt) {
    case 'o':
        a->out = text;
        return 0;
    case OPT_SMOOTH:
        return 0;
    case OPT_PASSES:
        return dx_arg_u64(&a->n_passes, &arg, 1, 16, "passes");
    case OPT_FIT:
        return set_choice(a, &arg);
    case OPT_SW:
        return dx_arg_double(&a->smooth.sw, &arg, 0.5, 4, "spacings");
    case OPT_SR:
        return dx_arg_double(&a->smooth.sr, &arg, 0.1, 10, "spacings");
    case OPT_THIN:
        return dx_arg_u64(&a->max_points, &arg, 1, 1000000, "points");
    case OPT_FRAME:
        return dx_cloud_arg_frame(&a->source, &arg);
    case OPT_TOPIC:
        a->source.topic = text;
        return 0;
    case OPT_VIEWPOINT:
        a->has_viewpoint = true;
        return dx_cloud_arg_viewpoint(a->viewpoint, &arg);
    case OPT_THREADS:
        return dx_arg_u64(&a->n_threads, &arg, 1, 64, "threads");
    case OPT_ASCII:
        a->ascii = true;
        return 0;
    default:
        return -EINVAL; /* getopt has said what it did not know */
    }
}

static int parse(struct args *a, int argc, char **argv)
{
    struct dx_err err;
    int rc;

    *a = (struct args){.source.frame = DX_CLOUD_READ_LAST, .n_passes = 1};
    rc = dx_arg_options(argc, argv, options, OPT_HELP, help, set_option, a);
    if (rc)
        return rc;
    if (argc - optind != (a->out ? 1 : 2)) {
        fprintf(stderr, "dexel convert: found %d arguments, expected IN and OUT\n",
                argc - optind + (a->out ? 1 : 0));
        return -EINVAL;
    }
    a->source.path = argv[optind];
    if (!a->out)
        a->out = argv[optind + 1];
    if (dx_out_points_check(a->out, &err) < 0) {
        fprintf(stderr, "dexel convert: %s\n", err.text);
        return -EINVAL;
    }
    return dx_cloud_arg_check(&a->source, "dexel convert");
}

/* ---- the run -------------------------------------------------------------------------------- */

static int thin(struct dx_stages *s, const struct args *a, struct dx_err *err)
{
    struct dx_cluster_config config;
    int rc;

    dx_cluster_defaults(&config);
    config.max_points = (uint32_t)a->max_points;
    if (config.min_points > config.max_points)
        config.min_points = config.max_points;
    rc = dx_stages_cluster(s, &config, err);
    return rc == 0 ? dx_stages_reduce(s, err) : rc;
}

static int smooth(struct dx_stages *s, const struct args *a, struct dx_err *err)
{
    int rc = 0;

    for (uint64_t pass = 0; rc == 0 && pass < a->n_passes; pass++) {
        const double step = s->cloud.step;
        struct dx_cloud_smooth_stats stats;
        struct dx_cloud_smooth_scale q;

        rc = dx_stages_smooth(s, &q, &stats, &a->smooth, err);
        if (rc == 0)
            fprintf(stderr,
                    "%s: %u points; spacing %.3g, noise %.3g; sw %.3g, sr %.3g of spacings, fit "
                    "%s: moved by %.3g, %u left as they were\n",
                    a->source.path, s->n, q.spacing * step, q.noise * step, q.sw, q.sr,
                    q.quadric ? "quadric" : "plane", stats.rms_moved * step, stats.n_unchanged);
    }
    if (rc == 0 && a->max_points)
        rc = thin(s, a, err);
    return rc == 0 ? dx_stages_orient(s, a->has_viewpoint ? a->viewpoint : NULL, err) : rc;
}

static int write_points(const struct args *a, const struct dx_stages *s, struct dx_err *err)
{
    const bool is_thin = s->reduced.n > 0;
    const struct dx_out_points points = {
        .n = is_thin ? s->reduced.n : s->n,
        .xyz = is_thin ? *s->reduced.xyz : *s->xyz,
        .normal = (const float(*)[3])(is_thin ? s->reduced.normal : s->normal),
    };

    return dx_out_points(a->out, &points, a->ascii, err);
}

static int run(const struct args *a, struct dx_err *err)
{
    struct dx_point_list list = {0};
    struct dx_pool *pool = NULL;
    struct dx_stages s;
    int rc = dx_cloud_read(&list, &a->source, err);

    if (rc == 0 && dx_pool_new(&pool, (unsigned)a->n_threads) < 0)
        rc = dx_err_set(err, -ENOMEM, "no threads");
    if (rc == 0) {
        rc = dx_stages_init(&s, list.xyz, list.n, pool, err);
        dx_point_list_fini(&list);
        if (rc == 0) {
            rc = smooth(&s, a, err);
            rc = rc == 0 ? write_points(a, &s, err) : rc;
            dx_stages_fini(&s);
        }
    }
    dx_pool_free(pool);
    dx_point_list_fini(&list);
    return rc;
}

int dx_convert_smooth(int argc, char **argv)
{
    struct dx_err err = {""};
    struct args a;
    int rc = parse(&a, argc, argv);

    if (rc != 0)
        return rc == DX_ARG_E_HELP ? 0 : 2;
    if (run(&a, &err) < 0) {
        fprintf(stderr, "dexel convert: %s\n", err.text);
        return 1;
    }
    return 0;
}
