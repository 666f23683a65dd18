/* Field of view of a geometry, and an even array over it. */
#include "core/grid/cover.h"

#include "core/base/trig.h"
#include "core/grid/plane.h"

#include <errno.h>
#include <math.h>
#include <string.h>

#define MIN_WRAP_WIDTH 8
/* Nearer to the poles (sine of the angle) a direction does not tell its azimuth. */
#define NO_AZIMUTH 1e-4

/* Radians. Azimuths are followed from dexel to dexel, so that they may pass 180 degrees. */
struct field {
    double azimuth[2], elevation[2]; /* from, to */
    double first_azimuth;            /* of column 0, middle row */
    bool clockwise, downward;
};

static double nearest_turn(double angle, double to)
{
    return angle - 2 * DX_PI * rint((angle - to) / (2 * DX_PI));
}

/* Azimuth (the one before where it has none) and elevation of a dexel. */
static void angles(const struct dx_geometry *g, uint32_t row, uint32_t col, double *azimuth,
                   double *elevation)
{
    double d[3], across;

    dx_geometry_direction(g, row, col, d);
    across = sqrt(d[0] * d[0] + d[1] * d[1]);
    *elevation = dx_atan2(d[2], across);
    if (across > NO_AZIMUTH)
        *azimuth = nearest_turn(dx_atan2(d[1], d[0]), *azimuth);
}

static void widen(double range[2], double v)
{
    range[0] = v < range[0] ? v : range[0];
    range[1] = v > range[1] ? v : range[1];
}

static struct field field_of(const struct dx_geometry *g)
{
    struct field f = {.azimuth = {INFINITY, -INFINITY}, .elevation = {INFINITY, -INFINITY}};
    double start = 0, first_elevation = 0, elevation = 0;

    for (uint32_t row = 0; row < g->height; row++) {
        double azimuth = start;

        for (uint32_t col = 0; col < g->width; col++) {
            angles(g, row, col, &azimuth, &elevation);
            start = col == 0 ? azimuth : start;
            first_elevation = row == 0 && col == 0 ? elevation : first_elevation;
            widen(f.azimuth, azimuth);
            widen(f.elevation, elevation);
        }
        if (row == g->height / 2) {
            f.first_azimuth = start;
            f.clockwise = azimuth < start;
        }
    }
    f.downward = elevation < first_elevation;
    return f;
}

static int cover_spinning(struct dx_geometry **out, const struct dx_geometry *g, uint32_t height,
                          uint32_t width, struct dx_err *err)
{
    struct field f = field_of(g);
    double across = f.azimuth[1] - f.azimuth[0], up = f.elevation[1] - f.elevation[0];
    double azimuth0 = f.azimuth[f.clockwise], step = across / (width - 1);
    bool turn = g->wrap || step * width > 2 * DX_PI;
    int rc;

    if (!(across > 0 && up > 0))
        return dx_err_set(err, -EINVAL, "field of view of %g x %g degrees, expected more than 0",
                          dx_deg(across), dx_deg(up));
    if (turn) {
        azimuth0 = f.first_azimuth;
        step = 2 * DX_PI / width;
    }
    rc = dx_geometry_new_spinning(out, height, width, azimuth0, f.clockwise ? -step : step,
                                  f.elevation[f.downward], (f.downward ? -up : up) / (height - 1));
    if (rc == 0)
        (*out)->wrap = g->wrap && width >= MIN_WRAP_WIDTH;
    return rc;
}

static int cover_pinhole(struct dx_geometry **out, const struct dx_geometry *g, uint32_t height,
                         uint32_t width, struct dx_err *err)
{
    const float *x = g->table, *y = g->table + g->width;
    double x_step = ((double)x[g->width - 1] - (double)x[0]) / (width - 1);
    double y_step = ((double)y[g->height - 1] - (double)y[0]) / (height - 1);

    if (x_step == 0 || y_step == 0)
        return dx_err_set(err, -EINVAL, "field of view without width or height, expected both");
    return dx_geometry_new_pinhole(out, height, width, 1 / x_step, 1 / y_step,
                                   -(double)x[0] / x_step, -(double)y[0] / y_step);
}

int dx_cover_geometry(struct dx_geometry **out, const struct dx_geometry *g, uint32_t height,
                      uint32_t width, struct dx_err *err)
{
    int rc;

    if (height < 2 || width < 2 || dx_geometry_table_len(DX_MODEL_SPINNING, height, width) == 0)
        return dx_err_set(err, -EINVAL,
                          "array of %ux%u dexels, expected sides of 2 to %u and at most %u", width,
                          height, DX_PLANE_MAX_SIDE, DX_PLANE_MAX_DEXELS);
    if (g->model == DX_MODEL_PINHOLE)
        rc = cover_pinhole(out, g, height, width, err);
    else
        rc = cover_spinning(out, g, height, width, err);
    if (rc)
        return rc == -ENOMEM ? dx_err_set(err, rc, "no memory for %ux%u dexels", width, height)
                             : rc;
    (*out)->unit_m = g->unit_m;
    (*out)->range_bytes = g->range_bytes;
    (*out)->exact = g->exact;
    memcpy((*out)->pose, g->pose, sizeof(g->pose));
    return 0;
}
