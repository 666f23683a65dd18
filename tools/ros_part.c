/* Parts of a mesh. */
#include "tools/ros_part.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

int dx_ros_part_new(struct dx_ros_part **out, uint32_t max_vertices)
{
    struct dx_ros_part *p = calloc(1, sizeof(*p));

    if (!p)
        return -ENOMEM;
    p->max_vertices = max_vertices;
    p->max_indices = 6 * max_vertices;
    p->xyz = malloc(3 * (size_t)p->max_vertices * sizeof(*p->xyz));
    p->index = malloc((size_t)p->max_indices * sizeof(*p->index));
    if (!p->xyz || !p->index) {
        dx_ros_part_free(p);
        return -ENOMEM;
    }
    *out = p;
    return 0;
}

void dx_ros_part_free(struct dx_ros_part *p)
{
    if (!p)
        return;
    free(p->xyz);
    free(p->index);
    free(p->map);
    free(p);
}

int dx_ros_part_begin(struct dx_ros_part *p, const struct dx_mesh *mesh)
{
    if (mesh->n_vertices > p->map_cap) {
        free(p->map);
        p->map = malloc((size_t)mesh->n_vertices * sizeof(*p->map));
        p->map_cap = p->map ? mesh->n_vertices : 0;
        if (!p->map)
            return -ENOMEM;
    }
    if (mesh->n_vertices)
        memset(p->map, 0, (size_t)mesh->n_vertices * sizeof(*p->map));
    p->base = 1; /* above all that is in the map */
    p->n_vertices = p->n_indices = 0;
    return 0;
}

/* Vertices of the triangle that the part does not have yet. */
static uint32_t n_new(const struct dx_ros_part *p, const uint32_t *corner)
{
    uint32_t n = 0;

    for (int k = 0; k < 3; k++)
        n += p->map[corner[k]] < p->base;
    return n;
}

static void add(struct dx_ros_part *p, const struct dx_mesh *mesh, const uint32_t *corner)
{
    for (int k = 0; k < 3; k++) {
        uint32_t v = corner[k];

        if (p->map[v] < p->base) {
            memcpy(p->xyz + 3 * (size_t)p->n_vertices, mesh->xyz + 3 * (size_t)v,
                   3 * sizeof(*p->xyz));
            p->map[v] = p->base + p->n_vertices++;
        }
        p->index[p->n_indices++] = p->map[v] - p->base;
    }
}

uint32_t dx_ros_part_next(struct dx_ros_part *p, const struct dx_mesh *mesh, uint32_t first)
{
    p->base += p->n_vertices;
    p->n_vertices = p->n_indices = 0;
    for (; first < mesh->n_triangles; first++) {
        const uint32_t *corner = mesh->index + 3 * (size_t)first;

        if (p->n_vertices + n_new(p, corner) > p->max_vertices || p->n_indices + 3 > p->max_indices)
            break;
        add(p, mesh, corner);
    }
    return first;
}
