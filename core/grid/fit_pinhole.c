/*
 * Pinhole model: every column has a tangent x / z, every row a tangent y / z. They need not be
 * evenly spaced (a separable lens). Works for mirrored images: a step may be negative.
 */
#include "core/grid/fit_model.h"

/* Sums the tangents of all returns into the axes. False when one lies behind the camera. */
static bool sum_tangents(struct dx_fit_model *m, const struct dx_points *points)
{
    for (uint32_t row = 0; row < points->height; row++)
        for (uint32_t col = 0; col < points->width; col++) {
            const double *p = points->xyz + 3 * ((size_t)row * points->width + col);

            if (!dx_fit_valid(p))
                continue;
            if (!(p[2] > 1e-9))
                return false;
            m->col.value[col] += p[0] / p[2];
            m->col.weight[col]++;
            m->row.value[row] += p[1] / p[2];
            m->row.weight[row]++;
        }
    return true;
}

static void divide(struct dx_fit_axis *axis)
{
    for (uint32_t k = 0; k < axis->n; k++)
        if (axis->weight[k] > 0)
            axis->value[k] /= axis->weight[k];
}

static double residual(const struct dx_fit_model *m, const struct dx_points *points, double step_x,
                       double step_y)
{
    double sum = 0, n = 0;

    for (uint32_t row = 0; row < points->height; row++)
        for (uint32_t col = 0; col < points->width; col++) {
            const double *p = points->xyz + 3 * ((size_t)row * points->width + col);
            double dx, dy;

            if (!dx_fit_valid(p))
                continue;
            dx = (p[0] / p[2] - m->col.value[col]) / step_x;
            dy = (p[1] / p[2] - m->row.value[row]) / step_y;
            sum += dx * dx + dy * dy;
            n++;
        }
    return sqrt(sum / n);
}

void dx_fit_pinhole(struct dx_fit_model *m, const struct dx_points *points)
{
    double step_x, step_y;

    m->rms = INFINITY;
    if (!sum_tangents(m, points))
        return;
    divide(&m->col);
    divide(&m->row);
    if (!dx_fit_axis_complete(&m->col, false) || !dx_fit_axis_complete(&m->row, false))
        return;
    step_x = dx_fit_step(&m->col, &m->row);
    step_y = dx_fit_step(&m->row, &m->col);
    if (step_x > 0 && step_y > 0)
        m->rms = residual(m, points, step_x, step_y);
}
