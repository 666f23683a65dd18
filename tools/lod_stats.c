/* Levels of detail in numbers: every triangle of both meshes, and every sample between. */
#include "tools/lod_stats.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>

/* ---- triangles of a level -------------------------------------------------------------------- */

/* Corners as dexels, with columns that run on past the seam. */
struct corners {
    int64_t row[3], col[3];
};

typedef void visit(void *ctx, const struct corners *c);

struct walk {
    const struct dx_terrain *terrain;
    struct dx_lod *lod; /* NULL: the whole mesh */
    struct dx_lod_level level;
    struct dx_lod_scratch *scratch;
    struct dx_tile *tile;
    struct dx_tile_mesh *whole, *cut;
};

static void walk_fini(struct walk *w)
{
    free(w->tile);
    free(w->whole);
    free(w->cut);
    dx_lod_scratch_free(w->scratch);
    dx_lod_free(w->lod);
}

static int walk_init(struct walk *w, const struct dx_terrain *t, struct dx_lod_level level)
{
    const struct dx_lod_level levels[DX_LOD_SLOTS] = {level};

    *w = (struct walk){.terrain = t, .level = level};
    w->tile = malloc(sizeof(*w->tile));
    w->whole = malloc(sizeof(*w->whole));
    w->cut = malloc(sizeof(*w->cut));
    w->scratch = dx_lod_scratch_new();
    if (!w->tile || !w->whole || !w->cut || !w->scratch ||
        (!dx_lod_is_whole(level) && dx_lod_new(&w->lod, t, NULL) < 0))
        return -ENOMEM;
    if (w->lod)
        dx_lod_update(w->lod, levels, NULL);
    return 0;
}

static void walk_tile(const struct dx_tile_mesh *mesh, visit *fn, void *ctx)
{
    uint16_t at[DX_TILE_MAX_VERTICES], n = 0;

    for (uint16_t k = 0; k < DX_BLOCK_DEXELS; k++)
        if (mesh->mask[k / 8] >> (k % 8) & 1)
            at[n++] = k;
    for (uint32_t k = 0; k < mesh->n_triangles; k++) {
        struct corners c;

        for (uint32_t m = 0; m < 3; m++) {
            const uint16_t d = at[mesh->index[3 * k + m]];

            c.row[m] = (int64_t)mesh->row * DX_TILE_CELLS + d / DX_BLOCK - 1;
            c.col[m] = (int64_t)mesh->col * DX_TILE_CELLS + d % DX_BLOCK - 1;
        }
        fn(ctx, &c);
    }
}

static void walk_level(struct walk *w, visit *fn, void *ctx)
{
    const struct dx_tiling *tiling = dx_terrain_tiling(w->terrain);

    for (uint32_t n = 0; n < dx_tiling_n_tiles(tiling); n++) {
        if (!dx_terrain_tile(w->terrain, n, w->tile))
            continue;
        dx_tile_mesh_build(w->whole, w->tile, tiling, dx_terrain_geometry(w->terrain));
        if (w->lod)
            dx_lod_mesh(w->cut, w->lod, w->level, w->tile, w->whole, w->scratch);
        walk_tile(w->lod ? w->cut : w->whole, fn, ctx);
    }
}

static uint64_t dexel_at(const struct dx_tiling *t, int64_t row, int64_t col)
{
    return (uint64_t)(row * t->width + (col + t->width) % t->width);
}

/* ---- cracks ---------------------------------------------------------------------------------- */

/* Directed edges, from * 2^32 + to. */
struct edges {
    const struct dx_tiling *tiling;
    uint64_t *edge;
    size_t n, room;
};

static int by_number(const void *x, const void *y)
{
    const uint64_t a = *(const uint64_t *)x, b = *(const uint64_t *)y;

    return (a > b) - (a < b);
}

static void add_edges(void *ctx, const struct corners *c)
{
    struct edges *e = ctx;

    for (int m = 0; m < 3 && e->n < e->room; m++) {
        const int next = (m + 1) % 3;

        e->edge[e->n++] = dexel_at(e->tiling, c->row[m], c->col[m]) << 32 |
                          dexel_at(e->tiling, c->row[next], c->col[next]);
    }
}

static int edges_init(struct edges *e, struct walk *w)
{
    const struct dx_tiling *tiling = dx_terrain_tiling(w->terrain);

    *e = (struct edges){.tiling = tiling};
    e->room = 6 * (size_t)tiling->cell_rows * tiling->cell_cols;
    e->edge = malloc(e->room * sizeof(*e->edge));
    if (!e->edge)
        return -ENOMEM;
    walk_level(w, add_edges, e);
    qsort(e->edge, e->n, sizeof(*e->edge), by_number);
    return 0;
}

static bool has_edge(const struct edges *e, uint64_t edge)
{
    return bsearch(&edge, e->edge, e->n, sizeof(edge), by_number);
}

static bool is_on_border(const struct dx_tiling *t, uint64_t from, uint64_t to)
{
    const uint64_t width = t->width;

    if (from / width == to / width)
        return from / width == 0 || from / width == t->height - 1;
    return !t->wrap && from % width == to % width &&
           (from % width == 0 || from % width == width - 1);
}

static uint64_t count_cracks(const struct edges *cut, const struct edges *whole)
{
    uint64_t n = 0;

    for (size_t k = 0; k < cut->n; k++) {
        const uint64_t edge = cut->edge[k], back = edge >> 32 | edge << 32;

        if (has_edge(cut, back) || is_on_border(cut->tiling, edge >> 32, edge & UINT32_MAX))
            continue;
        n += !has_edge(whole, edge) || has_edge(whole, back);
    }
    return n;
}

/* ---- distances ------------------------------------------------------------------------------- */

/* Of a dexel. A sample on the edge of two triangles lies over both in the grid, and its beam meets
 * one of them: at a crease the other's plane runs far from it. */
enum seen { UNSEEN, BESIDE, MET, VERTEX };

struct distances {
    const struct dx_terrain *terrain;
    uint8_t *seen; /* enum seen */
    double *error; /* of those that were measured, in sigmas */
    uint64_t n_triangles;
};

static void point_of(const struct dx_terrain *t, uint64_t dexel, double p[3])
{
    const struct dx_geometry *g = dx_terrain_geometry(t);
    float x[3];

    dx_geometry_point(g, (uint32_t)(dexel / g->width), (uint32_t)(dexel % g->width),
                      dx_plane_range(dx_terrain_published(t), dexel), x);
    for (int k = 0; k < 3; k++)
        p[k] = (double)x[k];
}

static double det(const double a[3], const double b[3], const double c[3])
{
    return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
           a[2] * (b[0] * c[1] - b[1] * c[0]);
}

/* Whether the beam to q meets the triangle. */
static bool meets(double p[3][3], const double q[3])
{
    const double whole = det(p[0], p[1], p[2]), least = -1e-9;

    return det(q, p[1], p[2]) / whole >= least && det(p[0], q, p[2]) / whole >= least &&
           det(p[0], p[1], q) / whole >= least;
}

/* Of a dexel's sample q from a triangle's plane along its beam, in sigmas of its range (a pinhole's
 * is the depth). */
static double distance_of(const struct dx_terrain *t, double p[3][3], uint64_t dexel,
                          const double q[3])
{
    const double *s = dx_terrain_params(t)->sigma, unit = (double)dx_terrain_geometry(t)->unit_m;
    const double r = unit * dx_plane_range(dx_terrain_published(t), dexel);
    double u[3], v[3], n[3], along = 0, at = 0;

    for (int k = 0; k < 3; k++) {
        u[k] = p[1][k] - p[0][k];
        v[k] = p[2][k] - p[0][k];
    }
    n[0] = u[1] * v[2] - u[2] * v[1];
    n[1] = u[2] * v[0] - u[0] * v[2];
    n[2] = u[0] * v[1] - u[1] * v[0];
    for (int k = 0; k < 3; k++) {
        at += n[k] * p[0][k];
        along += n[k] * q[k];
    }
    return r * fabs(at / along - 1) / ((s[0] > unit / 2 ? s[0] : unit / 2) + r * (s[1] + r * s[2]));
}

static bool is_inside(const struct corners *c, int64_t row, int64_t col)
{
    int less = 0, more = 0;

    for (int m = 0; m < 3; m++) {
        const int n = (m + 1) % 3;
        const int64_t side = (c->col[n] - c->col[m]) * (row - c->row[m]) -
                             (c->row[n] - c->row[m]) * (col - c->col[m]);

        less += side < 0;
        more += side > 0;
    }
    return !less || !more;
}

static int64_t least(const int64_t x[3])
{
    const int64_t y = x[0] < x[1] ? x[0] : x[1];

    return y < x[2] ? y : x[2];
}

static int64_t greatest(const int64_t x[3])
{
    const int64_t y = x[0] > x[1] ? x[0] : x[1];

    return y > x[2] ? y : x[2];
}

static void mark_corners(void *ctx, const struct corners *c)
{
    struct distances *d = ctx;

    d->n_triangles++;
    for (int m = 0; m < 3; m++)
        d->seen[dexel_at(dx_terrain_tiling(d->terrain), c->row[m], c->col[m])] = VERTEX;
}

/* The triangle that the beam meets counts, else the one whose plane is the nearest. */
static void measure_dexel(struct distances *d, double p[3][3], uint64_t dexel)
{
    enum seen as;
    double q[3], e;

    point_of(d->terrain, dexel, q);
    as = meets(p, q) ? MET : BESIDE;
    e = distance_of(d->terrain, p, dexel, q);
    if (as < d->seen[dexel] || (as == d->seen[dexel] && e >= d->error[dexel]))
        return;
    d->seen[dexel] = (uint8_t)as;
    d->error[dexel] = e;
}

static void measure(void *ctx, const struct corners *c)
{
    struct distances *d = ctx;
    const struct dx_tiling *tiling = dx_terrain_tiling(d->terrain);
    double p[3][3];

    for (int m = 0; m < 3; m++)
        point_of(d->terrain, dexel_at(tiling, c->row[m], c->col[m]), p[m]);
    for (int64_t i = least(c->row); i <= greatest(c->row); i++)
        for (int64_t j = least(c->col); j <= greatest(c->col); j++) {
            const uint64_t dexel = dexel_at(tiling, i, j);

            if (d->seen[dexel] != VERTEX && is_inside(c, i, j) &&
                dx_plane_range(dx_terrain_published(d->terrain), dexel))
                measure_dexel(d, p, dexel);
        }
}

static void sum_up(struct dx_lod_stats *stats, const struct distances *d)
{
    const size_t n = dx_plane_n_dexels(dx_terrain_published(d->terrain));
    double sum = 0;

    for (size_t k = 0; k < n; k++) {
        if (d->seen[k] != BESIDE && d->seen[k] != MET)
            continue;
        stats->left_out++;
        stats->max_sigma = fmax(stats->max_sigma, d->error[k]);
        sum += d->error[k] * d->error[k];
    }
    stats->rms_sigma = stats->left_out ? sqrt(sum / (double)stats->left_out) : 0;
}

/* ---- together -------------------------------------------------------------------------------- */

int dx_lod_stats_compute(struct dx_lod_stats *stats, const struct dx_terrain *t,
                         struct dx_lod_level level)
{
    struct distances d = {.terrain = t};
    struct edges cut = {0}, whole = {0};
    struct walk w = {0}, all = {0};
    int rc;

    d.seen = calloc(dx_plane_n_dexels(dx_terrain_published(t)), 1);
    d.error = calloc(dx_plane_n_dexels(dx_terrain_published(t)), sizeof(*d.error));
    rc = d.seen && d.error ? walk_init(&w, t, level) : -ENOMEM;
    if (rc == 0)
        rc = walk_init(&all, t, (struct dx_lod_level){0});
    if (rc == 0)
        rc = edges_init(&whole, &all);
    if (rc == 0)
        rc = edges_init(&cut, &w);
    if (rc == 0) {
        walk_level(&w, mark_corners, &d);
        walk_level(&w, measure, &d);
        *stats = (struct dx_lod_stats){
            .triangles = d.n_triangles, .whole = whole.n / 3, .cracks = count_cracks(&cut, &whole)};
        sum_up(stats, &d);
    }
    free(cut.edge);
    free(whole.edge);
    free(d.error);
    free(d.seen);
    walk_fini(&all);
    walk_fini(&w);
    return rc;
}
