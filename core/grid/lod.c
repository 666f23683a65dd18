/*
 * The errors of a level of detail over time: which are computed anew, how they go up the lattice,
 * and which tiles are cut otherwise then.
 *
 * A middle's parents are found within 62 dexels of it in row and column, or beside a border of its
 * tile: so what a tile's change does ends before the far borders of its eight neighbours.
 */
#include "core/grid/lod_priv.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

static size_t tile_words(const struct dx_lod *lod)
{
    return dx_tiling_n_tiles(&lod->terrain->tiling) / 64 + 1;
}

static bool has_bit(const uint64_t *bits, uint32_t tile)
{
    return bits[tile / 64] >> (tile % 64) & 1;
}

/* Corners of tiles are always there; and those of the last ones where a seam cuts them short. */
static void set_corners(struct dx_lod *lod)
{
    const struct dx_tiling *t = &lod->terrain->tiling;

    for (uint32_t i = 0; i < t->height; i += DX_TILE_CELLS)
        for (uint32_t j = 0; j < t->width; j += DX_TILE_CELLS)
            lod->error[(size_t)i * t->width + j] = DX_LOD_INFINITE;
}

int dx_lod_new(struct dx_lod **out, const struct dx_terrain *t, struct dx_pool *pool)
{
    const size_t n_dexels = dx_plane_n_dexels(&t->published);
    const size_t n_tiles = dx_tiling_n_tiles(&t->tiling);
    struct dx_lod *lod = calloc(1, sizeof(*lod));
    bool ok = lod;

    if (!lod)
        return -ENOMEM;
    lod->terrain = t;
    lod->own = calloc(n_dexels, sizeof(*lod->own));
    lod->error = calloc(n_dexels, sizeof(*lod->error));
    lod->noted = calloc(tile_words(lod), sizeof(*lod->noted));
    for (unsigned s = 0; s < DX_LOD_SLOTS; s++) {
        lod->changed[s] = calloc(tile_words(lod), sizeof(*lod->changed[s]));
        ok = ok && lod->changed[s];
    }
    lod->task = calloc(n_tiles, sizeof(*lod->task));
    lod->part = calloc(n_tiles, sizeof(*lod->part));
    lod->recut = calloc(n_tiles, sizeof(*lod->recut));
    ok = ok && lod->own && lod->error && lod->noted && lod->task && lod->part && lod->recut;
    if (!ok || dx_lod_tables_init(lod, pool) < 0) {
        dx_lod_free(lod);
        return -ENOMEM;
    }
    memset(lod->noted, 0xff, tile_words(lod) * sizeof(*lod->noted));
    set_corners(lod);
    *out = lod;
    return 0;
}

void dx_lod_free(struct dx_lod *lod)
{
    if (!lod)
        return;
    for (unsigned s = 0; s < DX_LOD_SLOTS; s++)
        free(lod->changed[s]);
    free(lod->recut);
    free(lod->part);
    free(lod->task);
    free(lod->noted);
    free(lod->error);
    free(lod->own);
    free(lod->forced);
    free(lod->weights);
    free(lod);
}

void dx_lod_note(struct dx_lod *lod, const uint64_t *changed)
{
    for (size_t w = 0; w < tile_words(lod); w++)
        lod->noted[w] |= changed[w];
}

const uint64_t *dx_lod_changed(const struct dx_lod *lod, unsigned slot)
{
    return lod->changed[slot];
}

/* ---- which tiles ----------------------------------------------------------------------------- */

#define NO_TILE UINT32_MAX

static uint32_t beside(const struct dx_tiling *t, uint32_t tile, int down, int right)
{
    const int64_t row = (int64_t)(tile / t->cols) + down;
    int64_t col = (int64_t)(tile % t->cols) + right;

    if (t->wrap)
        col = (col + t->cols) % t->cols;
    return row < 0 || row >= t->rows || col < 0 || col >= t->cols ? NO_TILE
                                                                  : (uint32_t)(row * t->cols + col);
}

static bool is_noted(const struct dx_lod *lod, uint32_t tile)
{
    return tile != NO_TILE && has_bit(lod->noted, tile);
}

static uint8_t part_of(const struct dx_lod *lod, uint32_t tile)
{
    const struct dx_tiling *t = &lod->terrain->tiling;

    if (is_noted(lod, tile))
        return DX_LOD_PART_ALL;
    return (uint8_t)((is_noted(lod, beside(t, tile, -1, 0)) ? DX_LOD_PART_ROW : 0) |
                     (is_noted(lod, beside(t, tile, 0, -1)) ? DX_LOD_PART_COL : 0));
}

static bool is_near(const struct dx_lod *lod, uint32_t tile)
{
    for (int down = -1; down <= 1; down++)
        for (int right = -1; right <= 1; right++)
            if (is_noted(lod, beside(&lod->terrain->tiling, tile, down, right)))
                return true;
    return false;
}

/* ---- own errors ------------------------------------------------------------------------------ */

static void own_task(void *ctx, uint32_t task, unsigned thread)
{
    const struct dx_lod *lod = ctx;
    const uint32_t tile = lod->task[task];
    const struct dx_lod_rect all = dx_lod_own_rect(lod, tile);
    struct dx_lod_rect r = all;

    (void)thread;
    if (lod->part[tile] & DX_LOD_PART_ALL) {
        dx_lod_own_errors(lod, &all);
        return;
    }
    r.row1 = r.row0 + 1;
    if (lod->part[tile] & DX_LOD_PART_ROW)
        dx_lod_own_errors(lod, &r);
    r = all;
    r.col1 = r.col0 + 1;
    if (lod->part[tile] & DX_LOD_PART_COL)
        dx_lod_own_errors(lod, &r);
}

static void compute_own(struct dx_lod *lod, struct dx_pool *pool)
{
    uint32_t n = 0;

    for (uint32_t tile = 0; tile < dx_tiling_n_tiles(&lod->terrain->tiling); tile++) {
        lod->part[tile] = part_of(lod, tile);
        if (lod->part[tile])
            lod->task[n++] = tile;
    }
    dx_pool_run_tiles(pool, n, own_task, lod);
}

/* ---- update ---------------------------------------------------------------------------------- */

static void raise_all(struct dx_lod *lod, struct dx_pool *pool)
{
    uint32_t n = 0;

    for (uint32_t tile = 0; tile < dx_tiling_n_tiles(&lod->terrain->tiling); tile++)
        if (is_near(lod, tile))
            lod->task[n++] = tile;
    dx_lod_raise(lod, n, pool);
}

static void mark(uint64_t *bits, uint32_t tile)
{
    if (tile != NO_TILE)
        bits[tile / 64] |= UINT64_C(1) << (tile % 64);
}

static void find_changed(struct dx_lod *lod)
{
    const struct dx_tiling *t = &lod->terrain->tiling;

    for (unsigned s = 0; s < DX_LOD_SLOTS; s++)
        memcpy(lod->changed[s], lod->noted, tile_words(lod) * sizeof(*lod->noted));
    for (uint32_t tile = 0; tile < dx_tiling_n_tiles(t); tile++) {
        unsigned flags = lod->recut[tile];

        for (unsigned s = 0; flags; s++, flags >>= 4) {
            if (flags & DX_LOD_RECUT_HERE)
                mark(lod->changed[s], tile);
            if (flags & DX_LOD_RECUT_ABOVE)
                mark(lod->changed[s], beside(t, tile, -1, 0));
            if (flags & DX_LOD_RECUT_LEFT)
                mark(lod->changed[s], beside(t, tile, 0, -1));
        }
    }
}

void dx_lod_update(struct dx_lod *lod, const struct dx_lod_level level[DX_LOD_SLOTS],
                   struct dx_pool *pool)
{
    memcpy(lod->level, level, sizeof(lod->level));
    memset(lod->recut, 0, dx_tiling_n_tiles(&lod->terrain->tiling) * sizeof(*lod->recut));
    compute_own(lod, pool);
    raise_all(lod, pool);
    find_changed(lod);
    memset(lod->noted, 0, tile_words(lod) * sizeof(*lod->noted));
}
