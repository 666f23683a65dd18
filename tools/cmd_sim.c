/* dexel sim: frames of analytic scenes to scan files. */
#include "drivers/synth/scene.h"
#include "tools/args.h"
#include "tools/cmd.h"
#include "tools/out_frames.h"
#include "tools/sim_surface.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

static const char help[] =
    "usage: dexel sim SCENE -o OUT [OPTIONS]\n"
    "Simulates a range scanner in an analytic scene; unorganized points: --surface --help\n\n"
    "  -o OUT              a .ptx or .pcd file, or a directory for frame-NNNNNN files\n"
    "  --format ptx|pcd    of the files in a directory (ptx)\n"
    "  --list              the scenes\n"
    "  --size WxH          columns x rows (the scene's)\n"
    "  --frames N          how many (1); several go to a directory or one .ptx\n"
    "  --seed N            of the noise (1)\n"
    "  --noise S0[,S1[,S2]]  of a range r: S0 + S1 r + S2 r^2, metres, one sigma (0)\n"
    "  --dropouts P        share of dexels without a return (0)\n"
    "  --mixed P           share of dexels at steps of range that are a mix of both sides (0)\n"
    "  --unit M            range unit, metres (0.001)\n"
    "  --attr 0|8|16       bits of reflectance (8)\n";

enum {
    OPT_FORMAT = 256,
    OPT_LIST,
    OPT_SIZE,
    OPT_FRAMES,
    OPT_SEED,
    OPT_NOISE,
    OPT_DROPOUTS,
    OPT_MIXED,
    OPT_UNIT,
    OPT_ATTR,
    OPT_HELP,
};

static const struct option options[] = {
    {"format", required_argument, NULL, OPT_FORMAT},
    {"list", no_argument, NULL, OPT_LIST},
    {"size", required_argument, NULL, OPT_SIZE},
    {"frames", required_argument, NULL, OPT_FRAMES},
    {"seed", required_argument, NULL, OPT_SEED},
    {"noise", required_argument, NULL, OPT_NOISE},
    {"dropouts", required_argument, NULL, OPT_DROPOUTS},
    {"mixed", required_argument, NULL, OPT_MIXED},
    {"unit", required_argument, NULL, OPT_UNIT},
    {"attr", required_argument, NULL, OPT_ATTR},
    {"help", no_argument, NULL, OPT_HELP},
    {0},
};

struct args {
    const char *out;
    enum dx_frame_format format;
    uint32_t width, height; /* 0: the scene's */
    uint64_t n_frames;
    struct dx_scene_config config; /* scene and size are settled last */
    bool list;
};

static int set_attr(struct args *a, const struct dx_arg *arg)
{
    static const char *const bits[] = {"0", "8", "16", NULL};
    int k = dx_arg_choice(arg, bits);

    a->config.attr_bytes = (uint8_t)(k < 0 ? 0 : k);
    return k;
}

static int set_format(struct args *a, const struct dx_arg *arg)
{
    int k = dx_arg_choice(arg, dx_frame_formats);

    if (k >= 0)
        a->format = (enum dx_frame_format)k;
    return k;
}

/* Negative: wrong, and said so. */
static int set_option(void *args, int opt, const char *name, const char *text)
{
    struct args *a = args;
    const struct dx_arg arg = {"dexel sim", name, text};
    struct dx_scene_config *c = &a->config;

    switch (opt) {
    case 'o':
        a->out = text;
        return 0;
    case OPT_LIST:
        a->list = true;
        return 0;
    case OPT_FORMAT:
        return set_format(a, &arg);
    case OPT_SIZE:
        return dx_arg_size(&a->width, &a->height, &arg);
    case OPT_FRAMES:
        return dx_arg_u64(&a->n_frames, &arg, 1, 1000000, "frames");
    case OPT_SEED:
        return dx_arg_u64(&c->seed, &arg, 0, UINT64_MAX, "a number");
    case OPT_NOISE:
        return dx_arg_triple(c->sigma, &arg, 0, 1, "numbers");
    case OPT_DROPOUTS:
        return dx_arg_double(&c->dropout, &arg, 0, 1, "a share");
    case OPT_MIXED:
        return dx_arg_double(&c->mixed, &arg, 0, 1, "a share");
    case OPT_UNIT:
        return dx_arg_double(&c->unit_m, &arg, 1e-6, 1, "metres");
    case OPT_ATTR:
        return set_attr(a, &arg);
    default:
        return -EINVAL; /* getopt has said what it did not know */
    }
}

static int check_size(const struct dx_scene_config *c)
{
    if (c->width >= 8 && c->height >= 2 && (uint64_t)c->width * c->height <= DX_PLANE_MAX_DEXELS)
        return 0;
    fprintf(stderr, "dexel sim: --size: found %ux%u, expected at least 8x2, at most %u dexels\n",
            c->width, c->height, DX_PLANE_MAX_DEXELS);
    return -EINVAL;
}

static int settle_scene(struct args *a, const char *name)
{
    struct dx_scene_config defaults;
    struct dx_err err;
    int scene = dx_scene_from_name(name);

    if (scene < 0) {
        fprintf(stderr, "dexel sim: found scene '%s', expected one of --list\n", name);
        return -EINVAL;
    }
    if (!a->out) {
        fprintf(stderr, "dexel sim: found no -o, expected a file or directory to write\n");
        return -EINVAL;
    }
    if (dx_out_frames_check(a->out, &err) < 0) {
        fprintf(stderr, "dexel sim: -o: %s\n", err.text);
        return -EINVAL;
    }
    dx_scene_config_default(&defaults, (enum dx_scene)scene);
    a->config.scene = defaults.scene;
    a->config.width = a->width ? a->width : defaults.width;
    a->config.height = a->width ? a->height : defaults.height;
    return check_size(&a->config);
}

static int parse(struct args *a, int argc, char **argv)
{
    const char *name;
    int r;

    *a = (struct args){.n_frames = 1};
    dx_scene_config_default(&a->config, DX_SCENE_HALL);
    a->config.attr_bytes = 1;
    r = dx_arg_options(argc, argv, options, OPT_HELP, help, set_option, a);
    if (r || a->list)
        return r;
    name = dx_arg_operand(argc, argv, "a scene");
    return name ? settle_scene(a, name) : -EINVAL;
}

static int write_frames(const struct args *a, const struct dx_geometry *g, struct dx_plane *plane,
                        struct dx_err *err)
{
    struct dx_out_frames out;
    int r = dx_out_frames_open(&out, a->out, a->format, err);

    for (uint64_t k = 0; r == 0 && k < a->n_frames; k++) {
        dx_scene_cast(plane, g, &a->config, k, 0, g->width);
        r = dx_out_frames_add(&out, plane, g, err);
    }
    if (r == 0)
        return dx_out_frames_commit(&out, err);
    dx_out_frames_abort(&out);
    return r;
}

static int run(const struct args *a, struct dx_err *err)
{
    const struct dx_scene_config *c = &a->config;
    struct dx_geometry *g;
    struct dx_plane plane;
    int r = dx_scene_geometry(&g, c);

    if (r < 0)
        return dx_err_set(err, r, "%ux%u: %s", c->width, c->height, strerror(-r));
    r = dx_plane_init(&plane, g->height, g->width, g->range_bytes, c->attr_bytes);
    if (r < 0)
        dx_err_set(err, r, "%ux%u: %s", c->width, c->height, strerror(-r));
    else
        r = write_frames(a, g, &plane, err);
    dx_plane_fini(&plane);
    dx_geometry_unref(g);
    return r;
}

static int list_scenes(void)
{
    for (unsigned k = 0; dx_scene_name(k); k++) {
        struct dx_scene_config c;

        dx_scene_config_default(&c, (enum dx_scene)k);
        printf("%-10s  %ux%u  %s\n", dx_scene_name(k), c.width, c.height, dx_scene_help(k));
    }
    return 0;
}

int cmd_sim(int argc, char **argv)
{
    struct dx_err err = {""};
    struct args a;
    int r;

    if (dx_sim_surface_asked(argc, argv))
        return dx_sim_surface(argc, argv);
    r = parse(&a, argc, argv);
    if (r != 0)
        return r == DX_ARG_E_HELP ? 0 : 2;
    if (a.list)
        return list_scenes();
    if (run(&a, &err) < 0) {
        fprintf(stderr, "dexel sim: %s\n", err.text);
        return 1;
    }
    return 0;
}
