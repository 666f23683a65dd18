/* dexel convert --normals: what it is asked, and points in, points out. */
#include "tools/convert_normals.h"

#include "core/cloud/cloud_normals.h"
#include "core/cloud/spacing.h"
#include "tools/cloud_args.h"
#include "tools/out_points.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char help[] =
    "usage: dexel convert --normals IN OUT.{ply,pcd,xyz} [OPTIONS]\n"
    "Writes points with normals, all turned to one side. IN is what dexel mesh --mode delaunay\n"
    "reads; points that are not finite, and all but one of those in one place, are left out.\n\n"
    "  --fit N             neighbours that a normal is fitted to: 3 to 64 (16)\n"
    "  --viewpoint X,Y,Z   where the points were seen from: normals face it (the highest one is\n"
    "                      up, which is out of closed surfaces)\n"
    "  --frame N|all       of recordings, MCAP, folders and globs: which frame, from 0 (the last)\n"
    "  --topic TOPIC       of the clouds in an MCAP file (the only one)\n"
    "  --threads N         (one a processor)\n"
    "  --ascii             PLY and PCD as text\n";

enum {
    OPT_NORMALS = 256,
    OPT_FIT,
    OPT_VIEWPOINT,
    OPT_FRAME,
    OPT_TOPIC,
    OPT_THREADS,
    OPT_ASCII,
    OPT_HELP
};

static const struct option options[] = {
    {"normals", no_argument, NULL, OPT_NORMALS},
    {"fit", required_argument, NULL, OPT_FIT},
    {"viewpoint", required_argument, NULL, OPT_VIEWPOINT},
    {"frame", required_argument, NULL, OPT_FRAME},
    {"topic", required_argument, NULL, OPT_TOPIC},
    {"threads", required_argument, NULL, OPT_THREADS},
    {"ascii", no_argument, NULL, OPT_ASCII},
    {"help", no_argument, NULL, OPT_HELP},
    {0},
};

struct args {
    struct dx_cloud_source source;
    struct dx_cloud_normals_config normals;
    double viewpoint[3];
    const char *out;
    unsigned n_threads;
    bool ascii;
};

bool dx_convert_normals_asked(int argc, char **argv)
{
    for (int k = 1; k < argc; k++)
        if (strcmp(argv[k], "--normals") == 0)
            return true;
    return false;
}

static int set_option(void *ctx, int opt, const char *name, const char *text)
{
    const struct dx_arg arg = {"dexel convert", name, text};
    struct args *a = ctx;
    uint64_t n = 0;
    int rc = 0;

    switch (opt) {
    case OPT_FIT:
        rc = dx_arg_u64(&n, &arg, 3, DX_CLOUD_MAX_NEAREST, "neighbours");
        a->normals.k = (uint32_t)n;
        break;
    case OPT_VIEWPOINT:
        rc = dx_cloud_arg_viewpoint(a->viewpoint, &arg);
        a->normals.viewpoint = a->viewpoint;
        break;
    case OPT_FRAME:
        rc = dx_cloud_arg_frame(&a->source, &arg);
        break;
    case OPT_TOPIC:
        a->source.topic = text;
        break;
    case OPT_THREADS:
        rc = dx_arg_u64(&n, &arg, 1, 64, "threads");
        a->n_threads = (unsigned)n;
        break;
    case OPT_ASCII:
        a->ascii = true;
        break;
    case OPT_NORMALS:
        break;
    case 'o':
        a->out = text;
        break;
    default:
        return -EINVAL; /* getopt has said what it did not know */
    }
    return rc < 0 ? rc : 0;
}

static int parse(struct args *a, int argc, char **argv)
{
    struct dx_err err;
    int rc;

    *a = (struct args){.source.frame = DX_CLOUD_READ_LAST};
    dx_cloud_normals_defaults(&a->normals);
    rc = dx_arg_options(argc, argv, options, OPT_HELP, help, set_option, a);
    if (rc != 0)
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

/* By rank, and then in the order of the input without what is left out. */
struct made {
    float (*by_rank)[3], *variation;
    double *xyz;
    float (*normal)[3], *curvature;
    uint32_t *rank; /* of a point of the input; UINT32_MAX: left out */
};

static int reserve(struct made *m, size_t n_input, uint32_t n, struct dx_err *err)
{
    m->by_rank = malloc(n * sizeof(*m->by_rank) + 1);
    m->variation = malloc(n * sizeof(*m->variation) + 1);
    m->xyz = malloc(n * 3 * sizeof(*m->xyz) + 1);
    m->normal = malloc(n * sizeof(*m->normal) + 1);
    m->curvature = malloc(n * sizeof(*m->curvature) + 1);
    m->rank = malloc(n_input * sizeof(*m->rank) + 1);
    if (m->by_rank && m->variation && m->xyz && m->normal && m->curvature && m->rank)
        return 0;
    return dx_err_set(err, -ENOMEM, "no memory for the normals of %u points", n);
}

static void fini(struct made *m)
{
    free(m->by_rank);
    free(m->variation);
    free(m->xyz);
    free(m->normal);
    free(m->curvature);
    free(m->rank);
}

static void put_in_order(struct made *m, const struct dx_cloud *c, const struct dx_point_list *list)
{
    size_t to = 0;

    for (size_t v = 0; v < list->n; v++)
        m->rank[v] = UINT32_MAX;
    for (uint32_t r = 0; r < c->n; r++)
        m->rank[c->index[r]] = r;
    for (size_t v = 0; v < list->n; v++) {
        const uint32_t r = m->rank[v];

        if (r == UINT32_MAX)
            continue;
        memcpy(m->xyz + 3 * to, list->xyz + 3 * v, 3 * sizeof(*m->xyz));
        dx_cloud_normal_out(m->normal[to], c, (const float *)m->by_rank[r]);
        m->curvature[to++] = m->variation[r];
    }
}

static void tell(const struct args *a, const struct dx_cloud *c,
                 const struct dx_cloud_normals_stats *s)
{
    fprintf(stderr, "%s: %u points", a->source.path, c->n);
    if (c->n_not_finite)
        fprintf(stderr, ", %u not finite", c->n_not_finite);
    if (c->n_strays)
        fprintf(stderr, ", %u too far from the others", c->n_strays);
    if (c->n_duplicates)
        fprintf(stderr, ", %u duplicates", c->n_duplicates);
    fprintf(stderr, "; spacing %.3g; fit %u; %u part%s", dx_cloud_spacing(c) * c->step,
            a->normals.k, s->n_parts, s->n_parts == 1 ? "" : "s");
    if (s->n_undefined)
        fprintf(stderr, "; %u without a normal", s->n_undefined);
    fputc('\n', stderr);
}

static int convert(const struct args *a, const struct dx_cloud *c, const struct dx_point_list *list,
                   struct dx_pool *pool, struct dx_err *err)
{
    struct dx_cloud_normals_stats stats;
    struct made m = {0};
    int rc = reserve(&m, list->n, c->n, err);

    if (rc == 0)
        rc = dx_cloud_normals(m.by_rank, m.variation, &stats, c, NULL, &a->normals, pool, err);
    if (rc == 0) {
        const struct dx_out_points points = {c->n, m.xyz, (const float(*)[3])m.normal, m.curvature};

        tell(a, c, &stats);
        put_in_order(&m, c, list);
        rc = dx_out_points(a->out, &points, a->ascii, err);
    }
    fini(&m);
    return rc;
}

static int run(const struct args *a, struct dx_err *err)
{
    struct dx_point_list list = {0};
    struct dx_pool *pool = NULL;
    struct dx_cloud c = {0};
    int rc = dx_cloud_read(&list, &a->source, err);

    if (rc == 0 && dx_pool_new(&pool, a->n_threads) < 0)
        rc = dx_err_set(err, -ENOMEM, "no threads");
    if (rc == 0) {
        rc = dx_cloud_init(&c, list.xyz, list.n, pool, err);
        if (rc < 0)
            dx_err_prefix(err, a->source.path);
    }
    if (rc == 0)
        rc = convert(a, &c, &list, pool, err);
    dx_cloud_fini(&c);
    dx_pool_free(pool);
    dx_point_list_fini(&list);
    return rc;
}

int dx_convert_normals(int argc, char **argv)
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
