/*
 * Refining a mesh to the cloud it stands for (Mederos, Velho and de Figueiredo, section 2.5): an
 * edge whose middle is off the points gets a vertex there, which Q takes to them, and diagonals are
 * flipped to the shorter ones. What edges need is found over the pool, the mesh is changed by one
 * thread: the same bytes for any number of them.
 */
#ifndef DX_REFINE_H
#define DX_REFINE_H

#include "core/cloud/halfedge.h"
#include "core/cloud/smooth_cloud.h"

/* A mesh with places, in steps of the cloud that it stands for. */
struct dx_surface_mesh {
    struct dx_halfedges edges;
    double (*at)[3]; /* [edges.n_vertices] */
    uint32_t cap;
};

struct dx_refine_config {
    double tolerance;    /* spacings from the points that are no reason to refine */
    double min_ratio;    /* of the shortest to the longest edge of a triangle that is divided */
    double max_turn_deg; /* of the normal of a triangle that is divided, or flipped */
    uint32_t max_sweeps; /* of flips, while there are some */
};

struct dx_refine_stats {
    uint32_t n_edges, n_off;   /* looked at; off the points */
    uint32_t n_split, n_flips; /* done */
    uint32_t n_sweeps;
};

void dx_refine_defaults(struct dx_refine_config *config);

/* One pass over the edges that there are. Vertices have one fan. Errors: -EINVAL (a parameter out
 * of its range), -ENOMEM. */
int dx_refine(struct dx_surface_mesh *mesh, struct dx_refine_stats *stats,
              const struct dx_cloud *cloud, const struct dx_cloud_smooth_scale *scale,
              const struct dx_refine_config *config, struct dx_pool *pool, struct dx_err *err);

/* refine_flip.c: flips alone. */
void dx_refine_flip(struct dx_surface_mesh *mesh, struct dx_refine_stats *stats,
                    const struct dx_refine_config *config);

/* Normals of the vertices: mean of their triangles', unit length or 0 0 0; normal[n_vertices]. */
void dx_surface_normals(double (*normal)[3], const struct dx_surface_mesh *mesh);

void dx_surface_mesh_fini(struct dx_surface_mesh *mesh);

#endif
