/*
 * Errors up the lattice, pass by pass: a middle's is at least those of the middles that hang on it.
 * The finest ones, three quarters of all, by rows; the rest one by one.
 */
#include "core/grid/lod_priv.h"

#include <assert.h>
#include <string.h>

static_assert(DX_LOD_SLOTS == DX_ROWS_SLOTS, "a bit for each");

#define SERIAL_H 8 /* passes of so few dexels are not worth waking the pool */

/* ---- the finest ------------------------------------------------------------------------------ */

/* Own errors of a row of the grid from a tile's first column on, and of the dexel behind the tile's
 * last one; zeros outside the grid. */
static void pick(uint16_t out[DX_ROWS_FINEST], const struct dx_lod *lod, uint32_t row,
                 const struct dx_lod_rect *rect)
{
    const struct dx_tiling *t = &lod->terrain->tiling;
    const uint16_t *own = lod->own + (size_t)row * t->width;
    const uint32_t n = rect->col1 - rect->col0;

    memset(out, 0, DX_ROWS_FINEST * sizeof(*out));
    if (row >= t->height)
        return;
    memcpy(out, own + rect->col0, n * sizeof(*out));
    if (rect->col1 < t->width || t->wrap)
        out[n] = own[rect->col1 < t->width ? rect->col1 : 0];
}

/* Who is cut otherwise by what a row's loop tells of flips, a bit for each slot. */
static uint16_t recut_of(struct dx_row_flips flips, bool first_row)
{
    unsigned flags = 0;

    for (unsigned s = 0; s < DX_LOD_SLOTS; s++)
        if (flips.any >> s & 1)
            flags |= (DX_LOD_RECUT_HERE | (first_row ? DX_LOD_RECUT_ABOVE : 0) |
                      (flips.first >> s & 1 ? DX_LOD_RECUT_LEFT : 0))
                     << 4 * s;
    return (uint16_t)flags;
}

/* Middles with h = 1: those along rows and columns have their own errors alone, so that those of
 * diagonals can ask these for the errors of their four children, whichever tile's they are. */
static void raise_finest(void *ctx, uint32_t task, unsigned thread)
{
    struct dx_lod *lod = ctx;
    const uint32_t tile = lod->task[task];
    const struct dx_lod_rect rect = dx_lod_own_rect(lod, tile);
    const struct dx_tiling *t = &lod->terrain->tiling;
    const size_t len = (rect.col1 - rect.col0) * sizeof(*lod->error);
    struct dx_row_finest f = {.n = rect.col1 - rect.col0};
    uint16_t error[DX_ROWS_FINEST] = {0};

    (void)thread;
    for (unsigned s = 0; s < DX_LOD_SLOTS; s++)
        f.bound[s] = lod->level[s].bound ? lod->level[s].bound : DX_LOD_MAX_BOUND;
    for (uint32_t row = rect.row0; row < rect.row1; row++) {
        uint16_t *at = lod->error + (size_t)row * t->width + rect.col0;

        f.diagonals = row & 1;
        pick(f.own, lod, row, &rect);
        if (f.diagonals) {
            pick(f.up, lod, row - 1, &rect);
            pick(f.down, lod, row + 1, &rect);
        }
        memcpy(error, at, len);
        lod->recut[tile] |= recut_of(lod->terrain->gates.rows->raise(error, &f), row == rect.row0);
        memcpy(at, error, len);
    }
}

/* ---- the others ------------------------------------------------------------------------------ */

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
void dx_lod_raise(struct dx_lod *lod, uint32_t n_tasks, struct dx_pool *pool)
{
    dx_pool_run_tiles(pool, n_tasks, raise_finest, lod);
    for (lod->level_h = 2; lod->level_h < DX_TILE_CELLS; lod->level_h *= 2) {
        struct dx_pool *on = lod->level_h < SERIAL_H ? pool : NULL;

        lod->level_diagonal = false;
        dx_pool_run_tiles(on, n_tasks, raise_task, lod);
        lod->level_diagonal = true;
        dx_pool_run_tiles(on, n_tasks, raise_task, lod);
    }
}
