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
#define BLOCK     DX_ROWS_CELLS
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
        e->mean.est = calloc(n, sizeof(*e->mean.est));
        e->mean.alt = calloc(n, sizeof(*e->mean.alt));
        e->mean.state = calloc(n, sizeof(*e->mean.state));
        return e->mean.est && e->mean.alt && e->mean.state ? 0 : -ENOMEM;
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
                      const struct dx_plane *plane, const struct dx_rows *rows)
{
    int r = 0;

    *e = (struct dx_estimator){
        .filter = params->filter, .n_max = params->n_max, .n_gap = params->n_gap, .rows = rows};
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
    free(e->mean.est);
    free(e->mean.alt);
    free(e->mean.state);
    dx_plane_fini(&e->last[0]);
    dx_plane_fini(&e->last[1]);
    dx_plane_fini(&e->newest);
    free(e->n_taken);
    *e = (struct dx_estimator){0};
}

void dx_estimator_settle(struct dx_estimator *e, const struct dx_sigma *sigma)
{
    e->sigma = *sigma;
    e->row_mean = (struct dx_row_mean){.sigma = dx_sigma_rows(sigma),
                                       .surely_near = GATE * dx_sigma_at(sigma, 0),
                                       .gate = GATE,
                                       .n_max = e->n_max};
    e->settled = true;
}

void dx_estimator_forget(struct dx_estimator *e)
{
    const struct dx_plane *p = &e->newest;
    const size_t n = dx_plane_n_dexels(p);

    if (e->filter == DX_FILTER_MEAN) {
        memset(e->mean.est, 0, n * sizeof(*e->mean.est));
        memset(e->mean.alt, 0, n * sizeof(*e->mean.alt));
        memset(e->mean.state, 0, n * sizeof(*e->mean.state));
    }
    if (p->width)
        memset(e->n_taken, 0, p->width * sizeof(*e->n_taken));
}

/* ---- the mean ------------------------------------------------------------------------------- */

/* One dexel. */
struct hypotheses {
    uint32_t est, alt;
    uint8_t n, alt_n, n_missing, n_astray;
};

/* Most have no other hypothesis, and their alt is not looked at: it would come from afar. */
static struct hypotheses get(const struct dx_means *m, size_t at)
{
    const uint32_t s = m->state[at];
    struct hypotheses h = {.est = m->est[at],
                           .n = (uint8_t)s,
                           .alt_n = (uint8_t)(s >> 8),
                           .n_missing = (uint8_t)(s >> 16),
                           .n_astray = (uint8_t)(s >> 24)};

    if (h.alt_n)
        h.alt = m->alt[at];
    return h;
}

static void put(struct dx_means *m, size_t at, const struct hypotheses *h)
{
    m->est[at] = h->est;
    m->state[at] =
        h->n | (uint32_t)h->alt_n << 8 | (uint32_t)h->n_missing << 16 | (uint32_t)h->n_astray << 24;
    if (h->alt_n)
        m->alt[at] = h->alt;
}

static uint32_t distance(uint32_t a, uint32_t b)
{
    return a > b ? a - b : b - a;
}

static bool confirms(const struct dx_estimator *e, uint32_t sample, uint32_t hypothesis)
{
    uint32_t d = distance(sample, hypothesis);

    return d <= e->row_mean.surely_near ||
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

static void restart(struct hypotheses *h, uint32_t est, uint32_t n)
{
    *h = (struct hypotheses){.est = est, .n = (uint8_t)n};
}

static void contradict(const struct dx_estimator *e, struct hypotheses *h, uint32_t sample)
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

static void take_return(const struct dx_estimator *e, struct hypotheses *h, uint32_t range)
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

static void take_missing(const struct dx_estimator *e, struct hypotheses *h)
{
    if (h->est && h->n_missing++ >= e->n_gap)
        *h = (struct hypotheses){0};
}

/* Dexels that do more than confirm what is estimated of them. */
static void take_left(const struct dx_estimator *e, struct dx_means *m, const uint32_t *range,
                      uint64_t left)
{
    for (; left; left &= left - 1) {
        const uint32_t k = (uint32_t)__builtin_ctzll(left);
        struct hypotheses h = get(m, k);

        if (range[k])
            take_return(e, &h, range[k]);
        else
            take_missing(e, &h);
        put(m, k, &h);
    }
}

static void take_block(const struct dx_estimator *e, struct dx_means m, const uint32_t *range,
                       uint32_t *fine, uint32_t *rounded)
{
    const struct dx_row_filters *loops = &e->rows->filters;
    uint64_t left = UINT64_MAX;

    if (e->settled)
        left = loops->join_mean(m.est, m.state, range, &e->row_mean);
    take_left(e, &m, range, left);
    loops->tell_mean(fine, rounded, m.est, m.state);
}

/* Less than a block: beside copies that are empty, as missing dexels leave them. */
static void take_some(const struct dx_estimator *e, struct dx_means m, const uint32_t *range,
                      uint32_t n, uint32_t *fine, uint32_t *rounded)
{
    uint32_t est[BLOCK] = {0}, alt[BLOCK] = {0}, state[BLOCK] = {0};
    const size_t len = n * sizeof(*est);

    memcpy(est, m.est, len);
    memcpy(alt, m.alt, len);
    memcpy(state, m.state, len);
    take_block(e, (struct dx_means){est, alt, state}, range, fine, rounded);
    memcpy(m.est, est, len);
    memcpy(m.alt, alt, len);
    memcpy(m.state, state, len);
}

static void take_mean(const struct dx_estimator *e, const uint32_t *range, size_t at, uint32_t n,
                      uint32_t *fine, uint32_t *rounded)
{
    const struct dx_means m = {e->mean.est + at, e->mean.alt + at, e->mean.state + at};

    if (n == BLOCK)
        take_block(e, m, range, fine, rounded);
    else
        take_some(e, m, range, n, fine, rounded);
}

/* ---- the median ----------------------------------------------------------------------------- */

/* A missing return is 0 and takes part as the nearest of the three: with one missing the nearer of
 * the two others is taken, with two missing there is no return. */
static void take_median(struct dx_estimator *e, const struct dx_plane *frame, const uint32_t *range,
                        size_t at, uint32_t n, uint32_t *median)
{
    const size_t bytes = frame->range_bytes, from = at * bytes, len = n * bytes;
    uint32_t before[2][BLOCK];

    for (int k = 0; k < 2; k++)
        dx_plane_get_ranges(&e->last[k], at, n, before[k], BLOCK);
    e->rows->filters.median3(median, range, before[0], before[1]);
    memcpy((uint8_t *)e->last[1].range + from, (const uint8_t *)e->last[0].range + from, len);
    memcpy((uint8_t *)e->last[0].range + from, (const uint8_t *)frame->range + from, len);
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

/* Ranges that are estimates themselves. */
static void tell_ranges(const uint32_t *range, uint32_t n, uint32_t *fine, uint32_t *rounded)
{
    for (uint32_t k = 0; k < n; k++) {
        rounded[k] = range[k];
        fine[k] = range[k] < DX_ESTIMATE_TOO_FAR ? range[k] << DX_ESTIMATE_FRACTION : UINT32_MAX;
    }
}

static void take_ranges(struct dx_estimator *e, const struct dx_plane *frame, size_t at, uint32_t n,
                        uint32_t *fine, uint32_t *rounded)
{
    uint32_t range[BLOCK], median[BLOCK];

    dx_plane_get_ranges(frame, at, n, range, BLOCK);
    switch (e->filter) {
    case DX_FILTER_MEAN:
        take_mean(e, range, at, n, fine, rounded);
        break;
    case DX_FILTER_MEDIAN3:
        take_median(e, frame, range, at, n, median);
        tell_ranges(median, BLOCK, fine, rounded);
        break;
    default:
        tell_ranges(range, BLOCK, fine, rounded);
    }
}

void dx_estimator_take(struct dx_estimator *e, const struct dx_plane *frame, uint32_t row,
                       uint32_t col0, uint32_t n, struct dx_estimates *out)
{
    const size_t at = (size_t)row * frame->width + col0;

    for (uint32_t k = 0; k < n; k += BLOCK)
        take_ranges(e, frame, at + k, n - k < BLOCK ? n - k : BLOCK, out->fine + k, out->range + k);
    if (e->newest.attr_bytes)
        take_attributes(e, frame, at, n);
}
