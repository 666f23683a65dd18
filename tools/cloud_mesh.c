/* Triangles as they come, then the vertices they use. */
#include "tools/cloud_mesh.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define STEP_OF_PROGRESS 65536 /* triangles */
#define UNUSED           UINT32_MAX
/* Lattice, index and dexels; states, queue and rings of the mode; vertices and 2 triangles. */
#define LEN_OF_POINT (18 + 33 + 4 + 12 + 24)

struct collect {
    uint32_t *index;
    size_t n, cap, expected;
    bool progress;
};

size_t dx_cloud_mesh_most_len(uint32_t n)
{
    return (size_t)n * LEN_OF_POINT;
}

static int take(void *ctx, const uint32_t v[3])
{
    struct collect *t = ctx;

    if (t->n == t->cap) {
        size_t cap = t->cap + t->cap / 2 + 1024;
        uint32_t *index = realloc(t->index, cap * 3 * sizeof(*index));

        if (!index)
            return -ENOMEM;
        t->index = index;
        t->cap = cap;
    }
    memcpy(t->index + 3 * t->n++, v, 3 * sizeof(*v));
    if (t->progress && t->n % STEP_OF_PROGRESS == 0)
        fprintf(stderr, "\r%3.0f %%", fmin(100, 100 * (double)t->n / (double)t->expected));
    return 0;
}

/* Of an axis: 0 where floats hold all the points, else a whole number near them. */
static double offset_of(const struct dx_cloud *c, const double *xyz, size_t axis)
{
    double low = INFINITY;
    bool exact = true;

    for (uint32_t r = 0; r < c->n; r++) {
        const double x = xyz[3 * (size_t)c->index[r] + axis];

        exact &= (double)(float)x == x || fabs(x) < 1024;
        low = x < low ? x : low;
    }
    return exact ? 0 : floor(low);
}

/* Where each point used goes; how many there are. */
static uint32_t number_vertices(uint32_t *to, uint32_t n_input, const struct collect *t)
{
    uint32_t n = 0;

    for (uint32_t v = 0; v < n_input; v++)
        to[v] = UNUSED;
    for (size_t k = 0; k < 3 * t->n; k++)
        to[t->index[k]] = 0;
    for (uint32_t v = 0; v < n_input; v++)
        if (to[v] != UNUSED)
            to[v] = n++;
    return n;
}

static int make(struct dx_mesh *mesh, const struct dx_cloud *c, const double *xyz,
                const struct collect *t, struct dx_out_options *write)
{
    uint32_t n_input = c->n + c->n_not_finite + c->n_duplicates;
    uint32_t *to = malloc(n_input * sizeof(*to) + 1);
    double offset[3];
    int rc;

    if (!to)
        return -ENOMEM;
    rc = dx_mesh_init(mesh, number_vertices(to, n_input, t), t->n, 0, 0);
    for (size_t k = 0; k < 3; k++) {
        offset[k] = offset_of(c, xyz, k);
        write->world |= offset[k] != 0;
    }
    memcpy(write->pose, (double[12]){1, 0, 0, offset[0], 0, 1, 0, offset[1], 0, 0, 1, offset[2]},
           sizeof(write->pose));
    for (uint32_t v = 0; rc == 0 && v < n_input; v++)
        for (size_t k = 0; k < 3 && to[v] != UNUSED; k++)
            mesh->xyz[3 * (size_t)to[v] + k] = (float)(xyz[3 * (size_t)v + k] - offset[k]);
    for (size_t k = 0; rc == 0 && k < 3 * t->n; k++)
        mesh->index[k] = to[t->index[k]];
    free(to);
    return rc;
}

int dx_cloud_mesh(struct dx_mesh *mesh, struct dx_project_stats *stats, const struct dx_cloud *c,
                  const double *xyz, const struct dx_project_config *config, bool progress,
                  struct dx_out_options *write, struct dx_err *err)
{
    struct collect t = {.expected = 2 * (size_t)c->n, .progress = progress};
    const struct dx_project_sink sink = {take, &t};
    int rc = dx_project(stats, c, config, &sink, err);

    *mesh = (struct dx_mesh){0};
    if (progress && t.n >= STEP_OF_PROGRESS)
        fprintf(stderr, "\r      \r");
    if (rc == 0) {
        rc = make(mesh, c, xyz, &t, write);
        if (rc < 0)
            dx_err_set(err, rc, "the mesh of %u points: %s", c->n, strerror(-rc));
    }
    free(t.index);
    return rc;
}
