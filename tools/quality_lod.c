/* What levels of detail leave out, how far that is from what they keep, and whether they crack. */
#include "tools/quality.h"

#include "core/grid/lod.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define MM 1e-3

/* ---- triangles of a level -------------------------------------------------------------------- */

/* Corners as dexels, with columns that run on past the seam. */
struct cut_triangle {
    int64_t row[3], col[3];
};

struct walk {
    const struct dx_quality_rig *rig;
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

static int walk_init(struct walk *w, const struct dx_quality_rig *rig, struct dx_lod_level level)
{
    const struct dx_lod_level levels[DX_LOD_SLOTS] = {level};
    int rc = 0;

    *w = (struct walk){.rig = rig, .level = level};
    w->tile = malloc(sizeof(*w->tile));
    w->whole = malloc(sizeof(*w->whole));
    w->cut = malloc(sizeof(*w->cut));
    w->scratch = dx_lod_scratch_new();
    if (!w->tile || !w->whole || !w->cut || !w->scratch)
        rc = -ENOMEM;
    if (rc == 0 && !dx_lod_is_whole(level))
        rc = dx_lod_new(&w->lod, rig->terrain, NULL);
    if (rc < 0)
        walk_fini(w);
    else if (w->lod)
        dx_lod_update(w->lod, levels, NULL);
    return rc;
}

static void walk_tile(const struct walk *w, const struct dx_tile_mesh *mesh,
                      void (*fn)(void *ctx, const struct cut_triangle *t), void *ctx)
{
    uint16_t at[DX_TILE_MAX_VERTICES], n = 0;

    for (uint16_t k = 0; k < DX_BLOCK_DEXELS; k++)
        if (mesh->mask[k / 8] >> (k % 8) & 1)
            at[n++] = k;
    for (uint32_t k = 0; k < mesh->n_triangles; k++) {
        struct cut_triangle t;

        for (int m = 0; m < 3; m++) {
            const uint16_t d = at[mesh->index[3 * k + (uint32_t)m]];

            t.row[m] = (int64_t)mesh->row * DX_TILE_CELLS + d / DX_BLOCK - 1;
            t.col[m] = (int64_t)mesh->col * DX_TILE_CELLS + d % DX_BLOCK - 1;
        }
        fn(ctx, &t);
    }
    (void)w;
}

static void walk_level(struct walk *w, void (*fn)(void *ctx, const struct cut_triangle *t),
                       void *ctx)
{
    for (uint32_t n = 0; n < dx_tiling_n_tiles(&w->rig->tiling); n++) {
        if (!dx_terrain_tile(w->rig->terrain, n, w->tile))
            continue;
        dx_tile_mesh_build(w->whole, w->tile, &w->rig->tiling, w->rig->geometry);
        if (w->lod)
            dx_lod_mesh(w->cut, w->lod, w->level, w->tile, w->whole, w->scratch);
        walk_tile(w, w->lod ? w->cut : w->whole, fn, ctx);
    }
}

static uint64_t dexel_at(const struct dx_quality_rig *rig, int64_t row, int64_t col)
{
    const int64_t width = rig->geometry->width;

    return (uint64_t)(row * width + (col + width) % width);
}

/* ---- cracks ---------------------------------------------------------------------------------- */

/* Directed edges, from * 2^32 + to. */
struct edges {
    const struct dx_quality_rig *rig;
    uint64_t *edge;
    size_t n, room;
};

static int by_number(const void *x, const void *y)
{
    const uint64_t a = *(const uint64_t *)x, b = *(const uint64_t *)y;

    return (a > b) - (a < b);
}

static void add_edges(void *ctx, const struct cut_triangle *t)
{
    struct edges *e = ctx;

    for (int m = 0; m < 3 && e->n < e->room; m++) {
        const int next = (m + 1) % 3;

        e->edge[e->n++] = dexel_at(e->rig, t->row[m], t->col[m]) << 32 |
                          dexel_at(e->rig, t->row[next], t->col[next]);
    }
}

static int edges_init(struct edges *e, const struct dx_quality_rig *rig, struct walk *w)
{
    *e = (struct edges){.rig = rig};
    e->room = 6 * (size_t)rig->tiling.cell_rows * rig->tiling.cell_cols;
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

static bool is_on_border(const struct dx_quality_rig *rig, uint64_t from, uint64_t to)
{
    const uint64_t width = rig->geometry->width, last = rig->geometry->height - 1;

    if (from / width == to / width)
        return from / width == 0 || from / width == last;
    return !rig->geometry->wrap && from % width == to % width &&
           (from % width == 0 || from % width == width - 1);
}

/* Edges of one triangle that are neither so in the whole mesh nor on the border of the grid. */
static uint64_t count_cracks(const struct edges *cut, const struct edges *whole)
{
    uint64_t n = 0;

    for (size_t k = 0; k < cut->n; k++) {
        const uint64_t edge = cut->edge[k], back = edge >> 32 | edge << 32;
        const bool was_open = has_edge(whole, edge) && !has_edge(whole, back);

        n += !has_edge(cut, back) && !was_open &&
             !is_on_border(cut->rig, edge >> 32, edge & UINT32_MAX);
    }
    return n;
}

/* ---- distances ------------------------------------------------------------------------------- */

struct distances {
    const struct dx_quality_rig *rig;
    uint8_t *seen; /* by dexel: a vertex, or measured */
    uint64_t n, n_triangles;
    double most, sum;
};

static void point_of(const struct dx_quality_rig *rig, uint64_t dexel, double p[3])
{
    const uint32_t row = (uint32_t)(dexel / rig->geometry->width);
    const uint32_t col = (uint32_t)(dexel % rig->geometry->width);
    float x[3];

    dx_geometry_point(rig->geometry, row, col,
                      dx_plane_range(dx_terrain_published(rig->terrain), dexel), x);
    for (int k = 0; k < 3; k++)
        p[k] = (double)x[k];
}

/* How far dexel's sample is from the triangle's plane along its beam, in sigmas. */
static double distance_of(const struct dx_quality_rig *rig, double p[3][3], uint64_t dexel)
{
    const double *s = rig->scene.sigma, half_unit = 0.5 * (double)rig->geometry->unit_m;
    double u[3], v[3], n[3], q[3], r, along = 0, at = 0, s0 = s[0] > half_unit ? s[0] : half_unit;

    for (int k = 0; k < 3; k++) {
        u[k] = p[1][k] - p[0][k];
        v[k] = p[2][k] - p[0][k];
    }
    n[0] = u[1] * v[2] - u[2] * v[1];
    n[1] = u[2] * v[0] - u[0] * v[2];
    n[2] = u[0] * v[1] - u[1] * v[0];
    point_of(rig, dexel, q);
    for (int k = 0; k < 3; k++) {
        at += n[k] * p[0][k];
        along += n[k] * q[k];
    }
    r = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2]);
    return r * fabs(at / along - 1) / (s0 + r * (s[1] + r * s[2]));
}

static bool is_inside(const struct cut_triangle *t, int64_t row, int64_t col)
{
    int less = 0, more = 0;

    for (int m = 0; m < 3; m++) {
        const int n = (m + 1) % 3;
        const int64_t side = (t->col[n] - t->col[m]) * (row - t->row[m]) -
                             (t->row[n] - t->row[m]) * (col - t->col[m]);

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

static void mark_corners(void *ctx, const struct cut_triangle *t)
{
    struct distances *d = ctx;

    d->n_triangles++;
    for (int m = 0; m < 3; m++)
        d->seen[dexel_at(d->rig, t->row[m], t->col[m])] = 1;
}

static void measure(void *ctx, const struct cut_triangle *t)
{
    struct distances *d = ctx;
    double p[3][3];

    for (int m = 0; m < 3; m++)
        point_of(d->rig, dexel_at(d->rig, t->row[m], t->col[m]), p[m]);
    for (int64_t i = least(t->row); i <= greatest(t->row); i++)
        for (int64_t j = least(t->col); j <= greatest(t->col); j++) {
            const uint64_t dexel = dexel_at(d->rig, i, j);
            double e;

            if (d->seen[dexel] || !is_inside(t, i, j) ||
                !dx_plane_range(dx_terrain_published(d->rig->terrain), dexel))
                continue;
            d->seen[dexel] = 1;
            e = distance_of(d->rig, p, dexel);
            d->most = e > d->most ? e : d->most;
            d->sum += e * e;
            d->n++;
        }
}

/* ---- the figure ------------------------------------------------------------------------------ */

int dx_quality_lod(struct dx_quality_lod *out, const struct dx_quality_rig *rig,
                   struct dx_lod_level level)
{
    struct distances d = {.rig = rig};
    struct edges cut = {0}, whole = {0};
    struct walk w, all = {0};
    int rc = walk_init(&w, rig, level);

    if (rc < 0)
        return rc;
    d.seen = calloc(dx_plane_n_dexels(&rig->frame), 1);
    rc = d.seen ? walk_init(&all, rig, (struct dx_lod_level){0}) : -ENOMEM;
    if (rc == 0)
        rc = edges_init(&whole, rig, &all);
    if (rc == 0)
        rc = edges_init(&cut, rig, &w);
    if (rc == 0) {
        walk_level(&w, mark_corners, &d);
        walk_level(&w, measure, &d);
        *out = (struct dx_quality_lod){.triangles = d.n_triangles,
                                       .whole = whole.n / 3,
                                       .cracks = count_cracks(&cut, &whole),
                                       .max_sigma = d.most,
                                       .rms_sigma = d.n ? sqrt(d.sum / (double)d.n) : 0};
    }
    free(cut.edge);
    free(whole.edge);
    free(d.seen);
    walk_fini(&all);
    walk_fini(&w);
    return rc;
}

/* ---- the theme ------------------------------------------------------------------------------- */

static int lod_rows(struct dx_quality_table *t, struct dx_quality_rig *rig)
{
    static const struct dx_lod_level levels[] = {
        {.bound = 1 * DX_LOD_PER_SIGMA},
        {.bound = 2 * DX_LOD_PER_SIGMA},
        {.bound = 4 * DX_LOD_PER_SIGMA},
        {.bound = 8 * DX_LOD_PER_SIGMA},
        {.stride = 8},
    };

    for (size_t k = 0; k < sizeof(levels) / sizeof(levels[0]); k++) {
        struct dx_quality_lod q;
        struct dx_quality_row *row;
        int rc = dx_quality_lod(&q, rig, levels[k]);

        if (rc < 0)
            return rc;
        row = dx_quality_row(t, &rig->scene);
        if (levels[k].stride)
            snprintf(row->note, sizeof(row->note), "stride %u", levels[k].stride);
        else
            snprintf(row->note, sizeof(row->note), "%u sigma", levels[k].bound / DX_LOD_PER_SIGMA);
        row->value[0] = (double)q.triangles;
        row->value[1] = 100 * (double)q.triangles / (double)q.whole;
        row->value[2] = q.max_sigma;
        row->value[3] = q.rms_sigma;
        row->value[4] = (double)q.cracks;
        dx_quality_hold(row, 4, DX_QUALITY_AT_MOST, 0);
    }
    return 0;
}

int dx_quality_theme_lod(struct dx_quality_run *run)
{
    static const struct {
        struct dx_quality_scan scan;
        double sigma, dropout;
    } cases[] = {
        {{DX_SCENE_HALL, 600, 400, false}, 2 * MM, 0},
        {{DX_SCENE_HALL, 600, 400, false}, 10 * MM, 0},
        {{DX_SCENE_HALL, 600, 400, false}, 10 * MM, 0.01},
        {{DX_SCENE_OPEN, 600, 400, false}, 5 * MM, 0},
        {{DX_SCENE_MOVING_BOX, 640, 480, false}, 5 * MM, 0},
    };
    struct dx_quality_table t = {
        .theme = "lod",
        .title = "Levels of detail",
        .text =
            "Triangles of a level, and their share of the whole mesh's; how far the samples that "
            "it\n"
            "leaves out are from its surface along their beams, in sigmas, at most and root of "
            "the\n"
            "mean square (samples on the surface itself have 1); cracks are open edges that the\n"
            "whole mesh does not have.",
        .column = {{"triangles", "triangles", 0},
                   {"of whole %", "share_percent", 1},
                   {"max / sigma", "max_sigma", 1},
                   {"rms / sigma", "rms_sigma", 2},
                   {"cracks", "cracks", 0}},
    };
    int rc = 0;

    for (size_t k = 0; rc == 0 && k < sizeof(cases) / sizeof(cases[0]); k++) {
        const struct dx_quality_draw draw = {
            .sigma = {cases[k].sigma}, .dropout = cases[k].dropout, .seed = run->seed};
        struct dx_quality_rig *rig = NULL;
        struct dx_terrain_params p;

        rc = dx_quality_run_rig(&rig, run, &cases[k].scan);
        if (rc < 0)
            break;
        dx_quality_rig_draw(rig, &draw);
        p = dx_quality_rig_params(rig);
        rc = dx_quality_rig_mesh(rig, &p);
        if (rc == 0)
            rc = lod_rows(&t, rig);
        dx_quality_rig_free(rig);
    }
    if (rc == 0)
        dx_quality_report_table(run->report, &t);
    return rc;
}
