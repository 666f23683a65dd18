/* What the mesh of the published array is in one tile: outcome, samples, normals. */
#include "core/grid/normals.h"
#include "core/grid/rules.h"
#include "core/grid/runs.h"
#include "core/grid/terrain_priv.h"
#include "core/rows/rows.h"

#include <assert.h>
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

/* ---- samples -------------------------------------------------------------------------------- */

static void widen_ranges(uint32_t *restrict to, const uint16_t *from, uint32_t n)
{
    for (uint32_t j = 0; j < n; j++)
        to[j] = from[j];
}

static void widen_attrs(uint16_t *restrict to, const uint8_t *from, uint32_t n)
{
    for (uint32_t j = 0; j < n; j++)
        to[j] = from[j];
}

static void gather_ranges(uint32_t *to, const struct dx_plane *p, size_t row,
                          const struct dx_runs *runs)
{
    if (p->range_bytes == 4) {
        dx_runs_gather(to, (const uint32_t *)p->range + row, 4, runs, DX_BLOCK);
        return;
    }
    if (runs->n_columns < DX_BLOCK)
        memset(to, 0, DX_BLOCK * sizeof(*to));
    for (const struct dx_run *r = runs->run; r < runs->run + runs->n; r++)
        widen_ranges(to + r->at, (const uint16_t *)p->range + row + r->col, r->n);
}

static_assert(DX_ROWS_BLOCK == DX_BLOCK, "rows of the same columns");

/* Most blocks are in the middle of the grid: whole rows of 16-bit ranges, and room behind them. */
static bool gather_whole(uint32_t *to, const struct dx_plane *p, int64_t row0,
                         const struct dx_runs *runs)
{
    const size_t last = (size_t)(row0 + DX_BLOCK - 1) * p->width + runs->run->col;

    if (p->range_bytes != 2 || row0 < 0 || row0 + DX_BLOCK > p->height || runs->n != 1 ||
        runs->n_columns < DX_BLOCK || last + DX_ROWS_N > dx_plane_n_dexels(p))
        return false;
    dx_rows_get(DX_SIMD_AUTO)
        ->widen(to, (const uint16_t *)p->range + (size_t)row0 * p->width + runs->run->col, p->width,
                DX_BLOCK);
    return true;
}

static void gather_attrs(uint16_t *to, const struct dx_plane *p, size_t row,
                         const struct dx_runs *runs)
{
    const uint8_t *narrow = (const uint8_t *)p->attr + row;

    if (p->attr_bytes == 2)
        dx_runs_gather(to, (const uint16_t *)p->attr + row, 2, runs, DX_BLOCK);
    if (p->attr_bytes != 1)
        return;
    memset(to, 0, DX_BLOCK * sizeof(*to));
    for (const struct dx_run *r = runs->run; r < runs->run + runs->n; r++)
        widen_attrs(to + r->at, narrow + r->col, r->n);
}

/* The samples of a tile's block: struts use dexels beside its own cells. 0 outside the grid. */
static void gather(const struct dx_terrain *t, struct dx_tile *tile)
{
    const struct dx_plane *p = &t->published;
    const int64_t row0 = (int64_t)tile->row * DX_TILE_CELLS - 1;
    static const struct dx_runs none;
    struct dx_runs runs;

    bool is_whole;

    dx_runs_find(&runs, (int64_t)tile->col * DX_TILE_CELLS - 1, DX_BLOCK, t->tiling.wrap, p->width);
    is_whole = gather_whole(tile->range, p, row0, &runs);
    if (is_whole && !tile->attr_bytes && !tile->exact)
        return;
    for (uint32_t i = 0; i < DX_BLOCK; i++) {
        const bool in_grid = row0 + i >= 0 && row0 + i < p->height;
        const size_t row = in_grid ? (size_t)(row0 + i) * p->width : 0, to = (size_t)i * DX_BLOCK;

        if (!is_whole)
            gather_ranges(tile->range + to, p, row, in_grid ? &runs : &none);
        gather_attrs(tile->attr + to, p, row, in_grid ? &runs : &none);
        if (tile->exact)
            dx_runs_gather(tile->xyz + 3 * to, p->xyz + 3 * row, 3 * sizeof(*p->xyz),
                           in_grid ? &runs : &none, DX_BLOCK);
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
    if (t->has_struts[number])
        memcpy(tile->strut, t->strut + (size_t)number * sizeof(tile->strut), sizeof(tile->strut));
    else
        memset(tile->strut, 0, sizeof(tile->strut));
    if (!dx_rules_any(tile))
        return false;
    gather(t, tile);
    fill_normals(t, tile);
    return true;
}
