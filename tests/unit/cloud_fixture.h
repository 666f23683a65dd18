/* Clouds for the tests of core/cloud, the mesh that dx_project makes of them, and what it is. */
#ifndef CLOUD_FIXTURE_H
#define CLOUD_FIXTURE_H

#include "core/base/hash.h"
#include "core/cloud/project.h"
#include "drivers/synth/surfaces.h"
#include "tools/mesh_crossings.h"

#include <stdlib.h>
#include <string.h>

static inline struct dx_surface_points surface_points(const struct dx_surface_config *config)
{
    struct dx_surface_points p;

    assert_int_equal(dx_surface_sample(&p, config), 0);
    return p;
}

struct soup {
    uint32_t *v; /* [n][3] */
    size_t n, cap;
};

static inline int soup_take(void *ctx, const uint32_t v[3])
{
    struct soup *s = ctx;

    if (s->n == s->cap) {
        s->cap = s->cap ? 2 * s->cap : 1024;
        s->v = realloc(s->v, s->cap * 3 * sizeof(*s->v));
        assert_non_null(s->v);
    }
    memcpy(s->v + 3 * s->n++, v, 3 * sizeof(*v));
    return 0;
}

static inline uint64_t soup_hash(const struct soup *s)
{
    return dx_hash(0, s->v, 3 * s->n * sizeof(*s->v));
}

/* Edges as low << 32 | high << 1 | the direction is low to high. */
static inline int soup_by_key(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;

    return (x > y) - (x < y);
}

struct soup_counts {
    uint64_t n_edges, n_boundary;
    uint32_t n_points; /* used */
    int64_t euler;
};

/* Fails when an edge is in more than two triangles or runs twice in one direction, or a triangle
 * names a point twice or one that is not there. */
static inline struct soup_counts soup_count(const struct soup *s, uint32_t n_input)
{
    struct soup_counts c = {0};
    uint64_t *keys = malloc(3 * s->n * sizeof(*keys) + 1);
    uint8_t *used = calloc(n_input + 1, 1);

    assert_non_null(keys);
    assert_non_null(used);
    for (size_t k = 0; k < 3 * s->n; k++) {
        const uint64_t a = s->v[k], b = s->v[k % 3 == 2 ? k - 2 : k + 1];

        assert_true(a < n_input && b < n_input && a != b);
        used[a] = 1;
        keys[k] = a < b ? a << 32 | b << 1 | 1 : b << 32 | a << 1;
    }
    qsort(keys, 3 * s->n, sizeof(*keys), soup_by_key);
    for (size_t k = 0, end; k < 3 * s->n; k = end) {
        for (end = k; end < 3 * s->n && keys[end] >> 1 == keys[k] >> 1;)
            end++;
        assert_true(end - k <= 2);
        assert_true(end - k == 1 || keys[k] != keys[k + 1]);
        c.n_edges++;
        c.n_boundary += end - k == 1;
    }
    for (uint32_t k = 0; k < n_input; k++)
        c.n_points += used[k];
    c.euler = (int64_t)c.n_points - (int64_t)c.n_edges + (int64_t)s->n;
    free(keys);
    free(used);
    return c;
}

static inline int soup_by_corners(const void *a, const void *b)
{
    const uint32_t *x = a, *y = b;
    int k = 0;

    while (k < 2 && x[k] == y[k])
        k++;
    return (x[k] > y[k]) - (x[k] < y[k]);
}

/* Each triangle from its lowest corner on, triangles by their corners. */
static inline void soup_sort(struct soup *s)
{
    for (size_t t = 0; t < s->n; t++) {
        uint32_t *v = s->v + 3 * t;

        while (v[0] > v[1] || v[0] > v[2])
            memcpy(v, (uint32_t[3]){v[1], v[2], v[0]}, 3 * sizeof(*v));
    }
    qsort(s->v, s->n, 3 * sizeof(*s->v), soup_by_corners);
}

/* Triangles of sorted a that sorted b has not. */
static inline size_t soup_missing(const struct soup *a, const struct soup *b)
{
    size_t n = 0;

    for (size_t t = 0; t < a->n; t++)
        n += !bsearch(a->v + 3 * t, b->v, b->n, 3 * sizeof(*b->v), soup_by_corners);
    return n;
}

/* Triangles into *soup, which is emptied first. */
static inline struct dx_project_stats project(struct soup *soup, const double *xyz, size_t n,
                                              const struct dx_project_config *config,
                                              struct dx_pool *pool)
{
    const struct dx_project_sink sink = {soup_take, soup};
    struct dx_project_stats stats;
    struct dx_cloud cloud;

    soup->n = 0;
    assert_int_equal(dx_cloud_init(&cloud, xyz, n, pool, NULL), 0);
    assert_int_equal(dx_project(&stats, &cloud, config, &sink, NULL), 0);
    assert_int_equal(stats.n_triangles, soup->n);
    assert_int_equal(stats.n_completed + stats.n_boundary + stats.n_isolated, cloud.n);
    dx_cloud_fini(&cloud);
    return stats;
}

/* No triangle goes through another (invariant G2). */
static inline void expect_no_crossing(const struct soup *soup, const double *xyz)
{
    struct dx_mesh_crossings c;

    assert_int_equal(dx_mesh_crossings_count(&c, xyz, soup->v, soup->n), 0);
    if (c.n_pairs)
        fail_msg("%llu pairs of %zu triangles cross", (unsigned long long)c.n_pairs, soup->n);
}

/* A mesh without boundary of all points, which does not cross itself: T = 2 V - 2 chi (G3). */
static inline void expect_closed(const struct soup *soup, const double *xyz, uint32_t n,
                                 int64_t euler)
{
    const struct soup_counts c = soup_count(soup, n);

    expect_no_crossing(soup, xyz);
    if (c.n_boundary || c.n_points != n || c.euler != euler ||
        (int64_t)soup->n != 2 * n - 2 * euler)
        fail_msg("%zu triangles of %u of %u points, %llu boundary edges, characteristic %lld",
                 soup->n, c.n_points, n, (unsigned long long)c.n_boundary, (long long)c.euler);
}

#endif
