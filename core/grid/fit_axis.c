/*
 * One side of a separable model: unwrapping of azimuths, lines without a return, mean step and
 * evenness.
 */
#include "core/grid/fit_model.h"

#include "core/base/trig.h"

#include <math.h>
#include <stdlib.h>

/* Known lines that a slope at the ends of an axis is taken over. */
#define SLOPE_LINES 16u

double dx_fit_wrap_angle(double a)
{
    return a - 2 * DX_PI * rint(a / (2 * DX_PI));
}

static uint32_t next_known(const struct dx_fit_axis *axis, uint32_t k)
{
    while (k < axis->n && axis->weight[k] <= 0)
        k++;
    return k;
}

static int compare_doubles(const void *pa, const void *pb)
{
    double a = *(const double *)pa, b = *(const double *)pb;

    return (a > b) - (a < b);
}

/* Median of the steps between known neighbours; over gaps when there are no neighbours. */
static double median_step(const struct dx_fit_axis *axis)
{
    double *room = axis->scratch;
    uint32_t n = 0;

    for (uint32_t k = 0; k + 1 < axis->n; k++)
        if (axis->weight[k] > 0 && axis->weight[k + 1] > 0)
            room[n++] = dx_fit_wrap_angle(axis->value[k + 1] - axis->value[k]);
    for (uint32_t k = next_known(axis, 0), l; n == 0 && k < axis->n; k = l) {
        l = next_known(axis, k + 1);
        if (l < axis->n)
            room[n++] = dx_fit_wrap_angle(axis->value[l] - axis->value[k]) / (l - k);
    }
    qsort(room, n, sizeof(*room), compare_doubles);
    return n ? room[n / 2] : 0;
}

/* Makes the azimuths of known columns continuous: each is put near where the median step expects
 * it. */
static void unwrap(struct dx_fit_axis *axis)
{
    double step = median_step(axis);

    for (uint32_t k = next_known(axis, 0), l; k < axis->n; k = l) {
        l = next_known(axis, k + 1);
        if (l < axis->n) {
            double expected = axis->value[k] + step * (l - k);
            double turns = rint((axis->value[l] - expected) / (2 * DX_PI));

            axis->value[l] -= turns * (2 * DX_PI);
        }
    }
}

/* Slope at one end: between the end's known line `k` and one up to SLOPE_LINES known lines inside.
 */
static double end_slope(const struct dx_fit_axis *axis, uint32_t k, int inwards)
{
    uint32_t far = k, seen = 0;

    for (uint32_t l = k; l < axis->n && seen <= SLOPE_LINES; l += (uint32_t)inwards)
        if (axis->weight[l] > 0) {
            far = l;
            seen++;
        }
    return far == k ? 0 : (axis->value[far] - axis->value[k]) / ((double)far - (double)k);
}

static void fill(struct dx_fit_axis *axis, uint32_t first, uint32_t last)
{
    double head = end_slope(axis, first, 1), tail = end_slope(axis, last, -1);

    for (uint32_t k = 0; k < first; k++)
        axis->value[k] = axis->value[first] - head * (first - k);
    for (uint32_t k = last + 1; k < axis->n; k++)
        axis->value[k] = axis->value[last] + tail * (k - last);
    for (uint32_t k = first, l; k < last; k = l) {
        l = next_known(axis, k + 1);
        for (uint32_t m = k + 1; m < l; m++)
            axis->value[m] = axis->value[k] + (axis->value[l] - axis->value[k]) * (m - k) / (l - k);
    }
}

bool dx_fit_axis_complete(struct dx_fit_axis *axis, bool azimuth)
{
    uint32_t first = next_known(axis, 0), last = axis->n - 1;

    if (first == axis->n)
        return false;
    while (axis->weight[last] <= 0)
        last--;
    if (axis->n > 1 && first == last)
        return false;
    if (azimuth)
        unwrap(axis);
    fill(axis, first, last);
    if (axis->n > 1)
        axis->step = (axis->value[axis->n - 1] - axis->value[0]) / (axis->n - 1);
    return true;
}

double dx_fit_axis_irregularity(const struct dx_fit_axis *axis)
{
    double mean = 0, slope = 0, sxx = 0, sum = 0;

    if (axis->n < 2 || !(fabs(axis->step) > 1e-12))
        return 0;
    for (uint32_t k = 0; k < axis->n; k++)
        mean += axis->value[k] / axis->n;
    for (uint32_t k = 0; k < axis->n; k++) {
        double x = k - (axis->n - 1) / 2.0;

        slope += x * (axis->value[k] - mean);
        sxx += x * x;
    }
    slope /= sxx;
    for (uint32_t k = 0; k < axis->n; k++) {
        double d = axis->value[k] - mean - slope * (k - (axis->n - 1) / 2.0);

        sum += d * d / (axis->step * axis->step);
    }
    return sum;
}

double dx_fit_step(const struct dx_fit_axis *axis, const struct dx_fit_axis *other)
{
    return fabs(axis->n > 1 ? axis->step : other->step);
}
