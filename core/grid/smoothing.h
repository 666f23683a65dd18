/*
 * Smoothing as a stage of terrain mode, between what is ingested and what is published: it holds
 * the array of samples, knows which parts of the published array are no longer theirs, and makes
 * those anew before a commit. After that the published array is a pure function of the samples and
 * the constants, whatever the parts in which they came. Owned by one terrain; only the parts go
 * over the pool.
 */
#ifndef DX_SMOOTHING_H
#define DX_SMOOTHING_H

#include "core/base/pool.h"
#include "core/grid/smooth.h"

struct dx_smoothing {
    struct dx_smooth smooth;
    struct dx_plane sampled; /* what ingest lets through */
    uint64_t *stale;         /* bits by tile number: parts to be made anew */
    uint32_t *task;          /* their numbers, of the run under way */
    struct dx_rect *changed; /* by task: what differs; empty (row0 > row1) where nothing does */
    struct dx_plane *out;    /* of the run under way */
    const struct dx_tiling *tiling;
    const struct dx_geometry *geometry;
};

/* `like`: a plane of the published array's kind; `noise`, `uneven` as dx_smooth_init. Errors:
 * -ENOMEM. */
int dx_smoothing_new(struct dx_smoothing **out, const struct dx_geometry *g,
                     const struct dx_tiling *tiling, const struct dx_plane *like, double noise,
                     bool uneven);
void dx_smoothing_free(struct dx_smoothing *s); /* NULL is fine */

/* The constants have changed, and with them everything. */
void dx_smoothing_set(struct dx_smoothing *s, const struct dx_gates *gates);

/* Samples have changed. */
void dx_smoothing_mark(struct dx_smoothing *s, const struct dx_rect *dexels);

/* Makes the stale parts of `out` anew, on the pool. Returns how many rectangles of s->changed tell
 * what that was (some may be empty). */
uint32_t dx_smoothing_run(struct dx_smoothing *s, struct dx_plane *out, struct dx_pool *pool);

#endif
