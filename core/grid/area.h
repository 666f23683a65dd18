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

#define DX_MARGIN      6 /* the most that any rule reads beyond the tile (gates.h: margin) */
#define DX_AREA        (DX_TILE_CELLS + 1 + 2 * DX_MARGIN)
#define DX_AREA_N      80 /* columns computed in each row, whatever the tile has: whole vectors */
#define DX_AREA_STRIDE 88 /* and room for their neighbours: missing */

struct dx_area {
    int64_t row0, col0;      /* of the grid; negative in the first tiles */
    uint32_t n_rows, n_cols; /* the tile's cells */
    uint32_t first, end;     /* area rows that the rules in force read */

    uint32_t range[DX_AREA][DX_AREA_STRIDE];
    uint16_t range16[DX_AREA][DX_AREA_STRIDE];         /* narrow only */
    uint16_t noise[DX_AREA][DX_AREA_STRIDE];           /* narrow only: t0 + quadratic term */
    uint32_t c[DX_N_EDGES][DX_AREA][DX_AREA_STRIDE];   /* uneven grids only */
    uint16_t c16[DX_N_EDGES][DX_AREA][DX_AREA_STRIDE]; /* the same, narrow only */
    int32_t direction[DX_AREA][DX_AREA_STRIDE][3];     /* capped only: unit vectors * 2^24 */
    uint64_t q[DX_AREA]
              [DX_AREA_STRIDE]; /* inverse range, 2^40 / range; 0: none. For rescue, bend */

    uint8_t joined[DX_N_EDGES][DX_AREA][DX_AREA_STRIDE]; /* edges.h */
    uint8_t alive[DX_AREA][DX_AREA_STRIDE];              /* mixed.h: valid and no mixed pixel */
};

/* Fills all but joined and alive for tile (row, col). */
void dx_area_gather(struct dx_area *a, const struct dx_plane *plane, const struct dx_tiling *tiling,
                    const struct dx_geometry *g, const struct dx_gates *gates, uint32_t tile_row,
                    uint32_t tile_col);

/* Grid row and column of an area dexel that lies inside the grid. */
static inline uint32_t dx_area_row(const struct dx_area *a, uint32_t p)
{
    return (uint32_t)(a->row0 + p);
}

static inline uint32_t dx_area_col(const struct dx_area *a, uint32_t q, uint32_t width)
{
    return (uint32_t)((a->col0 + q + width) % width);
}

/* Whether the two dexels are no farther apart than the cap (true without one). */
bool dx_area_within_cap(const struct dx_area *a, const struct dx_gates *gates, uint32_t p0,
                        uint32_t q0, uint32_t p1, uint32_t q1);

/* A final edge: joined, and neither end a mixed pixel. (p,q) names the cell. */
static inline bool dx_area_edge(const struct dx_area *a, enum dx_edge e, uint32_t p, uint32_t q)
{
    static const uint8_t end[DX_N_EDGES][2][2] = {
        {{0, 0}, {0, 1}}, {{0, 0}, {1, 0}}, {{0, 0}, {1, 1}}, {{0, 1}, {1, 0}}};
    const uint8_t(*x)[2] = end[e];

    return a->joined[e][p][q] & a->alive[p + x[0][0]][q + x[0][1]] &
           a->alive[p + x[1][0]][q + x[1][1]];
}

#endif
