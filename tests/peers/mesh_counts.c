/*
 * Counts of a mesh that somebody wrote as PLY, by the code of `dexel mesh --stats`, so that meshes
 * of different programs are judged alike. compare_scans.sh runs it.
 *
 * Output: "POINTS TRIANGLES BOUNDARY_EDGES COMPONENTS NONMANIFOLD_EDGES GRAZING": points are those
 * that a triangle uses; grazing triangles are seen at more than 85 degrees from the origin, where
 * the scanner stood.
 */
#include "tools/mesh_stats.h"
#include "tools/ply_read.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define COS_GRAZING 0.08715574274765817 /* of 85 degrees */

static bool grazes(const struct dx_mesh *m, const uint32_t corner[3])
{
    double a[3], u[3], v[3], n[3], along, length = 0, range = 0;

    for (int k = 0; k < 3; k++) {
        a[k] = (double)m->xyz[3 * (size_t)corner[0] + (size_t)k];
        u[k] = (double)m->xyz[3 * (size_t)corner[1] + (size_t)k] - a[k];
        v[k] = (double)m->xyz[3 * (size_t)corner[2] + (size_t)k] - a[k];
    }
    along = 0;
    for (int k = 0; k < 3; k++) {
        int p = (k + 1) % 3, q = (k + 2) % 3;

        n[k] = u[p] * v[q] - u[q] * v[p];
        along += n[k] * a[k];
        length += n[k] * n[k];
        range += a[k] * a[k];
    }
    return fabs(along) < COS_GRAZING * sqrt(length * range);
}

int main(int argc, char **argv)
{
    struct dx_mesh_stats s;
    struct dx_mesh mesh;
    struct dx_err err;
    uint32_t n_grazing = 0;
    int rc;

    if (argc != 2) {
        fprintf(stderr, "usage: mesh_counts MESH.ply\n");
        return 2;
    }
    rc = dx_ply_read(&mesh, argv[1], &err);
    if (rc < 0) {
        fprintf(stderr, "mesh_counts: %s: %s\n", argv[1], err.text);
        return 1;
    }
    rc = dx_mesh_stats_compute(&s, &mesh);
    for (size_t t = 0; t < mesh.n_triangles; t++)
        n_grazing += grazes(&mesh, mesh.index + 3 * t);
    if (rc < 0)
        fprintf(stderr, "mesh_counts: %s: %s\n", argv[1], strerror(-rc));
    else
        printf("%u %u %llu %u %llu %u\n", s.points, s.triangles,
               (unsigned long long)s.boundary_edges, s.components,
               (unsigned long long)s.nonmanifold_edges, n_grazing);
    dx_mesh_fini(&mesh);
    return rc < 0 ? 1 : 0;
}
