/* dexel sim --surface: what it is asked, and the points as PLY or text. */
#include "tools/sim_surface.h"

#include "core/base/bytes.h"
#include "drivers/synth/surfaces.h"
#include "tools/args.h"
#include "tools/out_file.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char help[] =
    "usage: dexel sim --surface SURFACE -o OUT [OPTIONS]\n"
    "Writes points of an analytic surface of about unit size, in no order that counts.\n\n"
    "  -o OUT              a .ply or .xyz file\n"
    "  --list              the surfaces\n"
    "  --points N          about how many: 64 to 2^27 (10000)\n"
    "  --jitter J          move points on the surface by up to so many spacings: 0 to 1 (0)\n"
    "  --noise S           along the normal, spacings, one sigma: 0 to 10 (0)\n"
    "  --gap G             of nested spheres, spacings (4)\n"
    "  --seed N            of jitter, noise and random surfaces (1)\n";

enum {
    OPT_SURFACE = 256,
    OPT_LIST,
    OPT_POINTS,
    OPT_JITTER,
    OPT_NOISE,
    OPT_GAP,
    OPT_SEED,
    OPT_HELP,
};

static const struct option options[] = {
    {"surface", no_argument, NULL, OPT_SURFACE},
    {"list", no_argument, NULL, OPT_LIST},
    {"points", required_argument, NULL, OPT_POINTS},
    {"jitter", required_argument, NULL, OPT_JITTER},
    {"noise", required_argument, NULL, OPT_NOISE},
    {"gap", required_argument, NULL, OPT_GAP},
    {"seed", required_argument, NULL, OPT_SEED},
    {"help", no_argument, NULL, OPT_HELP},
    {0},
};

struct args {
    const char *out;
    struct dx_surface_config config;
    bool list;
};

bool dx_sim_surface_asked(int argc, char **argv)
{
    for (int k = 1; k < argc; k++)
        if (strcmp(argv[k], "--surface") == 0)
            return true;
    return false;
}

/* Negative: wrong, and said so. */
static int set_option(void *args, int opt, const char *name, const char *text)
{
    struct args *a = args;
    const struct dx_arg arg = {"dexel sim", name, text};
    struct dx_surface_config *c = &a->config;
    uint64_t n = 0;
    int rc;

    switch (opt) {
    case 'o':
        a->out = text;
        return 0;
    case OPT_SURFACE:
        return 0;
    case OPT_LIST:
        a->list = true;
        return 0;
    case OPT_POINTS:
        rc = dx_arg_u64(&n, &arg, 64, 1u << 27, "points");
        c->n = (uint32_t)n;
        return rc;
    case OPT_JITTER:
        return dx_arg_double(&c->jitter, &arg, 0, 1, "spacings");
    case OPT_NOISE:
        return dx_arg_double(&c->noise, &arg, 0, 10, "spacings");
    case OPT_GAP:
        return dx_arg_double(&c->gap, &arg, 0, 1000, "spacings");
    case OPT_SEED:
        return dx_arg_u64(&c->seed, &arg, 0, UINT64_MAX, "a number");
    default:
        return -EINVAL; /* getopt has said what it did not know */
    }
}

static bool has_ending(const char *path, const char *ending)
{
    const size_t len = strlen(path), n = strlen(ending);

    return len > n && strcmp(path + len - n, ending) == 0;
}

static int settle(struct args *a, const char *name)
{
    const int surface = dx_surface_from_name(name);

    if (surface < 0) {
        fprintf(stderr, "dexel sim: found surface '%s', expected one of --surface --list\n", name);
        return -EINVAL;
    }
    if (!a->out || !(has_ending(a->out, ".ply") || has_ending(a->out, ".xyz"))) {
        fprintf(stderr, "dexel sim: -o: found '%s', expected a name ending in .ply or .xyz\n",
                a->out ? a->out : "");
        return -EINVAL;
    }
    a->config.surface = (enum dx_surface)surface;
    /* Of two unit spheres. */
    if (surface == DX_SURFACE_NESTED && a->config.gap * sqrt(25.2 / a->config.n) >= 1) {
        fprintf(stderr, "dexel sim: --gap: found %g, expected less than the radius\n",
                a->config.gap);
        return -EINVAL;
    }
    return 0;
}

static int parse(struct args *a, int argc, char **argv)
{
    const char *name;
    int r;

    *a = (struct args){.config = {.n = 10000, .gap = 4, .seed = 1}};
    r = dx_arg_options(argc, argv, options, OPT_HELP, help, set_option, a);
    if (r || a->list)
        return r;
    name = dx_arg_operand(argc, argv, "a surface");
    return name ? settle(a, name) : -EINVAL;
}

/* As floats in both formats, so that they hold the same points. */
static void write_points(FILE *f, const struct dx_surface_points *p, bool ply)
{
    if (ply)
        fprintf(f,
                "ply\nformat binary_little_endian 1.0\ncomment dexel " DEXELD_VERSION "\n"
                "element vertex %u\nproperty float x\nproperty float y\nproperty float z\n"
                "end_header\n",
                p->n);
    for (size_t k = 0; k < p->n; k++) {
        const float v[3] = {(float)p->xyz[3 * k], (float)p->xyz[3 * k + 1],
                            (float)p->xyz[3 * k + 2]};
        uint8_t bytes[12];

        if (!ply) {
            fprintf(f, "%.9g %.9g %.9g\n", (double)v[0], (double)v[1], (double)v[2]);
            continue;
        }
        for (size_t i = 0; i < 3; i++)
            dx_put_u32(bytes + 4 * i, dx_f32_bits(v[i]));
        fwrite(bytes, sizeof(bytes), 1, f);
    }
}

static int run(const struct args *a, struct dx_err *err)
{
    struct dx_surface_points points;
    struct dx_out_file f;
    int rc = dx_surface_sample(&points, &a->config);

    if (rc < 0)
        return dx_err_set(err, rc, "%u points: %s", a->config.n, strerror(-rc));
    rc = dx_out_file_open(&f, a->out, err);
    if (rc == 0) {
        write_points(f.stream, &points, has_ending(a->out, ".ply"));
        rc = dx_out_file_commit(&f, err);
    }
    free(points.xyz);
    return rc;
}

static int list_surfaces(void)
{
    for (unsigned k = 0; dx_surface_name(k); k++) {
        const enum dx_surface s = (enum dx_surface)k;

        printf("%-13s  Euler characteristic %2d, rims %u\n", dx_surface_name(k),
               dx_surface_euler(s), dx_surface_n_rims(s));
    }
    return 0;
}

int dx_sim_surface(int argc, char **argv)
{
    struct dx_err err = {""};
    struct args a;
    int rc = parse(&a, argc, argv);

    if (rc != 0)
        return rc == DX_ARG_E_HELP ? 0 : 2;
    if (a.list)
        return list_surfaces();
    if (run(&a, &err) < 0) {
        fprintf(stderr, "dexel sim: %s\n", err.text);
        return 1;
    }
    return 0;
}
