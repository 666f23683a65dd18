/*
 * The policies that keep a sample compare one 64-bit key: the measure above, the sample's number
 * below, so that no two are equal and the least one is the same in any order. The mean adds
 * integers.
 */
#include "core/grid/represent.h"

#include "core/grid/fit.h"
#include "core/grid/lookup.h"
#include "core/grid/median.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#define NO_KEY UINT64_MAX
/* Angles in keys, by radian: chords are at most 2, so that they fit 32 bits. */
#define ANGLE_UNITS 0x1p30

struct kept {
    uint64_t key; /* NO_KEY: no sample yet */
    uint32_t range;
    uint16_t attr;
};

struct sum {
    uint64_t range, attr; /* 2^32 samples of 32 bits fit */
    uint32_t n;
};

struct dx_represent {
    struct dx_geometry *geometry;
    struct dx_lookup lookup;
    enum dx_keep keep;
    uint32_t max_samples;
    size_t n_dexels;
    struct kept *kept; /* [n_dexels]: centre, nearest, first */
    struct sum *sum;   /* [n_dexels]: mean */
    struct dx_medians medians;
    struct dx_represent_counts counts;
};

const char *dx_keep_name(unsigned keep)
{
    static const char *const names[DX_N_KEEP] = {
        [DX_KEEP_CENTRE] = "centre", [DX_KEEP_NEAREST] = "nearest", [DX_KEEP_MEDIAN] = "median",
        [DX_KEEP_MEAN] = "mean",     [DX_KEEP_FIRST] = "first",
    };

    return keep < DX_N_KEEP ? names[keep] : NULL;
}

static int make_room(struct dx_represent *r)
{
    size_t n = r->n_dexels;

    if (r->keep == DX_KEEP_MEDIAN)
        return dx_medians_init(&r->medians, (uint32_t)n, r->max_samples);
    if (r->keep == DX_KEEP_MEAN)
        r->sum = calloc(n, sizeof(*r->sum));
    else
        r->kept = calloc(n, sizeof(*r->kept));
    return r->sum || r->kept ? 0 : -ENOMEM;
}

int dx_represent_new(struct dx_represent **out, struct dx_geometry *g, enum dx_keep keep,
                     uint32_t max_samples)
{
    struct dx_represent *r;
    int rc;

    if ((unsigned)keep >= DX_N_KEEP)
        return -EINVAL;
    r = calloc(1, sizeof(*r));
    if (!r)
        return -ENOMEM;
    r->geometry = dx_geometry_ref(g);
    r->keep = keep;
    r->max_samples = max_samples;
    r->n_dexels = (size_t)g->height * g->width;
    rc = dx_lookup_init(&r->lookup, g);
    if (rc == 0)
        rc = make_room(r);
    if (rc) {
        dx_represent_free(r);
        return rc;
    }
    dx_represent_reset(r);
    *out = r;
    return 0;
}

void dx_represent_free(struct dx_represent *r)
{
    if (!r)
        return;
    dx_medians_fini(&r->medians);
    free(r->kept);
    free(r->sum);
    dx_lookup_fini(&r->lookup);
    dx_geometry_unref(r->geometry);
    free(r);
}

void dx_represent_reset(struct dx_represent *r)
{
    r->counts = (struct dx_represent_counts){0};
    if (r->keep == DX_KEEP_MEDIAN)
        dx_medians_reset(&r->medians);
    else if (r->keep == DX_KEEP_MEAN)
        memset(r->sum, 0, r->n_dexels * sizeof(*r->sum));
    else
        for (size_t k = 0; k < r->n_dexels; k++)
            r->kept[k] = (struct kept){.key = NO_KEY};
}

/* ---- samples -------------------------------------------------------------------------------- */

/* A sample and the dexel it falls into. */
struct sample {
    uint32_t dexel, number;
    uint32_t range;
    uint16_t attr;
    uint32_t off_axis;
};

/* Between a point's direction and the dexel's axis: the chord, which the angle grows with. */
static uint32_t off_axis(const struct dx_geometry *g, uint32_t row, uint32_t col, const double p[3],
                         double distance)
{
    double axis[3], chord2 = 0;

    dx_geometry_direction(g, row, col, axis);
    for (int k = 0; k < 3; k++) {
        double d = p[k] / distance - axis[k];

        chord2 += d * d;
    }
    return (uint32_t)(sqrt(chord2) * ANGLE_UNITS);
}

/* Where a point falls; false: nowhere, and counted as such. */
static bool place(struct dx_represent *r, struct sample *s, const double p[3])
{
    const struct dx_geometry *g = r->geometry;
    uint32_t row, col;
    double distance;

    if (!dx_fit_valid(p)) {
        r->counts.missing++;
        return false;
    }
    distance = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
    if (!dx_lookup_find(&r->lookup, p, distance, &row, &col)) {
        r->counts.outside++;
        return false;
    }
    s->range = dx_geometry_units(g, g->model == DX_MODEL_PINHOLE ? p[2] : distance);
    if (s->range == 0) {
        r->counts.unfit++;
        return false;
    }
    s->dexel = row * g->width + col;
    s->off_axis = r->keep == DX_KEEP_CENTRE ? off_axis(g, row, col, p, distance) : 0;
    r->counts.taken++;
    return true;
}

static void keep_least(struct kept *k, const struct sample *s, uint32_t measure)
{
    uint64_t key = (uint64_t)measure << 32 | s->number;

    if (key < k->key)
        *k = (struct kept){key, s->range, s->attr};
}

static void take(struct dx_represent *r, const struct sample *s)
{
    struct sum *sum;

    switch (r->keep) {
    case DX_KEEP_NEAREST:
        keep_least(&r->kept[s->dexel], s, s->range);
        break;
    case DX_KEEP_MEDIAN:
        dx_medians_add(&r->medians, s->dexel, (uint64_t)s->range << 32 | s->number, s->attr);
        break;
    case DX_KEEP_MEAN:
        sum = &r->sum[s->dexel];
        sum->range += s->range;
        sum->attr += s->attr;
        sum->n++;
        break;
    default: /* off_axis is 0 for the first */
        keep_least(&r->kept[s->dexel], s, s->off_axis);
    }
}

int dx_represent_add(struct dx_represent *r, const struct dx_samples *s)
{
    if (s->number > r->max_samples || s->n > r->max_samples - s->number ||
        r->counts.taken + s->n > r->max_samples)
        return -ERANGE;
    for (size_t k = 0; k < s->n; k++) {
        struct sample sample = {.number = s->number + (uint32_t)k};
        double p[3];

        for (size_t i = 0; i < 3; i++)
            p[i] = s->xyz ? s->xyz[3 * k + i] : (double)s->xyz32[3 * k + i];
        sample.attr = s->attr ? s->attr[k] : 0;
        if (place(r, &sample, p))
            take(r, &sample);
    }
    return 0;
}

/* ---- the result ----------------------------------------------------------------------------- */

static void set_dexel(struct dx_plane *plane, uint32_t *kept, size_t dexel, uint32_t range,
                      uint32_t attr, uint32_t number)
{
    dx_plane_set_range(plane, dexel, range);
    dx_plane_set_attr(plane, dexel, attr);
    if (kept)
        kept[dexel] = number;
}

static uint32_t mean(uint64_t sum, uint32_t n)
{
    return n ? (uint32_t)((sum + n / 2) / n) : 0;
}

void dx_represent_finish(struct dx_represent *r, struct dx_plane *plane, uint32_t *kept)
{
    if (r->keep == DX_KEEP_MEDIAN)
        dx_medians_sort(&r->medians);
    for (uint32_t k = 0; k < r->n_dexels; k++) {
        const struct dx_median_value *v;

        if (r->keep == DX_KEEP_MEDIAN) {
            v = dx_medians_of(&r->medians, k);
            set_dexel(plane, kept, k, v ? (uint32_t)(v->key >> 32) : 0, v ? v->attr : 0,
                      v ? (uint32_t)v->key : UINT32_MAX);
        } else if (r->keep == DX_KEEP_MEAN) {
            const struct sum *s = &r->sum[k];

            set_dexel(plane, kept, k, mean(s->range, s->n), mean(s->attr, s->n), UINT32_MAX);
        } else {
            const struct kept *s = &r->kept[k];

            set_dexel(plane, kept, k, s->range, s->attr, (uint32_t)s->key);
        }
    }
}

const struct dx_represent_counts *dx_represent_counts(const struct dx_represent *r)
{
    return &r->counts;
}
