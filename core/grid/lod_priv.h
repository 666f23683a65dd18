/*
 * Inside levels of detail: the lattice of hypotenuse middles, and what lod*.c share.
 *
 * Every dexel but the tiles' corners is the middle of one hypotenuse, whose half reaches over h
 * rows or columns: h is the lowest bit set in row or column. The two triangles on it are its
 * diamond. Its parents are the right angles of these, since it can be cut only when they are there.
 */
#ifndef DX_LOD_PRIV_H
#define DX_LOD_PRIV_H

#include "core/grid/lod.h"
#include "core/grid/terrain_priv.h"

#define DX_LOD_INFINITE UINT16_MAX

/* How the hypotenuse of a middle lies. */
enum dx_lod_kind { DX_LOD_ALONG_ROW, DX_LOD_ALONG_COLUMN, DX_LOD_MAIN, DX_LOD_ANTI };

/* Ends 0 and 1 and right angles 2 and 3 of a diamond, in steps of h from its middle. Triangles
 * (2, 1, 0) and (3, 0, 1) run as a cell's abc does. */
static const int8_t dx_lod_diamond[4][4][2] = {
    [DX_LOD_ALONG_ROW] = {{0, -1}, {0, 1}, {-1, 0}, {1, 0}},
    [DX_LOD_ALONG_COLUMN] = {{1, 0}, {-1, 0}, {0, -1}, {0, 1}},
    [DX_LOD_MAIN] = {{-1, -1}, {1, 1}, {-1, 1}, {1, -1}},
    [DX_LOD_ANTI] = {{1, -1}, {-1, 1}, {-1, -1}, {1, 1}},
};

/* Middles of one kind in a row of the grid: every `step` columns from `first` on. A row has at most
 * 9 of them; on even grids they share their constants, under `slot`. */
struct dx_lod_run {
    enum dx_lod_kind kind;
    int32_t h;
    uint32_t first, step;
    unsigned slot;
};

#define DX_LOD_RUNS 9

static inline uint32_t dx_lod_low_bit(uint32_t x)
{
    return x ? x & -x : UINT32_C(1) << 31;
}

/* The runs of a row, from the tile column that begins at `col0` on. Returns how many. */
unsigned dx_lod_runs(struct dx_lod_run run[DX_LOD_RUNS], uint32_t row, uint32_t col0);

/* The plane of a triangle of the diamond in inverse range: q(middle) = end0 q(0) + end1 q(1) + apex
 * q(right angle). Of the triangle that the middle's beam meets. */
#define DX_LOD_WEIGHT_BITS 22

struct dx_lod_weights {
    int32_t end[2], apex;
    int32_t side; /* 0: the right angle is 2; 1: it is 3 */
};

struct dx_lod {
    const struct dx_terrain *terrain;
    bool per_dexel;
    struct dx_lod_weights *weights; /* [row][slot], or per_dexel [row][col] */
    size_t row_words;
    uint64_t *forced; /* bit [row][col]: always active, for its place or its directions */
    uint16_t *own;    /* [row][col]: error of the middle itself */
    uint16_t *error;  /* and the largest of it and those that hang on it */

    uint64_t *noted;                 /* bits by tile: changed since the last update */
    uint64_t *changed[DX_LOD_SLOTS]; /* bits by tile */
    uint32_t *task;                  /* tiles of the pass under way */
    uint8_t *part;                   /* by tile: DX_LOD_PART_* whose own errors are computed */
    uint16_t *recut;                 /* by tile: DX_LOD_RECUT_* << 4 slot: who was cut otherwise */
    uint32_t level_h;                /* of the pass under way */
    bool level_diagonal;
    struct dx_lod_level level[DX_LOD_SLOTS];
};

/* The dexels of a tile whose own errors an update computes: those whose diamond a noted tile has a
 * part in. */
#define DX_LOD_PART_ALL 0x1u
#define DX_LOD_PART_ROW 0x2u /* the first row, which the tile above ends with */
#define DX_LOD_PART_COL 0x4u

/* Where dexels became active or ceased to be: in the tile, and on the border with another. */
#define DX_LOD_RECUT_HERE  0x1u
#define DX_LOD_RECUT_ABOVE 0x2u
#define DX_LOD_RECUT_LEFT  0x4u

static inline bool dx_lod_is_forced(const struct dx_lod *lod, uint32_t row, uint32_t col)
{
    return lod->forced[row * lod->row_words + col / 64] >> (col % 64) & 1;
}

/* The dexels that a tile has the errors of: its own 64x64, and the rest in the last ones. */
struct dx_lod_rect {
    uint32_t row0, row1, col0, col1;
};

static inline uint32_t dx_lod_rest(uint32_t n, uint32_t n_tiles, uint32_t side)
{
    return n + 1 < n_tiles ? (n + 1) * DX_TILE_CELLS : side;
}

static inline struct dx_lod_rect dx_lod_own_rect(const struct dx_lod *lod, uint32_t tile)
{
    const struct dx_tiling *g = &lod->terrain->tiling;
    const uint32_t row = tile / g->cols, col = tile % g->cols;

    return (struct dx_lod_rect){row * DX_TILE_CELLS, dx_lod_rest(row, g->rows, g->height),
                                col * DX_TILE_CELLS, dx_lod_rest(col, g->cols, g->width)};
}

/* Whether a dexel whose error is `error` is active; h as above. */
static inline bool dx_lod_is_active(struct dx_lod_level level, uint16_t error, uint32_t h)
{
    const uint32_t bound = level.bound ? level.bound : DX_LOD_MAX_BOUND;

    return error > bound || (level.stride && h >= level.stride);
}

/* lod_tables.c: weights, forced. */
int dx_lod_tables_init(struct dx_lod *lod, struct dx_pool *pool);

/* lod_raise.c: `error` of the tiles of the first `n_tasks` tasks, and who is cut otherwise. */
void dx_lod_raise(struct dx_lod *lod, uint32_t n_tasks, struct dx_pool *pool);

/* lod_error.c: `own` of a rectangle inside one tile's own. */
void dx_lod_own_errors(const struct dx_lod *lod, const struct dx_lod_rect *rect);

#endif
