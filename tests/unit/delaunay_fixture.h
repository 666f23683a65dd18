/* Clouds for the tests of localized Delaunay: normals, the mesh, and what it is. */
#ifndef DELAUNAY_FIXTURE_H
#define DELAUNAY_FIXTURE_H

#include "cloud_fixture.h"
#include "core/cloud/cloud_normals.h"
#include "core/cloud/delaunay.h"

/* A cloud with its neighbours and normals. */
struct bed {
    struct dx_cloud cloud;
    struct dx_neighbours nb;
    float (*normals)[3];
};

static inline void bed_init(struct bed *b, const double *xyz, size_t n, uint32_t k,
                            const double *viewpoint, struct dx_pool *pool)
{
    const struct dx_cloud_normals_config config = {k, viewpoint};
    struct dx_cloud_normals_stats stats;

    assert_int_equal(dx_cloud_init(&b->cloud, xyz, n, pool, NULL), 0);
    assert_int_equal(dx_neighbours_init(&b->nb, &b->cloud, k, pool, NULL), 0);
    b->normals = malloc(b->cloud.n * sizeof(*b->normals) + 1);
    assert_non_null(b->normals);
    assert_int_equal(
        dx_cloud_normals(b->normals, NULL, &stats, &b->cloud, &b->nb, &config, pool, NULL), 0);
}

static inline void bed_fini(struct bed *b)
{
    free(b->normals);
    dx_neighbours_fini(&b->nb);
    dx_cloud_fini(&b->cloud);
}

/* Triangles into *soup, which is emptied first. `k`: neighbours for a normal. */
static inline struct dx_delaunay_stats delaunay(struct soup *soup, const double *xyz, size_t n,
                                                const struct dx_delaunay_config *config, uint32_t k,
                                                struct dx_pool *pool)
{
    const struct dx_delaunay_sink sink = {soup_take, NULL, soup};
    struct dx_delaunay_stats s;
    struct bed bed;

    soup->n = 0;
    bed_init(&bed, xyz, n, k, NULL, pool);
    assert_int_equal(dx_delaunay(&s, &bed.cloud, &bed.nb, (const float(*)[3])bed.normals, config,
                                 &sink, pool, NULL),
                     0);
    assert_int_equal(s.n_triangles, soup->n);
    assert_int_equal(s.n_by_votes[1] + s.n_by_votes[2] + s.n_by_votes[3] + s.n_loop_triangles,
                     soup->n);
    assert_int_equal(s.n_completed + s.n_boundary + s.n_isolated, bed.cloud.n);
    bed_fini(&bed);
    return s;
}

#endif
