/* Clouds for the tests of core/cloud, the mesh that dx_project makes of them, and what it is. */
#ifndef CLOUD_FIXTURE_H
#define CLOUD_FIXTURE_H

#include "core/base/hash.h"
#include "core/cloud/project.h"
#include "drivers/synth/surfaces.h"

#include <stdlib.h>
#include <string.h>

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

/* A mesh without boundary of all points: T = 2 V - 2 chi. */
static inline void expect_closed(const struct soup *soup, uint32_t n, int64_t euler)
{
    const struct soup_counts c = soup_count(soup, n);

    if (c.n_boundary || c.n_points != n || c.euler != euler ||
        (int64_t)soup->n != 2 * n - 2 * euler)
        fail_msg("%zu triangles of %u of %u points, %llu boundary edges, characteristic %lld",
                 soup->n, c.n_points, n, (unsigned long long)c.n_boundary, (long long)c.euler);
}

#endif
