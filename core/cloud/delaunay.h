/*
 * The mesh of an unorganized cloud by localized Delaunay triangulation (Gopi, "Surface
 * Reconstruction based on Lower Dimensional Localized Delaunay Triangulation", 2000). Each point
 * triangulates its candidates in its own tangent plane; a triangle that all three corners find is
 * in the mesh. What they disagree on is decided afterwards, in one order, and small holes are
 * filled. What the paper leaves open is told in docs/algorithms.md. Stars and votes are made over
 * the pool; the same bytes for any number of threads and any order of the input.
 */
#ifndef DX_DELAUNAY_H
#define DX_DELAUNAY_H

#include "core/cloud/neighbours.h"

#include <stdbool.h>

#define DX_DELAUNAY_MAX_LOOP 32

struct dx_delaunay_config {
    uint32_t k; /* candidates at first: so many nearest neighbours, or all there are */
    /* Candidates are sought as far as empty circles reach, up to so many radii of the nearest
     * neighbours; in larger circles no surface is made. At least 1. */
    double widest;
    /* As the paper has it instead: within m_p distances of the nearest point, and no farther, where
     * m_p is twice the ratio of the principal curvatures, kept between these two (section 5.3). */
    bool paper_radius;
    double least_m, most_m;
    /* Points are put into the tangent plane where they are over it, not turned into it at their
     * distance (section 5.4): heights that are noise count less. */
    bool shadow;
    double max_edge;   /* in the input's unit; 0: no bound */
    uint32_t max_loop; /* holes of at most so many edges are filled (section 6); 0: none */
};

enum dx_delaunay_stage { DX_DELAUNAY_STARS, DX_DELAUNAY_ACCEPT, DX_DELAUNAY_HOLES };

struct dx_delaunay_stats {
    uint64_t n_triangles;
    uint64_t n_by_votes[4];                       /* that 1, 2 and 3 corners found */
    uint32_t n_loop_triangles;                    /* to fill holes */
    uint32_t n_completed, n_boundary, n_isolated; /* points */
    uint32_t n_pinched; /* of n_boundary, points in which several fans of triangles meet */
    uint32_t n_widened; /* points that looked beyond their neighbours */
    uint32_t n_open;    /* points whose star was not agreed on by all; rims among them */
};

/* Takes a triangle, as numbers of the input's points, to the left around it seen from where its
 * normals point. Negative: stop, with this error. `stage`, or NULL, is told what begins. */
struct dx_delaunay_sink {
    int (*triangle)(void *ctx, const uint32_t v[3]);
    void (*stage)(void *ctx, enum dx_delaunay_stage stage);
    void *ctx;
};

void dx_delaunay_defaults(struct dx_delaunay_config *config);

/* `normals` by rank, oriented, as of dx_cloud_normals; `nb` the cloud's neighbours. Errors: -EINVAL
 * (a parameter out of its range), -ENOMEM, the sink's. */
int dx_delaunay(struct dx_delaunay_stats *stats, const struct dx_cloud *cloud,
                const struct dx_neighbours *nb, const float (*normals)[3],
                const struct dx_delaunay_config *config, const struct dx_delaunay_sink *sink,
                struct dx_pool *pool, struct dx_err *err);

#endif
