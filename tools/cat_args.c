/* Options of `dexel cat`. */
#include "tools/cat_args.h"

#include "tools/args.h"
#include "tools/out_mesh.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

static const char help[] =
    "usage: dexel cat [OPTIONS]\n"
    "Receives the mesh of a stream until the stream ends (or --frames, or Ctrl-C).\n\n"
    "  --socket PATH         mesh socket ($DEXELD_SOCKET, else /run/dexeld/mesh.sock)\n"
    "  --stream NAME         which stream (the only one)\n"
    "  --encoding f32|q16|delta  how the mesh travels (f32)\n"
    "  --lod SIGMA           a mesh without samples that are so near to what is left (f32)\n"
    "  --stride N            in steps of N, 2, 4 .. 64; with --lod at most so far (f32)\n"
    "  --attr, --no-attr     ask for the attribute, where there is one (--attr)\n"
    "  --normals             ask for normals, where there are some\n"
    "  --frames N            stop after N commits\n"
    "  --lossless            every epoch; from a replay at --rate max only\n"
    "  --pull                ask for each epoch when the one before is done with\n"
    "  --interval MS         at most one epoch in so many milliseconds\n"
    "  --reconnect           wait for a service, and for the next one when it goes away\n"
    "  --timeout S           give up after so many seconds of silence (never)\n"
    "  -o OUT.{ply,obj,stl}  write the last whole mesh\n"
    "  --every               write every commit; %06d in OUT is its number\n"
    "  --split               each fan of triangles that meet in a point gets its own vertex\n"
    "  --world               vertices in the world's frame, by the scan's pose\n"
    "  --stats               one JSON object on standard output at the end\n"
    "  --quiet               nothing on standard error but errors\n";

/* ---- arguments
 * ------------------------------------------------------------------------------------- */

enum {
    OPT_SOCKET = 256,
    OPT_STREAM,
    OPT_ENCODING,
    OPT_LOD,
    OPT_STRIDE,
    OPT_ATTR,
    OPT_NO_ATTR,
    OPT_NORMALS,
    OPT_FRAMES,
    OPT_LOSSLESS,
    OPT_PULL,
    OPT_INTERVAL,
    OPT_RECONNECT,
    OPT_TIMEOUT,
    OPT_EVERY,
    OPT_SPLIT,
    OPT_WORLD,
    OPT_STATS,
    OPT_QUIET,
    OPT_HELP
};

static const struct option options[] = {
    {"socket", required_argument, NULL, OPT_SOCKET},
    {"stream", required_argument, NULL, OPT_STREAM},
    {"encoding", required_argument, NULL, OPT_ENCODING},
    {"lod", required_argument, NULL, OPT_LOD},
    {"stride", required_argument, NULL, OPT_STRIDE},
    {"attr", no_argument, NULL, OPT_ATTR},
    {"no-attr", no_argument, NULL, OPT_NO_ATTR},
    {"normals", no_argument, NULL, OPT_NORMALS},
    {"frames", required_argument, NULL, OPT_FRAMES},
    {"lossless", no_argument, NULL, OPT_LOSSLESS},
    {"pull", no_argument, NULL, OPT_PULL},
    {"interval", required_argument, NULL, OPT_INTERVAL},
    {"reconnect", no_argument, NULL, OPT_RECONNECT},
    {"timeout", required_argument, NULL, OPT_TIMEOUT},
    {"every", no_argument, NULL, OPT_EVERY},
    {"split", no_argument, NULL, OPT_SPLIT},
    {"world", no_argument, NULL, OPT_WORLD},
    {"stats", no_argument, NULL, OPT_STATS},
    {"quiet", no_argument, NULL, OPT_QUIET},
    {"help", no_argument, NULL, OPT_HELP},
    {0},
};

static int set_number(struct dx_cat_args *cat, int opt, const char *text)
{
    uint64_t ms;
    int rc;

    if (opt == OPT_FRAMES)
        return dx_arg_u64(&cat->n_frames, &(struct dx_arg){"dexel cat", "--frames", text}, 1,
                          1000000000, "commits");
    if (opt == OPT_TIMEOUT)
        return dx_arg_double(&cat->timeout_s, &(struct dx_arg){"dexel cat", "--timeout", text},
                             0.001, 1e6, "seconds");
    rc = dx_arg_u64(&ms, &(struct dx_arg){"dexel cat", "--interval", text}, 0, 3600000,
                    "milliseconds");
    cat->subscribe.min_interval_ms = rc < 0 ? 0 : (uint32_t)ms;
    return rc;
}

static int set_mode(struct dx_cat_args *cat, enum dexel_mode mode)
{
    if (cat->subscribe.mode != DEXEL_LIVE && cat->subscribe.mode != mode) {
        fprintf(stderr, "dexel cat: --lossless and --pull do not go together\n");
        return -EINVAL;
    }
    cat->subscribe.mode = mode;
    return 0;
}

static int set_encoding(struct dx_cat_args *cat, const char *text)
{
    static const char *const names[] = {
        [DEXEL_F32] = "f32", [DEXEL_Q16] = "q16", [DEXEL_DELTA] = "delta", NULL};
    int k = dx_arg_choice(&(struct dx_arg){"dexel cat", "--encoding", text}, names);

    cat->subscribe.encoding = k < 0 ? DEXEL_F32 : (enum dexel_encoding)k;
    return k < 0 ? k : 0;
}

static int set_option(struct dx_cat_args *cat, int opt, const char *text)
{
    switch (opt) {
    case OPT_SOCKET:
        cat->subscribe.socket = text;
        return 0;
    case OPT_STREAM:
        cat->subscribe.stream = text;
        return 0;
    case OPT_ENCODING:
        return set_encoding(cat, text);
    case OPT_LOD:
        return dx_arg_sigmas(&cat->subscribe.lod_sigma,
                             &(struct dx_arg){"dexel cat", "--lod", text});
    case OPT_STRIDE:
        return dx_arg_stride(&cat->subscribe.stride,
                             &(struct dx_arg){"dexel cat", "--stride", text});
    case OPT_ATTR:
    case OPT_NO_ATTR:
        cat->subscribe.want_attr = opt == OPT_ATTR;
        return 0;
    case OPT_NORMALS:
        return cat->subscribe.want_normals = 1, 0;
    case OPT_FRAMES:
    case OPT_INTERVAL:
    case OPT_TIMEOUT:
        return set_number(cat, opt, text);
    case OPT_RECONNECT:
        return cat->subscribe.reconnect = 1, 0;
    case OPT_LOSSLESS:
        return set_mode(cat, DEXEL_LOSSLESS);
    case OPT_PULL:
        return set_mode(cat, DEXEL_PULL);
    case 'o':
        cat->out = text;
        return 0;
    case OPT_EVERY:
        return cat->every = true, 0;
    case OPT_SPLIT:
        return cat->split = true, 0;
    case OPT_WORLD:
        return cat->world = true, 0;
    case OPT_STATS:
        return cat->stats = true, 0;
    case OPT_QUIET:
        return cat->quiet = true, 0;
    default:
        return -EINVAL; /* getopt has said what it did not know */
    }
}

static int check(const struct dx_cat_args *cat)
{
    struct dx_err err;

    if (cat->every && !cat->out) {
        fprintf(stderr, "dexel cat: --every needs -o\n");
        return -EINVAL;
    }
    if (cat->out && !dx_mesh_writer_for(cat->out, &err)) {
        fprintf(stderr, "dexel cat: %s\n", err.text);
        return -EINVAL;
    }
    return dx_encoding_args_check(cat->subscribe.encoding == DEXEL_F32   ? NULL
                                  : cat->subscribe.encoding == DEXEL_Q16 ? "q16"
                                                                         : "delta",
                                  false, cat->subscribe.lod_sigma > 0 || cat->subscribe.stride > 1,
                                  "dexel cat");
}

int dx_cat_args_parse(struct dx_cat_args *cat, int argc, char **argv)
{
    int opt;

    *cat = (struct dx_cat_args){.subscribe = {.want_attr = 1}};
    while ((opt = getopt_long(argc, argv, "o:", options, NULL)) != -1) {
        if (opt == OPT_HELP)
            return dx_arg_help(help);
        if (set_option(cat, opt, optarg) < 0)
            return -EINVAL;
    }
    if (optind < argc) {
        fprintf(stderr, "dexel cat: found '%s', expected options only\n", argv[optind]);
        return -EINVAL;
    }
    return check(cat);
}
