/*
 * Rims of a manifold are simple loops. A small one gets the triangles whose new edges have the
 * least sum of squared lengths, by dynamic programming over its parts; none of them is an edge that
 * there is already, or has no area.
 */
#include "tools/mesh_repair_priv.h"
#include "tools/union_find.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>

#define FLAT 1e-24 /* of the fourth power of a length: the square of an area that is none */

/* The cover of one loop. */
struct cover {
    uint32_t n, v[DX_MESH_REPAIR_MAX_HOLE]; /* its vertices, against the rim's triangles */
    double p[DX_MESH_REPAIR_MAX_HOLE][3];
    double cost[DX_MESH_REPAIR_MAX_HOLE][DX_MESH_REPAIR_MAX_HOLE]; /* of the part from i to j > i */
    uint8_t corner[DX_MESH_REPAIR_MAX_HOLE][DX_MESH_REPAIR_MAX_HOLE]; /* with i and j: a triangle */
};

struct work {
    struct dx_mesh *mesh;
    uint32_t max_hole;
    struct dx_mesh_edges edges;
    uint32_t *next; /* [n_vertices] along the loop, or DX_REPAIR_NONE; taken out as it is walked */
    uint32_t *parent; /* [n_vertices] union-find: components */
    double *area;     /* [n_vertices] of a root's component */
    size_t cap;       /* triangles in mesh->index */
    struct cover cover;
};

static void difference(double out[3], const double *a, const double *b)
{
    for (int k = 0; k < 3; k++)
        out[k] = b[k] - a[k];
}

static double length2(const double u[3])
{
    return u[0] * u[0] + u[1] * u[1] + u[2] * u[2];
}

/* Twice the area, squared. */
static double area2_of(const double *a, const double *b, const double *c)
{
    double u[3], v[3];

    difference(u, a, b);
    difference(v, a, c);
    return length2((double[3]){u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                               u[0] * v[1] - u[1] * v[0]});
}

static bool is_flat(const double *a, const double *b, const double *c)
{
    double u[3], v[3], longest;

    difference(u, a, b);
    difference(v, a, c);
    longest = fmax(length2(u), length2(v));
    return !(area2_of(a, b, c) > FLAT * longest * longest);
}

/* ---- the cover ------------------------------------------------------------------------------ */

static void cover_part(struct cover *c, const struct dx_mesh_edges *edges, uint32_t i, uint32_t j)
{
    double side[3], least = INFINITY;
    const bool is_rim = i == 0 && j == c->n - 1;

    difference(side, c->p[i], c->p[j]);
    for (uint32_t k = i + 1; k < j; k++) {
        const double cost = c->cost[i][k] + c->cost[k][j];

        if (cost < least && !is_flat(c->p[i], c->p[k], c->p[j])) {
            least = cost;
            c->corner[i][j] = (uint8_t)k;
        }
    }
    if (!is_rim && dx_mesh_edges_has(edges, c->v[i], c->v[j]))
        least = INFINITY;
    c->cost[i][j] = is_rim ? least : least + length2(side);
}

/* Whether there is a cover. */
static bool find_cover(struct cover *c, const struct dx_mesh_edges *edges)
{
    for (uint32_t i = 0; i + 1 < c->n; i++)
        c->cost[i][i + 1] = 0;
    for (uint32_t len = 2; len < c->n; len++)
        for (uint32_t i = 0; i + len < c->n; i++)
            cover_part(c, edges, i, i + len);
    return isfinite(c->cost[0][c->n - 1]);
}

static double cover_area(const struct cover *c, uint32_t i, uint32_t j)
{
    const uint32_t k = c->corner[i][j];

    if (j - i < 2)
        return 0;
    return sqrt(area2_of(c->p[i], c->p[k], c->p[j])) / 2 + cover_area(c, i, k) +
           cover_area(c, k, j);
}

static void put_cover(struct dx_mesh *mesh, const struct cover *c, uint32_t i, uint32_t j)
{
    const uint32_t k = c->corner[i][j];
    uint32_t *to = mesh->index + 3 * (size_t)mesh->n_triangles;

    if (j - i < 2)
        return;
    to[0] = c->v[i];
    to[1] = c->v[k];
    to[2] = c->v[j];
    mesh->n_triangles++;
    put_cover(mesh, c, i, k);
    put_cover(mesh, c, k, j);
}

/* ---- loops ---------------------------------------------------------------------------------- */

static int reserve(struct work *w, uint32_t more)
{
    const size_t n = (size_t)w->mesh->n_triangles + more, cap = n + n / 8 + 1024;
    uint32_t *grown;

    if (n <= w->cap)
        return 0;
    if (n > DX_MESH_MAX_TRIANGLES)
        return -EOVERFLOW;
    grown = realloc(w->mesh->index, 3 * cap * sizeof(*grown));
    if (!grown)
        return -ENOMEM;
    w->mesh->index = grown;
    w->cap = cap;
    return 0;
}

static int close_loop(struct work *w, struct dx_mesh_repair *counts)
{
    struct cover *c = &w->cover;
    const double whole = w->area[dx_union_root(w->parent, c->v[0])];
    int rc;

    for (uint32_t i = 0; i < c->n; i++)
        for (size_t k = 0; k < 3; k++)
            c->p[i][k] = (double)w->mesh->xyz[3 * (size_t)c->v[i] + k];
    if (!find_cover(c, &w->edges) || cover_area(c, 0, c->n - 1) > whole / 2)
        return 0;
    rc = reserve(w, c->n - 2);
    if (rc < 0)
        return rc;
    put_cover(w->mesh, c, 0, c->n - 1);
    counts->holes++;
    counts->hole_triangles += c->n - 2;
    return 0;
}

/* Walks the loop from v; its length, 0 when it is longer than asked for or does not come back. */
static uint32_t walk(struct work *w, uint32_t v)
{
    const uint32_t start = v;
    uint32_t n = 0;

    do {
        const uint32_t next = w->next[v];

        if (next == DX_REPAIR_NONE)
            return 0;
        if (n < w->max_hole)
            w->cover.v[n] = v;
        n++;
        w->next[v] = DX_REPAIR_NONE;
        v = next;
    } while (v != start);
    return n <= w->max_hole && n > 2 ? n : 0;
}

static void find_loops(struct work *w)
{
    const uint32_t *index = w->mesh->index;
    struct dx_edge_run run = {0};

    for (uint32_t v = 0; v < w->mesh->n_vertices; v++) {
        w->next[v] = DX_REPAIR_NONE;
        w->parent[v] = v;
    }
    while (dx_mesh_edges_next(&w->edges, &run)) {
        const uint32_t c = run.edge->corner;

        dx_union_join(w->parent, run.low, run.edge->high);
        if (run.n == 1)
            w->next[index[dx_corner_next(c)]] = index[c];
    }
}

static void measure_components(struct work *w)
{
    for (size_t t = 0; t < w->mesh->n_triangles; t++) {
        const uint32_t *v = w->mesh->index + 3 * t;
        double p[3][3];

        for (size_t i = 0; i < 3; i++)
            for (size_t k = 0; k < 3; k++)
                p[i][k] = (double)w->mesh->xyz[3 * (size_t)v[i] + k];
        w->area[dx_union_root(w->parent, v[0])] += sqrt(area2_of(p[0], p[1], p[2])) / 2;
    }
}

static int close_loops(struct work *w, struct dx_mesh_repair *counts)
{
    int rc = 0;

    find_loops(w);
    measure_components(w);
    for (uint32_t v = 0; rc == 0 && v < w->mesh->n_vertices; v++)
        if (w->next[v] != DX_REPAIR_NONE && (w->cover.n = walk(w, v)) > 0)
            rc = close_loop(w, counts);
    return rc;
}

int dx_repair_holes(struct dx_mesh *mesh, uint32_t max_hole, struct dx_mesh_repair *counts)
{
    const size_t n = (size_t)mesh->n_vertices + 1;
    struct work *w = calloc(1, sizeof(*w));
    int rc;

    if (!w)
        return -ENOMEM;
    w->mesh = mesh;
    w->max_hole = max_hole;
    w->cap = mesh->n_triangles;
    rc = dx_mesh_edges_init(&w->edges, mesh->index, mesh->n_triangles, mesh->n_vertices);
    w->next = malloc(n * sizeof(*w->next));
    w->parent = malloc(n * sizeof(*w->parent));
    w->area = calloc(n, sizeof(*w->area));
    if (rc == 0 && (!w->next || !w->parent || !w->area))
        rc = -ENOMEM;
    if (rc == 0)
        rc = close_loops(w, counts);
    dx_mesh_edges_fini(&w->edges);
    free(w->next);
    free(w->parent);
    free(w->area);
    free(w);
    return rc;
}
