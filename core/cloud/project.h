/*
 * The projection-based mesh of an unorganized cloud (Gopi and Krishnan, "A Fast and Efficient
 * Projection-Based Approach for Surface Reconstruction", 2002). From a seed on, each point is in
 * turn the reference point: the points near it and the edges of the mesh so far are projected on
 * its tangent plane, and the triangles that it lacks are made with what it sees there. Triangles go
 * to the caller as they are made; only the rings of unfinished points are kept. What the paper
 * leaves open is told in docs/clouds.md. One thread; the same bytes for the same points.
 */
#ifndef DX_PROJECT_H
#define DX_PROJECT_H

#include "core/cloud/cloud.h"

#define DX_PROJECT_MAX_LOOP 32

/* Which of the points that R sees becomes the neighbour after P (section 4.1, figure 3). */
enum dx_project_choice {
    DX_PROJECT_WIDEST, /* the one that sees R and P at the widest angle: a local Delaunay star */
    DX_PROJECT_NEXT,   /* the next by angle: all that are visible, the paper without beta */
    DX_PROJECT_BETA,   /* the paper's angle criterion */
};

enum dx_project_plane {
    DX_PROJECT_FIT,   /* fitted to the points near R */
    DX_PROJECT_FACES, /* mean normal of R's triangles, the paper's */
    DX_PROJECT_AXIS,  /* that of XY, YZ and ZX which is nearest to the fitted one, section 6.1 */
};

struct dx_project_config {
    double mu;        /* radius of influence over the distance of the nearest point, at least 1 */
    double alpha_deg; /* no wider angle at the reference point */
    double beta_deg;  /* DX_PROJECT_BETA: narrower ones are avoided */
    double max_edge;  /* in the input's unit; 0: no bound */
    enum dx_project_choice choice;
    enum dx_project_plane plane;
    uint32_t max_loop; /* holes of at most so many edges are closed at the end; 0: none */
    bool has_seed;     /* start at this point of the input (section 6.2) */
    uint32_t seed;
    const double *viewpoint; /* [3], triangles face it; NULL: first normals point along +depth */
};

struct dx_project_stats {
    uint64_t n_triangles;
    uint32_t n_completed, n_boundary, n_isolated; /* points */
    uint32_t n_pinched;        /* of n_boundary, points in which several fans of triangles meet */
    uint32_t n_components;     /* seeds that grew */
    uint32_t n_loop_triangles; /* of n_triangles, to close holes */
    uint32_t n_again;          /* reference points taken with a wider radius */
    uint32_t peak_rings;       /* unfinished points at a time, at most */
    size_t peak_ring_len;      /* bytes of their rings, at most */
    double spacing;            /* median distance of neighbours, input's unit */
};

/* Takes a triangle, as numbers of the input's points, to the left around it seen from outside.
 * Negative: stop, with this error. */
struct dx_project_sink {
    int (*triangle)(void *ctx, const uint32_t v[3]);
    void *ctx;
};

void dx_project_defaults(struct dx_project_config *config);

/* Errors: -EINVAL (a parameter out of its range), -ENOMEM, the sink's. */
int dx_project(struct dx_project_stats *stats, const struct dx_cloud *c,
               const struct dx_project_config *config, const struct dx_project_sink *sink,
               struct dx_err *err);

#endif
