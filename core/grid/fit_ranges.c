/* Points as ranges of a geometry, and whether points still lie in one. */
#include "core/grid/fit_model.h"

#include "core/base/trig.h"

/* Distance from the beam's origin (pinhole: along the axis), metres. */
static double range_of(const struct dx_geometry *g, uint32_t row, uint32_t col, const double p[3])
{
    double x = p[0], y = p[1], z = p[2];

    if (g->model == DX_MODEL_PINHOLE)
        return z;
    if (g->model == DX_MODEL_SPINNING) {
        const float *cs = g->table + 2 * (size_t)col;
        const float *o = g->table + 2 * (size_t)g->width + 6 * (size_t)row + 3;

        x -= (double)o[0] * (double)cs[0] - (double)o[1] * (double)cs[1];
        y -= (double)o[0] * (double)cs[1] + (double)o[1] * (double)cs[0];
        z -= (double)o[2];
    }
    return sqrt(x * x + y * y + z * z);
}

static bool missing(const double p[3])
{
    return isnan(p[0]) || isnan(p[1]) || isnan(p[2]);
}

uint32_t dx_fit_ranges(struct dx_plane *plane, const struct dx_geometry *g,
                       const struct dx_points *points)
{
    uint32_t dropped = 0;
    size_t k = 0;

    for (uint32_t row = 0; row < g->height; row++)
        for (uint32_t col = 0; col < g->width; col++, k++) {
            const double *p = points->xyz + 3 * k;
            uint32_t range = dx_fit_valid(p) ? dx_geometry_units(g, range_of(g, row, col, p)) : 0;

            dropped += range == 0 && !missing(p);
            dx_plane_set_range(plane, k, range);
            dx_plane_set_attr(plane, k, range && points->attr ? points->attr[k] : 0);
            for (size_t m = 3 * k; plane->xyz && m < 3 * k + 3; m++)
                plane->xyz[m] = range ? (float)points->xyz[m] : 0;
        }
    return dropped;
}

/* Squared chord between a point's direction and its dexel's, relative to the dexel's larger step.
 */
static double departure2(const struct dx_geometry *g, uint32_t row, uint32_t col, const double p[3])
{
    double r = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]), dir[3], chord2 = 0, step, other;

    dx_geometry_direction(g, row, col, dir);
    for (int k = 0; k < 3; k++)
        chord2 += (p[k] / r - dir[k]) * (p[k] / r - dir[k]);
    /* within f32 rounding of the tables: no need for the steps */
    if (chord2 < 1e-12)
        return 0;
    step = dx_geometry_angle(g, row, col, row ? row - 1 : (g->height > 1), col);
    other = dx_geometry_angle(g, row, col, row, col ? col - 1 : (g->width > 1));
    step = other > step ? other : step;
    return step > 0 ? chord2 / (step * step) : INFINITY;
}

bool dx_fit_holds(const struct dx_geometry *g, const struct dx_points *points, double dexels)
{
    size_t k = 0;

    if (g->height != points->height || g->width != points->width)
        return false;
    for (uint32_t row = 0; row < g->height; row++)
        for (uint32_t col = 0; col < g->width; col++, k++) {
            const double *p = points->xyz + 3 * k;

            if (dx_fit_valid(p) && (dx_geometry_units(g, range_of(g, row, col, p)) == 0 ||
                                    departure2(g, row, col, p) > dexels * dexels))
                return false;
        }
    return true;
}
