/* Parts of growing: one run, owned by the one thread of dx_grow. */
#ifndef DX_GROW_PRIV_H
#define DX_GROW_PRIV_H

#include "core/cloud/grow.h"

struct dx_grow_run {
    const struct dx_cloud *cloud;
    const struct dx_neighbours *nb;
    const struct dx_grow_config *config;
    struct dx_halfedges *mesh;
    struct dx_grow_stats *stats;
    double (*normal)[3]; /* [n] sum of the unit normals of a point's triangles */
    uint32_t *queue;     /* half-edges, borders when they were put in */
    uint32_t head, tail, cap;
    uint32_t round;
    uint32_t n_bends;
    double cos_bend[DX_GROW_MAX_BENDS]; /* falling */
    double cos_angle, cos_lean;
};

static inline bool dx_grow_is_used(const struct dx_grow_run *run, uint32_t v)
{
    return run->mesh->out[v] != DX_NO_HALFEDGE;
}

static inline void dx_grow_between(double d[3], const struct dx_grow_run *run, uint32_t from,
                                   uint32_t to)
{
    const int32_t *p = run->cloud->at[from], *q = run->cloud->at[to];

    for (int k = 0; k < 3; k++)
        d[k] = (double)q[k] - p[k];
}

static inline double dx_grow_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void dx_grow_cross(double out[3], const double a[3], const double b[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

/* Unit normal of a triangle, or 0 0 0. */
void dx_grow_face_normal(double n[3], const struct dx_grow_run *run, uint32_t a, uint32_t b,
                         uint32_t c);

/* grow.c: the triangle on the left of border half-edge b; pushes its borders. Errors: -ENOMEM. */
int dx_grow_add(struct dx_grow_run *run, uint32_t b, uint32_t q, uint32_t corner);

/* grow_point.c: the point for border half-edge b, or DX_NO_HALFEDGE; *corner as
 * dx_halfedge_fits. */
uint32_t dx_grow_point(const struct dx_grow_run *run, uint32_t b, uint32_t *corner);
/* How long the edges of a triangle beside edge (u, v) may be, steps. */
double dx_grow_reach(const struct dx_grow_run *run, uint32_t u, uint32_t v);

/* grow_seed.c: the first triangle of another component, at point p of those without triangles.
 * False: there is none. */
bool dx_grow_seed(const struct dx_grow_run *run, uint32_t v[3], uint32_t p);

/* grow_sight.c: triangle (u, v, t) overlaps the stars of none of the points near it, seen along
 * their normals; of border points alone, or of all. */
bool dx_grow_is_clear(const struct dx_grow_run *run, const uint32_t v[3], bool all);
/* The gap of q in which both u and v lie, seen along its normal, or DX_NO_HALFEDGE. */
uint32_t dx_grow_gap(const struct dx_grow_run *run, uint32_t q, uint32_t u, uint32_t v);

/* grow_loops.c: closes small holes. Errors: -ENOMEM. */
int dx_grow_close_loops(struct dx_grow_run *run);

#endif
