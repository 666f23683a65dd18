/* The truth of a scan, and meshes of its noisy frames. */
#include "tools/quality_rig.h"

#include "drivers/synth/world.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define ROUGH_M 0.03 /* an edge may leave the surface by this, or by the spacing of its ends */

/* ---- the truth of edges and cells ------------------------------------------------------------ */

/* Two rows of directions, the first of them repeated past the seam. */
struct directions {
    double (*row[2])[3];
};

static void fill_directions(double (*out)[3], const struct dx_geometry *g, uint32_t row)
{
    for (uint32_t j = 0; j <= g->width; j++)
        dx_sight_direction(out[j], g, row, j % g->width);
}

struct end {
    const double *direction;
    double range;
};

/*
 * Where the straight edge between two true points passes the middle of their directions, and where
 * the surface is there. In lengths of m = (d0 + d1) / 2 the edge is at the harmonic mean of the two
 * ranges: that is interpolation of inverse range, exactly, for depths as well.
 */
static bool is_rough(const struct dx_world *w, struct end x, struct end y, float *true_mid)
{
    double m[3], spacing = 0, near = x.range < y.range ? x.range : y.range, edge, surface;

    if (isinf(x.range) || isinf(y.range))
        return true;
    for (int k = 0; k < 3; k++) {
        double step = y.direction[k] - x.direction[k];

        m[k] = (x.direction[k] + y.direction[k]) / 2;
        spacing += step * step;
    }
    spacing = near * sqrt(spacing);
    edge = 2 / (1 / x.range + 1 / y.range);
    surface = dx_sight_along(w, m).range;
    *true_mid = (float)surface;
    return fabs(surface - edge) > (spacing > ROUGH_M ? spacing : ROUGH_M);
}

static struct end end_at(const struct dx_quality_rig *rig, const struct directions *d, uint32_t row,
                         uint32_t down, uint32_t col)
{
    return (struct end){d->row[down][col],
                        dx_quality_sight(rig, row + down, col % rig->geometry->width)->range};
}

static void find_rough(struct dx_quality_rig *rig, const struct dx_world *w,
                       const struct directions *d, uint32_t i, uint32_t j)
{
    const struct dx_geometry *g = rig->geometry;
    bool right = j + 1 < g->width || g->wrap, below = i + 1 < g->height;
    size_t k = (size_t)i * g->width + j;
    struct end a = end_at(rig, d, i, 0, j), b = a, c = a, e = a;
    unsigned rough = 0;
    float unused;

    if (right)
        b = end_at(rig, d, i, 0, j + 1);
    if (below)
        e = end_at(rig, d, i, 1, j);
    if (right && below)
        c = end_at(rig, d, i, 1, j + 1);
    rough |= (unsigned)(right && is_rough(w, a, b, &unused)) << DX_EDGE_H;
    rough |= (unsigned)(below && is_rough(w, a, e, &unused)) << DX_EDGE_V;
    if (right && below) {
        rough |= (unsigned)is_rough(w, a, c, &rig->mid[0][k]) << DX_EDGE_AC;
        rough |= (unsigned)is_rough(w, b, e, &rig->mid[1][k]) << DX_EDGE_BD;
    }
    rig->rough[k] = (uint8_t)rough;
}

static int find_all_rough(struct dx_quality_rig *rig)
{
    const struct dx_geometry *g = rig->geometry;
    double(*rows)[3] = malloc(2 * ((size_t)g->width + 1) * sizeof(*rows));
    struct directions d;
    struct dx_world w;

    if (!rows)
        return -ENOMEM;
    d = (struct directions){{rows, rows + g->width + 1}};
    dx_world_init(&w, &rig->scene, 0);
    fill_directions(d.row[0], g, 0);
    for (uint32_t i = 0; i < g->height; i++) {
        double(*first)[3] = d.row[0];

        if (i + 1 < g->height)
            fill_directions(d.row[1], g, i + 1);
        for (uint32_t j = 0; j < g->width; j++)
            find_rough(rig, &w, &d, i, j);
        d.row[0] = d.row[1];
        d.row[1] = first;
    }
    free(rows);
    return 0;
}

static uint8_t class_of(const struct dx_quality_rig *rig, uint32_t i, uint32_t j)
{
    uint32_t width = rig->geometry->width, next = (j + 1) % width;
    const struct dx_sight *a = dx_quality_sight(rig, i, j), *b = dx_quality_sight(rig, i, next);
    const struct dx_sight *c = dx_quality_sight(rig, i + 1, next);
    const struct dx_sight *d = dx_quality_sight(rig, i + 1, j);
    const uint8_t *rough = rig->rough;
    size_t k[4];
    unsigned any;

    if (!a->surface || !b->surface || !c->surface || !d->surface)
        return 0;
    dx_quality_corners(rig, i, j, k);
    any = rough[k[0]] | (rough[k[1]] & 1u << DX_EDGE_V) | (rough[k[3]] & 1u << DX_EDGE_H);
    if (any)
        return DX_QUALITY_SEEN;
    if (a->surface != b->surface || a->surface != c->surface || a->surface != d->surface)
        return DX_QUALITY_SEEN | DX_QUALITY_SMOOTH | DX_QUALITY_CROSSED;
    return DX_QUALITY_SEEN | DX_QUALITY_SMOOTH;
}

static void classify(struct dx_quality_rig *rig)
{
    const struct dx_tiling *t = &rig->tiling;

    for (uint32_t i = 0; i < t->cell_rows; i++)
        for (uint32_t j = 0; j < t->cell_cols; j++)
            rig->class[(size_t)i * t->cell_cols + j] = class_of(rig, i, j);
}

/* ---- rigs ------------------------------------------------------------------------------------ */

static void set_drawing(struct dx_scene_config *scene, const struct dx_quality_draw *draw)
{
    memcpy(scene->sigma, draw->sigma, sizeof(scene->sigma));
    scene->dropout = draw->dropout;
    scene->mixed = draw->mixed;
    scene->seed = draw->seed;
}

static int allocate(struct dx_quality_rig *rig)
{
    const struct dx_geometry *g = rig->geometry;
    size_t n = (size_t)g->height * g->width;

    rig->sights = malloc((n + 2 * (size_t)g->height) * sizeof(*rig->sights));
    rig->rough = calloc(n, 1);
    rig->class = calloc(n, 1);
    rig->code = calloc(n, 1);
    for (int k = 0; k < 2; k++)
        rig->mid[k] = calloc(n, sizeof(float));
    if (!rig->sights || !rig->rough || !rig->class || !rig->code || !rig->mid[0] || !rig->mid[1])
        return -ENOMEM;
    return dx_plane_init(&rig->frame, g->height, g->width, g->range_bytes, 0);
}

static int look(struct dx_quality_rig *rig)
{
    const struct dx_geometry *g = rig->geometry;
    struct dx_world w;

    dx_world_init(&w, &rig->scene, 0);
    for (uint32_t i = 0; i < g->height; i++)
        dx_sight_row(rig->sights + (size_t)i * (g->width + 2), &w, g, i, -1, g->width + 2);
    return find_all_rough(rig);
}

int dx_quality_rig_new(struct dx_quality_rig **out, const struct dx_scene_config *scene)
{
    const struct dx_quality_draw quiet = {.seed = scene->seed};
    struct dx_quality_rig *rig = calloc(1, sizeof(*rig));
    int rc;

    if (!rig)
        return -ENOMEM;
    rig->scene = *scene;
    set_drawing(&rig->scene, &quiet);
    rc = dx_scene_geometry(&rig->geometry, &rig->scene);
    if (rc == 0)
        rc = allocate(rig);
    if (rc == 0)
        rc = look(rig);
    if (rc < 0) {
        dx_quality_rig_free(rig);
        return rc;
    }
    dx_tiling_init(&rig->tiling, scene->height, scene->width, rig->geometry->wrap);
    classify(rig);
    *out = rig;
    return 0;
}

void dx_quality_rig_free(struct dx_quality_rig *rig)
{
    if (!rig)
        return;
    dx_terrain_free(rig->terrain);
    dx_plane_fini(&rig->frame);
    free(rig->code);
    free(rig->mid[0]);
    free(rig->mid[1]);
    free(rig->class);
    free(rig->rough);
    free(rig->sights);
    dx_geometry_unref(rig->geometry);
    free(rig);
}

/* ---- frames and meshes ----------------------------------------------------------------------- */

static const struct dx_sight *row_or_null(const struct dx_quality_rig *rig, int64_t row)
{
    return row >= 0 && row < rig->geometry->height ? dx_quality_sight(rig, (uint32_t)row, 0) : NULL;
}

void dx_quality_rig_draw(struct dx_quality_rig *rig, const struct dx_quality_draw *draw)
{
    struct dx_sensor sensor;

    set_drawing(&rig->scene, draw);
    rig->frame_number = draw->frame;
    dx_sensor_init(&sensor, rig->geometry, &rig->scene, draw->frame);
    for (uint32_t i = 0; i < rig->geometry->height; i++)
        dx_sensor_row(&rig->frame, &sensor, i, 0, rig->geometry->width, dx_quality_sight(rig, i, 0),
                      row_or_null(rig, (int64_t)i - 1), row_or_null(rig, (int64_t)i + 1));
}

bool dx_quality_rig_mixed(const struct dx_quality_rig *rig, uint32_t row, uint32_t col)
{
    const struct dx_sight *above = row_or_null(rig, (int64_t)row - 1);
    const struct dx_sight *below = row_or_null(rig, (int64_t)row + 1);
    struct dx_sensor sensor;

    dx_sensor_init(&sensor, rig->geometry, &rig->scene, rig->frame_number);
    return dx_sensor_mixes(&sensor, row, col, dx_quality_sight(rig, row, col),
                           above ? above + col : NULL, below ? below + col : NULL);
}

struct dx_terrain_params dx_quality_rig_params(const struct dx_quality_rig *rig)
{
    struct dx_terrain_params p;

    dx_terrain_params_default(&p);
    memcpy(p.sigma, rig->scene.sigma, sizeof(p.sigma));
    p.sigma_given = true;
    return p;
}

static void copy_codes(struct dx_quality_rig *rig, const struct dx_tile *tile)
{
    size_t stride = rig->tiling.cell_cols;
    uint8_t *to =
        rig->code + (size_t)tile->row * DX_TILE_CELLS * stride + (size_t)tile->col * DX_TILE_CELLS;

    for (uint32_t i = 0; i < tile->cell_rows; i++)
        memcpy(to + i * stride, tile->code + (size_t)i * DX_TILE_CELLS, tile->cell_cols);
}

int dx_quality_rig_mesh(struct dx_quality_rig *rig, const struct dx_terrain_params *params)
{
    struct dx_tile *tile = malloc(sizeof(*tile));
    int rc = tile ? 0 : -ENOMEM;

    dx_terrain_free(rig->terrain);
    rig->terrain = NULL;
    if (rc == 0)
        rc = dx_terrain_new(&rig->terrain, rig->geometry, params, 0);
    if (rc == 0) {
        dx_terrain_publish(rig->terrain, &rig->frame, 0, rig->frame.width, NULL);
        dx_terrain_commit(rig->terrain, NULL);
        for (uint32_t k = 0; k < dx_tiling_n_tiles(&rig->tiling); k++) {
            dx_terrain_tile(rig->terrain, k, tile);
            copy_codes(rig, tile);
        }
    }
    free(tile);
    return rc;
}

/* ---- triangles ------------------------------------------------------------------------------- */

struct tile_walk {
    struct dx_tile tile;
    struct dx_tile_mesh mesh;
    uint16_t block[DX_TILE_MAX_VERTICES]; /* block dexel of a rank */
};

static void walk_tile(struct tile_walk *w, const struct dx_tiling *tiling,
                      void (*fn)(void *, const struct dx_quality_triangle *), void *ctx)
{
    uint32_t n = 0;

    for (uint16_t k = 0; k < DX_BLOCK_DEXELS; k++)
        if (w->mesh.mask[k / 8] >> (k % 8) & 1)
            w->block[n++] = k;
    for (uint32_t k = 0; k < w->mesh.n_triangles; k++) {
        struct dx_quality_triangle t;

        for (int m = 0; m < 3; m++) {
            uint16_t rank = w->mesh.index[3 * (size_t)k + (size_t)m], at = w->block[rank];

            t.id[m] = dx_tile_vertex_id(tiling, w->tile.row, w->tile.col, at);
            t.row[m] = (int64_t)w->tile.row * DX_TILE_CELLS + at / DX_BLOCK - 1;
            t.col[m] = (int64_t)w->tile.col * DX_TILE_CELLS + at % DX_BLOCK - 1;
            t.point[m] = w->mesh.xyz + 3 * (size_t)rank;
        }
        fn(ctx, &t);
    }
}

int dx_quality_each_triangle(const struct dx_quality_rig *rig,
                             void (*fn)(void *ctx, const struct dx_quality_triangle *t), void *ctx)
{
    struct tile_walk *w = calloc(1, sizeof(*w));

    if (!w)
        return -ENOMEM;
    for (uint32_t k = 0; k < dx_tiling_n_tiles(&rig->tiling); k++) {
        if (!dx_terrain_tile(rig->terrain, k, &w->tile))
            continue;
        dx_tile_mesh_build(&w->mesh, &w->tile, &rig->tiling, rig->geometry);
        walk_tile(w, &rig->tiling, fn, ctx);
    }
    free(w);
    return 0;
}
