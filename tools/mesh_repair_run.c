/* dexel mesh --repair: what it is asked, what it tells. */
#include "tools/mesh_repair_run.h"

#include "drivers/file/triangles.h"
#include "tools/args.h"
#include "tools/cloud_mesh.h"
#include "tools/stats_json.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

static const char help[] =
    "usage: dexel mesh --repair IN -o OUT.{ply,obj,stl} [OPTIONS]\n"
    "Mends any mesh: PLY, OBJ or STL, each plain or .gz. The outcome is a manifold whose triangles "
    "agree\n"
    "on their side.\n\n"
    "  -o OUT              the mesh; may be left out with --stats\n"
    "  --repair-holes N    close holes of at most N edges, 0 to 64 (16)\n"
    "  --ascii             PLY as text\n"
    "  --stats             one JSON object on standard output\n";

enum { OPT_ASCII = 256, OPT_STATS, OPT_HELP };

static const struct option options[] = {
    {"ascii", no_argument, NULL, OPT_ASCII},
    {"stats", no_argument, NULL, OPT_STATS},
    {"help", no_argument, NULL, OPT_HELP},
    DX_REPAIR_OPTIONS,
    {0},
};

struct args {
    struct dx_mesh_repair_args repair;
    const char *path, *out;
    bool ascii, stats;
};

/* ---- as an option --------------------------------------------------------------------------- */

void dx_mesh_repair_args_default(struct dx_mesh_repair_args *a)
{
    *a = (struct dx_mesh_repair_args){.max_hole = DX_MESH_REPAIR_HOLE};
}

int dx_mesh_repair_args_set(struct dx_mesh_repair_args *a, int opt, const char *text)
{
    uint64_t n = 0;
    int rc;

    a->asked = true;
    if (opt == DX_OPTION_REPAIR)
        return 0;
    rc = dx_arg_u64(&n, &(struct dx_arg){"dexel mesh", "--repair-holes", text}, 0,
                    DX_MESH_REPAIR_MAX_HOLE, "edges");
    a->max_hole = (uint32_t)n;
    return rc;
}

static void tell(const struct dx_mesh_repair *c, const char *path)
{
    const struct {
        uint32_t n;
        const char *what;
    } rows[] = {
        {c->degenerate, "triangles of two equal corners left out"},
        {c->duplicate, "triangles left out that were there already"},
        {c->nonmanifold, "edges of three and more triangles told apart"},
        {c->turned, "triangles turned"},
        {c->cut, "edges cut of a surface with one side"},
        {c->split, "vertices added for fans that shared one"},
        {c->removed, "triangles left out of edges that could not be told apart"},
        {c->holes, "holes closed"},
    };
    const char *between = ": ";

    fprintf(stderr, "%s: repair", path);
    for (size_t k = 0; k < sizeof(rows) / sizeof(rows[0]); k++)
        if (rows[k].n) {
            fprintf(stderr, "%s%u %s", between, rows[k].n, rows[k].what);
            between = ", ";
        }
    fprintf(stderr, "%s\n", between[0] == ':' ? ": nothing to mend" : "");
}

int dx_mesh_repair_run(struct dx_mesh *mesh, struct dx_mesh_repair *counts,
                       const struct dx_mesh_repair_args *a, const char *path, struct dx_err *err)
{
    int rc;

    *counts = (struct dx_mesh_repair){0};
    if (!a->asked)
        return 0;
    rc = dx_mesh_repair(mesh, a->max_hole, counts);
    if (rc < 0)
        return dx_err_set(err, rc, "%s: the repair: %s", path, strerror(-rc));
    tell(counts, path);
    return 0;
}

json_t *dx_mesh_repair_json(const struct dx_mesh_repair *c)
{
    return json_pack("{s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:I}", "degenerate",
                     (json_int_t)c->degenerate, "duplicate", (json_int_t)c->duplicate,
                     "nonmanifold", (json_int_t)c->nonmanifold, "turned", (json_int_t)c->turned,
                     "cut", (json_int_t)c->cut, "split", (json_int_t)c->split, "removed",
                     (json_int_t)c->removed, "holes", (json_int_t)c->holes, "hole_triangles",
                     (json_int_t)c->hole_triangles);
}

/* ---- as a command --------------------------------------------------------------------------- */

bool dx_mesh_repair_asked(int argc, char **argv)
{
    bool asked = false;

    for (int k = 1; k < argc; k++) {
        asked |= strcmp(argv[k], "--repair") == 0;
        if (strncmp(argv[k], "--mode", 6) == 0)
            return false;
    }
    return asked;
}

static int parse(struct args *a, int argc, char **argv)
{
    struct dx_err err;
    int opt;

    *a = (struct args){0};
    dx_mesh_repair_args_default(&a->repair);
    while ((opt = getopt_long(argc, argv, "o:", options, NULL)) != -1) {
        if (opt == OPT_HELP)
            return dx_arg_help(help);
        if (opt == 'o')
            a->out = optarg;
        else if (opt == OPT_ASCII)
            a->ascii = true;
        else if (opt == OPT_STATS)
            a->stats = true;
        else if (opt < DX_OPTION_REPAIR || dx_mesh_repair_args_set(&a->repair, opt, optarg) < 0)
            return -EINVAL;
    }
    a->path = dx_arg_operand(argc, argv, "a mesh");
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

static int load(struct dx_mesh *mesh, const char *path, struct dx_out_options *write,
                struct dx_err *err)
{
    struct dx_triangle_list triangles = {0};
    struct dx_point_list points = {0};
    struct dx_cloud_mesh all;
    int rc = dx_triangle_list_read(&triangles, &points, path, err);

    if (rc < 0)
        return rc;
    all = (struct dx_cloud_mesh){.index = triangles.index, .n = triangles.n};
    rc = dx_cloud_mesh_make(mesh, &all, points.xyz, points.n, write);
    if (rc < 0)
        dx_err_set(err, rc, "%s: %s", path, strerror(-rc));
    dx_cloud_mesh_fini(&all);
    dx_point_list_fini(&points);
    return rc;
}

static int print_stats(const struct dx_mesh *mesh, const struct dx_mesh_repair *counts)
{
    struct dx_mesh_stats stats;
    json_t *j;

    if (dx_mesh_stats_compute(&stats, mesh) < 0) {
        fprintf(stderr, "dexel mesh: out of memory\n");
        return -ENOMEM;
    }
    j = dx_stats_json(&stats);
    json_object_set_new(j, "repair", dx_mesh_repair_json(counts));
    return dx_json_print(j, "dexel mesh");
}

static int run(const struct args *a, struct dx_err *err)
{
    struct dx_out_options write = {.ascii = a->ascii};
    struct dx_mesh_repair counts;
    struct dx_mesh mesh = {0};
    int rc = load(&mesh, a->path, &write, err);

    if (rc == 0)
        rc = dx_mesh_repair_run(&mesh, &counts, &a->repair, a->path, err);
    if (rc == 0 && a->out)
        rc = dx_out_mesh(a->out, &mesh, &write, err);
    if (rc == 0 && a->stats && print_stats(&mesh, &counts) < 0)
        rc = dx_err_set(err, -EIO, "no statistics");
    dx_mesh_fini(&mesh);
    return rc;
}

int dx_mesh_repair_command(int argc, char **argv)
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
