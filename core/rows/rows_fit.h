/*
 * The loops of rows.h from points to ranges, DX_ROWS_CELLS points of a row of a grid at a time: in
 * f64, by the operations of core/grid/fit_ranges.c. Included once by each rows_SET.c.
 */
#include "core/rows/rows.h"

#include <math.h>
#include <string.h>

#define POINTS DX_ROWS_CELLS

struct points {
    double x[POINTS], y[POINTS], z[POINTS];
};

static inline void load_points(struct points *restrict p, const double *xyz)
{
    for (uint32_t j = 0; j < POINTS; j++) {
        p->x[j] = xyz[3 * j];
        p->y[j] = xyz[3 * j + 1];
        p->z[j] = xyz[3 * j + 2];
    }
}

static inline void load_table(struct points *restrict d, const float *v)
{
    for (uint32_t j = 0; j < POINTS; j++) {
        d->x[j] = (double)v[3 * j];
        d->y[j] = (double)v[3 * j + 1];
        d->z[j] = (double)v[3 * j + 2];
    }
}

/* v, turned to each column. */
static inline void turn_to(struct points *restrict d, const float *cs, const float *v)
{
    for (uint32_t j = 0; j < POINTS; j++) {
        const double c = (double)cs[2 * j], s = (double)cs[2 * j + 1];

        d->x[j] = (double)v[0] * c - (double)v[1] * s;
        d->y[j] = (double)v[0] * s + (double)v[1] * c;
        d->z[j] = (double)v[2];
    }
}

/* Of any length. */
static inline void find_directions(struct points *restrict d, const struct dx_row_beams *b)
{
    if (b->kind == DX_BEAMS_SPINNING)
        turn_to(d, b->columns, b->row);
    else if (b->kind == DX_BEAMS_TABLE)
        load_table(d, b->columns);
    else
        for (uint32_t j = 0; j < POINTS; j++) {
            d->x[j] = (double)b->columns[j];
            d->y[j] = (double)b->row[0];
            d->z[j] = 1;
        }
}

/* Points from their beams' origins. */
static inline void from_origins(struct points *restrict q, const struct points *p,
                                const struct dx_row_beams *b)
{
    *q = *p;
    if (b->kind == DX_BEAMS_SPINNING) {
        struct points o;

        turn_to(&o, b->columns, b->row + 3);
        for (uint32_t j = 0; j < POINTS; j++) {
            q->x[j] -= o.x[j];
            q->y[j] -= o.y[j];
            q->z[j] -= o.z[j];
        }
    }
}

static inline void square(double *restrict out, const struct points *p)
{
    for (uint32_t j = 0; j < POINTS; j++)
        out[j] = p->x[j] * p->x[j] + p->y[j] * p->y[j] + p->z[j] * p->z[j];
}

/* dx_fit_valid */
static inline void find_valid(uint32_t *restrict valid, const struct points *p,
                              const double *length2)
{
    for (uint32_t j = 0; j < POINTS; j++)
        valid[j] = ((fabs(p->x[j]) < 1e12) & (fabs(p->y[j]) < 1e12) & (fabs(p->z[j]) < 1e12) &
                    (length2[j] > 1e-24))
                       ? UINT32_MAX
                       : 0;
}

/* Added to what is not negative and below 2^51, it rounds to a whole number, as rint() does, which
 * is in the low bits. */
#define WHOLE 0x1p52

static inline void find_units(uint32_t *restrict units, const double *range, const uint32_t *valid,
                              double unit_m, double limit)
{
    uint64_t bits[POINTS];
    double sum[POINTS];

    for (uint32_t j = 0; j < POINTS; j++)
        sum[j] = range[j] / unit_m + WHOLE;
    memcpy(bits, sum, sizeof(bits));
    for (uint32_t j = 0; j < POINTS; j++) {
        const double whole = sum[j] - WHOLE;

        units[j] = ((whole >= 1) & (whole <= limit)) ? (uint32_t)bits[j] : 0;
    }
    for (uint32_t j = 0; j < POINTS; j++)
        units[j] &= valid[j];
}

static uint64_t units_row(uint32_t units[DX_ROWS_CELLS], const double *xyz,
                          const struct dx_row_beams *b, double unit_m, double limit)
{
    struct points p, q;
    double range[POINTS], length2[POINTS];
    uint32_t valid[POINTS], dropped[POINTS];

    load_points(&p, xyz);
    square(length2, &p);
    find_valid(valid, &p, length2);
    if (b->kind == DX_BEAMS_SPINNING) {
        from_origins(&q, &p, b);
        square(length2, &q);
    }
    for (uint32_t j = 0; j < POINTS; j++)
        range[j] = b->kind == DX_BEAMS_PINHOLE ? p.z[j] : sqrt(length2[j]);
    find_units(units, range, valid, unit_m, limit);
    for (uint32_t j = 0; j < POINTS; j++)
        dropped[j] =
            ((units[j] == 0) & (p.x[j] == p.x[j]) & (p.y[j] == p.y[j]) & (p.z[j] == p.z[j]))
                ? UINT32_MAX
                : 0;
    return (uint64_t)pack32(dropped, POINTS);
}

/*
 * The chord between two directions, squared, is less than 1.01 squared sines of a small angle, and
 * the sine is the cross product's: no root and no quotient. Rounding is 2^-100 of the squares.
 */
#define SINE2 2.5e-13

static uint64_t on_beams_row(const double *xyz, const struct dx_row_beams *b, double near,
                             double far)
{
    struct points p, d, q;
    double length2[POINTS], beam2[POINTS], range2[POINTS];
    uint32_t is[POINTS];

    load_points(&p, xyz);
    find_directions(&d, b);
    from_origins(&q, &p, b);
    square(length2, &p);
    square(beam2, &d);
    square(range2, &q);
    for (uint32_t j = 0; j < POINTS && b->kind == DX_BEAMS_PINHOLE; j++)
        range2[j] = p.z[j] * p.z[j];
    for (uint32_t j = 0; j < POINTS; j++) {
        const double x = p.y[j] * d.z[j] - p.z[j] * d.y[j];
        const double y = p.z[j] * d.x[j] - p.x[j] * d.z[j];
        const double z = p.x[j] * d.y[j] - p.y[j] * d.x[j];
        const double along = p.x[j] * d.x[j] + p.y[j] * d.y[j] + p.z[j] * d.z[j];

        is[j] = ((x * x + y * y + z * z < SINE2 * length2[j] * beam2[j]) & (along > 0) &
                 (length2[j] > 1e-22) & (length2[j] < 1e22) & (range2[j] > near * near) &
                 (range2[j] < far * far))
                    ? UINT32_MAX
                    : 0;
    }
    return (uint64_t)pack32(is, POINTS);
}
