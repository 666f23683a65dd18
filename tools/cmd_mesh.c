/* dexel mesh: a scan file to a mesh file, without the service. */
#include "core/wire/wire.h"
#include "tools/now.h"
#include "tools/cmd.h"
#include "tools/mesh_cloud.h"
#include "tools/mesh_repair_run.h"
#include "tools/mesh_report.h"
#include "tools/mesh_split.h"
#include "tools/offline.h"
#include "tools/out_mesh.h"
#include "tools/stats_json.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

static const char help[] =
    "usage: dexel mesh IN -o OUT.{ply,obj,stl} [OPTIONS]\n"
    "Meshes a scan file (or a frame of a directory or glob of files), or a recording.\n\n"
    "  -o OUT              the mesh; may be left out with --stats\n"
    "  --mode terrain|project|delaunay|smooth\n"
    "                      how (terrain); the others are for unorganized points:\n"
    "                      --mode project --help\n"
    "  --report            what a mesh file is, in numbers: --report --help\n"
    "  --repair            mend a mesh file: --repair --help; with --mode, the mesh that is made\n"
    "  --frame N           which frame of a sequence, from 0 (the last)\n"
    "  --topic TOPIC       of the clouds in an MCAP file (the only one)\n"
    "  --threads N         for the tiles (one a processor)\n"
    "  --world             vertices in the world's frame, by the scan's pose\n"
    "  --ascii             PLY as text\n"
    "  --split             each fan of triangles that meet in a point gets a vertex of its own\n"
    "  --encoding f32|q16|delta\n"
    "                      pass the tiles through an encoding of the protocol\n"
    "  --lod SIGMA         leave out samples within so many sigmas of what is left\n"
    "  --stride N          leave out samples in steps of N: 2, 4 .. 64; with --lod at most so far\n"
    "  --exact             vertices are the scan's own points, bit for bit (not by q16, delta)\n"
    "  --stats             one JSON object on standard output\n\n" DX_THIN_HELP(
        "--size WxH           ") "\n" DX_TERRAIN_HELP;

enum {
    OPT_MODE = 256,
    OPT_FRAME,
    OPT_TOPIC,
    OPT_THREADS,
    OPT_WORLD,
    OPT_ASCII,
    OPT_SPLIT,
    OPT_ENCODING,
    OPT_LOD,
    OPT_STRIDE,
    OPT_EXACT,
    OPT_STATS,
    OPT_SIZE,
    OPT_KEEP,
    OPT_HELP
};

static const struct option options[] = {
    {"mode", required_argument, NULL, OPT_MODE},
    {"frame", required_argument, NULL, OPT_FRAME},
    {"topic", required_argument, NULL, OPT_TOPIC},
    {"threads", required_argument, NULL, OPT_THREADS},
    {"world", no_argument, NULL, OPT_WORLD},
    {"ascii", no_argument, NULL, OPT_ASCII},
    {"split", no_argument, NULL, OPT_SPLIT},
    {"encoding", required_argument, NULL, OPT_ENCODING},
    {"lod", required_argument, NULL, OPT_LOD},
    {"stride", required_argument, NULL, OPT_STRIDE},
    {"exact", no_argument, NULL, OPT_EXACT},
    {"stats", no_argument, NULL, OPT_STATS},
    {"size", required_argument, NULL, OPT_SIZE},
    {"keep", required_argument, NULL, OPT_KEEP},
    {"help", no_argument, NULL, OPT_HELP},
    DX_REPAIR_OPTIONS,
    DX_TERRAIN_OPTIONS,
    {0},
};

struct args {
    struct dx_offline_config config;
    struct dx_out_options write;
    const char *out;
    double lod_sigmas;
    unsigned stride;
    struct dx_mesh_repair_args repair;
    bool split, stats;
};

static int set_value(struct args *a, int opt, const char *text)
{
    static const char *const encodings[] = {
        [DX_ENCODING_F32] = "f32", [DX_ENCODING_Q16] = "q16", [DX_ENCODING_DELTA] = "delta", NULL};
    uint64_t n = 0;
    int rc;

    switch (opt) {
    case OPT_MODE:
        return dx_arg_choice(&(struct dx_arg){"dexel mesh", "--mode", text}, dx_mesh_mode_names());
    case OPT_FRAME:
        return dx_arg_u64(&a->config.frame, &(struct dx_arg){"dexel mesh", "--frame", text}, 0,
                          1000000000, "a frame's number");
    case OPT_THREADS:
        rc = dx_arg_u64(&n, &(struct dx_arg){"dexel mesh", "--threads", text}, 1, 64, "threads");
        a->config.n_threads = (unsigned)n;
        return rc;
    case OPT_ENCODING:
        a->config.encoding =
            dx_arg_choice(&(struct dx_arg){"dexel mesh", "--encoding", text}, encodings);
        return a->config.encoding < 0 ? -EINVAL : 0;
    case OPT_LOD:
        return dx_arg_sigmas(&a->lod_sigmas, &(struct dx_arg){"dexel mesh", "--lod", text});
    case OPT_STRIDE:
        return dx_arg_stride(&a->stride, &(struct dx_arg){"dexel mesh", "--stride", text});
    case OPT_SIZE:
        return dx_thin_args_size(&a->config.thin, &(struct dx_arg){"dexel mesh", "--size", text});
    case OPT_KEEP:
        return dx_arg_keep(&a->config.thin.keep, &(struct dx_arg){"dexel mesh", "--keep", text});
    default:
        return dx_terrain_args_set(&a->config.terrain, "dexel mesh", opt, text);
    }
}

static int set_option(struct args *a, int opt, const char *text)
{
    switch (opt) {
    case 'o':
        a->out = text;
        return 0;
    case OPT_TOPIC:
        a->config.topic = text;
        return 0;
    case OPT_WORLD:
        a->write.world = true;
        return 0;
    case OPT_ASCII:
        a->write.ascii = true;
        return 0;
    case OPT_SPLIT:
        a->split = true;
        return 0;
    case OPT_EXACT:
        a->config.exact = true;
        return 0;
    case DX_OPTION_REPAIR:
    case DX_OPTION_REPAIR_HOLES:
        return dx_mesh_repair_args_set(&a->repair, opt, text);
    case OPT_STATS:
        a->stats = true;
        return 0;
    default:
        return set_value(a, opt, text);
    }
}

static int check(const struct args *a)
{
    struct dx_err err;

    if (dx_terrain_args_check(&a->config.terrain, "dexel mesh") < 0 ||
        dx_thin_args_check(&a->config.thin, "dexel mesh", "--size") < 0 ||
        dx_exact_args_check(a->config.exact, &a->config.thin, &a->config.terrain, "dexel mesh") < 0)
        return -EINVAL;
    if (!a->out && !a->stats) {
        fprintf(stderr, "dexel mesh: found neither -o nor --stats, expected one of them\n");
        return -EINVAL;
    }
    if (a->out && !dx_mesh_writer_for(a->out, &err)) {
        fprintf(stderr, "dexel mesh: %s\n", err.text);
        return -EINVAL;
    }
    return dx_offline_check(&a->config, "dexel mesh");
}

static int parse(struct args *a, int argc, char **argv)
{
    int opt;

    *a = (struct args){.config = {.frame = DX_OFFLINE_LAST, .encoding = DX_OFFLINE_PLAIN}};
    dx_terrain_args_default(&a->config.terrain);
    dx_mesh_repair_args_default(&a->repair);
    while ((opt = getopt_long(argc, argv, "o:", options, NULL)) != -1) {
        if (opt == OPT_HELP)
            return dx_arg_help(help);
        if (set_option(a, opt, optarg) < 0)
            return -EINVAL;
    }
    dx_lod_level_set(&a->config.lod, a->lod_sigmas, a->stride);
    a->config.lod_stats = a->stats;
    a->config.path = dx_arg_operand(argc, argv, "a scan");
    return a->config.path ? check(a) : -EINVAL;
}

static json_t *lod_json(const struct dx_lod_stats *s)
{
    return json_pack("{s:I, s:I, s:f, s:f, s:I}", "whole_triangles", (json_int_t)s->whole,
                     "left_out", (json_int_t)s->left_out, "max_sigma", s->max_sigma, "rms_sigma",
                     s->rms_sigma, "cracks", (json_int_t)s->cracks);
}

/* `repair` is NULL where none was made. */
static int print_stats(const struct dx_offline *o, const struct dx_mesh *mesh,
                       const struct dx_mesh_repair *repair, double seconds)
{
    double n_dexels = (double)o->geometry->height * o->geometry->width;
    struct dx_mesh_stats stats;
    json_t *j;
    int rc = dx_mesh_stats_compute(&stats, mesh);

    if (rc < 0) {
        fprintf(stderr, "dexel mesh: out of memory\n");
        return rc;
    }
    j = dx_stats_json(&stats);
    json_object_set_new(j, "seconds", json_real(seconds));
    json_object_set_new(j, "geometry", json_string(dx_model_name(o->geometry->model)));
    json_object_set_new(j, "width", json_integer(o->geometry->width));
    json_object_set_new(j, "height", json_integer(o->geometry->height));
    json_object_set_new(j, "wrap", json_boolean(o->geometry->wrap));
    json_object_set_new(j, "unit", json_real((double)o->geometry->unit_m));
    json_object_set_new(j, "sigma", dx_sigma_json(o->params.sigma));
    json_object_set_new(j, "smoothed", json_boolean(o->params.smooth));
    json_object_set_new(j, "rms_dexel", json_real(o->fit.rms_dexel));
    json_object_set_new(j, "regularity", json_real(o->fit.regularity));
    json_object_set_new(j, "azimuth_step_deg", json_real(o->fit.azimuth_step_deg));
    json_object_set_new(j, "elevation_step_deg", json_real(o->fit.elevation_step_deg));
    json_object_set_new(j, "valid", json_real(o->fit.valid));
    json_object_set_new(j, "frame", json_integer((json_int_t)o->frame));
    json_object_set_new(j, "ns_per_dexel", json_real(o->mesh_s * 1e9 / n_dexels));
    if (repair)
        json_object_set_new(j, "repair", dx_mesh_repair_json(repair));
    if (o->lod.triangles)
        json_object_set_new(j, "lod", lod_json(&o->lod));
    return dx_json_print(j, "dexel mesh");
}

/* Seconds go to the mesh: reading to welding, without writing it and counting it. */
static int run(const struct args *a)
{
    struct dx_out_options write = a->write;
    struct dx_mesh_repair counts;
    struct dx_offline o;
    struct dx_mesh mesh;
    struct dx_err err;
    uint64_t start = dx_now_ns();
    double seconds;
    int rc = dx_offline_run(&o, &a->config, &err);

    if (rc < 0) {
        fprintf(stderr, "dexel mesh: %s\n", err.text);
        return rc;
    }
    memcpy(write.pose, o.geometry->pose, sizeof(write.pose));
    rc = dx_mesh_store_weld(&mesh, o.mesh);
    if (rc == 0 && a->split)
        rc = dx_mesh_split(&mesh) < 0 ? -ENOMEM : 0;
    seconds = dx_seconds_since(start);
    if (rc == 0 && mesh.n_triangles == 0)
        fprintf(stderr, "dexel mesh: %s: no triangle: no three neighbours are joined\n",
                a->config.path);
    if (rc < 0)
        dx_err_set(&err, rc, "%s: the mesh: %s", a->config.path, strerror(-rc));
    else
        rc = dx_mesh_repair_run(&mesh, &counts, &a->repair, a->config.path, &err);
    if (rc == 0 && a->out)
        rc = dx_out_mesh(a->out, &mesh, &write, &err);
    if (rc < 0)
        fprintf(stderr, "dexel mesh: %s\n", err.text);
    else if (a->stats)
        rc = print_stats(&o, &mesh, a->repair.asked ? &counts : NULL, seconds);
    dx_mesh_fini(&mesh);
    dx_offline_fini(&o);
    return rc;
}

int cmd_mesh(int argc, char **argv)
{
    const struct dx_mesh_mode *of_points = dx_mesh_mode_asked(argc, argv);
    struct args a;
    int rc;

    if (of_points)
        return dx_mesh_cloud(of_points, argc, argv);
    if (dx_mesh_report_asked(argc, argv))
        return dx_mesh_report(argc, argv);
    if (dx_mesh_repair_asked(argc, argv))
        return dx_mesh_repair_command(argc, argv);
    rc = parse(&a, argc, argv);
    if (rc != 0)
        return rc == DX_ARG_E_HELP ? 0 : 2;
    return run(&a) < 0 ? 1 : 0;
}
