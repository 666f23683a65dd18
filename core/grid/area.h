/*
 * A tile's neighbourhood on its way through the rules: the tile's own 65 x 65 dexels with a margin
 * around them, in one dense block. The seam is unwrapped and what lies outside the grid is missing,
 * so that no rule after this one knows of either. One per thread.
 *
 * Area dexel (p, q) is dexel (row0 + p, col0 + q) of the grid. Its edges H, V, AC, BD are those of
 * the cell of which it is corner a.
 */
#ifndef DX_AREA_H
#define DX_AREA_H

#include "core/grid/gates.h"
#include "core/rows/rows.h"

#define DX_MARGIN      6 /* the most that any rule reads beyond the tile (gates.h: margin) */
#define DX_AREA        (DX_TILE_CELLS + 1 + 2 * DX_MARGIN)
#define DX_AREA_STRIDE (DX_ROWS_N + 8) /* and room for neighbours: missing */

struct dx_area {
    int64_t row0, col0;      /* of the grid; negative in the first tiles */
    uint32_t n_rows, n_cols; /* the tile's cells */
    uint32_t first, end;     /* area rows that the rules in force read */
    bool wide;               /* as the gates: which of the two kinds of ranges is filled */

    /* narrow: 16-bit ranges, where they are published if they lie together there, or copied; and
     * what is beside them: it has no edges (valid) */
    const uint16_t *range16[DX_AREA + 1]; /* and a row below the last */
    uint16_t copy16[DX_AREA + 1][DX_AREA_STRIDE];
    uint16_t c16[DX_N_EDGES][DX_AREA][DX_AREA_STRIDE]; /* uneven grids only */

    /* wide: 32-bit ranges */
    uint32_t range[DX_AREA + 1][DX_AREA_STRIDE];
    uint32_t c[DX_N_EDGES][DX_AREA][DX_AREA_STRIDE]; /* uneven grids only */

    /* capped only (cap.h): points, units, and what |x| + |y| + |z| is in each row at most */
    const struct dx_geometry *geometry;
    struct dx_row_points point[DX_AREA];
    float sum[DX_AREA];

    struct dx_row_words valid;              /* within what the rules in force read */
    struct dx_row_words joined[DX_N_EDGES]; /* edges.h; those of row p's cells */
    struct dx_row_words alive;              /* mixed.h: valid and no mixed pixel */
    struct dx_row_words edge[DX_N_EDGES]; /* joined, and both ends alive: cells are made of them */
};

/* Fills all but joined, alive and edge for tile (row, col). */
void dx_area_gather(struct dx_area *a, const struct dx_plane *plane, const struct dx_tiling *tiling,
                    const struct dx_geometry *g, const struct dx_gates *gates, uint32_t tile_row,
                    uint32_t tile_col);

static inline uint32_t dx_area_range(const struct dx_area *a, uint32_t p, uint32_t q)
{
    return a->wide ? a->range[p][q] : a->range16[p][q];
}

/* Fills the 32-bit ranges from 16-bit ones, for who wants them. */
static inline void dx_area_widen(struct dx_area *a)
{
    for (uint32_t p = a->first; p < a->end; p++)
        for (uint32_t q = 0; q < DX_AREA_STRIDE; q++)
            a->range[p][q] = a->range16[p][q];
}

/* floor(2^40 / range); 0 for what is missing or too near for the fixed point. The quotient of
 * doubles is off by less than 2^-52 of it, and no closer to the next integer than 1 / range: it
 * truncates to the same, at a third of the time of an integer division. */
#define DX_INVERSE_LEAST 16

static inline uint64_t dx_area_invert(uint32_t range)
{
    return range < DX_INVERSE_LEAST ? 0 : (uint64_t)(int64_t)(0x1p40 / (double)range);
}

static inline uint64_t dx_area_inverse(const struct dx_area *a, uint32_t p, uint32_t q)
{
    return dx_area_invert(dx_area_range(a, p, q));
}

/* Grid row and column of an area dexel that lies inside the grid. */
static inline uint32_t dx_area_row(const struct dx_area *a, uint32_t p)
{
    return (uint32_t)(a->row0 + p);
}

static inline uint32_t dx_area_col(const struct dx_area *a, uint32_t q, uint32_t width)
{
    return (uint32_t)((a->col0 + q + width) % width);
}

/* Whether the two dexels, which are there, are no farther apart than the cap (true without one).
 * In cap.c. */
bool dx_area_within_cap(const struct dx_area *a, const struct dx_gates *gates, uint32_t p0,
                        uint32_t q0, uint32_t p1, uint32_t q1);

/* The dexels that an edge of cell (p, q) joins: (p + p0, q + q0) and (p + p1, q + q1). */
struct dx_ends {
    uint8_t p0, q0, p1, q1;
};

static inline struct dx_ends dx_edge_ends(enum dx_edge e)
{
    static const struct dx_ends ends[DX_N_EDGES] = {
        {0, 0, 0, 1}, {0, 0, 1, 0}, {0, 0, 1, 1}, {0, 1, 1, 0}};

    return ends[e];
}

/* Which cells of row p have both ends of their edges among the dexels that `here` (row p) and
 * `below` (row p + 1) tell. */
static inline void dx_edges_both(dx_bits both[DX_N_EDGES], dx_bits here, dx_bits below)
{
    both[DX_EDGE_H] = here & here >> 1;
    both[DX_EDGE_V] = here & below;
    both[DX_EDGE_AC] = here & below >> 1;
    both[DX_EDGE_BD] = here >> 1 & below;
}

/* The tile's own cells, or dexels, of a row: bit j is that of column j. */
static inline uint64_t dx_area_own(dx_bits row)
{
    return (uint64_t)(row >> DX_MARGIN);
}

/* A final edge; (p,q) names the cell. */
static inline bool dx_area_edge(const struct dx_area *a, enum dx_edge e, uint32_t p, uint32_t q)
{
    return dx_bits_at(dx_words_at(&a->edge[e], p), q);
}

#endif
