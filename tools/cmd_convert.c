/* dexel convert: recordings, through the file driver, to scan files. */
#include "drivers/file/file.h"
#include "tools/args.h"
#include "tools/cmd.h"
#include "tools/out_frames.h"
#include "tools/repair.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

static const char help[] =
    "usage: dexel convert IN OUT [OPTIONS]\n"
    "       dexel convert --repair IN -o OUT\n"
    "Converts a scan file, or a directory or glob of files, by way of the dexel array.\n"
    "With --repair: writes all that can be read of a damaged or cut recording (MCAP)\n"
    "into a whole one.\n\n"
    "  OUT                 a .ptx or .pcd file, or a directory for frame-NNNNNN files\n"
    "  --format ptx|pcd    of the files in a directory (ptx)\n"
    "  --unit M            range unit, metres (finest that holds the range in 16 "
    "bits)\n"
    "  --exact             the points themselves, not those of their ranges\n\n" DX_THIN_HELP(
        "--size WxH           ");

enum { OPT_FORMAT = 256, OPT_UNIT, OPT_EXACT, OPT_SIZE, OPT_KEEP, OPT_REPAIR, OPT_HELP };

static const struct option options[] = {
    {"format", required_argument, NULL, OPT_FORMAT}, {"unit", required_argument, NULL, OPT_UNIT},
    {"exact", no_argument, NULL, OPT_EXACT},         {"size", required_argument, NULL, OPT_SIZE},
    {"keep", required_argument, NULL, OPT_KEEP},     {"repair", no_argument, NULL, OPT_REPAIR},
    {"help", no_argument, NULL, OPT_HELP},           {0},
};

struct args {
    const char *in, *out;
    enum dx_frame_format format;
    double unit_m; /* 0: from the data */
    struct dx_thin_options thin;
    bool exact, repair;
};

/* Takes frames from the driver and hands them on to the writer. */
struct sink {
    struct dx_geometry *g;
    struct dx_plane plane;
    struct dx_out_frames *out;
    struct dx_err *err;
    int failed; /* what writing returned: deliver cannot */
};

static int sink_geometry(void *ctx, struct dx_geometry *g, uint8_t attr_bytes)
{
    struct sink *s = ctx;
    int r;

    dx_plane_fini(&s->plane);
    r = dx_plane_init_for(&s->plane, g, attr_bytes);
    if (r < 0)
        return dx_err_set(s->err, r, "%ux%u: %s", g->width, g->height, strerror(-r));
    dx_geometry_unref(s->g);
    s->g = dx_geometry_ref(g);
    return 0;
}

static struct dx_plane *sink_plane(void *ctx, uint64_t number)
{
    struct sink *s = ctx;

    (void)number; /* files come in whole frames */
    dx_plane_clear(&s->plane);
    return &s->plane;
}

static void sink_deliver(void *ctx, const struct dx_frame_part *part)
{
    struct sink *s = ctx;

    if (part->last && s->failed == 0)
        s->failed = dx_out_frames_add(s->out, &s->plane, s->g, s->err);
}

/* Every frame; a damaged one ends it, since a sequence with holes is not what was asked for. */
static int copy(struct dx_device *dev, struct sink *s)
{
    const struct dx_frame_sink sink = {s, sink_geometry, sink_plane, sink_deliver};
    struct dx_block block;
    int r = 0;

    while (r == 0) {
        r = dx_file_driver.read(dev, &block, s->err);
        if (r == DX_DRIVER_E_EOF)
            return 0;
        if (r == 0)
            r = dx_file_driver.decode(dev, &block, &sink, s->err);
        if (r == 0)
            r = s->failed;
    }
    return r < 0 ? r : -EBADMSG;
}

static int run(const struct args *a, struct dx_err *err)
{
    const struct dx_file_config config = {.path = a->in,
                                          .attr_bytes = -1,
                                          .fit = {.unit_m = a->unit_m, .seam = -1},
                                          .thin = a->thin,
                                          .exact = a->exact};
    struct dx_out_frames out;
    struct sink s = {.out = &out, .err = err};
    struct dx_device *dev;
    int r = dx_file_driver.open(&dev, &config, err);

    if (r < 0)
        return r;
    r = dx_file_driver.start(dev, err);
    if (r == 0)
        r = dx_out_frames_open(&out, a->out, a->format, err);
    if (r == 0) {
        r = copy(dev, &s);
        if (r == 0)
            r = dx_out_frames_commit(&out, err);
        else
            dx_out_frames_abort(&out);
        dx_file_driver.stop(dev);
    }
    dx_file_driver.close(dev);
    dx_plane_fini(&s.plane);
    dx_geometry_unref(s.g);
    return r;
}

static int set_option(struct args *a, int opt, const char *text)
{
    int k;

    switch (opt) {
    case OPT_FORMAT:
        k = dx_arg_choice(&(struct dx_arg){"dexel convert", "--format", text}, dx_frame_formats);
        a->format = k < 0 ? DX_FRAME_PTX : (enum dx_frame_format)k;
        return k;
    case OPT_UNIT:
        return dx_arg_double(&a->unit_m, &(struct dx_arg){"dexel convert", "--unit", text}, 1e-6, 1,
                             "metres");
    case OPT_EXACT:
        a->exact = true;
        return 0;
    case OPT_REPAIR:
        a->repair = true;
        return 0;
    case 'o':
        a->out = text;
        return 0;
    case OPT_SIZE:
        return dx_thin_args_size(&a->thin, &(struct dx_arg){"dexel convert", "--size", text});
    case OPT_KEEP:
        return dx_arg_keep(&a->thin.keep, &(struct dx_arg){"dexel convert", "--keep", text});
    default:
        return -EINVAL; /* getopt has said what it did not know */
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

static int parse(struct args *a, int argc, char **argv)
{
    struct dx_err err;
    int opt;

    *a = (struct args){.format = DX_FRAME_PTX};
    while ((opt = getopt_long(argc, argv, "o:", options, NULL)) != -1) {
        if (opt == OPT_HELP)
            return dx_arg_help(help);
        if (set_option(a, opt, optarg) < 0)
            return -EINVAL;
    }
    if (take_operands(a, argc, argv) < 0)
        return -EINVAL;
    if (dx_thin_args_check(&a->thin, "dexel convert", "--size") < 0 ||
        dx_exact_args_check(a->exact, &a->thin, NULL, "dexel convert") < 0)
        return -EINVAL;
    if (a->repair || dx_out_frames_check(a->out, &err) == 0)
        return 0;
    fprintf(stderr, "dexel convert: %s\n", err.text);
    return -EINVAL;
}

int cmd_convert(int argc, char **argv)
{
    struct dx_err err = {""};
    struct args a;
    int r = parse(&a, argc, argv);

    if (r != 0)
        return r == DX_ARG_E_HELP ? 0 : 2;
    r = a.repair ? dx_repair_file(a.in, a.out, "dexel convert", &err) : run(&a, &err);
    if (r < 0)
        fprintf(stderr, "dexel convert: %s\n", err.text[0] ? err.text : strerror(-r));
    return r < 0 ? 1 : 0;
}
