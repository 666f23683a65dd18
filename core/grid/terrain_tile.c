/* What the mesh of the published array is in one tile: outcome, samples, normals. */
#include "core/grid/normals.h"
#include "core/grid/rules.h"
#include "core/grid/terrain_priv.h"

#include <string.h>

/* Which rectangle of the grid a tile is, without its samples. */
void dx_terrain_describe(const struct dx_terrain *t, uint32_t number, struct dx_tile *tile)
{
    const struct dx_tiling *g = &t->tiling;
    uint32_t row = number / g->cols, col = number % g->cols;
    uint32_t rows = g->cell_rows - row * DX_TILE_CELLS, cols = g->cell_cols - col * DX_TILE_CELLS;

    tile->row = (uint16_t)row;
    tile->col = (uint16_t)col;
    tile->cell_rows = (uint8_t)(rows < DX_TILE_CELLS ? rows : DX_TILE_CELLS);
    tile->cell_cols = (uint8_t)(cols < DX_TILE_CELLS ? cols : DX_TILE_CELLS);
    tile->attr_bytes = t->published.attr_bytes;
}

/* n samples of the array from element k on, widened to what a tile holds. */
static void gather_run(const struct dx_plane *p, size_t k, uint32_t n, uint32_t *range,
                       uint16_t *attr)
{
    if (p->range_bytes == 4)
        memcpy(range, (const uint32_t *)p->range + k, n * sizeof(*range));
    else
        for (uint32_t j = 0; j < n; j++)
            range[j] = ((const uint16_t *)p->range)[k + j];
    if (p->attr_bytes == 2)
        memcpy(attr, (const uint16_t *)p->attr + k, n * sizeof(*attr));
    else if (p->attr_bytes == 1)
        for (uint32_t j = 0; j < n; j++)
            attr[j] = ((const uint8_t *)p->attr)[k + j];
}

/* One block row of a tile whose first block column is column `col` of the grid (-1: the one before
 * it), which is the grid's row `row`. */
static void gather_row(const struct dx_terrain *t, uint32_t row, int64_t col, uint32_t *range,
                       uint16_t *attr)
{
    const struct dx_plane *p = &t->published;
    uint32_t j = !t->tiling.wrap && col < 0, n;

    if (j)
        range[0] = attr[0] = 0;
    for (; j < DX_BLOCK; j += n) {
        uint32_t at =
            (uint32_t)((col + j + p->width) % p->width); /* past the seam: from column 0 */

        if (!t->tiling.wrap && col + j >= p->width)
            break;
        n = DX_BLOCK - j < p->width - at ? DX_BLOCK - j : p->width - at;
        gather_run(p, (size_t)row * p->width + at, n, range + j, attr + j);
    }
    memset(range + j, 0, (DX_BLOCK - j) * sizeof(*range));
    memset(attr + j, 0, (DX_BLOCK - j) * sizeof(*attr));
}

/* The samples of a tile's block: struts use dexels beside its own cells. 0 outside the grid. */
static void gather(const struct dx_terrain *t, struct dx_tile *tile)
{
    int64_t row = (int64_t)tile->row * DX_TILE_CELLS - 1;
    int64_t col = (int64_t)tile->col * DX_TILE_CELLS - 1;

    for (uint32_t i = 0; i < DX_BLOCK; i++, row++) {
        uint32_t *range = tile->range + (size_t)i * DX_BLOCK;
        uint16_t *attr = tile->attr + (size_t)i * DX_BLOCK;

        if (row >= 0 && row < t->published.height) {
            gather_row(t, (uint32_t)row, col, range, attr);
        } else {
            memset(range, 0, DX_BLOCK * sizeof(*range));
            memset(attr, 0, DX_BLOCK * sizeof(*attr));
        }
    }
}

/* ---- normals -------------------------------------------------------------------------------- */

static const uint8_t *cells_of(const void *ctx, uint32_t tile)
{
    const struct dx_terrain *t = ctx;

    return t->code + (size_t)tile * DX_TILE_CELLS * DX_TILE_CELLS;
}

static const uint8_t *struts_of(const void *ctx, uint32_t tile)
{
    const struct dx_terrain *t = ctx;

    return t->gates.bridge ? t->strut + (size_t)tile * DX_BLOCK_DEXELS : NULL;
}

static void fill_normals(const struct dx_terrain *t, struct dx_tile *tile)
{
    const struct dx_normals_source source = {.plane = &t->published,
                                             .tiling = &t->tiling,
                                             .geometry = t->geometry,
                                             .ctx = t,
                                             .cells = cells_of,
                                             .struts = struts_of};

    tile->has_normals = t->params.normals;
    if (t->params.normals)
        dx_normals_compute(tile, &source);
}

/* ---- a tile --------------------------------------------------------------------------------- */

bool dx_terrain_tile(const struct dx_terrain *t, uint32_t number, struct dx_tile *tile)
{
    dx_terrain_describe(t, number, tile);
    memcpy(tile->code, t->code + (size_t)number * sizeof(tile->code), sizeof(tile->code));
    memcpy(tile->strut, t->strut + (size_t)number * sizeof(tile->strut), sizeof(tile->strut));
    if (!dx_rules_any(tile))
        return false;
    gather(t, tile);
    fill_normals(t, tile);
    return true;
}
