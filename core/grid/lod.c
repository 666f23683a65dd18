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

#define SERIAL_H 8 /* passes of so few dexels are not worth waking the pool */

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

/* ---- up the lattice -------------------------------------------------------------------------- */

/* Rows with the errors of those whose parent a middle is; NULL outside the grid. Along a row or
 * column they are at the four corners `step` away, else at the ends of a cross. */
struct children {
    const uint16_t *up, *here, *down;
    int32_t step;
    bool cross;
};

static struct children children_of(const struct dx_lod *lod, const struct dx_lod_run *run,
                                   uint32_t row)
{
    const struct dx_tiling *t = &lod->terrain->tiling;
    const bool cross = run->kind >= DX_LOD_MAIN;
    const int32_t step = cross ? run->h : run->h / 2;
    const uint16_t *here = lod->error + (size_t)row * t->width;
    const size_t rows = (size_t)step * t->width;

    return (struct children){.up = row >= (uint32_t)step ? here - rows : NULL,
                             .here = here,
                             .down = row + (uint32_t)step < t->height ? here + rows : NULL,
                             .step = step,
                             .cross = cross};
}

static uint16_t larger(uint16_t a, uint16_t b)
{
    return a > b ? a : b;
}

/* NULL: none of them is in the grid. */
static uint16_t at(const uint16_t *row, int64_t col)
{
    return row && col >= 0 ? row[col] : 0;
}

/* The largest error of a middle's children. Of a middle that is not forced: a cross is in the grid.
 */
static uint16_t most_of(const struct children *c, const struct dx_tiling *t, uint32_t col)
{
    int64_t left = (int64_t)col - c->step, right = (int64_t)col + c->step;

    left += left < 0 && t->wrap ? t->width : 0;
    right = right < t->width ? right : t->wrap ? right - t->width : -1;
    if (c->cross)
        return larger(larger(at(c->up, col), at(c->down, col)),
                      larger(at(c->here, left), at(c->here, right)));
    return larger(larger(at(c->up, left), at(c->up, right)),
                  larger(at(c->down, left), at(c->down, right)));
}

/* Who is cut otherwise when a dexel's error changes. */
static uint16_t recut_by(const struct dx_lod *lod, uint16_t was, uint16_t is, uint32_t h,
                         unsigned borders)
{
    unsigned flags = 0;

    for (unsigned s = 0; s < DX_LOD_SLOTS; s++)
        if (dx_lod_is_active(lod->level[s], was, h) != dx_lod_is_active(lod->level[s], is, h))
            flags |= (DX_LOD_RECUT_HERE | borders) << 4 * s;
    return (uint16_t)flags;
}

static void raise_run(struct dx_lod *lod, uint32_t tile, const struct dx_lod_run *run, uint32_t row,
                      const struct dx_lod_rect *rect)
{
    const struct dx_tiling *t = &lod->terrain->tiling;
    const struct children children = children_of(lod, run, row);
    const uint16_t *own = lod->own + (size_t)row * t->width;
    uint16_t *error = lod->error + (size_t)row * t->width;

    for (uint32_t col = run->first; col < rect->col1; col += run->step) {
        uint16_t most = own[col];

        if (children.step && most != DX_LOD_INFINITE)
            most = larger(most, most_of(&children, t, col));
        if (most == error[col])
            continue;
        lod->recut[tile] |= recut_by(lod, error[col], most, (uint32_t)run->h,
                                     (row == rect->row0 ? DX_LOD_RECUT_ABOVE : 0) |
                                         (col == rect->col0 ? DX_LOD_RECUT_LEFT : 0));
        error[col] = most;
    }
}

static void raise_task(void *ctx, uint32_t task, unsigned thread)
{
    struct dx_lod *lod = ctx;
    const uint32_t tile = lod->task[task];
    const struct dx_lod_rect rect = dx_lod_own_rect(lod, tile);

    (void)thread;
    for (uint32_t row = rect.row0; row < rect.row1; row += lod->level_h) {
        struct dx_lod_run run[DX_LOD_RUNS];
        const unsigned n = dx_lod_runs(run, row, rect.col0);

        for (unsigned k = 0; k < n; k++)
            if (run[k].h == (int32_t)lod->level_h &&
                (run[k].kind >= DX_LOD_MAIN) == lod->level_diagonal)
                raise_run(lod, tile, &run[k], row, &rect);
    }
}

/* Each pass reads what the one before it has written, in neighbouring tiles too. */
static void raise_all(struct dx_lod *lod, struct dx_pool *pool)
{
    uint32_t n = 0;

    for (uint32_t tile = 0; tile < dx_tiling_n_tiles(&lod->terrain->tiling); tile++)
        if (is_near(lod, tile))
            lod->task[n++] = tile;
    for (lod->level_h = 1; lod->level_h < DX_TILE_CELLS; lod->level_h *= 2) {
        struct dx_pool *on = lod->level_h < SERIAL_H ? pool : NULL;

        lod->level_diagonal = false;
        dx_pool_run(on, n, raise_task, lod);
        lod->level_diagonal = true;
        dx_pool_run(on, n, raise_task, lod);
    }
}

/* ---- update ---------------------------------------------------------------------------------- */

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
