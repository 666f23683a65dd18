/* dexel render: a scan, or a mesh that was written as PLY, as a picture. */
#include "core/base/trig.h"
#include "tools/cmd.h"
#include "tools/offline.h"
#include "tools/out_png.h"
#include "tools/ply_read.h"
#include "tools/render.h"
#include "tools/shade.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char help[] =
    "usage: dexel render IN -o OUT.png [OPTIONS]\n"
    "Draws a scan or a recording (meshed first) or a binary PLY mesh.\n\n"
    "  -o OUT.png               the picture\n"
    "  --view scanner           as the scanner saw it; a panorama where that is wide (default)\n"
    "  --view front|iso         from outside, at the scanner's back; obliquely from above\n"
    "  --view YAW,PITCH[,DIST]  from outside, degrees to the right and above; metres away\n"
    "  --size WxH               pixels (1600 wide)\n"
    "  --shade normal|attr|range\n"
    "  --edges                  with the triangles' edges\n"
    "  --few-colours            32 steps a channel, a much smaller file\n"
    "  --frame N                which frame of a sequence, from 0 (the last)\n"
    "  --topic TOPIC            of the clouds in an MCAP file (the only one)\n\n" DX_THIN_HELP(
        "--array WxH          ") "\n" DX_TERRAIN_HELP;

#define MAX_PIXELS (1u << 25)

enum view { VIEW_SCANNER, VIEW_ORBIT };

struct args {
    struct dx_offline_config config;
    const char *out;
    enum view view;
    double yaw_deg, pitch_deg, dist_m;
    uint32_t width, height; /* height 0: by the view */
    enum dx_shade shade;
    bool edges, few_colours;
};

/* ---- arguments
 * ------------------------------------------------------------------------------------ */

static int set_view(struct args *a, const char *text)
{
    const struct dx_arg arg = {"dexel render", "--view", text};
    double v[3];
    int n;

    a->view = strcmp(text, "scanner") == 0 ? VIEW_SCANNER : VIEW_ORBIT;
    a->yaw_deg = a->pitch_deg = a->dist_m = 0;
    if (a->view == VIEW_SCANNER || strcmp(text, "front") == 0)
        return 0;
    if (strcmp(text, "iso") == 0) {
        a->yaw_deg = 35;
        a->pitch_deg = 35;
        return 0;
    }
    if (text[0] > '9')
        return dx_arg_bad(&arg, "scanner|front|iso|YAW,PITCH[,DIST]");
    n = dx_arg_triple(v, &arg, -360, 1e6, "numbers");
    if (n < 0)
        return n;
    if (n < 2 || v[0] > 360 || v[1] < -90 || v[1] > 90 || v[2] < 0)
        return dx_arg_bad(&arg, "YAW,PITCH[,DIST]: degrees to 360, degrees to 90, metres");
    a->yaw_deg = v[0];
    a->pitch_deg = v[1];
    a->dist_m = v[2];
    return 0;
}

static int set_size(struct args *a, const char *text)
{
    const struct dx_arg arg = {"dexel render", "--size", text};
    int rc = dx_arg_size(&a->width, &a->height, &arg);

    if (rc == 0 && (a->width > DX_RASTER_MAX_SIDE / 2 || a->height > DX_RASTER_MAX_SIDE / 2 ||
                    (uint64_t)a->width * a->height > MAX_PIXELS))
        rc = dx_arg_bad(&arg, "sides to %u and at most %u pixels", DX_RASTER_MAX_SIDE / 2,
                        MAX_PIXELS);
    return rc;
}

static int set_shade(struct args *a, const char *text)
{
    static const char *const names[] = {
        [DX_SHADE_NORMAL] = "normal", [DX_SHADE_ATTR] = "attr", [DX_SHADE_RANGE] = "range", NULL};
    int k = dx_arg_choice(&(struct dx_arg){"dexel render", "--shade", text}, names);

    a->shade = k < 0 ? DX_SHADE_NORMAL : (enum dx_shade)k;
    return k < 0 ? k : 0;
}

enum {
    OPT_VIEW = 256,
    OPT_SIZE,
    OPT_SHADE,
    OPT_EDGES,
    OPT_FEW_COLOURS,
    OPT_FRAME,
    OPT_TOPIC,
    OPT_ARRAY,
    OPT_KEEP,
    OPT_HELP
};

static const struct option options[] = {
    {"view", required_argument, NULL, OPT_VIEW},
    {"size", required_argument, NULL, OPT_SIZE},
    {"shade", required_argument, NULL, OPT_SHADE},
    {"edges", no_argument, NULL, OPT_EDGES},
    {"few-colours", no_argument, NULL, OPT_FEW_COLOURS},
    {"frame", required_argument, NULL, OPT_FRAME},
    {"topic", required_argument, NULL, OPT_TOPIC},
    {"array", required_argument, NULL, OPT_ARRAY},
    {"keep", required_argument, NULL, OPT_KEEP},
    {"help", no_argument, NULL, OPT_HELP},
    DX_TERRAIN_OPTIONS,
    {0},
};

static int set_option(struct args *a, int opt, const char *text)
{
    switch (opt) {
    case 'o':
        a->out = text;
        return 0;
    case OPT_VIEW:
        return set_view(a, text);
    case OPT_SIZE:
        return set_size(a, text);
    case OPT_SHADE:
        return set_shade(a, text);
    case OPT_EDGES:
        a->edges = true;
        return 0;
    case OPT_FEW_COLOURS:
        a->few_colours = true;
        return 0;
    case OPT_FRAME:
        return dx_arg_u64(&a->config.frame, &(struct dx_arg){"dexel render", "--frame", text}, 0,
                          1000000000, "a frame's number");
    case OPT_TOPIC:
        return a->config.topic = text, 0;
    case OPT_ARRAY: /* --size is the picture's */
        return dx_thin_args_size(&a->config.thin,
                                 &(struct dx_arg){"dexel render", "--array", text});
    case OPT_KEEP:
        return dx_arg_keep(&a->config.thin.keep, &(struct dx_arg){"dexel render", "--keep", text});
    default:
        return dx_terrain_args_set(&a->config.terrain, "dexel render", opt, text);
    }
}

static int check(const struct args *a)
{
    const char *dot = a->out ? strrchr(a->out, '.') : NULL;

    if (!dot || strcmp(dot, ".png") != 0) {
        fprintf(stderr, "dexel render: -o: found '%s', expected OUT.png\n", a->out ? a->out : "");
        return -EINVAL;
    }
    if ((a->config.frame != DX_OFFLINE_LAST || a->config.thin.width) &&
        dx_ply_probe(a->config.path)) {
        fprintf(stderr, "dexel render: %s: found the mesh '%s', expected a scan\n",
                a->config.thin.width ? "--array" : "--frame", a->config.path);
        return -EINVAL;
    }
    if (dx_thin_args_check(&a->config.thin, "dexel render", "--array") < 0)
        return -EINVAL;
    if (dx_terrain_args_check(&a->config.terrain, "dexel render") < 0)
        return -EINVAL;
    return dx_offline_check(&a->config, "dexel render");
}

static int parse(struct args *a, int argc, char **argv)
{
    int opt;

    *a = (struct args){.config = {.frame = DX_OFFLINE_LAST, .encoding = DX_OFFLINE_PLAIN},
                       .width = 1600};
    dx_terrain_args_default(&a->config.terrain);
    while ((opt = getopt_long(argc, argv, "o:", options, NULL)) != -1) {
        if (opt == OPT_HELP)
            return dx_arg_help(help);
        if (set_option(a, opt, optarg) < 0)
            return -EINVAL;
    }
    a->config.path = dx_arg_operand(argc, argv, "a scan or a .ply mesh");
    return a->config.path ? check(a) : -EINVAL;
}

/* ---- drawing
 * -------------------------------------------------------------------------------------- */

static int load_mesh(struct dx_mesh *mesh, const struct args *a, struct dx_err *err)
{
    struct dx_offline o;
    int rc;

    *mesh = (struct dx_mesh){0};
    if (dx_ply_probe(a->config.path))
        return dx_ply_read(mesh, a->config.path, err);
    rc = dx_offline_run(&o, &a->config, err);
    if (rc < 0)
        return rc;
    rc = dx_mesh_store_weld(mesh, o.mesh);
    dx_offline_fini(&o);
    return rc < 0 ? dx_err_set(err, rc, "%s: the mesh: %s", a->config.path, strerror(-rc)) : 0;
}

/* The camera looks into an image of twice the size, which is then halved. */
static void aim(struct dx_camera *c, struct args *a, const struct dx_view_frame *f,
                const struct dx_mesh *mesh)
{
    uint32_t height = 2 * a->height;

    if (a->view == VIEW_SCANNER)
        dx_camera_scanner(c, f, mesh, 2 * a->width, &height);
    else
        dx_camera_orbit(c, f, mesh, 2 * a->width, &height, dx_rad(a->yaw_deg), dx_rad(a->pitch_deg),
                        a->dist_m);
    a->height = height / 2 ? height / 2 : 1;
}

static int draw(uint8_t *rgb, const struct args *a, const struct dx_mesh *mesh,
                const struct dx_camera *camera, const struct dx_view_frame *f)
{
    float *colours = malloc((size_t)mesh->n_vertices * 3 * sizeof(*colours) + 1);
    struct dx_raster raster = {0};
    int rc = colours ? dx_shade_vertices(colours, mesh, a->shade, camera, f->up) : -ENOMEM;

    if (rc == 0)
        rc = dx_raster_init(&raster, 2 * a->width, 2 * a->height, dx_shade_background);
    if (rc == 0) {
        raster.edge_px = a->edges ? 1.5f : 0;
        rc = dx_render_mesh(&raster, mesh, colours, camera);
    }
    if (rc == 0)
        dx_raster_halve(rgb, &raster);
    dx_raster_fini(&raster);
    free(colours);
    return rc;
}

static int render(struct args *a, const struct dx_mesh *mesh, struct dx_err *err)
{
    struct dx_view_frame frame;
    struct dx_camera camera;
    uint8_t *rgb;
    int rc = dx_view_frame_of(&frame, mesh);

    if (rc < 0)
        return dx_err_set(err, rc, "%s: %s", a->config.path,
                          rc == -ENODATA ? "found no triangle, expected a surface" : strerror(-rc));
    if (a->shade == DX_SHADE_ATTR && !mesh->attr)
        return dx_err_set(err, -EINVAL, "%s: found no attribute, expected one for --shade attr",
                          a->config.path);
    aim(&camera, a, &frame, mesh);
    rgb = malloc((size_t)a->width * a->height * 3);
    rc = rgb ? draw(rgb, a, mesh, &camera, &frame) : -ENOMEM;
    if (rc < 0)
        dx_err_set(err, rc, "%s: %s", a->config.path, strerror(-rc));
    else
        rc = (a->few_colours ? dx_out_png_few : dx_out_png)(a->out, rgb, a->width, a->height, err);
    free(rgb);
    return rc;
}

int cmd_render(int argc, char **argv)
{
    struct dx_mesh mesh;
    struct dx_err err;
    struct args a;
    int rc = parse(&a, argc, argv);

    if (rc != 0)
        return rc == DX_ARG_E_HELP ? 0 : 2;
    rc = load_mesh(&mesh, &a, &err);
    if (rc == 0)
        rc = render(&a, &mesh, &err);
    dx_mesh_fini(&mesh);
    if (rc < 0)
        fprintf(stderr, "dexel render: %s\n", err.text);
    return rc < 0 ? 1 : 0;
}
