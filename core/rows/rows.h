/*
 * The inner loops of terrain mode over rows of dexels. One source, compiled once for each
 * instruction set and chosen at run time: the loops are plain C that compilers turn into vectors,
 * so every set gives the same bytes. What a loop decides in floating point it decides by an
 * interval: where rounding could matter it says "unsure", and the caller asks exact integers.
 *
 * Rows have DX_ROWS_N columns and as much room that one more of each kind may be read. Pure
 * functions; any thread.
 */
#ifndef DX_ROWS_H
#define DX_ROWS_H

#include "core/base/bytes.h"
#include "core/base/delta.h"
#include "core/rows/row_bits.h"
#include "core/rows/smoother.h"

#include <stdbool.h>
#include <stdint.h>

#define DX_ROWS_N       80 /* columns of a tile's neighbourhood: whole vectors */
#define DX_ROWS_BLOCK   67 /* columns of a tile's block */
#define DX_ROWS_CELLS   64 /* cells of a tile's row */
#define DX_ROWS_CORNERS 72 /* their corners, in whole vectors */
#define DX_ROWS_LANES   24 /* of a hash: words of a row of 16-bit ranges, in whole vectors */
#define DX_ROWS_SLACK   48 /* elements of the longest stores */

enum dx_simd {
    DX_SIMD_AUTO = 0, /* the best that this processor has */
    DX_SIMD_GENERIC,  /* what every processor of this kind has (NEON on arm64) */
    DX_SIMD_AVX2,
    DX_SIMD_AVX512,
    DX_N_SIMD,
};

#define DX_ROW_EDGES 4 /* of a cell: H from a to b, V from a to d, AC, BD; in this order */

/* Rows `first` to `end` of a neighbourhood. */
struct dx_row_run {
    uint32_t first, end;
};

/* What the first-order rule looks at in rows of 16-bit ranges. The noise term of the gates is t0 +
 * ((r r >> 16) n2 >> 16), and fits 16 bits. */
struct dx_row_first_order {
    struct dx_row_run run;
    const uint16_t *const *range; /* by rows; and of one below the last */
    uint16_t t0, n2;
    const uint16_t (*c)[DX_ROW_EDGES];     /* by rows, or */
    const uint16_t *(*each)[DX_ROW_EDGES]; /* by rows and edges, if not NULL */
};

/* 32-bit ranges of such rows, and the gate's terms (gates.h). */
struct dx_row_wide_pair {
    const uint32_t *top, *bottom;
    double t0, n2;
};

/* What came out of a row of pairs, where both are there. */
struct dx_row_joined {
    dx_bits joined, unsure; /* unsure: ask integers */
};

/* sigma.h in floating point: sigma8(r) = min(max, a0 + a1 r + a2 r^2), and how far the integers may
 * be off. */
struct dx_row_sigma {
    double a0, a1, a2, max, off;
};

/* Weights of the two diagonal lines through a dexel: minus and plus of a-c, minus and plus of b-d;
 * at most 1, and no numbers where there is no line. */
struct dx_row_weights {
    double ac[2], bd[2];
};

/* What the choice between bends looks at: the inverse ranges of four rows around a row of cells,
 * from one column before the first cell's corner a on; the ranges of the cells' corners from that
 * one on; and weights of the lines through the upper and the lower ones, for each or for the row.
 */
struct dx_row_bend {
    const void *inverse[4];
    const void *range, *range_below;
    const struct dx_row_weights *top, *bottom;
    uint64_t outer; /* cells with edges to the four samples beyond their corners */
};

/* Which cells of a row prefer the diagonal b-d; unsure: ask integers. */
struct dx_row_preference {
    uint64_t bd, unsure;
};

/* What decides of samples whether they join a mean (estimator.h): in 1/256 unit; the gate in
 * sigmas. */
struct dx_row_mean {
    struct dx_row_sigma sigma;
    uint32_t surely_near, gate;
    uint32_t n_max; /* samples that a mean counts */
};

/* What is held (publish.c), in 1/256 unit; sigmas are a number of them, / 256. */
struct dx_row_hold {
    struct dx_row_sigma sigma;
    uint32_t surely_held;
    double sigmas;
};

/* Filters over frames, DX_ROWS_CELLS dexels of a row at a time. Estimates are in 1/256 unit. */
struct dx_row_filters {
    /* Where samples confirm estimates, those follow, and states are the samples they count and
     * nothing else. Which dexels are left to the caller: not those without sample and estimate. */
    uint64_t (*join_mean)(uint32_t *est, uint32_t *state, const uint32_t *range,
                          const struct dx_row_mean *mean);

    /* Estimates, and in whole units; UINT32_MAX where the state counts no sample: est is in whole
     * units there. */
    void (*tell_mean)(uint32_t *estimate, uint32_t *range, const uint32_t *est,
                      const uint32_t *state);

    void (*median3)(uint32_t *median, const uint32_t *x, const uint32_t *y, const uint32_t *z);

    /* Which dexels are not known to be held where they are: ask integers. */
    uint64_t (*may_have_moved)(const uint32_t *estimate, const uint32_t *published,
                               const struct dx_row_hold *hold);
};

#define DX_ROWS_MIDDLES      16
#define DX_ROWS_LEAST_MIDDLE 64

#define DX_ROWS_FINEST       80 /* 64 columns, or 65 in a last tile, and one more; whole vectors */
#define DX_ROWS_SLOTS        4

/* Own errors of a row of n middles and of the one behind, and where the row has diagonals, at odd
 * columns, of those above and below; bounds of levels. */
struct dx_row_finest {
    uint32_t n;
    bool diagonals;
    uint16_t own[DX_ROWS_FINEST], up[DX_ROWS_FINEST], down[DX_ROWS_FINEST];
    uint16_t bound[DX_ROWS_SLOTS];
};

/* Bits by slot: whether a middle's error has passed the bound, either way; whether the first
 * column's has. */
struct dx_row_flips {
    unsigned any, first;
};

/* 16-bit ranges of DX_ROWS_MIDDLES hypotenuse middles, of the ends, and of right angles (any that
 * is there, where they have no weight); weights * 2^22; sigma's factors are below 2^36. */
struct dx_row_middles {
    const uint32_t *middle, *end[2], *apex;
    double end_weight[2], apex_weight;
    struct dx_row_sigma sigma;
};

/* The loops for 16-bit ranges with f32, or for 32-bit ones with f64. */
struct dx_row_bends {
    /* 2^40 / r of DX_ROWS_CORNERS ranges; infinite for r below 16, which integers take for missing;
     * 0 for 0. */
    void (*inverse)(void *out, const void *range);

    /* Whether b-d bends less than a-c by a margin of noise; without outer samples, whether its
     * ends differ less in range. With weights for the row, or for each corner. */
    struct dx_row_preference (*bend)(const struct dx_row_bend *row,
                                     const struct dx_row_sigma *sigma);
    struct dx_row_preference (*bend_each)(const struct dx_row_bend *row,
                                          const struct dx_row_sigma *sigma);
};

/* Triangles that the cells of a tile can have, by rows; even: both diagonals would give as many,
 * and some. */
struct dx_row_cells {
    uint64_t abc[DX_ROWS_CELLS], acd[DX_ROWS_CELLS], abd[DX_ROWS_CELLS], bcd[DX_ROWS_CELLS];
    uint64_t even[DX_ROWS_CELLS];
};

/* The rules on rows of bits: those of all rows of a tile's neighbourhood at once. */
struct dx_row_rules {
    /* Of the edges that the first order joins, those whose ends are there; those that are there and
     * fail, and whether any of a row's does. */
    void (*join_there)(struct dx_row_words joined[DX_ROW_EDGES],
                       struct dx_row_words failed[DX_ROW_EDGES],
                       uint64_t some_failed[DX_WORDS_ROWS], const struct dx_row_words *valid);

    /* Valid samples that no axis takes for mixed; and of those the ones that are joined to more
     * than three of eight neighbours. */
    void (*attached)(struct dx_row_words *alive, const struct dx_row_words *valid,
                     const struct dx_row_words joined[DX_ROW_EDGES]);
    void (*well_joined)(struct dx_row_words *alive, const struct dx_row_words joined[DX_ROW_EDGES]);

    /* Joined edges both of whose ends are alive. */
    void (*keep_alive)(struct dx_row_words edge[DX_ROW_EDGES],
                       const struct dx_row_words joined[DX_ROW_EDGES],
                       const struct dx_row_words *alive);

    /* The triangles that the tile's own cells can have, which begin at row and column `margin`. */
    void (*triangles)(struct dx_row_cells *out, const struct dx_row_words edge[DX_ROW_EDGES],
                      uint32_t margin);

    /* The three bits of their codes. */
    void (*outcomes)(uint64_t bit[3][DX_ROWS_CELLS], const struct dx_row_cells *cells,
                     const uint64_t prefer_bd[DX_ROWS_CELLS],
                     const uint64_t is_cell[DX_ROWS_CELLS]);

    /* The dexels of the tile's block that its cells use. */
    void (*corners)(dx_bits used[DX_ROWS_CELLS + 3], const uint64_t bit[3][DX_ROWS_CELLS]);
};

/* A block row of a tile under a spinning geometry (geometry.h): its row's six numbers, cosines and
 * sines of its columns. */
struct dx_row_spin {
    const float *row;
    float unit_m;
    float c[DX_ROWS_N], s[DX_ROWS_N];
};

/* Which dexels of two block rows are used, and the ranks of the rows' first ones. */
struct dx_row_ranks {
    dx_bits top, bottom;
    uint16_t first_top, first_bottom;
};

/* A block row's ranges and those of the row above, and which of them are used. */
struct dx_row_delta {
    const uint32_t *range, *north;
    const uint8_t *used, *used_north;
};

/* Points, or vectors. */
struct dx_row_points {
    float x[DX_ROWS_N + 8], y[DX_ROWS_N + 8], z[DX_ROWS_N + 8];
};

/* Cosines and sines of a row's columns. */
struct dx_row_turn {
    float c[DX_ROWS_N], s[DX_ROWS_N];
};

/* Two rows of points that are paired. */
struct dx_row_span {
    const float *x[2], *y[2], *z[2];
};

/* Where the dexels of a row look, from some column on: those of a spinning geometry by cosines and
 * sines of their columns, in pairs, and the row's six numbers; of a pinhole by their tangents and
 * the row's; of a table by three numbers each. */
struct dx_row_beams {
    enum { DX_BEAMS_SPINNING, DX_BEAMS_PINHOLE, DX_BEAMS_TABLE } kind;
    const float *columns, *row;
};

struct dx_rows {
    const char *name;

    /* ---- rules ---- */

    /* Which ranges are not 0; the same of rows `first` to `end` of a neighbourhood, as far as they
     * are among the columns. */
    dx_bits (*valid)(const uint16_t *range);
    void (*valid_rows)(struct dx_row_words *valid, const uint16_t *const *range,
                       struct dx_row_run run, dx_bits columns);
    dx_bits (*valid_wide)(const uint32_t *range);

    /* The edges that the first-order rule joins, by one constant of each kind and row or by one for
     * each edge. Where one of the two ends is missing, it may say either. */
    void (*join)(struct dx_row_words joined[DX_ROW_EDGES], const struct dx_row_first_order *rows);

    /* The same of 32-bit ranges. */
    void (*join_wide)(struct dx_row_joined out[DX_ROW_EDGES], const struct dx_row_wide_pair *rows,
                      const uint32_t c[DX_ROW_EDGES]);
    void (*join_wide_each)(struct dx_row_joined out[DX_ROW_EDGES],
                           const struct dx_row_wide_pair *rows,
                           const uint32_t *const c[DX_ROW_EDGES]);

    struct dx_row_bends narrow, wide;
    struct dx_row_rules rules;

    /* Cell codes, one byte each, from the three bits of a row of them. */
    void (*code)(uint8_t *code, const uint64_t bit[3]);

    /* ---- tiles; what is written to `out` may be followed by up to DX_ROWS_SLACK elements more
     * ----
     */

    /* The three bits of a row of cell codes. */
    void (*bits)(uint64_t bit[3], const uint8_t *code);

    /* Which of 64 bytes are not 0. */
    uint64_t (*some)(const uint8_t *bytes);

    /* Used dexels of all rows before each; and of all of them. */
    void (*count)(uint16_t *first, const dx_bits *row, uint32_t n_rows);

    /* DX_ROWS_N ranks, where dexels are used: `first` and those before them in the row. */
    void (*rank)(uint16_t *rank, dx_bits used, uint16_t first);

    /* Rows of DX_ROWS_BLOCK elements, from those of a grid of that width; each row is written to
     * DX_ROWS_N elements. */
    void (*widen)(uint32_t *out, const uint16_t *from, uint32_t width, uint32_t n_rows);

    /* Content hash of rows of 16-bit ranges, 0 for those that are not used; and of rows of words.
     */
    void (*digest)(uint64_t lane[DX_ROWS_LANES], const uint16_t *const *range, const dx_bits *used,
                   uint32_t n_rows);
    void (*digest_words)(uint64_t lane[DX_ROWS_LANES], const uint64_t (*word)[DX_ROWS_LANES],
                         uint32_t n_rows);

    /* Points of the used dexels of a block row, metres, one after the other. Returns where the next
     * one goes. */
    dx_packed_f32 *(*spin)(dx_packed_f32 *out, const struct dx_row_spin *spin,
                           const uint32_t *range, dx_bits used);

    /* Triangles of a row of cells, as ranks of their corners. */
    dx_packed_u16 *(*emit)(dx_packed_u16 *out, const uint8_t *code,
                           const struct dx_row_ranks *ranks, bool flip);

    /* ---- encodings: block rows of tiles ---- */

    /* Values of the used dexels, one after the other; and the same in 16 bits. Returns where the
     * next one goes. */
    uint32_t *(*keep)(uint32_t *out, const uint32_t *v, dx_bits used);
    uint16_t *(*keep16)(uint16_t *out, const uint32_t *v, dx_bits used);

    /* Codes of up to DX_ROWS_CELLS rows of cells to three bits each (codes.h), one row after the
     * other; a byte behind them is written too. And their triangles. */
    void (*pack_codes)(uint8_t *out, const uint8_t *code, uint32_t n_rows);
    uint32_t (*count_triangles)(const uint8_t *code, uint32_t n_rows);

    /* Folded residuals of each predictor (delta.h) from the neighbours that are used. alone: used,
     * and without a neighbour to tell from; the caller knows better. */
    void (*deltas)(uint32_t folded[DX_N_DELTA_PREDICTORS][DX_ROWS_N], uint8_t *alone,
                   const struct dx_row_delta *row);

    /* ---- points ---- */

    /* Ranges of DX_ROWS_CELLS points from their beams' origins (pinhole: along the axis), in units;
     * 0 where a point is no return (dx_fit_valid), or the range rounds to none or to more than
     * `limit`. Returns as bits which are 0 and have three numbers. */
    uint64_t (*units)(uint32_t units[DX_ROWS_CELLS], const double *xyz,
                      const struct dx_row_beams *beams, double unit_m, double limit);

    /* Which of DX_ROWS_CELLS points are surely returns, within 1e-6 of their beams' directions and
     * between two distances from their origins. */
    uint64_t (*on_beams)(const double *xyz, const struct dx_row_beams *beams, double near,
                         double far);

    /* Those of ranges r (metres) in a row of a spinning geometry, by its six numbers; and in any
     * other, by the vectors that ranges stretch. */
    void (*turn)(struct dx_row_points *out, const float *row, const struct dx_row_turn *turn,
                 const float *r);
    void (*stretch)(struct dx_row_points *out, const struct dx_row_points *p, const float *r);

    /* Of length 1, to 2^-20; no numbers where f32 cannot tell. */
    void (*unit)(struct dx_row_points *p);

    /* Which pairs are within the cap; unsure: by less than the margin on either side of its square.
     */
    struct dx_row_joined (*cap)(const struct dx_row_span *span, float cap2, float margin);

    /* ---- normals: from the points of two rows ---- */

    /* Adds the cross products of a row of cells' triangles to the sums of their upper corners, and
     * begins those of the lower ones: the order of normals.h. */
    void (*add_cells)(struct dx_row_points *top, struct dx_row_points *bottom,
                      const struct dx_row_points *above, const struct dx_row_points *below,
                      const uint8_t *code);

    /* Two bytes (octahedral.h) of each sum, or of its opposite; 0, 0 where it is not used. */
    void (*octahedral)(int8_t *out, const struct dx_row_points *sum, dx_bits used, bool flip);

    struct dx_row_filters filters;

    /* ---- levels of detail ---- */

    /* Errors of middles in 1/16 sigma (lod_error.c), infinite where a range is nearer than
     * DX_ROWS_LEAST_MIDDLE. Which ones are unsure: ask integers. */
    uint32_t (*errors)(uint32_t *error, const struct dx_row_middles *m);

    /* Errors of the finest middles of a row (h = 1); the others at even columns stay. */
    struct dx_row_flips (*raise)(uint16_t error[DX_ROWS_FINEST], const struct dx_row_finest *f);

    struct dx_smoother smoother;
};

/* NULL: this processor (or this build) has no such instructions. */
const struct dx_rows *dx_rows_get(enum dx_simd simd);

#endif
