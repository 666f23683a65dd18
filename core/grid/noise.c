/*
 * The noise model from one frame. Second differences of inverse range vanish on planes, so what
 * they show along rows is noise: sigma_r = r^2 sigma_q, and a second difference of white noise has
 * sqrt(6) sigma_q. Medians over octaves of range ignore edges and curved parts; s0 and s2 are
 * fitted to the octaves.
 */
#include "core/grid/terrain.h"

#include "core/base/bytes.h"

#include <math.h>
#include <string.h>

#define OCTAVES         32
#define BINS_PER_OCTAVE 32
#define BINS            (64 * BINS_PER_OCTAVE)
#define MIN_SAMPLES     256
#define MAD_TO_SIGMA    (1.4826 / 2.449489742783178) /* of a second difference, to one sample */

/* Samples of |second difference| * r^2 in units, by octave of r: histograms with logarithmic bins.
 */
struct histogram {
    uint32_t n;
    double sum_r;
    uint32_t bin[BINS];
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

static void add_triple(struct histogram *h, double r0, double r1, double r2, double factor)
{
    double d = fabs(1 / r0 - factor / r1 + 1 / r2) * r1 * r1;
    int octave = 0;

    for (double r = r1; r >= 2 && octave < OCTAVES - 1; r /= 2)
        octave++;
    h[octave].n++;
    h[octave].sum_r += r1;
    h[octave].bin[bin_of(d)]++;
}

static double median(const struct histogram *h)
{
    uint32_t seen = 0;

    for (uint32_t k = 0; k < BINS; k++) {
        seen += h->bin[k];
        if (2 * (uint64_t)seen >= h->n)
            return bin_value(k);
    }
    return 0;
}

/* Least squares of s0 + s2 r^2 over the octaves, weighted by samples; neither may be negative.
 * False: no octave has samples enough. */
static bool fit(double *s0, double *s2, const struct histogram *h)
{
    double w = 0, wx = 0, wxx = 0, wy = 0, wxy = 0, det;

    for (int k = 0; k < OCTAVES; k++) {
        double r, x, y, n = h[k].n;

        if (h[k].n < MIN_SAMPLES)
            continue;
        r = h[k].sum_r / n;
        x = r * r;
        y = median(&h[k]) * MAD_TO_SIGMA;
        n /= y * y + 0.25; /* relative errors, above half a unit */
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

/* 2 cos(psi) between neighbours of a row; exactly 2 for depths, which are affine (ALGORITHMS 1.3,
 * D2). */
static double two_cos(const struct dx_geometry *g, uint32_t i, uint32_t j)
{
    double a[3], b[3];

    if (g->model == DX_MODEL_PINHOLE)
        return 2;
    dx_geometry_direction(g, i, j, a);
    dx_geometry_direction(g, i, j + 1, b);
    return 2 * (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
}

static void add_row(struct histogram *h, const struct dx_plane *frame, const struct dx_geometry *g,
                    uint32_t i)
{
    size_t k = (size_t)i * frame->width;

    for (uint32_t j = 0; j + 2 < frame->width; j++, k++) {
        uint32_t r0 = dx_plane_range(frame, k), r1 = dx_plane_range(frame, k + 1);
        uint32_t r2 = dx_plane_range(frame, k + 2);

        if (r0 && r1 && r2)
            add_triple(h, r0, r1, r2, two_cos(g, i, j));
    }
}

bool dx_noise_estimate(double sigma[3], const struct dx_plane *frame, const struct dx_geometry *g)
{
    static const size_t enough =
        1u << 20; /* triples for a median; larger frames are thinned by rows */
    struct histogram h[OCTAVES];
    uint32_t step = 1 + (uint32_t)(dx_plane_n_dexels(frame) / enough);
    double u = (double)g->unit_m, s0, s2;
    bool known;

    memset(h, 0, sizeof(h));
    for (uint32_t i = 0; i < frame->height; i += step)
        add_row(h, frame, g, i);
    known = fit(&s0, &s2, h);
    sigma[0] = (s0 > 0.5 ? s0 : 0.5) * u;
    sigma[1] = 0;
    sigma[2] = s2 / u;
    return known;
}
