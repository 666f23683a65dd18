/* Geometries: making them, their orientation, angles between dexels, and how far two differ. */
#include "core/grid/geometry.h"

#include "core/base/trig.h"
#include "core/grid/plane.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A step whose angle to the whole turn is smaller than this share of it closes the seam. */
#define SEAM_TOLERANCE 0.1
#define MIN_WRAP_WIDTH 8

size_t dx_geometry_table_len(enum dx_model model, uint32_t height, uint32_t width)
{
    size_t n = (size_t)height * width;

    if (height == 0 || width == 0 || height > DX_PLANE_MAX_SIDE || width > DX_PLANE_MAX_SIDE ||
        n > DX_PLANE_MAX_DEXELS)
        return 0;
    switch (model) {
    case DX_MODEL_SPINNING:
        return 2 * (size_t)width + 6 * (size_t)height;
    case DX_MODEL_PINHOLE:
        return (size_t)width + height;
    case DX_MODEL_TABLE:
        return 3 * n;
    }
    return 0;
}

int dx_geometry_new(struct dx_geometry **out, enum dx_model model, uint32_t height, uint32_t width)
{
    size_t n_table = dx_geometry_table_len(model, height, width);
    struct dx_geometry *g;

    if (n_table == 0)
        return -EINVAL;
    g = calloc(1, sizeof(*g));
    if (!g)
        return -ENOMEM;
    g->table = calloc(n_table, sizeof(*g->table));
    if (!g->table) {
        free(g);
        return -ENOMEM;
    }
    atomic_init(&g->refs, 1);
    g->model = model;
    g->height = height;
    g->width = width;
    g->range_bytes = 2;
    g->unit_m = 0.001f;
    g->n_table = n_table;
    g->pose[0] = g->pose[5] = g->pose[10] = 1;
    *out = g;
    return 0;
}

struct dx_geometry *dx_geometry_ref(struct dx_geometry *g)
{
    /* relaxed: who takes a reference already holds one */
    atomic_fetch_add_explicit(&g->refs, 1, memory_order_relaxed);
    return g;
}

void dx_geometry_unref(struct dx_geometry *g)
{
    /* release our reads before the last owner (acquire) frees */
    if (!g || atomic_fetch_sub_explicit(&g->refs, 1, memory_order_acq_rel) != 1)
        return;
    free(g->table);
    free(g);
}

int dx_geometry_new_spinning(struct dx_geometry **out, uint32_t height, uint32_t width,
                             double azimuth0, double azimuth_step, double elevation0,
                             double elevation_step)
{
    struct dx_geometry *g;
    int r = dx_geometry_new(&g, DX_MODEL_SPINNING, height, width);

    if (r < 0)
        return r;
    for (uint32_t j = 0; j < width; j++) {
        double s, c;

        dx_sincos(azimuth0 + j * azimuth_step, &s, &c);
        g->table[2 * j] = (float)c;
        g->table[2 * j + 1] = (float)s;
    }
    for (uint32_t i = 0; i < height; i++) {
        float *row = g->table + 2 * (size_t)width + 6 * (size_t)i;
        double s, c;

        dx_sincos(elevation0 + i * elevation_step, &s, &c);
        row[0] = (float)c;
        row[2] = (float)s;
    }
    g->wrap = width >= MIN_WRAP_WIDTH &&
              fabs(fabs(width * azimuth_step) - 2 * DX_PI) < SEAM_TOLERANCE * fabs(azimuth_step);
    dx_geometry_orient(g);
    *out = g;
    return 0;
}

int dx_geometry_new_pinhole(struct dx_geometry **out, uint32_t height, uint32_t width, double fx,
                            double fy, double cx, double cy)
{
    struct dx_geometry *g;
    int r;

    if (!(fabs(fx) > 0) || !(fabs(fy) > 0))
        return -EINVAL;
    r = dx_geometry_new(&g, DX_MODEL_PINHOLE, height, width);
    if (r < 0)
        return r;
    for (uint32_t j = 0; j < width; j++)
        g->table[j] = (float)((j - cx) / fx);
    for (uint32_t i = 0; i < height; i++)
        g->table[(size_t)width + i] = (float)((i - cy) / fy);
    dx_geometry_orient(g);
    *out = g;
    return 0;
}

/* The vector whose multiples are the points of a dexel (beam origins apart). */
static void beam(const struct dx_geometry *g, uint32_t row, uint32_t col, double d[3])
{
    const float *t = g->table;

    if (g->model == DX_MODEL_SPINNING) {
        const float *cs = t + 2 * (size_t)col, *v = t + 2 * (size_t)g->width + 6 * (size_t)row;

        d[0] = (double)v[0] * cs[0] - (double)v[1] * cs[1];
        d[1] = (double)v[0] * cs[1] + (double)v[1] * cs[0];
        d[2] = v[2];
    } else if (g->model == DX_MODEL_PINHOLE) {
        d[0] = t[col];
        d[1] = t[(size_t)g->width + row];
        d[2] = 1;
    } else {
        const float *v = t + 3 * ((size_t)row * g->width + col);

        d[0] = v[0];
        d[1] = v[1];
        d[2] = v[2];
    }
}

/* det(a, b, c); its sign is the orientation of the spherical triangle abc as seen from the scanner.
 */
static double det3(const double a[3], const double b[3], const double c[3])
{
    return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
           a[2] * (b[0] * c[1] - b[1] * c[0]);
}

/* The orientation of a triangle by its directions' own determinant; 0 where the rounding of points
 * to f32 could turn it over: a height of less than some steps of f32 over its longest side. */
static int corner_sign(const double p[3], const double q[3], const double r[3])
{
    const double *v[3] = {p, q, r};
    double longest2 = 0, far2 = 0, det = det3(p, q, r);

    for (int m = 0; m < 3; m++) {
        const double *x = v[m], *y = v[(m + 1) % 3];
        double d2 = 0, l2 = 0;

        for (int k = 0; k < 3; k++) {
            d2 += (x[k] - y[k]) * (x[k] - y[k]);
            l2 += x[k] * x[k];
        }
        longest2 = d2 > longest2 ? d2 : longest2;
        far2 = l2 > far2 ? l2 : far2;
    }
    if (det * det <= 0x1p-42 * longest2 * far2 * far2)
        return 0;
    return det > 0 ? 1 : -1;
}

int dx_geometry_cell_sign(const struct dx_geometry *g, uint32_t row, uint32_t col)
{
    uint32_t next = (col + 1) % g->width;
    double a[3], b[3], c[3], d[3];
    int sign;

    beam(g, row, col, a);
    beam(g, row, next, b);
    beam(g, row + 1, next, c);
    beam(g, row + 1, col, d);
    sign = corner_sign(a, b, c);
    return corner_sign(a, c, d) == sign && corner_sign(a, b, d) == sign &&
                   corner_sign(b, c, d) == sign
               ? sign
               : 0;
}

void dx_geometry_orient(struct dx_geometry *g)
{
    uint32_t cols = g->wrap ? g->width : g->width - 1;
    int64_t balance = 0;

    /* A separable table has one sign everywhere; only a table of directions needs every cell. */
    uint32_t step_i = g->model == DX_MODEL_TABLE ? 1 : 1 + g->height / 32;
    uint32_t step_j = g->model == DX_MODEL_TABLE ? 1 : 1 + g->width / 32;

    for (uint32_t i = 0; i + 1 < g->height; i += step_i)
        for (uint32_t j = 0; j < cols; j += step_j)
            balance += dx_geometry_cell_sign(g, i, j);

    g->flip = balance > 0; /* n.(o - p) > 0 asks for det(a, b, c) < 0 */
}

void dx_geometry_direction(const struct dx_geometry *g, uint32_t row, uint32_t col, double dir[3])
{
    double len;

    beam(g, row, col, dir);
    len = sqrt(dir[0] * dir[0] + dir[1] * dir[1] + dir[2] * dir[2]);
    for (int k = 0; k < 3; k++)
        dir[k] /= len > 0 ? len : 1;
}

double dx_geometry_angle(const struct dx_geometry *g, uint32_t row0, uint32_t col0, uint32_t row1,
                         uint32_t col1)
{
    double a[3], b[3], d2 = 0, half;

    if (g->model == DX_MODEL_PINHOLE) {
        double dx = (double)g->table[col1] - g->table[col0];
        double dy = (double)g->table[(size_t)g->width + row1] - g->table[(size_t)g->width + row0];

        return sqrt(dx * dx + dy * dy);
    }
    dx_geometry_direction(g, row0, col0, a);
    dx_geometry_direction(g, row1, col1, b);
    for (int k = 0; k < 3; k++)
        d2 += (a[k] - b[k]) * (a[k] - b[k]);
    half = sqrt(d2) / 2; /* the chord keeps its precision where the dot product loses it */
    return 2 * dx_atan2(half, sqrt(half < 1 ? 1 - half * half : 0));
}

uint32_t dx_geometry_units(const struct dx_geometry *g, double range_m)
{
    double units = rint(range_m / (double)g->unit_m);
    double limit = g->range_bytes == 2 ? 65535.0 : 4294967295.0;

    return units >= 1 && units <= limit ? (uint32_t)units : 0;
}

double dx_geometry_unit_for(double max_range_m)
{
    static const double mantissa[3] = {1, 2, 5};
    double decade = 1e-6;

    for (int e = 0; e < 12; e++, decade *= 10)
        for (int k = 0; k < 3; k++)
            if (max_range_m / (decade * mantissa[k]) < 65535.0)
                return decade * mantissa[k];
    return decade;
}

double dx_geometry_departure(const struct dx_geometry *a, const struct dx_geometry *b)
{
    double worst = 0;

    if (a->model != b->model || a->height != b->height || a->width != b->width ||
        a->wrap != b->wrap)
        return INFINITY;
    for (uint32_t i = 0; i < a->height; i++)
        for (uint32_t j = 0; j < a->width; j++) {
            uint32_t ni = i ? i - 1 : (a->height > 1), nj = j ? j - 1 : (a->width > 1);
            double da[3], db[3], chord2 = 0, step, off;

            dx_geometry_direction(a, i, j, da);
            dx_geometry_direction(b, i, j, db);
            for (int k = 0; k < 3; k++)
                chord2 += (da[k] - db[k]) * (da[k] - db[k]);
            if (chord2 == 0)
                continue;
            /* the larger step: towards a pole the other one vanishes */
            step = dx_geometry_angle(a, i, j, ni, j);
            off = dx_geometry_angle(a, i, j, i, nj);
            step = off > step ? off : step;
            off = step > 0 ? sqrt(chord2) / step : 0;
            if (off > worst)
                worst = off;
        }
    return worst;
}

bool dx_geometry_is_same(const struct dx_geometry *a, const struct dx_geometry *b)
{
    return a == b ||
           (a->model == b->model && a->height == b->height && a->width == b->width &&
            a->wrap == b->wrap && a->flip == b->flip && a->range_bytes == b->range_bytes &&
            a->exact == b->exact && memcmp(&a->unit_m, &b->unit_m, sizeof(a->unit_m)) == 0 &&
            memcmp(a->pose, b->pose, sizeof(a->pose)) == 0 && a->n_table == b->n_table &&
            memcmp(a->table, b->table, a->n_table * sizeof(*a->table)) == 0);
}

const char *dx_model_name(enum dx_model model)
{
    switch (model) {
    case DX_MODEL_SPINNING:
        return "spinning";
    case DX_MODEL_PINHOLE:
        return "pinhole";
    case DX_MODEL_TABLE:
        return "table";
    }
    return "unknown";
}
