/*
 * Errors of hypotenuse middles: in integers, so that no level depends on how a double is rounded.
 */
#include "core/grid/lod_priv.h"

#include <string.h>

/* q = floor(2^44 / range): three products with weights below 2 fit 63 bits from this range on; what
 * is nearer stays as it is. */
#define INVERSE      0x1p44
#define INVERSE_BITS 44
#define LEAST_RANGE  DX_ROWS_LEAST_MIDDLE

static int64_t inverse(uint32_t range)
{
    return (int64_t)(INVERSE / (double)range); /* the quotient truncates right: see area.c */
}

/* Where the corners of a run's diamonds are: dexels of three rows of the grid, each `shift` columns
 * from the middle; end 0, end 1, right angle. */
struct reach {
    uint32_t row[3];
    int32_t shift[3];
    struct dx_lod_weights w; /* of the run, or of the dexel */
};

/* Inverse ranges have noise sigma / range^2, which makes |residual| range^2 / sigma of it. */
static uint16_t in_sigmas(int64_t residual, uint32_t range, const struct dx_sigma *sigma)
{
    const unsigned shift = INVERSE_BITS + DX_LOD_WEIGHT_BITS - 8 - 4; /* 1/256 unit, 1/16 sigma */
    const uint64_t off = (uint64_t)(residual < 0 ? -residual : residual);
    const unsigned __int128 scaled = (unsigned __int128)off * ((uint64_t)range * range) >> shift;
    const uint64_t one = dx_sigma_at(sigma, range);

    if (scaled >= DX_LOD_MAX_BOUND * one)
        return DX_LOD_MAX_BOUND;
    /* Below 2^43, and no closer to the next integer than 1 / one: the quotient of doubles truncates
     * to the same. */
    return (uint16_t)(uint32_t)((double)(int64_t)scaled / (double)(int64_t)one);
}

static uint32_t range_of(const struct dx_plane *p, uint32_t row, int64_t col)
{
    col += col < 0 ? p->width : col >= p->width ? -(int64_t)p->width : 0;
    return dx_plane_range(p, (size_t)row * p->width + (size_t)col);
}

/* Of a middle that is not forced, so that the ends are in the grid. */
static uint16_t error_at(const struct dx_terrain *t, uint32_t row, uint32_t col,
                         const struct reach *at)
{
    const struct dx_plane *p = &t->published;
    const uint32_t range = dx_plane_range(p, (size_t)row * p->width + col);
    const uint32_t r0 = range_of(p, at->row[0], (int64_t)col + at->shift[0]);
    const uint32_t r1 = range_of(p, at->row[1], (int64_t)col + at->shift[1]);
    int64_t residual;

    if (range < LEAST_RANGE || r0 < LEAST_RANGE || r1 < LEAST_RANGE)
        return DX_LOD_INFINITE;
    residual = (inverse(range) << DX_LOD_WEIGHT_BITS) - inverse(r0) * at->w.end[0] -
               inverse(r1) * at->w.end[1];
    if (at->w.apex) {
        const int64_t c = (int64_t)col + at->shift[2];
        uint32_t r2;

        if (!t->tiling.wrap && (c < 0 || c >= p->width))
            return DX_LOD_INFINITE; /* the beam leaves the grid */
        r2 = range_of(p, at->row[2], c);
        if (r2 < LEAST_RANGE)
            return DX_LOD_INFINITE;
        residual -= inverse(r2) * at->w.apex;
    }
    return in_sigmas(residual, range, &t->gates.sigma);
}

static void set_reach(struct reach *at, const struct dx_lod_run *run, uint32_t row,
                      const struct dx_lod_weights *w)
{
    const int corner[3] = {0, 1, 2 + w->side};

    for (int k = 0; k < 3; k++) {
        const int8_t *step = dx_lod_diamond[run->kind][corner[k]];

        at->row[k] = (uint32_t)((int32_t)row + run->h * step[0]);
        at->shift[k] = run->h * step[1];
    }
    at->w = *w;
}

/* ---- cells ----------------------------------------------------------------------------------- */

/* Which cells of two rows, above and below a row of dexels, are not full: [0] is the column before
 * the tile's first. */
struct gaps {
    uint8_t above[DX_TILE_CELLS + 2], below[DX_TILE_CELLS + 2];
};

static uint8_t is_gap(uint8_t code)
{
    return (code != DX_CELL_ABC_ACD) & (code != DX_CELL_ABD_BCD);
}

/* Cells outside the grid are no gaps. */
static void find_gaps(uint8_t gap[DX_TILE_CELLS + 2], const struct dx_terrain *t, int64_t row,
                      uint32_t tile_col)
{
    const struct dx_tiling *g = &t->tiling;
    const uint32_t col = tile_col * DX_TILE_CELLS;
    const uint32_t left = g->cell_cols - col, n = left < DX_TILE_CELLS ? left : DX_TILE_CELLS;
    const uint32_t before = col ? col - 1 : g->cell_cols - 1;
    const size_t size = DX_TILE_CELLS * DX_TILE_CELLS;
    const uint8_t *code;

    memset(gap, 0, DX_TILE_CELLS + 2);
    if (row < 0 || row >= g->cell_rows)
        return;
    code = t->code + (size_t)(row / DX_TILE_CELLS) * g->cols * size +
           (size_t)(row % DX_TILE_CELLS) * DX_TILE_CELLS;
    for (uint32_t j = 0; j < n; j++)
        gap[j + 1] = is_gap(code[tile_col * size + j]);
    if (col || g->wrap)
        gap[0] = is_gap(code[before / DX_TILE_CELLS * size + before % DX_TILE_CELLS]);
}

/* ---- runs of middles ------------------------------------------------------------------------- */

/* A row of a tile's, and what is known of all its middles. */
struct tile_row {
    const struct dx_lod *lod;
    uint32_t row, col0, col1;
    struct gaps gaps;
    bool has_gaps, has_forced;
};

/* A tile begins with a word of its own. */
static void look_at_row(struct tile_row *r)
{
    const struct dx_lod *lod = r->lod;
    const uint64_t *word = lod->forced + r->row * lod->row_words;
    const uint32_t tile_col = r->col0 / DX_TILE_CELLS;
    uint8_t some = 0;

    find_gaps(r->gaps.above, lod->terrain, (int64_t)r->row - 1, tile_col);
    find_gaps(r->gaps.below, lod->terrain, r->row, tile_col);
    for (uint32_t j = 0; j < DX_TILE_CELLS + 2; j++)
        some |= r->gaps.above[j] | r->gaps.below[j];
    r->has_gaps = some;
    r->has_forced = word[r->col0 / 64] || word[(r->col1 - 1) / 64];
}

/* Whether a middle is always active: for its place, or, the last on its cells, for gaps beside. */
static bool is_forced(const struct tile_row *r, uint32_t col, bool leaf)
{
    const uint32_t j = col - r->col0;
    const struct gaps *g = &r->gaps;

    return dx_lod_is_forced(r->lod, r->row, col) ||
           (leaf && g->above[j] | g->above[j + 1] | g->below[j] | g->below[j + 1]);
}

/* One by one. */
static void run_errors(const struct tile_row *r, const struct dx_lod_run *run)
{
    const struct dx_lod *lod = r->lod;
    const struct dx_terrain *t = lod->terrain;
    const bool leaf = run->h == 1 && run->kind <= DX_LOD_ALONG_COLUMN;
    const struct dx_lod_weights *w =
        lod->weights + (size_t)r->row * (lod->per_dexel ? t->tiling.width : DX_LOD_RUNS);
    uint16_t *own = lod->own + (size_t)r->row * t->tiling.width;
    struct reach at = {0};

    if (!lod->per_dexel)
        set_reach(&at, run, r->row, w + run->slot);
    for (uint32_t col = run->first; col < r->col1; col += run->step) {
        if (is_forced(r, col, leaf)) {
            own[col] = DX_LOD_INFINITE;
            continue;
        }
        if (lod->per_dexel)
            set_reach(&at, run, r->row, w + col);
        own[col] = error_at(t, r->row, col, &at);
    }
}

/* ---- blocks of them -------------------------------------------------------------------------- */

#define BLOCK DX_ROWS_MIDDLES

/* Ranges of every `step` columns from `col` on; 0 outside the grid. */
static void pick(uint32_t out[BLOCK], const struct dx_plane *p, bool wrap, uint32_t row,
                 int64_t col, uint32_t step)
{
    const uint16_t *range = (const uint16_t *)p->range + (size_t)row * p->width;
    const bool inside = col >= 0 && col + (int64_t)step * (BLOCK - 1) < p->width;

    for (uint32_t k = 0; inside && k < BLOCK; k++)
        out[k] = range[(size_t)col + (size_t)k * step];
    for (uint32_t k = 0; !inside && k < BLOCK; k++, col += step) {
        const int64_t c = !wrap             ? col
                          : col < 0         ? col + p->width
                          : col >= p->width ? col - p->width
                                            : col;

        out[k] = c >= 0 && c < p->width ? range[c] : 0;
    }
}

/* Up to BLOCK middles from column `col` on. */
static void block_errors(const struct tile_row *r, const struct dx_lod_run *run,
                         const struct reach *at, uint32_t col)
{
    const struct dx_terrain *t = r->lod->terrain;
    const struct dx_plane *p = &t->published;
    const bool wrap = t->tiling.wrap, leaf = run->h == 1 && run->kind <= DX_LOD_ALONG_COLUMN;
    const bool any = r->has_forced || (leaf && r->has_gaps);
    uint16_t *own = r->lod->own + (size_t)r->row * p->width;
    uint32_t middle[BLOCK], corner[3][BLOCK], error[BLOCK];
    const struct dx_row_middles m = {.middle = middle,
                                     .end = {corner[0], corner[1]},
                                     .apex = corner[at->w.apex ? 2 : 0],
                                     .end_weight = {at->w.end[0], at->w.end[1]},
                                     .apex_weight = at->w.apex,
                                     .sigma = t->gates.row_sigma};
    uint32_t unsure;

    pick(middle, p, wrap, r->row, col, run->step);
    for (int k = 0; k < (at->w.apex ? 3 : 2); k++)
        pick(corner[k], p, wrap, at->row[k], (int64_t)col + at->shift[k], run->step);
    unsure = t->gates.rows->errors(error, &m);
    for (uint32_t k = 0; k < BLOCK && col < r->col1; k++, col += run->step) {
        if (any && is_forced(r, col, leaf))
            own[col] = DX_LOD_INFINITE;
        else if (unsure >> k & 1)
            own[col] = error_at(t, r->row, col, at);
        else
            own[col] = (uint16_t)error[k];
    }
}

/* Where all are: a run that cannot be is forced as a whole. */
static bool rows_are_there(const struct reach *at, uint32_t height)
{
    return at->row[0] < height && at->row[1] < height && (!at->w.apex || at->row[2] < height);
}

/* Whether a run is long enough for blocks, and has what their loop takes. */
static bool fits_blocks(const struct dx_lod *lod, const struct dx_lod_run *run)
{
    const struct dx_terrain *t = lod->terrain;
    const uint64_t most = UINT64_C(1) << 36;

    return run->step <= 8 && !lod->per_dexel && t->published.range_bytes == 2 &&
           t->gates.sigma.a1 < most && t->gates.sigma.a2 < most;
}

static void error_run(const struct tile_row *r, const struct dx_lod_run *run)
{
    const struct dx_lod *lod = r->lod;
    struct reach at;

    if (fits_blocks(lod, run)) {
        set_reach(&at, run, r->row, lod->weights + (size_t)r->row * DX_LOD_RUNS + run->slot);
        if (rows_are_there(&at, lod->terrain->tiling.height)) {
            for (uint32_t col = run->first; col < r->col1; col += BLOCK * run->step)
                block_errors(r, run, &at, col);
            return;
        }
    }
    run_errors(r, run);
}

/* ---- a rectangle ----------------------------------------------------------------------------- */

void dx_lod_own_errors(const struct dx_lod *lod, const struct dx_lod_rect *rect)
{
    for (uint32_t row = rect->row0; row < rect->row1; row++) {
        struct dx_lod_run run[DX_LOD_RUNS];
        const unsigned n = dx_lod_runs(run, row, rect->col0);
        struct tile_row r = {.lod = lod, .row = row, .col0 = rect->col0, .col1 = rect->col1};

        look_at_row(&r);
        for (unsigned k = 0; k < n; k++)
            error_run(&r, &run[k]);
    }
}
