/*
 * A mesh that grows triangle by triangle at its border (Mederos, Velho and de Figueiredo, section
 * 2.4): the point for a border edge is the one that sees it at the widest angle among those that
 * bend the mesh least, make no triangle too long or too blunt, and none that overlaps the mesh. For
 * the few points that represent a large cloud. One thread; the same bytes for the same points.
 */
#ifndef DX_GROW_H
#define DX_GROW_H

#include "core/cloud/halfedge.h"
#include "core/cloud/neighbours.h"

#define DX_GROW_MAX_LOOP  64
#define DX_GROW_K         16 /* neighbours of each point that are looked at */
#define DX_GROW_MAX_BENDS 32

struct dx_grow_config {
    double bend_deg;      /* of the mesh at an edge: tried first */
    double bend_step_deg; /* more, while no point is found */
    double max_bend_deg;
    double max_angle_deg; /* at the ends of the edge */
    double max_ratio;     /* of a new edge to the distance of the nearest point at its ends */
    uint32_t n_rounds;   /* border edges are tried again: then by the mean distance of neighbours */
    double max_lean_deg; /* of a triangle from the normals of its points, where they are given */
    uint32_t max_loop;   /* holes of at most so many edges are closed in the end; 0: none */
    /* [n] by rank, in the cloud's axes, either side, 0 0 0: none; or NULL */
    const float (*normal)[3];
    const double *viewpoint; /* [3] of the input, first triangles face it; NULL: they face +depth at
                                the highest point, the outside of what is closed */
};

struct dx_grow_stats {
    uint32_t n_triangles, n_components;
    uint32_t n_loop_triangles; /* of n_triangles, to close holes */
    uint32_t n_unused;         /* points */
    uint32_t n_border;         /* edges */
};

void dx_grow_defaults(struct dx_grow_config *config);

/*
 * Makes *m, whose vertices are the ranks of the cloud; a vertex may be shared by fans. `nb`: the
 * cloud's neighbours, DX_GROW_K of each if there are so many. Errors: -EINVAL, -ENOMEM; then *m is
 * zeroed.
 */
int dx_grow(struct dx_halfedges *m, struct dx_grow_stats *stats, const struct dx_cloud *cloud,
            const struct dx_neighbours *nb, const struct dx_grow_config *config,
            struct dx_err *err);

#endif
