/* A cloud's mesh: triangles collected from the mode that makes them, then the vertices they use.
 * One thread. */
#ifndef DX_CLOUD_MESH_H
#define DX_CLOUD_MESH_H

#include "tools/out_mesh.h"
#include "tools/progress.h"

struct dx_cloud_mesh {
    uint32_t *index; /* [n][3], the mode's, of the input's points or of those it gave */
    size_t n, cap;
    size_t expected; /* triangles, for the progress; 0: not known */
    struct dx_progress *progress;
    double *xyz; /* [n_points][3] vertices that a mode gave; NULL: the input's */
    float *normal;
    uint32_t n_points;
    uint32_t n_pinched; /* points in which several fans of triangles meet, as the mode tells */
};

/* Takes a triangle, as numbers of points, to the left around it seen from outside. The first
 * argument is the struct: so it is a mode's sink as it stands. Errors: -ENOMEM. */
int dx_cloud_mesh_triangle(void *mesh, const uint32_t v[3]);

/* Triangles are of these points, not of the input's: all of them are vertices, also those that no
 * triangle uses. normal (may be NULL) is [n][3], of unit length. Both arrays (from malloc) are the
 * mesh's from now on. */
void dx_cloud_mesh_points(struct dx_cloud_mesh *m, double *xyz, float *normal, uint32_t n);

/*
 * The mesh as it is written: of the input's points xyz[n_input] those that a triangle uses, in
 * their order; or all that the mode gave. Where floats do not hold the points, vertices are
 * relative to a whole offset, which `write` adds again. The triangles move from m to the mesh.
 * Errors: -EINVAL (too many), -ENOMEM; then *mesh is zeroed.
 */
int dx_cloud_mesh_make(struct dx_mesh *mesh, struct dx_cloud_mesh *m, const double *xyz,
                       size_t n_input, struct dx_out_options *write);
void dx_cloud_mesh_fini(struct dx_cloud_mesh *m);

#endif
