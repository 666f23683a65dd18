/*
 * What levels of detail know before any range: where hypotenuse middles are, which of them no
 * coarser triangle may leave out, and the planes that their ranges are measured against.
 */
#include "core/grid/faces.h"
#include "core/grid/lines.h"
#include "core/grid/lod_priv.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>

/* First column from col0 on that is `rest` modulo `step`, a power of two. */
static uint32_t first_column(uint32_t col0, uint32_t rest, uint32_t step)
{
    return col0 + ((rest - col0) & (step - 1));
}

/* The square around a middle of a diagonal is a quarter of one of twice its side, and the diagonal
 * ends in that one's middle: it is the main one where the square's row and column, counted in its
 * sides, are both even or both odd. */
unsigned dx_lod_runs(struct dx_lod_run run[DX_LOD_RUNS], uint32_t row, uint32_t col0)
{
    const uint32_t low = dx_lod_low_bit(row), end = low < DX_TILE_CELLS ? low : DX_TILE_CELLS;
    const uint32_t odd = low < DX_TILE_CELLS ? row / low / 2 & 1 : 0;
    unsigned n = 0, slot = 0;

    for (uint32_t h = 1; h < end; h *= 2)
        run[n++] = (struct dx_lod_run){DX_LOD_ALONG_ROW, (int32_t)h, first_column(col0, h, 2 * h),
                                       2 * h, slot++};
    if (low >= DX_TILE_CELLS)
        return n;
    run[n++] = (struct dx_lod_run){DX_LOD_MAIN, (int32_t)low,
                                   first_column(col0, odd ? 3 * low : low, 4 * low), 4 * low, 6};
    run[n++] = (struct dx_lod_run){DX_LOD_ANTI, (int32_t)low,
                                   first_column(col0, odd ? low : 3 * low, 4 * low), 4 * low, 7};
    run[n++] = (struct dx_lod_run){DX_LOD_ALONG_COLUMN, (int32_t)low,
                                   first_column(col0, 0, 2 * low), 2 * low, 8};
    return n;
}

/* ---- triangles of a diamond ------------------------------------------------------------------ */

struct corner {
    int64_t row, col; /* where the seam is not undone */
};

static struct corner corner_of(enum dx_lod_kind kind, int64_t h, uint32_t row, uint32_t col, int k)
{
    return (struct corner){row + h * dx_lod_diamond[kind][k][0],
                           col + h * dx_lod_diamond[kind][k][1]};
}

/* Of a triangle and the cells of the grid. Across an uneven seam the lattice of the last tiles ends
 * like that of an open grid; only middles on column 0 look over it (see is_seam). */
enum where { OUTSIDE, INSIDE, ASTRIDE };

static enum where where_is(const struct dx_tiling *t, const struct corner c[3])
{
    const bool even_seam = t->wrap && t->cell_cols % DX_TILE_CELLS == 0;
    int64_t row0 = c[0].row, row1 = row0, col0 = c[0].col, col1 = col0;

    for (int k = 1; k < 3; k++) {
        row0 = c[k].row < row0 ? c[k].row : row0;
        row1 = c[k].row > row1 ? c[k].row : row1;
        col0 = c[k].col < col0 ? c[k].col : col0;
        col1 = c[k].col > col1 ? c[k].col : col1;
    }
    if (row0 < 0 || row0 >= t->cell_rows)
        return OUTSIDE;
    if (!even_seam && (col0 >= t->cell_cols || (col0 < 0 && !t->wrap)))
        return OUTSIDE;
    if (row1 > t->cell_rows || (!even_seam && col1 > t->cell_cols))
        return ASTRIDE;
    return INSIDE;
}

/* Column 0 of a turn that is no whole number of tiles: the last tiles end in it as well, but not
 * where larger triangles of theirs would. */
static bool is_seam(const struct dx_tiling *t, uint32_t row, uint32_t col)
{
    return t->wrap && t->cell_cols % DX_TILE_CELLS && col == 0 &&
           dx_lod_low_bit(row) >= dx_lod_low_bit(t->cell_cols);
}

/* Corners of the triangle on one side, as dexels: false when it is not inside the grid. */
static bool triangle_of(uint32_t at[3][2], const struct dx_lod *lod, enum dx_lod_kind kind,
                        int64_t h, uint32_t row, uint32_t col, int side)
{
    const struct dx_tiling *t = &lod->terrain->tiling;
    const struct corner c[3] = {corner_of(kind, h, row, col, 2 + side),
                                corner_of(kind, h, row, col, !side),
                                corner_of(kind, h, row, col, side)};

    if (where_is(t, c) != INSIDE)
        return false;
    for (int k = 0; k < 3; k++) {
        at[k][0] = (uint32_t)c[k].row;
        at[k][1] = (uint32_t)((c[k].col + DX_TILE_CELLS * (int64_t)t->width) % t->width);
    }
    return true;
}

static bool is_astride(const struct dx_lod *lod, enum dx_lod_kind kind, int64_t h, uint32_t row,
                       uint32_t col)
{
    for (int side = 0; side < 2; side++) {
        const struct corner c[3] = {corner_of(kind, h, row, col, 2 + side),
                                    corner_of(kind, h, row, col, 0),
                                    corner_of(kind, h, row, col, 1)};

        if (where_is(&lod->terrain->tiling, c) == ASTRIDE)
            return true;
    }
    return false;
}

/* ---- weights --------------------------------------------------------------------------------- */

static double det(const double a[3], const double b[3], const double c[3])
{
    return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
           a[2] * (b[0] * c[1] - b[1] * c[0]);
}

/* Weights with which the directions at the corners (right angle, end, end) give that of the middle.
 * False: not with such as fit the fixed point. */
static bool solve(double w[3], const struct dx_geometry *g, const uint32_t at[3][2], uint32_t row,
                  uint32_t col)
{
    double d[3][3], m[3], whole;

    for (int k = 0; k < 3; k++)
        dx_lines_direction(g, at[k][0], at[k][1], d[k]);
    dx_lines_direction(g, row, col, m);
    whole = det(d[0], d[1], d[2]);
    w[0] = det(m, d[1], d[2]) / whole;
    w[1] = det(d[0], m, d[2]) / whole;
    w[2] = det(d[0], d[1], m) / whole;
    return fabs(w[0]) <= 2 && fabs(w[1]) <= 2 && fabs(w[2]) <= 2; /* no NaN either */
}

static int32_t fixed(double w)
{
    return (int32_t)rint(w * (1 << DX_LOD_WEIGHT_BITS));
}

/* A camera's triangles face it as its cells do, however large. */
static bool faces(const struct dx_geometry *g, const uint32_t at[3][2])
{
    return g->model == DX_MODEL_PINHOLE || dx_faces_triangle(g, at);
}

/* Whether every triangle of the diamond that is in the grid faces the scanner; then the plane of
 * the one that the middle's beam meets, or of the only one. */
static bool weigh(struct dx_lod_weights *out, const struct dx_lod *lod, enum dx_lod_kind kind,
                  int64_t h, uint32_t row, uint32_t col)
{
    const struct dx_geometry *g = lod->terrain->geometry;
    bool some = false;

    for (int side = 1; side >= 0; side--) {
        uint32_t at[3][2];
        double w[3];

        if (!triangle_of(at, lod, kind, h, row, col, side))
            continue;
        if (!faces(g, (const uint32_t(*)[2])at) || !solve(w, g, (const uint32_t(*)[2])at, row, col))
            return false;
        if (some && w[0] < 0)
            continue;
        some = true;
        *out = (struct dx_lod_weights){.end = {fixed(w[side ? 1 : 2]), fixed(w[side ? 2 : 1])},
                                       .apex = fixed(w[0]),
                                       .side = side};
    }
    return some;
}

/* ---- tables ---------------------------------------------------------------------------------- */

/* On an even grid, for all columns; that of a kind along columns can be the first one. */
static bool weigh_row(struct dx_lod_weights *out, const struct dx_lod *lod,
                      const struct dx_lod_run *run, uint32_t row)
{
    const uint32_t col = run->kind == DX_LOD_ALONG_COLUMN ? 0 : (uint32_t)run->h;

    return col < lod->terrain->tiling.width && weigh(out, lod, run->kind, run->h, row, col);
}

static void force(struct dx_lod *lod, uint32_t row, uint32_t col)
{
    lod->forced[row * lod->row_words + col / 64] |= UINT64_C(1) << (col % 64);
}

/* Rows that polar caps hang on stay whole. */
static bool has_fan(const struct dx_terrain *t, uint32_t row)
{
    return (t->fans & DX_CAP_FIRST && row == 0) ||
           (t->fans & DX_CAP_LAST && row + 1 == t->tiling.height);
}

static void fill_run(struct dx_lod *lod, const struct dx_lod_run *run, uint32_t row)
{
    const struct dx_tiling *t = &lod->terrain->tiling;
    struct dx_lod_weights *at =
        lod->weights + (size_t)row * (lod->per_dexel ? t->width : DX_LOD_RUNS);
    const bool whole = has_fan(lod->terrain, row) && run->h == 1;
    const bool good = lod->per_dexel || weigh_row(at + run->slot, lod, run, row);

    for (uint32_t col = run->first; col < t->width; col += run->step)
        if (!good || whole || is_astride(lod, run->kind, run->h, row, col) ||
            is_seam(t, row, col) ||
            (lod->per_dexel && !weigh(at + col, lod, run->kind, run->h, row, col)))
            force(lod, row, col);
}

static void fill_row(void *ctx, uint32_t row, unsigned thread)
{
    struct dx_lod *lod = ctx;
    struct dx_lod_run run[DX_LOD_RUNS];
    const unsigned n = dx_lod_runs(run, row, 0);

    (void)thread;
    for (unsigned k = 0; k < n; k++)
        fill_run(lod, &run[k], row);
}

int dx_lod_tables_init(struct dx_lod *lod, struct dx_pool *pool)
{
    const struct dx_terrain *t = lod->terrain;
    const size_t height = t->tiling.height, width = t->tiling.width;

    lod->per_dexel = t->gates.per_dexel;
    lod->row_words = (width + 63) / 64;
    lod->weights = calloc(height * (lod->per_dexel ? width : DX_LOD_RUNS), sizeof(*lod->weights));
    lod->forced = calloc(height * lod->row_words, sizeof(*lod->forced));
    if (!lod->weights || !lod->forced)
        return -ENOMEM;
    dx_pool_run(pool, (uint32_t)height, fill_row, lod);
    return 0;
}
