/* dexel convert: scans and recordings to scan files, to recordings, to messages of ROS. */
#include "tools/args.h"
#include "tools/cmd.h"
#include "tools/convert.h"
#include "tools/convert_normals.h"
#include "tools/convert_smooth.h"
#include "tools/repair.h"
#include "tools/source.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

static const char help[] =
    "usage: dexel convert IN OUT [OPTIONS]\n"
    "       dexel convert --repair IN -o OUT\n"
    "       dexel convert --normals IN OUT    (unorganized points: --normals --help)\n"
    "       dexel convert --smooth IN OUT     (unorganized points: --smooth --help)\n"
    "Converts scans (a file, or a directory or glob of files), recordings of dexeld and\n"
    "organized clouds in MCAP files of other programs, by way of the dexel array.\n"
    "With --repair: writes all that can be read of a damaged or cut recording (MCAP)\n"
    "into a whole one.\n\n"
    "  OUT                 a .ptx or .pcd file, or a directory for frame-NNNNNN files;\n"
    "                      .mcap: a recording that dexeld replays\n"
    "  --format ptx|pcd    of the files in a directory (ptx)\n"
    "  --frame N           one frame of a sequence, from 0 (all)\n"
    "  --topic TOPIC       of the clouds in an MCAP file (the only one)\n"
    "  --ros clouds|mesh|both\n"
    "                      instead of a recording an .mcap for ROS 2 and Foxglove: of each frame\n"
    "                      a PointCloud2 on /dexel/points, its mesh as a SceneUpdate on "
    "/dexel/mesh\n"
    "  --exact             the points themselves, not those of their ranges\n\n" DX_THIN_HELP(
        "--size WxH           ") "\nof the geometry, and of the mesh of --ros, " DX_TERRAIN_HELP;

enum {
    OPT_FORMAT = 256,
    OPT_FRAME,
    OPT_TOPIC,
    OPT_ROS,
    OPT_EXACT,
    OPT_SIZE,
    OPT_KEEP,
    OPT_REPAIR,
    OPT_HELP
};

static const struct option options[] = {
    {"format", required_argument, NULL, OPT_FORMAT},
    {"frame", required_argument, NULL, OPT_FRAME},
    {"topic", required_argument, NULL, OPT_TOPIC},
    {"ros", required_argument, NULL, OPT_ROS},
    {"exact", no_argument, NULL, OPT_EXACT},
    {"size", required_argument, NULL, OPT_SIZE},
    {"keep", required_argument, NULL, OPT_KEEP},
    {"repair", no_argument, NULL, OPT_REPAIR},
    {"help", no_argument, NULL, OPT_HELP},
    DX_TERRAIN_OPTIONS,
    {0},
};

struct args {
    const char *in, *out;
    struct dx_convert_config config;
    struct dx_terrain_args terrain;
    bool repair;
    bool format_given;
    const char *of_mesh; /* the first option that a mesh alone obeys */
    const char *other;   /* the first one beside --repair and -o */
};

static int set_option(struct args *a, int opt, const char *text)
{
    struct dx_convert_config *c = &a->config;
    int k;

    switch (opt) {
    case OPT_FORMAT:
        k = dx_arg_choice(&(struct dx_arg){"dexel convert", "--format", text}, dx_frame_formats);
        c->format = k < 0 ? DX_FRAME_PTX : (enum dx_frame_format)k;
        a->format_given = true;
        return k;
    case OPT_FRAME:
        return dx_arg_u64(&c->frame, &(struct dx_arg){"dexel convert", "--frame", text}, 0,
                          1000000000, "a frame's number");
    case OPT_TOPIC:
        c->source.topic = text;
        return 0;
    case OPT_ROS: /* none is for those who do not ask */
        k = dx_arg_choice(&(struct dx_arg){"dexel convert", "--ros", text},
                          dx_ros_whats + DX_ROS_CLOUDS);
        c->ros = k < 0 ? DX_ROS_NONE : (enum dx_ros_what)(k + DX_ROS_CLOUDS);
        return k;
    case OPT_EXACT:
        c->source.exact = true;
        return 0;
    case OPT_REPAIR:
        a->repair = true;
        return 0;
    case 'o':
        a->out = text;
        return 0;
    case OPT_SIZE:
        return dx_thin_args_size(&c->source.thin,
                                 &(struct dx_arg){"dexel convert", "--size", text});
    case OPT_KEEP:
        return dx_arg_keep(&c->source.thin.keep, &(struct dx_arg){"dexel convert", "--keep", text});
    default:
        return dx_terrain_args_set(&a->terrain, "dexel convert", opt, text);
    }
}

/* IN and OUT, which may also be given as -o OUT. */
static int take_operands(struct args *a, int argc, char **argv)
{
    if (argc - optind != (a->out ? 1 : 2)) {
        fprintf(stderr, "dexel convert: found %d arguments, expected IN and OUT\n",
                argc - optind + (a->out ? 1 : 0));
        return -EINVAL;
    }
    a->in = argv[optind];
    if (!a->out)
        a->out = argv[optind + 1];
    return 0;
}

/* What was given for later checks; `k` is its place among the options. */
static void remember(struct args *a, int opt, int k)
{
    bool is_of_mesh = opt >= DX_OPTION_SIGMA && opt != DX_OPTION_SEAM && opt != DX_OPTION_UNIT;

    if (is_of_mesh && !a->of_mesh)
        a->of_mesh = options[k].name;
    if (opt != 'o' && opt != OPT_REPAIR && !a->other)
        a->other = options[k].name;
}

/* A repair copies; it makes no frames that an option could change. */
static int check_repair(const struct args *a)
{
    if (a->other)
        fprintf(stderr, "dexel convert: --repair: found --%s beside it, expected none\n", a->other);
    else if (!dx_convert_is_mcap(a->out))
        fprintf(stderr, "dexel convert: --repair: found -o '%s', expected a name ending in .mcap\n",
                a->out);
    return a->other || !dx_convert_is_mcap(a->out) ? -EINVAL : 0;
}

/* An option that the output has no use for is a mistake of whoever gave it. */
static int check_output(const struct args *a)
{
    const struct dx_convert_config *c = &a->config;
    struct dx_err err;

    if (c->ros != DX_ROS_NONE && !dx_convert_is_mcap(c->out)) {
        fprintf(stderr, "dexel convert: --ros: found '%s', expected a name ending in .mcap\n",
                c->out);
        return -EINVAL;
    }
    if (a->format_given && dx_convert_is_mcap(c->out)) {
        fprintf(stderr,
                "dexel convert: --format: found '%s' for the output '%s', expected a folder\n",
                dx_frame_formats[c->format], c->out);
        return -EINVAL;
    }
    if (a->of_mesh && c->ros != DX_ROS_MESH && c->ros != DX_ROS_BOTH) {
        fprintf(stderr,
                "dexel convert: --%s: found without --ros mesh or --ros both, which make meshes\n",
                a->of_mesh);
        return -EINVAL;
    }
    if (!dx_convert_is_mcap(c->out) && dx_out_frames_check(c->out, &err) < 0) {
        fprintf(stderr, "dexel convert: %s, or a name ending in .mcap\n", err.text);
        return -EINVAL;
    }
    return 0;
}

/* After the last option: what they make together. */
static int check(struct args *a)
{
    struct dx_convert_config *c = &a->config;

    c->source.path = a->in;
    c->source.fit = a->terrain.fit;
    c->terrain = a->terrain.params;
    c->out = a->out;
    if (dx_terrain_args_check(&a->terrain, "dexel convert") < 0 ||
        dx_thin_args_check(&c->source.thin, "dexel convert", "--size") < 0 ||
        dx_exact_args_check(c->source.exact, &c->source.thin, &a->terrain, "dexel convert") < 0)
        return -EINVAL;
    if (a->repair)
        return check_repair(a);
    if (check_output(a) < 0)
        return -EINVAL;
    return dx_source_check(&c->source, "dexel convert");
}

static int parse(struct args *a, int argc, char **argv)
{
    int opt, k = 0;

    *a = (struct args){
        .config = {.format = DX_FRAME_PTX, .source.attr_bytes = -1, .frame = DX_CONVERT_ALL}};
    dx_terrain_args_default(&a->terrain);
    while ((opt = getopt_long(argc, argv, "o:", options, &k)) != -1) {
        if (opt == OPT_HELP)
            return dx_arg_help(help);
        if (set_option(a, opt, optarg) < 0)
            return -EINVAL;
        remember(a, opt, k);
    }
    return take_operands(a, argc, argv) < 0 ? -EINVAL : check(a);
}

int cmd_convert(int argc, char **argv)
{
    struct dx_err err = {""};
    struct args a;
    int r;

    if (dx_convert_normals_asked(argc, argv))
        return dx_convert_normals(argc, argv);
    if (dx_convert_smooth_asked(argc, argv))
        return dx_convert_smooth(argc, argv);
    r = parse(&a, argc, argv);
    if (r != 0)
        return r == DX_ARG_E_HELP ? 0 : 2;
    r = a.repair ? dx_repair_file(a.in, a.out, "dexel convert", &err)
                 : dx_convert_run(&a.config, &err);
    if (r < 0)
        fprintf(stderr, "dexel convert: %s\n", err.text[0] ? err.text : strerror(-r));
    return r < 0 ? 1 : 0;
}
