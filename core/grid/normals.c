/*
 * Vertex normals of one tile: every triangle that can touch its block adds its cross product to its
 * corners. Cells are visited row by row, which is NW, NE, SW, SE for each vertex; then struts in
 * the order of their owners.
 */
#include "core/grid/normals.h"

#include "core/grid/octahedral.h"
#include "core/grid/tile_used.h"

/* Block coordinates are counted from the block's first dexel; a ring of one dexel around the block
 * has the far corners of its triangles. Strut owners lie up to two dexels outside (their corners
 * reach from -1 to 2). */
#define RING       1
#define SIDE       (DX_BLOCK + 2 * RING)
#define STRUT_RING 2
#define STRUT_SIDE (DX_BLOCK + 2 * STRUT_RING)

struct field {
    const struct dx_normals_source *source;
    int64_t row0, col0; /* of the block's first dexel; columns not yet modulo the width */
    bool flip;
    int32_t col[STRUT_SIDE]; /* of the grid, from block column -STRUT_RING on; -1 outside */
    float sum[SIDE][SIDE][3];
};

/* Column of the grid, or -1 when it has none there. */
static int32_t grid_col(const struct dx_tiling *t, int64_t col)
{
    if (t->wrap)
        return (int32_t)((col % t->width + t->width) % t->width);
    return col >= 0 && col < t->width ? (int32_t)col : -1;
}

/* (p1 - p0) x (p2 - p0), added to the sums of the three. */
static inline void add_triangle(float *const sum[3], const float *p0, const float *p1,
                                const float *p2)
{
    const float u[3] = {p1[0] - p0[0], p1[1] - p0[1], p1[2] - p0[2]};
    const float v[3] = {p2[0] - p0[0], p2[1] - p0[1], p2[2] - p0[2]};
    const float n[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                        u[0] * v[1] - u[1] * v[0]};

    for (int m = 0; m < 3; m++) {
        sum[m][0] += n[0];
        sum[m][1] += n[1];
        sum[m][2] += n[2];
    }
}

/* ---- cells ---------------------------------------------------------------------------------- */

/* Corners 0 a, 1 b, 2 c, 3 d of the triangles of each outcome. */
static const struct {
    uint8_t n, corner[2][3];
} outcomes[7] = {
    [DX_CELL_ABC] = {1, {{0, 1, 2}}},
    [DX_CELL_ACD] = {1, {{0, 2, 3}}},
    [DX_CELL_ABC_ACD] = {2, {{0, 1, 2}, {0, 2, 3}}},
    [DX_CELL_ABD] = {1, {{0, 1, 3}}},
    [DX_CELL_BCD] = {1, {{1, 2, 3}}},
    [DX_CELL_ABD_BCD] = {2, {{0, 1, 3}, {1, 2, 3}}},
};

/* Codes of the cells of one row from block column -RING on; 0 where there is no cell. */
static void fetch_codes(uint8_t code[SIDE - 1], const struct field *f, uint32_t row)
{
    const struct dx_tiling *t = f->source->tiling;
    const uint8_t *of_tile = NULL;
    int32_t tile_col = -1;

    for (int j = 0; j < SIDE - 1; j++) {
        int32_t col = f->col[j + STRUT_RING - RING];

        code[j] = 0;
        if (col < 0 || (uint32_t)col >= t->cell_cols)
            continue;
        if (col / DX_TILE_CELLS != tile_col) {
            tile_col = col / DX_TILE_CELLS;
            of_tile = f->source->cells(f->source->ctx,
                                       row / DX_TILE_CELLS * t->cols + (uint32_t)tile_col);
        }
        code[j] = of_tile[row % DX_TILE_CELLS * DX_TILE_CELLS + (uint32_t)col % DX_TILE_CELLS];
    }
}

static void point_at(float p[3], const struct dx_normals_source *s, uint32_t row, uint32_t col)
{
    size_t k = (size_t)row * s->plane->width + col;

    if (s->plane->xyz)
        memcpy(p, s->plane->xyz + 3 * k, 3 * sizeof(*p));
    else
        dx_geometry_point(s->geometry, row, col, dx_plane_range(s->plane, k), p);
}

/* Points of a row of the grid; those outside it are not touched, and not used. */
static void fetch_points(float point[SIDE][3], const struct field *f, uint32_t row)
{
    for (int j = 0; j < SIDE; j++) {
        int32_t col = f->col[j + STRUT_RING - RING];

        if (col >= 0)
            point_at(point[j], f->source, row, (uint32_t)col);
    }
}

/* The cells of one row, whose sums begin with row i of the field. */
static void add_row(struct field *f, const uint8_t code[SIDE - 1], float (*top)[3],
                    float (*bottom)[3], int64_t i)
{
    const int second = f->flip ? 2 : 1, third = f->flip ? 1 : 2;

    for (int j = 0; j < SIDE - 1; j++) {
        const float *p[4] = {top[j], top[j + 1], bottom[j + 1], bottom[j]};
        float *sum[4] = {f->sum[i][j], f->sum[i][j + 1], f->sum[i + 1][j + 1], f->sum[i + 1][j]};

        for (int t = 0; t < outcomes[code[j]].n; t++) {
            const uint8_t *c = outcomes[code[j]].corner[t];

            add_triangle((float *const[3]){sum[c[0]], sum[c[1]], sum[c[2]]}, p[c[0]], p[c[second]],
                         p[c[third]]);
        }
    }
}

static void add_cells(struct field *f)
{
    float point[2][SIDE][3];
    uint8_t code[SIDE - 1];
    int64_t fetched = -1; /* row whose points are in point[row & 1] */

    for (int64_t i = 0; i < SIDE - 1; i++) {
        int64_t row = f->row0 - RING + i;

        if (row < 0 || row >= f->source->tiling->cell_rows)
            continue;
        if (fetched != row)
            fetch_points(point[row & 1], f, (uint32_t)row);
        fetched = row + 1;
        fetch_points(point[fetched & 1], f, (uint32_t)fetched);
        fetch_codes(code, f, (uint32_t)row);
        add_row(f, code, point[row & 1], point[fetched & 1], i);
    }
}

/* ---- struts --------------------------------------------------------------------------------- */

/* The triangles of a strut whose owner is `i` rows and `j` columns from the block's first dexel. */
static void add_strut(struct field *f, uint8_t code, int64_t i, int64_t j)
{
    const struct dx_normals_source *s = f->source;
    struct dx_strut_corner triangle[DX_STRUT_MAX_TRIANGLES][3];
    unsigned n = dx_strut_triangles(triangle, code);
    float beyond[3] = {0, 0, 0}; /* for corners outside the field */

    for (unsigned t = 0; t < n; t++) {
        float point[3][3], *sum[3];

        for (int m = 0; m < 3; m++) {
            const struct dx_strut_corner c = triangle[t][m];
            int64_t p = i + c.row, q = j + c.col;
            bool inside = p >= -RING && p < DX_BLOCK + RING && q >= -RING && q < DX_BLOCK + RING;

            point_at(point[m], s, (uint32_t)(f->row0 + p),
                     (uint32_t)grid_col(s->tiling, f->col0 + q));
            sum[m] = inside ? f->sum[p + RING][q + RING] : beyond;
        }
        add_triangle(sum, point[0], point[f->flip ? 2 : 1], point[f->flip ? 1 : 2]);
    }
}

/* The struts whose owners are in one row of the grid, `i` rows from the block's first. */
static void add_strut_row(struct field *f, uint32_t row, int64_t i)
{
    const struct dx_tiling *t = f->source->tiling;
    const uint8_t *of_tile = NULL;
    uint32_t tile_row = row / DX_TILE_CELLS, before = UINT32_MAX;

    /* the last row and column of dexels belong to the last cells' tile */
    tile_row = tile_row < t->rows ? tile_row : t->rows - 1;
    for (int64_t j = 0; j < STRUT_SIDE; j++) {
        uint32_t col = (uint32_t)f->col[j], tile_col = col / DX_TILE_CELLS;
        uint8_t code;

        if (f->col[j] < 0)
            continue;
        tile_col = tile_col < t->cols ? tile_col : t->cols - 1;
        if (tile_col != before)
            of_tile = f->source->struts(f->source->ctx, tile_row * t->cols + tile_col);
        before = tile_col;
        if (!of_tile)
            continue;
        code = of_tile[(row - tile_row * DX_TILE_CELLS + 1) * DX_BLOCK + col -
                       tile_col * DX_TILE_CELLS + 1];
        if (code)
            add_strut(f, code, i, j - STRUT_RING);
    }
}

static void add_struts(struct field *f)
{
    for (int64_t i = -STRUT_RING; i < DX_BLOCK + STRUT_RING; i++)
        if (f->row0 + i >= 0 && f->row0 + i < f->source->tiling->height)
            add_strut_row(f, (uint32_t)(f->row0 + i), i);
}

/* ---- both ----------------------------------------------------------------------------------- */

void dx_normals_compute(struct dx_tile *tile, const struct dx_normals_source *source)
{
    struct field f = {.source = source,
                      .row0 = (int64_t)tile->row * DX_TILE_CELLS - 1,
                      .col0 = (int64_t)tile->col * DX_TILE_CELLS - 1,
                      .flip = source->geometry->flip};
    struct dx_used used;

    for (int j = 0; j < STRUT_SIDE; j++)
        f.col[j] = grid_col(source->tiling, f.col0 + j - STRUT_RING);
    add_cells(&f);
    add_struts(&f);
    dx_used_mark(&used, tile);
    memset(tile->normal, 0, sizeof(tile->normal));
    for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++)
        if (used.at[k])
            dx_octahedral_encode(tile->normal + 2 * k,
                                 f.sum[k / DX_BLOCK + RING][k % DX_BLOCK + RING]);
    tile->has_normals = true;
}
