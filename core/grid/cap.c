/*
 * The cap on edges. Two points of directions u and v at ranges r and s are |r u - s v| apart, whose
 * square is compared with that of the cap. Rounding: an f32 is off by 2^-24 of itself. A direction
 * takes three products and a difference, its length and the division by it: with the product by
 * the range, each point is off by less than 2^-19 of the sum of its coordinates. The integers cut
 * directions to 2^-24 and coordinates to 2^-12 units. Where all that could matter, the integers are
 * asked.
 */
#include "core/grid/cap.h"

#include "core/grid/strip.h"

#include <math.h>

#define POINT_OFF 0x1p-19 /* of |x| + |y| + |z| */
#define CUTS      0x1p-11
#define ROUNDING  0x1p-20 /* of a square of a length: seven operations */
#define UNIT_SUM  1.75    /* |x| + |y| + |z| of a unit vector, at most; sqrt(3) */

/* ---- the integers ---------------------------------------------------------------------------- */

static void find_direction(int64_t out[3], const struct dx_area *a, uint32_t p, uint32_t q)
{
    const struct dx_geometry *g = a->geometry;
    double d[3], z = 1;

    dx_geometry_direction(g, dx_area_row(a, p), dx_area_col(a, q, g->width), d);
    if (g->model == DX_MODEL_PINHOLE)
        z = d[2]; /* its ranges are depths: scale the unit vector to depth 1 */
    for (int k = 0; k < 3; k++)
        out[k] = (int64_t)rint(d[k] / z * 0x1p24);
}

static bool is_within(const struct dx_area *a, const struct dx_gates *gates, uint32_t p0,
                      uint32_t q0, uint32_t p1, uint32_t q1)
{
    const __int128 r0 = dx_area_range(a, p0, q0), r1 = dx_area_range(a, p1, q1);
    unsigned __int128 length2 = 0;
    int64_t d0[3], d1[3];

    find_direction(d0, a, p0, q0);
    find_direction(d1, a, p1, q1);
    for (int k = 0; k < 3; k++) {
        const __int128 d = (r0 * d0[k] - r1 * d1[k]) >> 12;

        length2 += (unsigned __int128)(d * d);
    }
    return length2 <= (unsigned __int128)gates->cap * gates->cap;
}

/* ---- f32 ------------------------------------------------------------------------------------- */

/* The cap's square, and how far from it a square must be to be told from it. */
struct limit {
    float cap2, margin;
};

/* Of points whose coordinates' sums are together at most `sums`. */
static struct limit limit_of(const struct dx_gates *gates, double sums)
{
    const double cap = (double)gates->cap * 0x1p-12, off = POINT_OFF * sums + CUTS;
    const double far = cap + off;

    return (struct limit){.cap2 = (float)(cap * cap),
                          .margin = (float)(off * (cap + far) + ROUNDING * far * far)};
}

static float find_farthest(const struct dx_area *a, uint32_t p)
{
    uint32_t farthest = 0;

    for (uint32_t q = 0; a->wide && q < DX_AREA; q++)
        farthest = farthest > a->range[p][q] ? farthest : a->range[p][q];
    if (!a->wide) {
        uint16_t most = 0;

        for (uint32_t q = 0; q < DX_AREA; q++)
            most = most > a->range16[p][q] ? most : a->range16[p][q];
        farthest = most;
    }
    return (float)farthest;
}

static void fill_ranges(float r[DX_ROWS_N], const struct dx_area *a, uint32_t p)
{
    for (uint32_t q = 0; a->wide && q < DX_ROWS_N; q++)
        r[q] = (float)a->range[p][q];
    for (uint32_t q = 0; !a->wide && q < DX_ROWS_N; q++)
        r[q] = (float)a->range16[p][q];
}

/* |x| + |y| + |z| of a row's beams, at most. */
static float find_sum(const struct dx_row_points *beam, const struct dx_geometry *g)
{
    float most = 0;

    if (g->model != DX_MODEL_PINHOLE)
        return (float)UNIT_SUM;
    for (uint32_t q = 0; q < DX_ROWS_N; q++) {
        const float sum = fabsf(beam->x[q]) + fabsf(beam->y[q]) + beam->z[q];

        most = most > sum ? most : sum;
    }
    return most;
}

void dx_cap_gather(struct dx_area *a, const struct dx_geometry *g, const struct dx_gates *gates)
{
    struct dx_row_points beam;
    struct dx_strip strip;
    float r[DX_ROWS_N];

    a->geometry = g;
    dx_strip_init(&strip, g, gates->rows, a->col0);
    for (uint32_t p = a->first; p < a->end; p++) {
        if (a->row0 + p < 0 || a->row0 + p >= g->height)
            continue;
        dx_strip_beams(&beam, &strip, dx_area_row(a, p));
        fill_ranges(r, a, p);
        gates->rows->stretch(&a->point[p], &beam, r);
        a->sum[p] = find_sum(&beam, g) * find_farthest(a, p);
    }
}

void dx_cap_row(struct dx_area *a, const struct dx_gates *gates, enum dx_edge e, uint32_t p)
{
    const struct dx_ends end = dx_edge_ends(e);
    const struct dx_row_points *from = &a->point[p + end.p0], *to = &a->point[p + end.p1];
    const struct dx_row_span span = {.x = {from->x + end.q0, to->x + end.q1},
                                     .y = {from->y + end.q0, to->y + end.q1},
                                     .z = {from->z + end.q0, to->z + end.q1}};
    const struct limit limit =
        limit_of(gates, (double)a->sum[p + end.p0] + (double)a->sum[p + end.p1]);
    const struct dx_row_joined row = gates->rows->cap(&span, limit.cap2, limit.margin);
    const dx_bits asked = dx_words_at(&a->joined[e], p);
    dx_bits joined = asked & row.joined & ~row.unsure;

    for (dx_bits unsure = asked & row.unsure; unsure; unsure &= unsure - 1) {
        const uint32_t q = dx_bits_first(unsure);

        joined |= (dx_bits)is_within(a, gates, p + end.p0, q + end.q0, p + end.p1, q + end.q1) << q;
    }
    dx_words_put(&a->joined[e], p, joined);
}

bool dx_area_within_cap(const struct dx_area *a, const struct dx_gates *gates, uint32_t p0,
                        uint32_t q0, uint32_t p1, uint32_t q1)
{
    const struct dx_row_points *from = &a->point[p0], *to = &a->point[p1];
    struct limit limit;
    float x, y, z, more;

    if (!gates->cap)
        return true;
    limit = limit_of(gates, (double)a->sum[p0] + (double)a->sum[p1]);
    x = from->x[q0] - to->x[q1];
    y = from->y[q0] - to->y[q1];
    z = from->z[q0] - to->z[q1];
    more = x * x + y * y + z * z - limit.cap2;
    if (fabsf(more) > limit.margin) /* not where it is no number */
        return more <= 0;
    return is_within(a, gates, p0, q0, p1, q1);
}
