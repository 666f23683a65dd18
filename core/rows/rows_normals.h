/*
 * The loops of rows.h for vertex normals: cross products of the triangles of a row of cells, added
 * to their corners in the order of normals.h, and the octahedral bytes of sums. A triangle that is
 * not there adds 0, which changes no sum: sums begin at 0 and are never -0. Included once by each
 * rows_SET.c.
 */
#include "core/rows/rows.h"

#include <math.h>
#include <string.h>

#define ROOM (N + 16) /* one before the first, and whole vectors */
#define AT   15       /* of lane -1 */

/* What a row of cells consists of, all ones or none: cut from b to d; its first (abc, abd) and
 * second triangle (acd, bcd) there. From lane -1 on, which has none. */
struct cell_masks {
    int32_t bd[ROOM], first[ROOM], second[ROOM];
};

/* Cross products of the first or second triangles, one array for each coordinate; from lane -1 on.
 */
struct cell_normals {
    float x[ROOM], y[ROOM], z[ROOM];
};

/* enum dx_cell: 1 and 2 of a cell cut from a to c are its first and second; 4 and 5 of one from b
 * to d. */
static inline void find_masks(struct cell_masks *restrict m, const uint8_t *code)
{
    uint8_t bd[N], first[N], second[N];

    for (uint32_t j = 0; j < N; j++) {
        const uint8_t on_bd = code[j] > 3, of_two = (uint8_t)(code[j] - 3 * on_bd);

        bd[j] = on_bd;
        first[j] = of_two & 1;
        second[j] = of_two >> 1;
    }
    m->bd[AT] = m->first[AT] = m->second[AT] = 0;
    for (uint32_t j = 0; j < N; j++)
        m->bd[AT + 1 + j] = -(int32_t)bd[j];
    for (uint32_t j = 0; j < N; j++)
        m->first[AT + 1 + j] = -(int32_t)first[j];
    for (uint32_t j = 0; j < N; j++)
        m->second[AT + 1 + j] = -(int32_t)second[j];
}

/* Three points of each triangle, of one coordinate. */
struct corner_lanes {
    float p0[N], p1[N], p2[N];
};

/* a, b, c or d. */
static inline void take_first(struct corner_lanes *restrict out, const float *top,
                              const float *bottom, const int32_t *bd)
{
    for (uint32_t j = 0; j < N; j++) {
        const float c = bottom[j + 1], d = bottom[j];

        out->p0[j] = top[j];
        out->p1[j] = top[j + 1];
        out->p2[j] = bd[j] ? d : c;
    }
}

/* a or b, c, d. */
static inline void take_second(struct corner_lanes *restrict out, const float *top,
                               const float *bottom, const int32_t *bd)
{
    for (uint32_t j = 0; j < N; j++) {
        const float a = top[j], b = top[j + 1];

        out->p0[j] = bd[j] ? b : a;
        out->p1[j] = bottom[j + 1];
        out->p2[j] = bottom[j];
    }
}

/* (p1 - p0) x (p2 - p0), or 0. */
static inline void cross_rows(struct cell_normals *restrict out, const struct corner_lanes *x,
                              const struct corner_lanes *y, const struct corner_lanes *z,
                              const int32_t *there)
{
    out->x[AT] = out->y[AT] = out->z[AT] = 0;
    for (uint32_t j = 0; j < N; j++) {
        const float ux = x->p1[j] - x->p0[j], vx = x->p2[j] - x->p0[j];
        const float uy = y->p1[j] - y->p0[j], vy = y->p2[j] - y->p0[j];
        const float uz = z->p1[j] - z->p0[j], vz = z->p2[j] - z->p0[j];
        const float nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;

        out->x[AT + 1 + j] = there[j] ? nx : 0;
        out->y[AT + 1 + j] = there[j] ? ny : 0;
        out->z[AT + 1 + j] = there[j] ? nz : 0;
    }
}

/* x, or 0 where no bit of the mask is set: a choice between a load and 0 becomes a branch. */
static inline float masked(float x, int32_t mask)
{
    int32_t bits;

    memcpy(&bits, &x, sizeof(bits));
    bits &= mask;
    memcpy(&x, &bits, sizeof(x));
    return x;
}

/* One coordinate. A dexel is corner b of the cell to its left below, a of that to its right; c and
 * d of those above: first triangles have a and b, second ones c and d, and each one more. */
static inline void add_normals(float *restrict top, float *restrict bottom, const float *first,
                               const float *second, const int32_t *bd)
{
    const float *f = first + 1, *s = second + 1;
    const int32_t *here = bd + 1;

    for (uint32_t j = 0; j < N; j++)
        top[j] = top[j] + first[j] + masked(second[j], bd[j]) + f[j] + masked(s[j], ~here[j]);
    for (uint32_t j = 0; j < N; j++)
        bottom[j] = 0.0f + masked(first[j], ~bd[j]) + second[j] + masked(f[j], here[j]) + s[j];
}

static void add_cells_row(struct dx_row_points *restrict top, struct dx_row_points *restrict bottom,
                          const struct dx_row_points *above, const struct dx_row_points *below,
                          const uint8_t *code)
{
    struct cell_normals first, second;
    struct corner_lanes x, y, z;
    struct cell_masks m;
    const int32_t *bd = m.bd + AT + 1;

    find_masks(&m, code);
    take_first(&x, above->x, below->x, bd);
    take_first(&y, above->y, below->y, bd);
    take_first(&z, above->z, below->z, bd);
    cross_rows(&first, &x, &y, &z, m.first + AT + 1);
    take_second(&x, above->x, below->x, bd);
    take_second(&y, above->y, below->y, bd);
    take_second(&z, above->z, below->z, bd);
    cross_rows(&second, &x, &y, &z, m.second + AT + 1);
    add_normals(top->x, bottom->x, first.x + AT, second.x + AT, m.bd + AT);
    add_normals(top->y, bottom->y, first.y + AT, second.y + AT, m.bd + AT);
    add_normals(top->z, bottom->z, first.z + AT, second.z + AT, m.bd + AT);
}

/* ---- octahedral bytes ------------------------------------------------------------------------ */

/* Rounds as rint: what is added leaves no room for a fraction. */
static inline int32_t round_lane(float x)
{
    return (int32_t)(x + 0x1.8p23f - 0x1.8p23f);
}

/* The operations are those of dx_octahedral_encode. */
static void octahedral_row(int8_t *restrict out, const struct dx_row_points *sum, dx_bits used,
                           bool flip)
{
    const float sign = flip ? -1.0f : 1.0f;
    uint32_t is_used[N];
    int32_t u[N], v[N];

    unpack32(is_used, used);
    for (uint32_t j = 0; j < N; j++) {
        const float x = sum->x[j] * sign, y = sum->y[j] * sign, z = sum->z[j] * sign;
        const float size = fabsf(x) + fabsf(y) + fabsf(z);
        const float finite = size < INFINITY ? size : 0; /* not what is no number */
        const float by = finite > 0 ? size : 1;
        const float a = finite > 0 ? x / by : 0, b = finite > 0 ? y / by : 0;
        const float fold_a = (1 - fabsf(b)) * (a >= 0 ? 1.0f : -1.0f);
        const float fold_b = (1 - fabsf(a)) * (b >= 0 ? 1.0f : -1.0f);
        const float to_a = z < 0 ? fold_a : a, to_b = z < 0 ? fold_b : b;

        u[j] = finite > 0 ? round_lane(to_a * 127) : 0;
        v[j] = finite > 0 ? round_lane(to_b * 127) : 0;
    }
    for (uint32_t j = 0; j < N; j++) {
        out[2 * j] = (int8_t)((uint32_t)u[j] & is_used[j]);
        out[2 * j + 1] = (int8_t)((uint32_t)v[j] & is_used[j]);
    }
}
