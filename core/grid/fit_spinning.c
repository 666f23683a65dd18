/*
 * Spinning model: every column has an azimuth, every row an elevation and, where it helps, an
 * azimuth offset. Azimuth errors are weighted by cos(elevation), so that dexels near a pole, whose
 * azimuth means little, count little.
 */
#include "core/grid/fit_model.h"

#include "core/base/trig.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* Alternation between rows and columns stops at this change (radians), or after so many rounds. */
#define SETTLED    1e-10
#define MAX_ROUNDS 60

/* Below this a dexel is at the pole: it says nothing about azimuth. */
#define LEAST_WEIGHT 1e-12

/* Row offsets must be worth it: the residual without them, in dexels, and the share that remains.
 */
#define OFFSETS_ABOVE  0.005
#define OFFSETS_REMAIN 0.7

/* Azimuth (radians) and its weight cos^2(elevation) of every dexel; weight 0 without a return. */
struct beams {
    uint32_t height, width;
    double *azimuth;
    float *weight;
    double *cos_sum, *sin_sum; /* of each column */
    double elevation_residual; /* sum of squares */
    uint64_t n;
};

static void beams_fini(struct beams *b)
{
    free(b->azimuth);
    free(b->weight);
    free(b->cos_sum);
}

static int beams_init(struct beams *b, const struct dx_points *points)
{
    size_t n = (size_t)points->height * points->width;

    *b = (struct beams){.height = points->height, .width = points->width};
    b->azimuth = calloc(n, sizeof(*b->azimuth));
    b->weight = calloc(n, sizeof(*b->weight));
    b->cos_sum = calloc(2 * (size_t)points->width, sizeof(*b->cos_sum));
    if (!b->azimuth || !b->weight || !b->cos_sum) {
        beams_fini(b);
        return -ENOMEM;
    }
    b->sin_sum = b->cos_sum + points->width;
    return 0;
}

/* Angles of one row, its mean elevation, and its share of the columns' mean directions. */
static void measure_row(struct dx_fit_model *m, struct beams *b, const double *xyz, uint32_t row)
{
    double sum = 0, square = 0, first = 0;
    uint32_t n = 0;

    for (uint32_t col = 0; col < b->width; col++) {
        size_t k = (size_t)row * b->width + col;
        const double *p = xyz + 3 * k;
        double rho, r2, e;

        if (!dx_fit_valid(p))
            continue;
        rho = sqrt(p[0] * p[0] + p[1] * p[1]);
        r2 = rho * rho + p[2] * p[2];
        e = dx_atan2(p[2], rho);
        first = n == 0 ? e : first;
        n++;
        sum += e - first;
        square += (e - first) * (e - first);
        b->azimuth[k] = dx_atan2(p[1], p[0]);
        b->weight[k] = rho * rho > LEAST_WEIGHT * r2 ? (float)(rho * rho / r2) : 0;
        b->cos_sum[col] += p[0] * rho / r2;
        b->sin_sum[col] += p[1] * rho / r2;
        m->col.weight[col] += (double)b->weight[k];
    }
    m->row.weight[row] = n;
    if (n) {
        m->row.value[row] = first + sum / n;
        square -= sum * sum / n;
        b->elevation_residual += square > 0 ? square : 0;
        b->n += n;
    }
}

static void measure(struct dx_fit_model *m, struct beams *b, const double *xyz)
{
    for (uint32_t row = 0; row < b->height; row++)
        measure_row(m, b, xyz, row);
    for (uint32_t col = 0; col < b->width; col++)
        m->col.value[col] = dx_atan2(b->sin_sum[col], b->cos_sum[col]);
}

static double departure(const struct dx_fit_model *m, const struct beams *b, uint32_t row,
                        uint32_t col)
{
    size_t k = (size_t)row * b->width + col;

    return dx_fit_wrap_angle(b->azimuth[k] - m->col.value[col] - m->offset[row]);
}

/* Mean departure of a row, weighted. */
static double row_departure(const struct dx_fit_model *m, const struct beams *b, uint32_t row)
{
    double sum = 0, weight = 0;

    for (uint32_t col = 0; col < b->width; col++) {
        double w = (double)b->weight[(size_t)row * b->width + col];

        if (w > 0) {
            sum += w * departure(m, b, row, col);
            weight += w;
        }
    }
    return weight > 0 ? sum / weight : 0;
}

/* One round of least squares: the rows' offsets (when asked for) given the columns, then the
 * columns. Returns the largest change. */
static double refine(struct dx_fit_model *m, const struct beams *b, bool offsets)
{
    double *sum = m->col.scratch, largest = 0;

    for (uint32_t col = 0; col < b->width; col++)
        sum[col] = 0;
    for (uint32_t row = 0; row < b->height; row++) {
        if (offsets) {
            double change = row_departure(m, b, row);

            m->offset[row] += change;
            largest = fabs(change) > largest ? fabs(change) : largest;
        }
        for (uint32_t col = 0; col < b->width; col++) {
            double w = (double)b->weight[(size_t)row * b->width + col];

            if (w > 0)
                sum[col] += w * departure(m, b, row, col);
        }
    }
    for (uint32_t col = 0; col < b->width; col++) {
        double change = m->col.weight[col] > 0 ? sum[col] / m->col.weight[col] : 0;

        m->col.value[col] += change;
        largest = fabs(change) > largest ? fabs(change) : largest;
    }
    return largest;
}

/* Sum of squared azimuth residuals, weighted. */
static double azimuth_residual(const struct dx_fit_model *m, const struct beams *b)
{
    double sum = 0;

    for (uint32_t row = 0; row < b->height; row++)
        for (uint32_t col = 0; col < b->width; col++) {
            double w = (double)b->weight[(size_t)row * b->width + col];

            if (w > 0) {
                double d = departure(m, b, row, col);

                sum += w * d * d;
            }
        }
    return sum;
}

/* Settles the azimuths. Returns their rms residual in dexels; INFINITY when there is no step. */
static double settle(struct dx_fit_model *m, const struct beams *b, bool offsets)
{
    double step;

    for (int round = 0; round < MAX_ROUNDS; round++)
        if (refine(m, b, offsets) < SETTLED)
            break;
    if (!dx_fit_axis_complete(&m->col, true))
        return INFINITY;
    step = dx_fit_step(&m->col, &m->row);
    return step > 0 ? sqrt(azimuth_residual(m, b) / (double)b->n) / step : INFINITY;
}

/* Offsets average to zero; what they have in common belongs to the columns. */
static void centre_offsets(struct dx_fit_model *m)
{
    double mean = 0;

    for (uint32_t row = 0; row < m->row.n; row++)
        mean += m->offset[row] / m->row.n;
    for (uint32_t row = 0; row < m->row.n; row++)
        m->offset[row] -= mean;
    for (uint32_t col = 0; col < m->col.n; col++)
        m->col.value[col] += mean;
}

/* Rows without a return take the offset of the known rows beside them. */
static void complete_offsets(struct dx_fit_model *m)
{
    struct dx_fit_axis axis = m->row;

    axis.value = m->offset;
    dx_fit_axis_complete(&axis, false);
}

/* Azimuths with row offsets where they help; returns the rms residual in dexels. */
static double fit_azimuths(struct dx_fit_model *m, const struct beams *b)
{
    double without = settle(m, b, false), with;

    if (!(without > OFFSETS_ABOVE) || without == INFINITY)
        return without;
    memcpy(m->saved, m->col.value, m->col.n * sizeof(*m->saved));
    with = settle(m, b, true);
    if (with < OFFSETS_REMAIN * without) {
        complete_offsets(m);
        centre_offsets(m);
        return with;
    }
    memcpy(m->col.value, m->saved, m->col.n * sizeof(*m->saved));
    memset(m->offset, 0, m->row.n * sizeof(*m->offset));
    dx_fit_axis_complete(&m->col, true);
    return without;
}

int dx_fit_spinning(struct dx_fit_model *m, const struct dx_points *points)
{
    struct beams b;
    double azimuth, elevation, step;
    int rc = beams_init(&b, points);

    if (rc)
        return rc;
    m->rms = INFINITY;
    measure(m, &b, points->xyz);
    if (dx_fit_axis_complete(&m->row, false)) {
        azimuth = fit_azimuths(m, &b);
        step = dx_fit_step(&m->row, &m->col);
        elevation = sqrt(b.elevation_residual / (double)b.n) / step;
        if (azimuth < INFINITY && step > 0)
            m->rms = sqrt(azimuth * azimuth + elevation * elevation);
    }
    beams_fini(&b);
    return 0;
}
