/*
 * Smoothing's arithmetic, a row of dexels at a time. f32 without contraction, and the same order of
 * operations in each lane: the same bits on every machine. Rows hold whole vectors; what lies
 * beyond a part's columns, or is not joined, is computed like the rest and has no weight.
 */
#ifndef DX_SMOOTH_ROWS_H
#define DX_SMOOTH_ROWS_H

#include "core/grid/smooth.h"

#define DX_SMOOTH_ROW 72 /* 65 dexels in whole vectors */

/* A pair: the neighbours di rows and dj columns before and after, and what its word counts beside
 * that of the dexel's own sample. */
struct dx_smooth_pair {
    int di, dj;
    float weight;
};

extern const struct dx_smooth_pair dx_smooth_pairs[DX_SMOOTH_PAIRS];

struct dx_smooth_row {
    uint32_t n;                    /* columns, a multiple of 8 */
    float sigma[DX_SMOOTH_ROW];    /* noise of the dexel's range, units */
    float scale[DX_SMOOTH_ROW];    /* from a departure in inverse range to one in cutoffs */
    float slope[3][DX_SMOOTH_ROW]; /* of inverse range by direction; uneven grids only */
    struct {
        float departure[DX_SMOOTH_ROW]; /* of what the pair tells from the own sample, in cutoffs */
        float weight[DX_SMOOTH_ROW];    /* 0: not joined */
    } pair[DX_SMOOTH_PAIRS];
    float shift[DX_SMOOTH_ROW]; /* the robust mean, in cutoffs from the own sample */
    float sum[DX_SMOOTH_ROW], total[DX_SMOOTH_ROW];
    int32_t move[DX_SMOOTH_ROW]; /* what to take from the range, units */
};

/* A row of the neighbourhood, and the rows of a pair's two ends (pointers to the dexels' own
 * columns; `before` and `after` are at the pair's). */
struct dx_smooth_ends {
    const float *before, *own, *after;
};

/* Noise and scale from ranges. */
void dx_smooth_row_scale(struct dx_smooth_row *r, const uint32_t *range,
                         const struct dx_sigma *sigma, double noise);

/* The slope of the inverse range at each dexel of an uneven grid, from its neighbours in its row
 * and in its column (by pair 0 and 1), where they are joined. */
struct dx_smooth_cross {
    struct dx_smooth_ends inverse[2], direction[2][3];
    const uint8_t *joined_before[2], *joined_after[2];
};

void dx_smooth_row_slope(struct dx_smooth_row *r, const struct dx_smooth_cross *cross);

/* What pair k tells, by the same line in all columns, or by one in each. */
void dx_smooth_row_even(struct dx_smooth_row *r, unsigned k, const struct dx_smooth_ends *inverse,
                        struct dx_smooth_line line);
void dx_smooth_row_uneven(struct dx_smooth_row *r, unsigned k, const struct dx_smooth_ends *inverse,
                          const struct dx_smooth_ends direction[3], bool depths);

/* The weight of pair k where it is joined (1) and not (0). */
void dx_smooth_row_weigh(struct dx_smooth_row *r, unsigned k, const uint8_t *joined);

/* From departures and weights to moves. */
void dx_smooth_row_solve(struct dx_smooth_row *r);

#endif
