/*
 * Smoothing's arithmetic, a row of dexels at a time (core/grid/smooth.h tells what for): the robust
 * mean by iterated weights of what pairs of neighbours tell. f32 without contraction, and the same
 * order of operations in each lane: the same bits on every machine. Rows hold whole vectors; what
 * lies beyond a part's columns, or is not joined, is computed like the rest and has no weight.
 */
#ifndef DX_SMOOTHER_H
#define DX_SMOOTHER_H

#include "core/rows/row_bits.h"

#define DX_SMOOTH_ROW   80 /* 65 dexels in whole vectors */
#define DX_SMOOTH_LANES 16 /* of the longest vector */
#define DX_SMOOTH_PAIRS 10

/* Weights of a pair's two inverse ranges. */
struct dx_smooth_line {
    float minus, plus;
};

struct dx_smooth_row {
    uint32_t n;                    /* columns, a multiple of DX_SMOOTH_LANES */
    float sigma[DX_SMOOTH_ROW];    /* noise of the dexel's range, units */
    float scale[DX_SMOOTH_ROW];    /* from a departure in inverse range to one in cutoffs */
    float slope[3][DX_SMOOTH_ROW]; /* of inverse range by direction; uneven grids only */
    float departure[DX_SMOOTH_PAIRS][DX_SMOOTH_ROW]; /* of what the pair tells from the own sample,
                                                        in cutoffs */
    float weight[DX_SMOOTH_PAIRS][DX_SMOOTH_ROW];    /* 0: not joined */
    float shift[DX_SMOOTH_ROW];  /* the robust mean, in cutoffs from the own sample */
    int32_t move[DX_SMOOTH_ROW]; /* what to take from the range, units */
};

/* A row of the neighbourhood, and the rows of a pair's two ends (pointers to the dexels' own
 * columns; `before` and `after` are at the pair's). */
struct dx_smooth_ends {
    const float *before, *own, *after;
};

/* What lies beside each dexel, along its row and along its column. */
struct dx_smooth_cross {
    struct dx_smooth_ends inverse[2], direction[2][3];
    dx_bits joined_before[2], joined_after[2];
};

/* sigma.h for 16-bit ranges and factors below 2^32. */
struct dx_smooth_noise {
    uint64_t a0;
    uint32_t a1, a2, full, max;
};

/* The loops, of one instruction set. */
struct dx_smoother {
    /* sigma8 of n ranges, a multiple of DX_SMOOTH_LANES. */
    void (*noise)(uint32_t *sigma8, const uint32_t *range, const struct dx_smooth_noise *s,
                  uint32_t n);

    /* 1 / range of n dexels, however many; of missing ones too: finite, and never looked at. */
    void (*invert)(float *out, const uint32_t *range, uint32_t n);

    /* Noise and scale from ranges; `per_unit` of what sigma8 counts. */
    void (*scale)(struct dx_smooth_row *r, const uint32_t *range, const uint32_t *sigma8,
                  float per_unit);

    /* The slope of the inverse range at each dexel of an uneven grid, from its neighbours in its
     * row and in its column, where they are joined. */
    void (*slope)(struct dx_smooth_row *r, const struct dx_smooth_cross *cross);

    /* What pair k tells, by the same line in all columns, or by one in each. */
    void (*even)(struct dx_smooth_row *r, unsigned k, const struct dx_smooth_ends *inverse,
                 struct dx_smooth_line line);
    void (*uneven)(struct dx_smooth_row *r, unsigned k, const struct dx_smooth_ends *inverse,
                   const struct dx_smooth_ends direction[3], bool depths);

    /* The weight of pair k, 0 where it is not joined. */
    void (*weigh)(struct dx_smooth_row *r, unsigned k, dx_bits joined, float weight);

    /* From departures and weights to moves, of at most `max_move` sigmas. */
    void (*solve)(struct dx_smooth_row *r, float max_move);
};

#endif
