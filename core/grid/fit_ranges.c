/* Points as ranges of a geometry, and whether points still lie in one. */
#include "core/grid/fit_model.h"

#include "core/base/trig.h"
#include "core/rows/rows.h"

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

static uint32_t limit_of(const struct dx_geometry *g)
{
    return g->range_bytes == 2 ? UINT16_MAX : UINT32_MAX;
}

static struct dx_row_beams beams_of(const struct dx_geometry *g, uint32_t row, uint32_t col)
{
    const float *t = g->table;

    switch (g->model) {
    case DX_MODEL_SPINNING:
        return (struct dx_row_beams){DX_BEAMS_SPINNING, t + 2 * (size_t)col,
                                     t + 2 * (size_t)g->width + 6 * (size_t)row};
    case DX_MODEL_PINHOLE:
        return (struct dx_row_beams){DX_BEAMS_PINHOLE, t + col, t + (size_t)g->width + row};
    default:
        return (struct dx_row_beams){DX_BEAMS_TABLE, t + 3 * ((size_t)row * g->width + col), NULL};
    }
}

/* A part of a row, by vectors; narrower grids go point by point. */
#define PART DX_ROWS_CELLS

/* Where the part after that of column `col` begins: the last one lies over the one before. */
static uint32_t next_part(const struct dx_geometry *g, uint32_t col)
{
    const uint32_t last = g->width - PART;

    return col < last && col + PART > last ? last : col + PART;
}

/* ---- ranges --------------------------------------------------------------------------------- */

static void put_dexel(struct dx_plane *plane, const struct dx_points *points, size_t k,
                      uint32_t range)
{
    dx_plane_set_range(plane, k, range);
    dx_plane_set_attr(plane, k, range && points->attr ? points->attr[k] : 0);
    for (size_t m = 3 * k; plane->xyz && m < 3 * k + 3; m++)
        plane->xyz[m] = range ? (float)points->xyz[m] : 0;
}

static uint32_t narrow_row(struct dx_plane *plane, const struct dx_geometry *g,
                           const struct dx_points *points, uint32_t row)
{
    uint32_t dropped = 0;

    for (uint32_t col = 0; col < g->width; col++) {
        const size_t k = (size_t)row * g->width + col;
        const double *p = points->xyz + 3 * k;
        uint32_t range = dx_fit_valid(p) ? dx_geometry_units(g, range_of(g, row, col, p)) : 0;

        dropped += range == 0 && !missing(p);
        put_dexel(plane, points, k, range);
    }
    return dropped;
}

static uint32_t wide_row(struct dx_plane *plane, const struct dx_geometry *g,
                         const struct dx_points *points, uint32_t row)
{
    const struct dx_rows *rows = dx_rows_get(DX_SIMD_AUTO);
    uint32_t dropped = 0, done = 0;

    for (uint32_t col = 0; col < g->width; col = next_part(g, col)) {
        const size_t k = (size_t)row * g->width + col;
        const struct dx_row_beams beams = beams_of(g, row, col);
        uint32_t units[PART];
        uint64_t bad =
            rows->units(units, points->xyz + 3 * k, &beams, (double)g->unit_m, limit_of(g));

        dropped += dx_bits_count(bad >> (done - col));
        done = col + PART;
        for (uint32_t j = 0; j < PART; j++)
            put_dexel(plane, points, k + j, units[j]);
    }
    return dropped;
}

uint32_t dx_fit_ranges(struct dx_plane *plane, const struct dx_geometry *g,
                       const struct dx_points *points)
{
    uint32_t dropped = 0;

    for (uint32_t row = 0; row < g->height; row++)
        dropped +=
            g->width < PART ? narrow_row(plane, g, points, row) : wide_row(plane, g, points, row);
    return dropped;
}

/* ---- whether they hold ---------------------------------------------------------------------- */

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

static bool point_holds(const struct dx_geometry *g, const struct dx_points *points, uint32_t row,
                        uint32_t col, double dexels)
{
    const double *p = points->xyz + 3 * ((size_t)row * g->width + col);

    return !dx_fit_valid(p) || (dx_geometry_units(g, range_of(g, row, col, p)) != 0 &&
                                departure2(g, row, col, p) <= dexels * dexels);
}

/* Which points of a part are to be looked at one by one: those of a scanner's own beams are on
 * them, as far as f32 tells. */
static uint64_t unsure(const struct dx_geometry *g, const struct dx_points *points, uint32_t row,
                       uint32_t col)
{
    const struct dx_row_beams beams = beams_of(g, row, col);
    const double *xyz = points->xyz + 3 * ((size_t)row * g->width + col);
    const double unit = (double)g->unit_m, near = 0.5000001 * unit;
    const double far = 0.9999999 * unit * limit_of(g);

    return ~dx_rows_get(DX_SIMD_AUTO)->on_beams(xyz, &beams, near, far);
}

static bool narrow_row_holds(const struct dx_geometry *g, const struct dx_points *points,
                             uint32_t row, double dexels)
{
    for (uint32_t col = 0; col < g->width; col++)
        if (!point_holds(g, points, row, col, dexels))
            return false;
    return true;
}

static bool wide_row_holds(const struct dx_geometry *g, const struct dx_points *points,
                           uint32_t row, double dexels)
{
    for (uint32_t col = 0; col < g->width; col = next_part(g, col))
        for (uint64_t look = unsure(g, points, row, col); look; look &= look - 1)
            if (!point_holds(g, points, row, col + dx_bits_first(look), dexels))
                return false;
    return true;
}

bool dx_fit_holds(const struct dx_geometry *g, const struct dx_points *points, double dexels)
{
    if (g->height != points->height || g->width != points->width)
        return false;
    for (uint32_t row = 0; row < g->height; row++)
        if (!(g->width < PART ? narrow_row_holds : wide_row_holds)(g, points, row, dexels))
            return false;
    return true;
}
