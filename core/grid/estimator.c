/*
 * The mean: a sample near the estimate joins it; one far from it becomes the other hypothesis,
 * which takes over as soon as a second sample confirms it. So one stray sample changes nothing, and
 * a surface that has moved is followed with the second frame. A surface that keeps moving confirms
 * no hypothesis at all: then the newest sample takes over, at the third that is astray, and with
 * each one while the estimate rests on a single sample.
 */
#include "core/grid/estimator.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define GATE      4 /* sigmas between a hypothesis and a sample that confirms it */
#define CONFIRMED 2 /* samples that make the other hypothesis the estimate */
#define ASTRAY    3 /* samples after which the estimate is wrong, even if no two of them agree */

static int alloc_filter(struct dx_estimator *e, const struct dx_plane *plane)
{
    size_t n = dx_plane_n_dexels(plane);

    e->newest = (struct dx_plane){.height = plane->height,
                                  .width = plane->width,
                                  .range_bytes = plane->range_bytes,
                                  .attr_bytes = plane->attr_bytes};
    e->newest.attr = plane->attr_bytes ? calloc(n, plane->attr_bytes) : NULL;
    if (plane->attr_bytes && !e->newest.attr)
        return -ENOMEM;
    if (e->filter == DX_FILTER_MEAN) {
        e->mean = calloc(n, sizeof(*e->mean));
        return e->mean ? 0 : -ENOMEM;
    }
    for (int k = 0; k < 2; k++) {
        int r = dx_plane_init(&e->last[k], plane->height, plane->width, plane->range_bytes, 0);

        if (r < 0)
            return r;
    }
    return 0;
}

/* floor(y / n) = y * factor >> shift for y < 2^30: the factor is too large by less than n / 2^shift
 * of itself, and 2^shift >= 2^30 n. */
static struct dx_reciprocal reciprocal_of(uint32_t n)
{
    struct dx_reciprocal r = {.shift = 30};

    while (1u << (r.shift - 30) < n)
        r.shift++;
    r.factor = (uint32_t)(((1ull << r.shift) + n - 1) / n);
    return r;
}

int dx_estimator_init(struct dx_estimator *e, const struct dx_ingest_params *params,
                      const struct dx_plane *plane)
{
    int r = 0;

    *e = (struct dx_estimator){
        .filter = params->filter, .n_max = params->n_max, .n_gap = params->n_gap};
    for (uint32_t n = 1; n < 256; n++)
        e->reciprocal[n] = reciprocal_of(n);
    e->n_taken = calloc(plane->width, sizeof(*e->n_taken));
    if (!e->n_taken)
        r = -ENOMEM;
    else if (e->filter != DX_FILTER_OFF)
        r = alloc_filter(e, plane);
    if (r < 0)
        dx_estimator_fini(e);
    return r;
}

double dx_estimator_noise(const struct dx_ingest_params *p)
{
    switch (p->filter) {
    case DX_FILTER_MEAN:
        return sqrt(1.0 / (2 * p->n_max - 1));
    case DX_FILTER_MEDIAN3:
        return 0.67;
    default:
        return 1;
    }
}

void dx_estimator_fini(struct dx_estimator *e)
{
    free(e->mean);
    dx_plane_fini(&e->last[0]);
    dx_plane_fini(&e->last[1]);
    dx_plane_fini(&e->newest);
    free(e->n_taken);
    *e = (struct dx_estimator){0};
}

void dx_estimator_settle(struct dx_estimator *e, const struct dx_sigma *sigma)
{
    e->sigma = *sigma;
    e->surely_near = GATE * dx_sigma_at(sigma, 0);
    e->settled = true;
}

void dx_estimator_forget(struct dx_estimator *e)
{
    const struct dx_plane *p = &e->newest;

    if (e->mean)
        memset(e->mean, 0, dx_plane_n_dexels(p) * sizeof(*e->mean));
    if (p->width)
        memset(e->n_taken, 0, p->width * sizeof(*e->n_taken));
}

/* ---- the mean ------------------------------------------------------------------------------- */

static uint32_t distance(uint32_t a, uint32_t b)
{
    return a > b ? a - b : b - a;
}

static bool confirms(const struct dx_estimator *e, uint32_t sample, uint32_t hypothesis)
{
    uint32_t d = distance(sample, hypothesis);

    return d <= e->surely_near ||
           d <= GATE * dx_sigma_at(&e->sigma, hypothesis >> DX_ESTIMATE_FRACTION);
}

/* hypothesis + (sample - hypothesis) / n, rounded half up. Without a branch: which side a sample is
 * on is a coin toss. */
static uint32_t joined_by(const struct dx_estimator *e, uint32_t hypothesis, uint32_t sample,
                          uint32_t n)
{
    const struct dx_reciprocal *r = &e->reciprocal[n];
    uint32_t down = sample < hypothesis, sign = 0 - down;
    uint64_t y = (uint64_t)((sample - hypothesis) ^ sign) + down + ((n - down) >> 1);
    uint32_t step = (uint32_t)(y * r->factor >> r->shift);

    return hypothesis + ((step ^ sign) + down);
}

static void restart(struct dx_hypotheses *h, uint32_t est, uint32_t n)
{
    *h = (struct dx_hypotheses){.est = est, .n = (uint8_t)n};
}

static void contradict(const struct dx_estimator *e, struct dx_hypotheses *h, uint32_t sample)
{
    if (h->alt_n && confirms(e, sample, h->alt)) {
        h->alt_n++;
        h->alt = joined_by(e, h->alt, sample, h->alt_n);
    } else {
        h->alt = sample;
        h->alt_n = 1;
    }
    h->n_astray++;
    if (h->alt_n >= CONFIRMED)
        restart(h, h->alt, h->alt_n < e->n_max ? h->alt_n : e->n_max);
    else if (h->n == 1 || h->n_astray >= ASTRAY)
        restart(h, sample, 1);
}

static void take_return(const struct dx_estimator *e, struct dx_hypotheses *h, uint32_t range)
{
    uint32_t sample = range << DX_ESTIMATE_FRACTION;

    if (range >= DX_ESTIMATE_TOO_FAR) {
        restart(h, range, 0);
    } else if (h->n == 0 || !e->settled) {
        restart(h, sample, 1);
    } else if (confirms(e, sample, h->est)) {
        h->n = (uint8_t)(h->n + (h->n < e->n_max));
        h->est = joined_by(e, h->est, sample, h->n);
        h->alt_n = h->n_missing = h->n_astray = 0;
    } else {
        contradict(e, h, sample);
    }
}

static void take_missing(const struct dx_estimator *e, struct dx_hypotheses *h)
{
    if (h->est && h->n_missing++ >= e->n_gap)
        *h = (struct dx_hypotheses){0};
}

static void take_mean(const struct dx_estimator *e, const struct dx_plane *frame, size_t at,
                      uint32_t n, uint64_t *estimate)
{
    struct dx_hypotheses *h = e->mean + at;

    for (uint32_t k = 0; k < n; k++, h++) {
        uint32_t range = dx_plane_range(frame, at + k);

        if (range)
            take_return(e, h, range);
        else
            take_missing(e, h);
        estimate[k] = (uint64_t)h->est << (h->n ? 0 : DX_ESTIMATE_FRACTION);
    }
}

/* ---- the median ----------------------------------------------------------------------------- */

/* A missing return is 0 and takes part as the nearest of the three: with one missing the nearer of
 * the two others is taken, with two missing there is no return. */
static uint32_t median3(uint32_t a, uint32_t b, uint32_t c)
{
    uint32_t lo = a < b ? a : b, hi = a < b ? b : a, hi_c = hi < c ? hi : c;

    return lo > hi_c ? lo : hi_c;
}

static void take_median(struct dx_estimator *e, const struct dx_plane *frame, size_t at, uint32_t n,
                        uint64_t *estimate)
{
    for (uint32_t k = 0; k < n; k++) {
        uint32_t range = dx_plane_range(frame, at + k);
        uint32_t before = dx_plane_range(&e->last[0], at + k);
        uint32_t m = median3(range, before, dx_plane_range(&e->last[1], at + k));

        estimate[k] = (uint64_t)m << DX_ESTIMATE_FRACTION;
        dx_plane_set_range(&e->last[1], at + k, before);
        dx_plane_set_range(&e->last[0], at + k, range);
    }
}

/* A first frame counts as three: the stream does not begin with frames without a mesh. */
static void repeat_column(struct dx_estimator *e, const struct dx_plane *frame, uint32_t col)
{
    for (uint32_t i = 0; i < frame->height; i++) {
        size_t at = (size_t)i * frame->width + col;
        uint32_t range = dx_plane_range(frame, at);

        dx_plane_set_range(&e->last[0], at, range);
        dx_plane_set_range(&e->last[1], at, range);
    }
}

/* ---- any filter ----------------------------------------------------------------------------- */

void dx_estimator_begin(struct dx_estimator *e, const struct dx_plane *frame, uint32_t col0,
                        uint32_t n_cols)
{
    for (uint32_t j = col0; j < col0 + n_cols; j++) {
        if (e->filter == DX_FILTER_MEDIAN3 && e->n_taken[j] == 0)
            repeat_column(e, frame, j);
        e->n_taken[j]++;
    }
}

static void take_attributes(struct dx_estimator *e, const struct dx_plane *frame, size_t at,
                            uint32_t n)
{
    for (uint32_t k = 0; k < n; k++)
        if (dx_plane_range(frame, at + k))
            dx_plane_set_attr(&e->newest, at + k, dx_plane_attr(frame, at + k));
}

void dx_estimator_take(struct dx_estimator *e, const struct dx_plane *frame, uint32_t row,
                       uint32_t col0, uint32_t n, uint64_t *estimate)
{
    size_t at = (size_t)row * frame->width + col0;

    switch (e->filter) {
    case DX_FILTER_MEAN:
        take_mean(e, frame, at, n, estimate);
        break;
    case DX_FILTER_MEDIAN3:
        take_median(e, frame, at, n, estimate);
        break;
    default:
        for (uint32_t k = 0; k < n; k++)
            estimate[k] = (uint64_t)dx_plane_range(frame, at + k) << DX_ESTIMATE_FRACTION;
    }
    if (e->newest.attr_bytes)
        take_attributes(e, frame, at, n);
}
