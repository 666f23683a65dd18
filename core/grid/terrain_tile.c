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
    tile->exact = t->published.xyz != NULL;
}

/* n samples of the array from element k on, widened to what a tile holds, to block dexel `to`. */
static void gather_run(struct dx_tile *tile, uint32_t to, const struct dx_plane *p, size_t k,
                       uint32_t n)
{
    uint32_t *range = tile->range + to;
    uint16_t *attr = tile->attr + to;

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
    if (tile->exact)
        memcpy(tile->xyz + 3 * (size_t)to, p->xyz + 3 * k, 3 * n * sizeof(*p->xyz));
}

static void clear_run(struct dx_tile *tile, uint32_t to, uint32_t n)
{
    memset(tile->range + to, 0, n * sizeof(*tile->range));
    memset(tile->attr + to, 0, n * sizeof(*tile->attr));
    if (tile->exact)
        memset(tile->xyz + 3 * (size_t)to, 0, 3 * n * sizeof(*tile->xyz));
}

/* The block row from block dexel `to` on of a tile whose first block column is column `col` of the
 * grid (-1: the one before it), which is the grid's row `row`. */
static void gather_row(struct dx_tile *tile, uint32_t to, const struct dx_terrain *t, uint32_t row,
                       int64_t col)
{
    const struct dx_plane *p = &t->published;
    uint32_t j = !t->tiling.wrap && col < 0, n;

    clear_run(tile, to, j);
    for (; j < DX_BLOCK; j += n) {
        uint32_t at =
            (uint32_t)((col + j + p->width) % p->width); /* past the seam: from column 0 */

        if (!t->tiling.wrap && col + j >= p->width)
            break;
        n = DX_BLOCK - j < p->width - at ? DX_BLOCK - j : p->width - at;
        gather_run(tile, to + j, p, (size_t)row * p->width + at, n);
    }
    clear_run(tile, to + j, DX_BLOCK - j);
}

/* The samples of a tile's block: struts use dexels beside its own cells. 0 outside the grid. */
static void gather(const struct dx_terrain *t, struct dx_tile *tile)
{
    int64_t row = (int64_t)tile->row * DX_TILE_CELLS - 1;
    int64_t col = (int64_t)tile->col * DX_TILE_CELLS - 1;

    for (uint32_t i = 0; i < DX_BLOCK; i++, row++)
        if (row >= 0 && row < t->published.height)
            gather_row(tile, i * DX_BLOCK, t, (uint32_t)row, col);
        else
            clear_run(tile, i * DX_BLOCK, DX_BLOCK);
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
