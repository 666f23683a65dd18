/*
 * The noise model from one frame. Along a row the azimuth goes on at a constant elevation, so the
 * inverse range of any plane is a cosine of the azimuth plus a constant; at even steps t
 *
 *     q3 - f q2 + f q1 - q0,   f = 1 + 2 cos t
 *
 * is 0 for all of them, floors and walls alike. (Three samples are not enough: what vanishes on
 * walls is t^2 r on a floor, millimetres at some distance.) What is left is noise, sigma_r = r^2
 * sigma_q, times sqrt(2 + 2 f^2). Medians over octaves of range ignore curved parts, and edges once
 * what lies far off the median is left out; s0 and s2 are fitted to the octaves.
 *
 * A camera that tells depth in few levels (disparities) has runs of equal samples, and medians of
 * 0. Where many neighbours are equal, its noise is at least a level's, and told by the tail.
 */
#include "core/grid/terrain.h"

#include "core/base/bytes.h"

#include <math.h>
#include <string.h>

#define OCTAVES         32
#define BINS_PER_OCTAVE 32
#define BINS            (64 * BINS_PER_OCTAVE)
#define MIN_SAMPLES     256
#define MAD_TO_SIGMA    1.4826
#define OUTLIER_SIGMAS  5      /* farther off is an edge, not noise */
#define FLOOR           0.5    /* ranges are rounded: no less noise than this, units */
#define MANY_EQUAL      0.3    /* share of equal neighbours from which on depths come in levels */
#define SOME_STEPS      0.01   /* share of neighbours that are levels apart, to tell from */
#define LARGEST_LEVEL   0.0625 /* of a range: farther apart is an edge */
#define LEVEL_OUTLIER   2.3    /* levels: farther off is an edge */
#define NINE_TENTHS     1.6448536269514722 /* of normal noise are within so many sigmas */
#define LEVELS_APART    0.5303300858899106 /* 3 / (4 sqrt(2)): the gate at 4 sigma is three levels */

/* Samples of the noise's size in units, by octave of r: histograms with logarithmic bins. */
struct histogram {
    uint32_t n;
    uint32_t n_equal, n_flat; /* of which the two in the middle are the same, all four are */
    uint32_t n_step;          /* in step[] */
    double sum_r;
    uint32_t bin[BINS];
    /* Of the two in the middle where they differ: their distance, at the octave's first range if it
     * is one of disparities. */
    uint32_t step[BINS];
};

/* Bin of v > 0: float bits are a logarithm; 2^-32 is bin 0. */
static uint32_t bin_of(double v)
{
    uint32_t bits = dx_f32_bits((float)v), zero = dx_f32_bits(0x1p-32f);
    uint32_t k = bits <= zero ? 0 : (bits - zero) >> 18;

    return k < BINS ? k : BINS - 1;
}

static double bin_value(uint32_t k)
{
    return (double)dx_f32_from_bits(dx_f32_bits(0x1p-32f) + (k << 18) + (1u << 17));
}

/* Four samples of a row in turn. */
static void add_four(struct histogram *h, const double r[4], double f)
{
    double d = fabs(1 / r[3] - 1 / r[0] - f * (1 / r[2] - 1 / r[1]));
    double first = 1;
    int octave = 0;

    d *= r[1] * r[2] / sqrt(2 + 2 * f * f);
    for (; r[1] >= 2 * first && octave < OCTAVES - 1; first *= 2)
        octave++;
    h[octave].n++;
    h[octave].sum_r += r[1];
    h[octave].bin[bin_of(d)]++;
    h[octave].n_flat += r[0] == r[1] && r[1] == r[2] && r[2] == r[3];
    if (r[1] == r[2]) {
        h[octave].n_equal++;
    } else if (fabs(r[1] - r[2]) < LARGEST_LEVEL * r[1]) {
        h[octave].n_step++;
        h[octave].step[bin_of(first * first * fabs(1 / r[1] - 1 / r[2]))]++;
    }
}

/* What `share` of the samples in bins 0 to `last`, less the `n_left_out` lowest, are not above. */
static double quantile(const uint32_t bin[BINS], uint32_t n_left_out, uint32_t last, double share)
{
    double n = -(double)n_left_out, seen = n;
    uint32_t k = 0;

    for (uint32_t m = 0; m <= last; m++)
        n += bin[m];
    for (; k < last; k++) {
        seen += bin[k];
        if (seen >= share * n)
            break;
    }
    return bin_value(k);
}

/* Sigma of an octave's samples. Edges push the median up by their share: those that stand clear of
 * the noise are left out, until there are no more of them. */
static double spread(const struct histogram *h)
{
    double sigma = MAD_TO_SIGMA * quantile(h->bin, 0, BINS - 1, 0.5);

    for (int round = 0; round < 8; round++) {
        double least = sigma > FLOOR ? sigma : FLOOR;
        double next = MAD_TO_SIGMA * quantile(h->bin, 0, bin_of(OUTLIER_SIGMAS * least), 0.5);

        if (next >= sigma)
            break;
        sigma = next;
    }
    return sigma;
}

/*
 * Sigma of depths that come in levels; 0 where they do not. Inside a level all samples agree, so
 * the noise shows only where levels change. Its own tail is heavier than a normal one's there:
 * neighbours on one surface are up to three levels apart, one by rounding and one for each of the
 * two, because which level is told is noisy too, in blots. So the gate lets three levels pass. A
 * level is the upper quartile of the steps: images registered to another camera blur levels into
 * steps of a few units. Slopes make larger steps, but leave no tail.
 */
static double level_noise(const struct histogram *h, int octave)
{
    double scale = h->sum_r / h->n / (double)(1u << octave), step, level, tail;

    if (!(h->n_equal > MANY_EQUAL * h->n) || !(h->n_step > SOME_STEPS * h->n))
        return 0;
    step = quantile(h->step, 0, BINS - 1, 0.75) * scale * scale;
    tail = quantile(h->bin, h->n_flat, bin_of(LEVEL_OUTLIER * step), 0.9) / NINE_TENTHS;
    level = LEVELS_APART * step;
    return level < tail ? tail : level < 2 * tail ? level : 2 * tail;
}

/* Least squares of s0 + s2 r^2 over the octaves, weighted by samples; neither may be negative.
 * False: no octave has samples enough. */
static bool fit(double *s0, double *s2, const struct histogram *h)
{
    double w = 0, wx = 0, wxx = 0, wy = 0, wxy = 0, det;

    for (int k = 0; k < OCTAVES; k++) {
        double r, x, y, level, n = h[k].n;

        if (h[k].n < MIN_SAMPLES)
            continue;
        r = h[k].sum_r / n;
        x = r * r;
        y = spread(&h[k]);
        level = level_noise(&h[k], k);
        y = y > level ? y : level;
        n /= y * y + FLOOR * FLOOR; /* relative errors, above the floor */
        w += n, wx += n * x, wxx += n * x * x, wy += n * y, wxy += n * x * y;
    }
    *s0 = *s2 = 0;
    det = w * wxx - wx * wx;
    if (det > 1e-12 * w * wxx) {
        *s0 = (wy * wxx - wxy * wx) / det;
        *s2 = (w * wxy - wx * wy) / det;
    }
    if (*s2 <= 0 || det <= 1e-12 * w * wxx) {
        *s2 = 0;
        *s0 = w > 0 ? wy / w : 0;
    } else if (*s0 < 0) {
        *s0 = 0;
        *s2 = wxy / wxx;
    }
    return w > 0;
}

/* f of the four columns from j on. Depths are affine in the column: t = 0 there. A table of
 * directions has the angle between two neighbours for t; what that is off is of third order in the
 * step. */
static double factor(const struct dx_geometry *g, uint32_t i, uint32_t j)
{
    const float *cs = g->table + 2 * (size_t)(j + 1);
    double a[3], b[3];

    if (g->model == DX_MODEL_PINHOLE)
        return 3;
    if (g->model == DX_MODEL_SPINNING)
        return 1 + 2 * ((double)cs[0] * (double)cs[2] + (double)cs[1] * (double)cs[3]);
    dx_geometry_direction(g, i, j + 1, a);
    dx_geometry_direction(g, i, j + 2, b);
    return 1 + 2 * (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
}

static void add_row(struct histogram *h, const struct dx_plane *frame, const struct dx_geometry *g,
                    uint32_t i)
{
    size_t k = (size_t)i * frame->width;

    for (uint32_t j = 0; j + 3 < frame->width; j++, k++) {
        double r[4];
        bool all = true;

        for (size_t m = 0; m < 4; m++) {
            r[m] = dx_plane_range(frame, k + m);
            all &= r[m] > 0;
        }
        if (all)
            add_four(h, r, factor(g, i, j));
    }
}

bool dx_noise_estimate(double sigma[3], const struct dx_plane *frame, const struct dx_geometry *g)
{
    static const size_t enough =
        1u << 20; /* samples for a median; larger frames are thinned by rows */
    struct histogram h[OCTAVES];
    uint32_t step = 1 + (uint32_t)(dx_plane_n_dexels(frame) / enough);
    double u = (double)g->unit_m, s0, s2;
    bool known;

    memset(h, 0, sizeof(h));
    for (uint32_t i = 0; i < frame->height; i += step)
        add_row(h, frame, g, i);
    known = fit(&s0, &s2, h);
    sigma[0] = (s0 > FLOOR ? s0 : FLOOR) * u;
    sigma[1] = 0;
    sigma[2] = s2 / u;
    return known;
}
