/*
 * The loops of rows.h over points, a row each of x, y and z: where dexels are, and which of them
 * are no farther apart than the cap. Included once by each rows_SET.c.
 */
#include "core/rows/rows.h"

#include <math.h>

/* ---- where they are ------------------------------------------------------------------------- */

/* The operations are those of dx_geometry_point. */
static void turn_row(struct dx_row_points *restrict out, const float *row,
                     const struct dx_row_turn *turn, const float *r)
{
    const float dx = row[0], dy = row[1], dz = row[2], ox = row[3], oy = row[4], oz = row[5];
    const float *c = turn->c, *s = turn->s;

    for (uint32_t j = 0; j < N; j++) {
        const float u = ox + r[j] * dx, v = oy + r[j] * dy;

        out->x[j] = u * c[j] - v * s[j];
        out->y[j] = u * s[j] + v * c[j];
        out->z[j] = oz + r[j] * dz;
    }
}

static void stretch_row(struct dx_row_points *restrict out, const struct dx_row_points *p,
                        const float *r)
{
    for (uint32_t j = 0; j < N; j++) {
        out->x[j] = r[j] * p->x[j];
        out->y[j] = r[j] * p->y[j];
        out->z[j] = r[j] * p->z[j];
    }
}

/* Squares of less, or more, lose what f32 says of them. */
#define SHORTEST 0x1p-60f
#define LONGEST  0x1p60f

static void unit_row(struct dx_row_points *p)
{
    float length2[N], by[N];

    for (uint32_t j = 0; j < N; j++)
        length2[j] = p->x[j] * p->x[j] + p->y[j] * p->y[j] + p->z[j] * p->z[j];
    for (uint32_t j = 0; j < N; j++) {
        const float l = length2[j] > SHORTEST ? length2[j] : NAN;

        by[j] = 1 / sqrtf(l < LONGEST ? l : NAN);
    }
    for (uint32_t j = 0; j < N; j++) {
        p->x[j] *= by[j];
        p->y[j] *= by[j];
        p->z[j] *= by[j];
    }
}

/* ---- the cap -------------------------------------------------------------------------------- */

static struct dx_row_joined cap_row(const struct dx_row_span *span, float cap2, float margin)
{
    uint32_t within[N], unsure[N];

    for (uint32_t j = 0; j < N; j++) {
        const float x = span->x[0][j] - span->x[1][j], y = span->y[0][j] - span->y[1][j];
        const float z = span->z[0][j] - span->z[1][j], more = x * x + y * y + z * z - cap2;

        within[j] = more <= 0 ? UINT32_MAX : 0;
        unsure[j] = fabsf(more) > margin ? 0 : UINT32_MAX; /* so where it is no number */
    }
    return (struct dx_row_joined){pack32(within, N), pack32(unsure, N)};
}
