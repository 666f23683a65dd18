/* A triangle is made: rings, states, the queue, the caller. */
#include "core/cloud/project_priv.h"

#include <math.h>

/* A completed point has no ring any more, which would take any triangle. */
static bool fits(const struct dx_project_run *run, uint32_t v, uint32_t a, uint32_t b)
{
    return run->state[v] != DX_COMPLETED && dx_ring_fits(&run->rings, run->point[v].ring, a, b);
}

bool dx_project_fits(const struct dx_project_run *run, uint32_t a, uint32_t b, uint32_t c)
{
    return a != b && b != c && c != a && fits(run, a, b, c) && fits(run, b, c, a) &&
           fits(run, c, a, b);
}

/* The triangle's normal, times its area: slivers, whose normals are noise, count little. */
static void add_face_normal(struct dx_project_run *run, const uint32_t v[3])
{
    const int32_t *a = run->cloud->at[v[0]], *b = run->cloud->at[v[1]], *c = run->cloud->at[v[2]];
    double p[3], q[3];

    for (int k = 0; k < 3; k++) {
        p[k] = (b[k] - a[k]) / run->spacing;
        q[k] = (c[k] - a[k]) / run->spacing;
    }
    for (int k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;

        for (int m = 0; m < 3; m++)
            run->point[v[m]].normal[k] += (float)(p[i] * q[j] - p[j] * q[i]);
    }
}

/* The plane of the reference point that makes it; it keeps its own. */
static void add_plane_normal(struct dx_project_run *run, const uint32_t v[3])
{
    for (int m = 1; m < 3; m++)
        for (int k = 0; k < 3; k++)
            run->point[v[m]].normal[k] += (float)run->normal[k];
}

void dx_project_push(struct dx_project_run *run, uint32_t v)
{
    const uint32_t n = run->cloud->n, at = run->head + run->n_queued++;

    run->queue[at < n ? at : at - n] = v;
}

uint32_t dx_project_pop(struct dx_project_run *run)
{
    const uint32_t v = run->queue[run->head];

    run->head = run->head + 1 < run->cloud->n ? run->head + 1 : 0;
    run->n_queued--;
    return v;
}

static void discover(struct dx_project_run *run, uint32_t v)
{
    run->state[v] = DX_FRINGE;
    run->point[v].reach = (float)run->reach;
    dx_project_push(run, v);
}

int dx_project_add(struct dx_project_run *run, uint32_t a, uint32_t b, uint32_t c)
{
    const uint32_t v[3] = {a, b, c};
    uint32_t of_input[3];

    for (int k = 0; k < 3; k++) {
        struct dx_project_point *p = &run->point[v[k]];
        int rc = dx_ring_add(&run->rings, &p->ring, v[(k + 1) % 3], v[(k + 2) % 3]);

        if (rc < 0)
            return rc;
        if (run->state[v[k]] == DX_FREE)
            discover(run, v[k]);
        if (rc == DX_RING_CLOSED) {
            run->state[v[k]] = DX_COMPLETED;
            dx_ring_free(&run->rings, &p->ring);
        }
        of_input[k] = run->cloud->index[v[k]];
    }
    if (run->plane == DX_PROJECT_FACES)
        add_face_normal(run, v);
    else
        add_plane_normal(run, v);
    run->stats->n_triangles++;
    return run->sink->triangle(run->sink->ctx, of_input);
}
