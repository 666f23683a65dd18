/* Triangles as they come, then the vertices they use. */
#include "tools/cloud_mesh.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define STEP_OF_PROGRESS 1024 /* triangles */
#define UNUSED           UINT32_MAX

int dx_cloud_mesh_triangle(void *mesh, const uint32_t v[3])
{
    struct dx_cloud_mesh *m = mesh;

    if (m->n == m->cap) {
        size_t cap = m->cap + m->cap / 2 + 1024;
        uint32_t *index = realloc(m->index, cap * 3 * sizeof(*index));

        if (!index)
            return -ENOMEM;
        m->index = index;
        m->cap = cap;
    }
    memcpy(m->index + 3 * m->n++, v, 3 * sizeof(*v));
    if (m->progress && m->expected && m->n % STEP_OF_PROGRESS == 0)
        dx_progress_share(m->progress, (double)m->n / (double)m->expected);
    return 0;
}

void dx_cloud_mesh_points(struct dx_cloud_mesh *m, double *xyz, float *normal, uint32_t n)
{
    free(m->xyz);
    free(m->normal);
    m->xyz = xyz;
    m->normal = normal;
    m->n_points = n;
}

/* Which vertex a point becomes; how many there are. */
static uint32_t number_vertices(uint32_t *to, size_t n_points, const struct dx_cloud_mesh *m)
{
    uint32_t n = 0;

    for (size_t v = 0; v < n_points; v++)
        to[v] = m->xyz ? 0 : UNUSED;
    for (size_t k = 0; k < 3 * m->n; k++)
        to[m->index[k]] = 0;
    for (size_t v = 0; v < n_points; v++)
        if (to[v] != UNUSED)
            to[v] = n++;
    return n;
}

/* Of an axis: 0 where floats hold all the vertices, else a whole number near them. */
static double offset_of(const uint32_t *to, const double *xyz, size_t n_points, size_t axis)
{
    double low = INFINITY;
    bool exact = true;

    for (size_t v = 0; v < n_points; v++) {
        const double x = xyz[3 * v + axis];

        if (to[v] == UNUSED)
            continue;
        exact &= (double)(float)x == x || fabs(x) < 1024;
        low = x < low ? x : low;
    }
    return exact ? 0 : floor(low);
}

static void put_vertices(struct dx_mesh *mesh, const uint32_t *to, const double *xyz,
                         size_t n_points, struct dx_out_options *write)
{
    double offset[3];

    for (size_t k = 0; k < 3; k++) {
        offset[k] = offset_of(to, xyz, n_points, k);
        write->world |= offset[k] != 0;
    }
    memcpy(write->pose, (double[12]){1, 0, 0, offset[0], 0, 1, 0, offset[1], 0, 0, 1, offset[2]},
           sizeof(write->pose));
    for (size_t v = 0; v < n_points; v++)
        for (size_t k = 0; k < 3 && to[v] != UNUSED; k++)
            mesh->xyz[3 * (size_t)to[v] + k] = (float)(xyz[3 * v + k] - offset[k]);
}

/* The triangles of `m`, by the numbers of vertices: there may be no room for two of them. */
static void move_triangles(struct dx_mesh *mesh, struct dx_cloud_mesh *m, const uint32_t *to)
{
    uint32_t *fit = realloc(m->index, 3 * m->n * sizeof(*m->index) + 1);

    mesh->index = fit ? fit : m->index;
    mesh->n_triangles = (uint32_t)m->n;
    for (size_t k = 0; k < 3 * m->n; k++)
        mesh->index[k] = to[mesh->index[k]];
    m->index = NULL;
    m->n = m->cap = 0;
}

int dx_cloud_mesh_make(struct dx_mesh *mesh, struct dx_cloud_mesh *m, const double *xyz,
                       size_t n_input, struct dx_out_options *write)
{
    const size_t n_points = m->xyz ? m->n_points : n_input;
    uint32_t *to = malloc(n_points * sizeof(*to) + 1);
    int rc;

    *mesh = (struct dx_mesh){0};
    if (!to)
        return -ENOMEM;
    rc = m->n > DX_MESH_MAX_TRIANGLES
             ? -EINVAL
             : dx_mesh_init(mesh, number_vertices(to, n_points, m), 0, 0, 0);
    if (rc == 0 && m->xyz && m->normal)
        rc = dx_mesh_add_normals(mesh);
    if (rc == 0) {
        put_vertices(mesh, to, m->xyz ? m->xyz : xyz, n_points, write);
        if (mesh->normal && m->normal)
            memcpy(mesh->normal, m->normal, 3 * n_points * sizeof(*m->normal));
        free(mesh->index);
        move_triangles(mesh, m, to);
    } else
        dx_mesh_fini(mesh);
    free(to);
    return rc;
}

void dx_cloud_mesh_fini(struct dx_cloud_mesh *m)
{
    free(m->index);
    free(m->xyz);
    free(m->normal);
    *m = (struct dx_cloud_mesh){0};
}
