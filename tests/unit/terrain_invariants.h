/*
 * What every mesh of terrain mode keeps (docs/terrain.md: T2 to T5), asserted. Triangles are those
 * of cells and of struts, which span up to 4 x 4 dexels. cmocka.h comes before.
 */
#ifndef DX_TERRAIN_INVARIANTS_H
#define DX_TERRAIN_INVARIANTS_H

#include "terrain_fixture.h"

/* ---- triangles in the index plane ------------------------------------------------------------ */

/* A triangle's corners, the seam undone: columns may be outside 0 .. width-1. */
struct flat {
    int64_t row[3], col[3];
};

static inline struct flat flatten(const struct triangle *t, const struct dx_geometry *g)
{
    const int64_t width = g->width;
    struct flat f;

    for (int m = 0; m < 3; m++) {
        f.row[m] = t->v[m] / g->width;
        f.col[m] = t->v[m] % g->width;
        if (g->wrap && 2 * llabs(f.col[m] - f.col[0]) > width)
            f.col[m] += f.col[m] < f.col[0] ? width : -width;
    }
    return f;
}

/* Twice the area; positive for triangles that run as abc does. */
static inline int64_t flat_area(const struct flat *f)
{
    return (f->col[1] - f->col[0]) * (f->row[2] - f->row[0]) -
           (f->col[2] - f->col[0]) * (f->row[1] - f->row[0]);
}

static inline int64_t least(const int64_t x[3])
{
    const int64_t y = x[0] < x[1] ? x[0] : x[1];

    return y < x[2] ? y : x[2];
}

static inline int64_t greatest(const int64_t x[3])
{
    const int64_t y = x[0] > x[1] ? x[0] : x[1];

    return y > x[2] ? y : x[2];
}

/* ---- half-edges ------------------------------------------------------------------------------ */

#define NO_TWIN UINT32_MAX

/* Half-edge 3k + m runs from corner m of triangle k to the next corner. */
struct half_edges {
    const struct whole_mesh *w;
    uint32_t n;
    uint32_t *start; /* of each dexel's half-edges in `leaving`; n_dexels + 1 */
    uint32_t *leaving, *twin;
};

static inline uint32_t tail(const struct half_edges *h, uint32_t e)
{
    return h->w->triangle[e / 3].v[e % 3];
}

static inline uint32_t next_in_triangle(uint32_t e)
{
    return e % 3 == 2 ? e - 2 : e + 1;
}

static inline uint32_t head(const struct half_edges *h, uint32_t e)
{
    return tail(h, next_in_triangle(e));
}

/* The half-edge from a to b, of which T2 allows one. */
static inline uint32_t find_half_edge(const struct half_edges *h, uint32_t a, uint32_t b)
{
    uint32_t found = NO_TWIN;

    for (uint32_t k = h->start[a]; k < h->start[a + 1]; k++)
        if (head(h, h->leaving[k]) == b) {
            assert_int_equal(found, NO_TWIN);
            found = h->leaving[k];
        }
    return found;
}

/* Asserts T2 on the way: a directed edge occurs once, so an edge has at most two triangles. */
static inline void half_edges_init(struct half_edges *h, const struct whole_mesh *w,
                                   uint32_t n_dexels)
{
    uint32_t *at = malloc(((size_t)n_dexels + 1) * sizeof(*at));

    *h = (struct half_edges){.w = w, .n = (uint32_t)(3 * w->n)};
    h->start = calloc((size_t)n_dexels + 1, sizeof(*h->start));
    h->leaving = malloc((h->n + 1) * sizeof(*h->leaving));
    h->twin = malloc((h->n + 1) * sizeof(*h->twin));
    assert_true(at && h->start && h->leaving && h->twin);
    for (uint32_t e = 0; e < h->n; e++) {
        assert_true(tail(h, e) < n_dexels);
        h->start[tail(h, e) + 1]++;
    }
    for (uint32_t k = 0; k < n_dexels; k++)
        h->start[k + 1] += h->start[k];
    memcpy(at, h->start, ((size_t)n_dexels + 1) * sizeof(*at));
    for (uint32_t e = 0; e < h->n; e++)
        h->leaving[at[tail(h, e)]++] = e;
    for (uint32_t e = 0; e < h->n; e++) {
        assert_int_equal(find_half_edge(h, tail(h, e), head(h, e)), e);
        h->twin[e] = find_half_edge(h, head(h, e), tail(h, e));
    }
    free(at);
}

static inline void half_edges_fini(struct half_edges *h)
{
    free(h->start);
    free(h->leaving);
    free(h->twin);
}

/* ---- T5 -------------------------------------------------------------------------------------- */

static inline uint32_t root(uint32_t *parent, uint32_t v)
{
    while (parent[v] != v)
        v = parent[v] = parent[parent[v]];
    return v;
}

static inline void unite(uint32_t *parent, uint32_t a, uint32_t b)
{
    a = root(parent, a);
    b = root(parent, b);
    parent[a > b ? a : b] = a < b ? a : b;
}

/* What a component has: triangles that hang together by edges. A vertex where two fans meet counts
 * once for each. */
struct component {
    int64_t vertices, triangles, boundary, loops;
};

/* The boundary edge after e, round its head inside the fan. */
static inline uint32_t next_on_boundary(const struct half_edges *h, uint32_t e)
{
    e = next_in_triangle(e);
    while (h->twin[e] != NO_TWIN)
        e = next_in_triangle(h->twin[e]);
    return e;
}

/* Union-find of the components (by triangles) and of the fans (by corners; corner 3k + m is where
 * half-edge 3k + m leaves). */
static inline void find_fans(const struct half_edges *h, uint32_t *component, uint32_t *fan)
{
    for (uint32_t e = 0; e < h->n; e++) {
        component[e / 3] = e / 3;
        fan[e] = e;
    }
    for (uint32_t e = 0; e < h->n; e++) {
        const uint32_t t = h->twin[e];

        if (t == NO_TWIN)
            continue;
        assert_true(tail(h, t) == head(h, e) && head(h, t) == tail(h, e));
        unite(component, e / 3, t / 3);
        unite(fan, e, next_in_triangle(t));
    }
}

static inline void count_components(const struct half_edges *h, struct component *c,
                                    uint32_t *component, uint32_t *fan)
{
    bool *traced = calloc(h->n + 1, sizeof(*traced));

    assert_non_null(traced);
    find_fans(h, component, fan);
    for (uint32_t e = 0; e < h->n; e++) {
        struct component *mine = &c[root(component, e / 3)];

        mine->triangles += e % 3 == 0;
        mine->vertices += root(fan, e) == e;
        mine->boundary += h->twin[e] == NO_TWIN;
        if (h->twin[e] != NO_TWIN || traced[e])
            continue;
        mine->loops++;
        for (uint32_t b = e; !traced[b]; b = next_on_boundary(h, b))
            traced[b] = true;
    }
    free(traced);
}

/*
 * 2V - T = B + 2 chi for each component. Counted from edges alone this holds of any mesh; chi here
 * is that of a sphere less a disc for each boundary loop, which a surface in the plane, on the
 * cylinder or closed by caps must have: it would fail by a handle or by a loop that is not closed.
 */
static inline void check_euler(const struct half_edges *h)
{
    struct component *c = calloc(h->w->n + 1, sizeof(*c));
    uint32_t *component = malloc((h->w->n + 1) * sizeof(*component));
    uint32_t *fan = malloc((h->n + 1) * sizeof(*fan));

    assert_true(c && component && fan);
    count_components(h, c, component, fan);
    for (size_t k = 0; k < h->w->n; k++)
        assert_int_equal(2 * c[k].vertices - c[k].triangles,
                         c[k].triangles ? c[k].boundary + 2 * (2 - c[k].loops) : 0);
    free(fan);
    free(component);
    free(c);
}

/* ---- T2 to T4 -------------------------------------------------------------------------------- */

static inline int64_t common_divisor(int64_t a, int64_t b)
{
    while (b) {
        const int64_t r = a % b;

        a = b;
        b = r;
    }
    return a;
}

/* No vertex lies inside an edge: along a strut, the lattice points are dexels without a sample. */
static inline void check_junctions(const struct whole_mesh *w, const struct half_edges *h,
                                   const struct dx_geometry *g)
{
    for (size_t k = 0; k < w->n; k++) {
        const struct flat f = flatten(&w->triangle[k], g);

        for (int m = 0; m < 3; m++) {
            const int64_t rows = f.row[(m + 1) % 3] - f.row[m],
                          cols = f.col[(m + 1) % 3] - f.col[m];
            const int64_t steps = common_divisor(llabs(rows), llabs(cols));

            for (int64_t s = 1; s < steps; s++) {
                const int64_t row = f.row[m] + s * rows / steps, width = g->width;
                const int64_t col = (f.col[m] + s * cols / steps + width) % width;
                const size_t v = (size_t)(row * width + col);

                assert_int_equal(h->start[v], h->start[v + 1]);
            }
        }
    }
}

/* T3: every face sees the scanner, in 3-D; and all have one orientation in the index plane. */
static inline void check_facing(const struct whole_mesh *w, const struct dx_geometry *g,
                                const struct dx_plane *plane)
{
    for (size_t k = 0; k < w->n; k++) {
        const struct flat f = flatten(&w->triangle[k], g);
        double p[3][3], det;

        for (int m = 0; m < 3; m++) {
            const uint32_t v = w->triangle[k].v[m];
            float x[3];

            dx_geometry_point(g, v / g->width, v % g->width, dx_plane_range(plane, v), x);
            for (int d = 0; d < 3; d++)
                p[m][d] = (double)x[d];
        }
        /* n.(o - p0) with n = (p1-p0)x(p2-p0) is -det(p0, p1, p2) */
        det = p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) -
              p[0][1] * (p[1][0] * p[2][2] - p[1][2] * p[2][0]) +
              p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0]);
        assert_true(det < 0);
        assert_true(flat_area(&f) * (g->flip ? -1 : 1) > 0);
        assert_true(greatest(f.row) - least(f.row) <= 3 && greatest(f.col) - least(f.col) <= 3);
    }
}

/* Which of a cell's 8 x 8 sample points, at irrational places, lie inside a triangle. */
static inline uint64_t samples_inside(const struct flat *f, int64_t row, int64_t col)
{
    uint64_t inside = 0;

    for (int s = 0; s < 64; s++) {
        const int part_row = s / 8, part_col = s % 8;
        const double y = (double)row + (part_row + 0.41421356) / 8;
        const double x = (double)col + (part_col + 0.73205081) / 8;
        int sides = 0;

        for (int m = 0; m < 3; m++) {
            const int n = (m + 1) % 3;
            const double side = (double)(f->col[n] - f->col[m]) * (y - (double)f->row[m]) -
                                (double)(f->row[n] - f->row[m]) * (x - (double)f->col[m]);

            sides += side > 0 ? 1 : -1;
        }
        if (sides == 3 || sides == -3)
            inside |= 1ull << s;
    }
    return inside;
}

/* T4: sample points are covered at most once. */
static inline void check_overlap(const struct whole_mesh *w, const struct dx_geometry *g)
{
    uint64_t *seen = calloc((size_t)g->height * g->width, sizeof(*seen)); /* 8 x 8 a cell */

    assert_non_null(seen);
    for (size_t k = 0; k < w->n; k++) {
        const struct flat f = flatten(&w->triangle[k], g);

        for (int64_t i = least(f.row); i < greatest(f.row); i++)
            for (int64_t j = least(f.col); j < greatest(f.col); j++) {
                const int64_t width = g->width;
                uint64_t *cell = &seen[i * width + (j + width) % width];
                const uint64_t inside = samples_inside(&f, i, j);

                assert_int_equal(*cell & inside, 0);
                *cell |= inside;
            }
    }
    free(seen);
}

/* A mesh without caps, under the plane it was made of. */
static inline void check_mesh(const struct whole_mesh *w, const struct dx_geometry *g,
                              const struct dx_plane *plane)
{
    struct half_edges h;

    half_edges_init(&h, w, g->height * g->width);
    check_euler(&h);
    check_junctions(w, &h, g);
    half_edges_fini(&h);
    check_facing(w, g, plane);
    check_overlap(w, g);
}

/* Of a mesh with caps: what does not need the index plane. */
static inline void check_closed(const struct whole_mesh *w, const struct dx_geometry *g)
{
    struct half_edges h;

    half_edges_init(&h, w, g->height * g->width);
    check_euler(&h);
    half_edges_fini(&h);
}

static inline void check_invariants(const struct dx_terrain *t)
{
    struct whole_mesh w = collect(t);

    check_mesh(&w, dx_terrain_geometry(t), dx_terrain_published(t));
    free(w.triangle);
}

#endif
