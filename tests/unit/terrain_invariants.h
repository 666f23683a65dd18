/* What every mesh of terrain mode keeps (docs/terrain.md: T2 to T5), asserted. */
#ifndef DX_TERRAIN_INVARIANTS_H
#define DX_TERRAIN_INVARIANTS_H

#include "terrain_fixture.h"

struct edge {
    uint32_t a, b;
};

static inline int by_edge(const void *x, const void *y)
{
    const struct edge *a = x, *b = y;

    if (a->a != b->a)
        return a->a < b->a ? -1 : 1;
    return a->b < b->b ? -1 : a->b > b->b;
}

static inline struct edge *directed_edges(const struct whole_mesh *w)
{
    struct edge *e = malloc((3 * w->n + 1) * sizeof(*e));

    for (size_t k = 0; k < w->n; k++)
        for (int m = 0; m < 3; m++)
            e[3 * k + (size_t)m] =
                (struct edge){w->triangle[k].v[m], w->triangle[k].v[(m + 1) % 3]};
    qsort(e, 3 * w->n, sizeof(*e), by_edge);
    return e;
}

static inline uint32_t root(uint32_t *parent, uint32_t v)
{
    while (parent[v] != v)
        v = parent[v] = parent[parent[v]];
    return v;
}

/* T2 (a directed edge once, so at most two triangles an edge) and T5 (Euler's formula, with
 * boundary loops traced: 2V - T = B + 2 chi; here as 3T = 2E - B, and loops close). */
static inline void check_edges(const struct whole_mesh *w, uint32_t n_dexels)
{
    struct edge *e = directed_edges(w);
    uint32_t *parent = malloc(n_dexels * sizeof(*parent));
    int32_t *balance = calloc(n_dexels, sizeof(*balance));
    size_t n = 3 * w->n, n_boundary = 0, n_edges = 0;

    for (uint32_t k = 0; k < n_dexels; k++)
        parent[k] = k;
    for (size_t k = 0; k < n; k++) {
        struct edge back = {e[k].b, e[k].a};
        bool shared = bsearch(&back, e, n, sizeof(*e), by_edge) != NULL;

        assert_true(k == 0 || by_edge(&e[k - 1], &e[k]) != 0);
        n_boundary += !shared;
        n_edges += !shared || e[k].a < e[k].b;
        if (!shared) { /* boundary edges form closed loops: as many leave a vertex as enter it */
            balance[e[k].a]++;
            balance[e[k].b]--;
        }
        parent[root(parent, e[k].a)] = root(parent, e[k].b);
    }
    for (uint32_t k = 0; k < n_dexels; k++)
        assert_int_equal(balance[k], 0);
    assert_int_equal(3 * w->n, 2 * n_edges - n_boundary);
    free(balance);
    free(parent);
    free(e);
}

/* T3: every face sees the scanner, in 3-D; and all have one orientation in the index plane. */
static inline void check_facing(const struct whole_mesh *w, const struct dx_terrain *t)
{
    const struct dx_geometry *g = dx_terrain_geometry(t);
    const struct dx_plane *plane = dx_terrain_published(t);

    for (size_t k = 0; k < w->n; k++) {
        double p[3][3], det;
        int64_t row[3], col[3], area;

        for (int m = 0; m < 3; m++) {
            uint32_t v = w->triangle[k].v[m];
            float f[3];

            row[m] = v / g->width;
            col[m] = v % g->width;
            dx_geometry_point(g, (uint32_t)row[m], (uint32_t)col[m], dx_plane_range(plane, v), f);
            for (int x = 0; x < 3; x++)
                p[m][x] = (double)f[x];
        }
        /* n.(o - p0) with n = (p1-p0)x(p2-p0) is -det(p0, p1, p2) */
        det = p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) -
              p[0][1] * (p[1][0] * p[2][2] - p[1][2] * p[2][0]) +
              p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0]);
        assert_true(det < 0);
        for (int m = 1; m < 3; m++) /* undo the seam */
            col[m] +=
                llabs(col[m] - col[0]) > 1 ? (col[m] < col[0] ? g->width : -(int64_t)g->width) : 0;
        area = (col[1] - col[0]) * (row[2] - row[0]) - (col[2] - col[0]) * (row[1] - row[0]);
        assert_int_equal(area, g->flip ? -1 : 1);
    }
}

/* T4: sample points inside the cells are covered at most once. */
static inline void check_overlap(const struct whole_mesh *w, const struct dx_geometry *g)
{
    uint64_t *seen = calloc((size_t)g->height * g->width, sizeof(*seen)); /* 8x8 samples a cell */

    for (size_t k = 0; k < w->n; k++) {
        int64_t row[3], col[3], top = INT64_MAX, left = INT64_MAX;
        uint64_t *cell;

        for (int m = 0; m < 3; m++) {
            row[m] = w->triangle[k].v[m] / g->width;
            col[m] = w->triangle[k].v[m] % g->width;
            if (m && llabs(col[m] - col[0]) > 1)
                col[m] += col[m] < col[0] ? g->width : -(int64_t)g->width;
            top = row[m] < top ? row[m] : top;
            left = col[m] < left ? col[m] : left;
        }
        cell = &seen[(size_t)top * g->width + (size_t)((left + g->width) % g->width)];
        for (int s = 0; s < 64; s++) {
            double y = (double)top + (s / 8 + 0.41421356) / 8,
                   x = (double)left + (s % 8 + 0.73205081) / 8;
            int sides = 0;

            for (int m = 0; m < 3; m++) {
                int n = (m + 1) % 3;
                double side = (double)(col[n] - col[m]) * (y - (double)row[m]) -
                              (double)(row[n] - row[m]) * (x - (double)col[m]);

                sides += side > 0 ? 1 : -1;
            }
            if (sides != 3 && sides != -3)
                continue;
            assert_true((*cell >> s & 1) == 0);
            *cell |= 1ull << s;
        }
    }
    free(seen);
}

static inline void check_invariants(const struct dx_terrain *t)
{
    const struct dx_geometry *g = dx_terrain_geometry(t);
    struct whole_mesh w = collect(t);

    check_edges(&w, g->height * g->width);
    check_facing(&w, t);
    check_overlap(&w, g);
    free(w.triangle);
}

#endif
