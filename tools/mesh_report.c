/* dexel mesh --report: what it is asked, what it measures, what it tells. */
#include "tools/mesh_report.h"

#include "drivers/file/triangles.h"
#include "tools/args.h"
#include "tools/mesh_crossings.h"
#include "tools/mesh_distance.h"
#include "tools/mesh_topology.h"
#include "tools/stats_json.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#define DEGREES   (180 / 3.14159265358979324)
#define SHARP_DEG 10 /* triangles with a smaller angle are counted */

static const char help[] =
    "usage: dexel mesh --report MESH [OPTIONS]\n"
    "Tells what a mesh file is, in numbers: PLY, OBJ or STL, each plain or .gz.\n\n"
    "  --points FILE       distances of these points to the mesh: any file of points\n"
    "  --stats             one JSON object on standard output\n";

enum { OPT_REPORT = 256, OPT_POINTS, OPT_STATS, OPT_HELP };

static const struct option options[] = {
    {"report", no_argument, NULL, OPT_REPORT},
    {"points", required_argument, NULL, OPT_POINTS},
    {"stats", no_argument, NULL, OPT_STATS},
    {"help", no_argument, NULL, OPT_HELP},
    {0},
};

struct args {
    const char *path, *points;
    bool stats;
};

struct report {
    size_t n_vertices;   /* in the file, used or not */
    uint32_t degenerate; /* triangles of which two corners are the same; left out of the rest */
    struct dx_mesh_stats stats;
    struct dx_mesh_topology topology;
    struct dx_mesh_crossings crossings;
    double min_deg, max_deg;
    uint32_t n_sharp;
    struct {
        size_t n;
        double max, rms;
    } distance;
};

bool dx_mesh_report_asked(int argc, char **argv)
{
    for (int k = 1; k < argc; k++)
        if (strcmp(argv[k], "--report") == 0)
            return true;
    return false;
}

static int parse(struct args *a, int argc, char **argv)
{
    int opt;

    *a = (struct args){0};
    while ((opt = getopt_long(argc, argv, "", options, NULL)) != -1) {
        if (opt == OPT_HELP)
            return dx_arg_help(help);
        if (opt == OPT_POINTS)
            a->points = optarg;
        else if (opt == OPT_STATS)
            a->stats = true;
        else if (opt != OPT_REPORT)
            return -EINVAL; /* getopt_long has said so */
    }
    a->path = dx_arg_operand(argc, argv, "a mesh");
    return a->path ? 0 : -EINVAL;
}

/* ---- measuring ------------------------------------------------------------------------------ */

/* Triangles of three different corners move to the front. */
static void drop_degenerate(struct report *r, struct dx_triangle_list *t)
{
    size_t n = 0;

    for (size_t k = 0; k < t->n; k++) {
        const uint32_t *v = t->index + 3 * k;

        if (v[0] != v[1] && v[1] != v[2] && v[2] != v[0])
            memmove(t->index + 3 * n++, v, 3 * sizeof(*v));
    }
    r->degenerate = (uint32_t)(t->n - n);
    t->n = n;
}

static int measure_topology(struct report *r, const struct dx_point_list *points,
                            const struct dx_triangle_list *t)
{
    struct dx_mesh mesh;
    int rc = dx_mesh_init(&mesh, points->n, t->n, 0, 0);

    if (rc < 0)
        return rc;
    for (size_t k = 0; k < 3 * points->n; k++)
        mesh.xyz[k] = (float)points->xyz[k];
    if (t->n)
        memcpy(mesh.index, t->index, 3 * t->n * sizeof(*t->index));
    rc = dx_mesh_stats_compute(&r->stats, &mesh);
    if (rc == 0)
        rc = dx_mesh_topology_compute(&r->topology, &mesh);
    dx_mesh_fini(&mesh);
    return rc;
}

/* Between the sides to b and c. */
static double angle_deg(const double *a, const double *b, const double *c)
{
    const double u[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    const double v[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
    const double x = u[1] * v[2] - u[2] * v[1], y = u[2] * v[0] - u[0] * v[2],
                 z = u[0] * v[1] - u[1] * v[0];

    return DEGREES * atan2(sqrt(x * x + y * y + z * z), u[0] * v[0] + u[1] * v[1] + u[2] * v[2]);
}

static void measure_angles(struct report *r, const struct dx_point_list *points,
                           const struct dx_triangle_list *t)
{
    r->min_deg = t->n ? 180 : 0;
    for (size_t k = 0; k < t->n; k++) {
        const double *p[3];
        double least = 180;

        for (size_t i = 0; i < 3; i++)
            p[i] = points->xyz + 3 * (size_t)t->index[3 * k + i];
        for (int i = 0; i < 3; i++) {
            const double angle = angle_deg(p[i], p[(i + 1) % 3], p[(i + 2) % 3]);

            least = fmin(least, angle);
            r->max_deg = fmax(r->max_deg, angle);
        }
        r->min_deg = fmin(r->min_deg, least);
        r->n_sharp += least < SHARP_DEG;
    }
}

static int measure_distances(struct report *r, const struct dx_point_list *points,
                             const struct dx_triangle_list *t, const char *path, struct dx_err *err)
{
    struct dx_point_list from = {0};
    struct dx_triangle_tree d = {0};
    double sum2 = 0;
    int rc = dx_point_list_read(&from, path, err);

    if (rc == 0 && t->n) {
        rc = dx_triangle_tree_init(&d, points->xyz, t->index, t->n);
        if (rc < 0)
            dx_err_set(err, rc, "distances: %s", strerror(-rc));
    }
    for (size_t k = 0; rc == 0 && t->n && k < from.n; k++) {
        const double *p = from.xyz + 3 * k;
        double x;

        if (!isfinite(p[0]) || !isfinite(p[1]) || !isfinite(p[2]))
            continue;
        x = dx_mesh_distance_to(&d, p);
        r->distance.n++;
        r->distance.max = fmax(r->distance.max, x);
        sum2 += x * x;
    }
    if (r->distance.n)
        r->distance.rms = sqrt(sum2 / (double)r->distance.n);
    dx_triangle_tree_fini(&d);
    dx_point_list_fini(&from);
    return rc;
}

static int measure(struct report *r, const struct args *a, struct dx_err *err)
{
    struct dx_triangle_list triangles = {0};
    struct dx_point_list points = {0};
    int rc = dx_triangle_list_read(&triangles, &points, a->path, err);

    *r = (struct report){.n_vertices = points.n};
    if (rc == 0) {
        drop_degenerate(r, &triangles);
        rc = measure_topology(r, &points, &triangles);
        if (rc == 0)
            rc = dx_mesh_crossings_count(&r->crossings, points.xyz, triangles.index, triangles.n);
        if (rc < 0)
            dx_err_set(err, rc, "%s: %s", a->path, strerror(-rc));
    }
    if (rc == 0) {
        measure_angles(r, &points, &triangles);
        if (a->points)
            rc = measure_distances(r, &points, &triangles, a->points, err);
    }
    dx_triangle_list_fini(&triangles);
    dx_point_list_fini(&points);
    return rc;
}

/* ---- telling -------------------------------------------------------------------------------- */

static bool is_manifold(const struct report *r)
{
    return r->stats.nonmanifold_edges == 0 && r->topology.nonmanifold_vertices == 0;
}

static double share_sharp(const struct report *r)
{
    return r->stats.triangles ? (double)r->n_sharp / r->stats.triangles : 0;
}

static int print_json(const struct report *r, bool distances)
{
    json_t *j = dx_stats_json(&r->stats);

    json_object_set_new(j, "vertices", json_integer((json_int_t)r->n_vertices));
    json_object_set_new(j, "degenerate", json_integer(r->degenerate));
    json_object_set_new(j, "nonmanifold_vertices", json_integer(r->topology.nonmanifold_vertices));
    json_object_set_new(j, "manifold", json_boolean(is_manifold(r)));
    json_object_set_new(j, "oriented", json_boolean(r->stats.duplicate_directed_edges == 0));
    json_object_set_new(j, "boundary_loops", json_integer(r->topology.boundary_loops));
    json_object_set_new(j, "longest_loop", json_integer(r->topology.longest_loop));
    json_object_set_new(j, "crossing_triangles", json_integer(r->crossings.n_triangles));
    json_object_set_new(j, "min_angle_deg", json_real(r->min_deg));
    json_object_set_new(j, "max_angle_deg", json_real(r->max_deg));
    json_object_set_new(j, "share_below_10_deg", json_real(share_sharp(r)));
    if (distances)
        json_object_set_new(j, "distance",
                            json_pack("{s:I, s:f, s:f}", "points", (json_int_t)r->distance.n, "max",
                                      r->distance.max, "rms", r->distance.rms));
    return dx_json_print(j, "dexel mesh");
}

static void print_text(const struct report *r, const struct args *a)
{
    const struct dx_mesh_stats *s = &r->stats;

    printf("%s: %zu vertices, %u used; %u triangles", a->path, r->n_vertices, s->points,
           s->triangles);
    if (r->degenerate)
        printf(", and %u with two equal corners", r->degenerate);
    printf("\n  manifold      %s: %" PRIu64 " edges of three and more triangles, %u vertices of "
           "several fans\n",
           is_manifold(r) ? "yes" : "no", s->nonmanifold_edges, r->topology.nonmanifold_vertices);
    printf("  orientation   %s: %" PRIu64 " times an edge twice in one direction\n",
           s->duplicate_directed_edges ? "not consistent" : "consistent",
           s->duplicate_directed_edges);
    printf("  boundary      %" PRIu64 " edges in %u loops, the longest of %u\n", s->boundary_edges,
           r->topology.boundary_loops, r->topology.longest_loop);
    printf("  components    %u; Euler characteristic %" PRId64 "\n", s->components, s->euler);
    printf("  crossings     %u triangles go through others, in %" PRIu64 " pairs\n",
           r->crossings.n_triangles, r->crossings.n_pairs);
    printf("  angles        %.3g to %.4g degrees; %.3g %% of the triangles have one below %d\n",
           r->min_deg, r->max_deg, 100 * share_sharp(r), SHARP_DEG);
    if (a->points)
        printf("  distance      of %zu points: at most %.6g, rms %.6g\n", r->distance.n,
               r->distance.max, r->distance.rms);
}

int dx_mesh_report(int argc, char **argv)
{
    struct dx_err err = {""};
    struct report r;
    struct args a;
    int rc = parse(&a, argc, argv);

    if (rc != 0)
        return rc == DX_ARG_E_HELP ? 0 : 2;
    if (measure(&r, &a, &err) < 0) {
        fprintf(stderr, "dexel mesh: %s\n", err.text);
        return 1;
    }
    if (a.stats)
        return print_json(&r, a.points) < 0 ? 1 : 0;
    print_text(&r, &a);
    return 0;
}
