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

struct field {
    const struct dx_normals_source *source;
    int64_t row0, col0; /* of the block's first dexel; columns not yet modulo the width */
    bool flip;
    float sum[SIDE][SIDE][3];
};

/* Column of the grid, or -1 when it has none there. */
static int64_t grid_col(const struct dx_tiling *t, int64_t col)
{
    if (t->wrap)
        return (col % t->width + t->width) % t->width;
    return col >= 0 && col < t->width ? col : -1;
}

/* (p1 - p0) x (p2 - p0), added to the sums of the three; turned round when `flip`. */
static void add_triangle(float *const sum[3], const float *const p[3], bool flip)
{
    float u[3], v[3], n[3];

    for (int k = 0; k < 3; k++) {
        u[k] = p[flip ? 2 : 1][k] - p[0][k];
        v[k] = p[flip ? 1 : 2][k] - p[0][k];
    }
    n[0] = u[1] * v[2] - u[2] * v[1];
    n[1] = u[2] * v[0] - u[0] * v[2];
    n[2] = u[0] * v[1] - u[1] * v[0];
    for (int m = 0; m < 3; m++)
        for (int k = 0; sum[m] && k < 3; k++)
            sum[m][k] += n[k];
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

/* Codes of the cells whose a is (row, col0 - 1 + j); 0 where there is no cell. */
static void fetch_codes(uint8_t code[SIDE - 1], const struct field *f, int64_t row)
{
    const struct dx_tiling *t = f->source->tiling;
    uint32_t tile_row = (uint32_t)row / DX_TILE_CELLS;

    for (int64_t j = 0; j < SIDE - 1; j++) {
        int64_t col = grid_col(t, f->col0 - RING + j);

        code[j] = 0;
        if (col < 0 || col >= t->cell_cols)
            continue;
        code[j] = f->source->cells(
            f->source->ctx,
            tile_row * t->cols +
                (uint32_t)col /
                    DX_TILE_CELLS)[row % DX_TILE_CELLS * DX_TILE_CELLS + col % DX_TILE_CELLS];
    }
}

/* Points of a row of the grid; those outside it are not touched, and not used. */
static void fetch_points(float point[SIDE][3], const struct field *f, int64_t row)
{
    const struct dx_normals_source *s = f->source;

    for (int64_t j = 0; j < SIDE; j++) {
        int64_t col = grid_col(s->tiling, f->col0 - RING + j);

        if (col >= 0)
            dx_geometry_point(s->geometry, (uint32_t)row, (uint32_t)col,
                              dx_plane_range(s->plane, (size_t)row * s->plane->width + (size_t)col),
                              point[j]);
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
            fetch_points(point[row & 1], f, row);
        fetch_points(point[(row + 1) & 1], f, row + 1);
        fetched = row + 1;
        fetch_codes(code, f, row);
        for (int64_t j = 0; j < SIDE - 1; j++) {
            const float *p[4] = {point[row & 1][j], point[row & 1][j + 1],
                                 point[(row + 1) & 1][j + 1], point[(row + 1) & 1][j]};
            float *sum[4] = {f->sum[i][j], f->sum[i][j + 1], f->sum[i + 1][j + 1],
                             f->sum[i + 1][j]};

            for (int t = 0; t < outcomes[code[j]].n; t++) {
                const uint8_t *c = outcomes[code[j]].corner[t];

                add_triangle((float *const[3]){sum[c[0]], sum[c[1]], sum[c[2]]},
                             (const float *const[3]){p[c[0]], p[c[1]], p[c[2]]}, f->flip);
            }
        }
    }
}

/* ---- struts --------------------------------------------------------------------------------- */

/* Code of the strut that dexel (row, col) owns; 0: none. */
static uint8_t strut_at(const struct field *f, uint32_t row, uint32_t col)
{
    const struct dx_tiling *t = f->source->tiling;
    uint32_t tile_row = row / DX_TILE_CELLS, tile_col = col / DX_TILE_CELLS;
    const uint8_t *struts;

    /* the last row and column of dexels belong to the last cells' tile */
    tile_row = tile_row < t->rows ? tile_row : t->rows - 1;
    tile_col = tile_col < t->cols ? tile_col : t->cols - 1;
    struts = f->source->struts(f->source->ctx, tile_row * t->cols + tile_col);
    return struts ? struts[(row - tile_row * DX_TILE_CELLS + 1) * DX_BLOCK +
                           (col - tile_col * DX_TILE_CELLS + 1)]
                  : 0;
}

/* The triangles of a strut whose owner is `i` rows and `j` columns from the block's first dexel. */
static void add_strut(struct field *f, uint8_t code, int64_t i, int64_t j)
{
    const struct dx_normals_source *s = f->source;
    struct dx_strut_corner triangle[DX_STRUT_MAX_TRIANGLES][3];
    unsigned n = dx_strut_triangles(triangle, code);

    for (unsigned t = 0; t < n; t++) {
        float point[3][3], *sum[3];

        for (int m = 0; m < 3; m++) {
            int64_t p = i + triangle[t][m].row, q = j + triangle[t][m].col;
            uint32_t row = (uint32_t)(f->row0 + p);
            uint32_t col = (uint32_t)grid_col(s->tiling, f->col0 + q);

            dx_geometry_point(s->geometry, row, col,
                              dx_plane_range(s->plane, (size_t)row * s->plane->width + col),
                              point[m]);
            sum[m] = p >= -RING && p < DX_BLOCK + RING && q >= -RING && q < DX_BLOCK + RING
                         ? f->sum[p + RING][q + RING]
                         : NULL;
        }
        add_triangle(sum, (const float *const[3]){point[0], point[1], point[2]}, f->flip);
    }
}

static void add_struts(struct field *f)
{
    for (int64_t i = -STRUT_RING; i < DX_BLOCK + STRUT_RING; i++) {
        int64_t row = f->row0 + i;

        if (row < 0 || row >= f->source->tiling->height)
            continue;
        for (int64_t j = -STRUT_RING; j < DX_BLOCK + STRUT_RING; j++) {
            int64_t col = grid_col(f->source->tiling, f->col0 + j);
            uint8_t code = col < 0 ? 0 : strut_at(f, (uint32_t)row, (uint32_t)col);

            if (code)
                add_strut(f, code, i, j);
        }
    }
}

/* ---- both ----------------------------------------------------------------------------------- */

void dx_normals_compute(struct dx_tile *tile, const struct dx_normals_source *source)
{
    struct field f = {.source = source,
                      .row0 = (int64_t)tile->row * DX_TILE_CELLS - 1,
                      .col0 = (int64_t)tile->col * DX_TILE_CELLS - 1,
                      .flip = source->geometry->flip};
    struct dx_used used;

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
