/*
 * What a dexel's range is, from the frames so far: nothing but the newest frame (off), a mean with
 * two hypotheses (mean), or the median of the last three frames (median3); docs/terrain.md has the
 * rules. All in integers. Columns may come in any parts: a dexel's estimate depends on its own
 * samples alone. Owned by one terrain; allocates when it is made and never after.
 */
#ifndef DX_ESTIMATOR_H
#define DX_ESTIMATOR_H

#include "core/grid/sigma.h"
#include "core/grid/terrain.h"

/* Bits of a unit's fraction in an estimate. */
#define DX_ESTIMATE_FRACTION 8

/* Ranges from here on do not fit an estimate's 32 bits: they are taken as they come. */
#define DX_ESTIMATE_TOO_FAR (1u << 24)

/*
 * What the mean knows of dexels, each an array. est and alt are in 1/256 unit. est 0: no return.
 * A state is four counts, a byte each from the lowest on: samples in est, at most the filter's
 * memory (0 and est not: a range too far to be filtered, in whole units); samples in alt (0: there
 * is none); frames without a return, and samples far from est, since it was confirmed.
 */
struct dx_means {
    uint32_t *est, *alt, *state;
};

/* Estimates of dexels side by side, [DX_ESTIMATES] each: in 1/256 unit, 0 where there is no return,
 * UINT32_MAX where the range is too far to be filtered; and in whole units, rounded. */
#define DX_ESTIMATES 128

struct dx_estimates {
    uint32_t fine[DX_ESTIMATES], range[DX_ESTIMATES];
};

struct dx_reciprocal {
    uint32_t factor, shift;
};

struct dx_estimator {
    enum dx_filter filter;
    uint32_t n_max; /* samples a mean counts at most */
    uint32_t n_gap; /* frames without a return that it bridges */
    bool settled;   /* the noise is known; until then samples are taken as they come */
    struct dx_sigma sigma;
    const struct dx_rows *rows;
    struct dx_row_mean row_mean;
    struct dx_means mean;    /* MEAN: by dexel */
    struct dx_plane last[2]; /* MEDIAN3: the two frames before the next */
    struct dx_plane newest;  /* attributes alone: of each dexel's newest return; unless OFF */
    uint32_t *n_taken;       /* by column: how often it has come */
    struct dx_reciprocal reciprocal[256];
};

/* For planes like `plane`, by an instruction set's loops. Errors: -ENOMEM. */
int dx_estimator_init(struct dx_estimator *e, const struct dx_ingest_params *params,
                      const struct dx_plane *plane, const struct dx_rows *rows);
void dx_estimator_fini(struct dx_estimator *e);

/* What is left of white noise of 1 sigma once the filter has settled. */
double dx_estimator_noise(const struct dx_ingest_params *params);

/* The noise is known from here on. */
void dx_estimator_settle(struct dx_estimator *e, const struct dx_sigma *sigma);

/* Forgets all samples; the noise stays. */
void dx_estimator_forget(struct dx_estimator *e);

/* Columns of a frame have come: to be called once for them, before their rows are taken. */
void dx_estimator_begin(struct dx_estimator *e, const struct dx_plane *frame, uint32_t col0,
                        uint32_t n_cols);

/* Takes samples (row, col0..col0 + n) of a frame, n <= DX_ESTIMATES. */
void dx_estimator_take(struct dx_estimator *e, const struct dx_plane *frame, uint32_t row,
                       uint32_t col0, uint32_t n, struct dx_estimates *out);

/* One of them in 1/256 unit, exactly. */
static inline uint64_t dx_estimate_at(const struct dx_estimates *e, uint32_t k)
{
    return e->fine[k] == UINT32_MAX ? (uint64_t)e->range[k] << DX_ESTIMATE_FRACTION : e->fine[k];
}

#endif
