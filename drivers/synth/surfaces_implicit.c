/*
 * A plate with holes: F(x, y)^2 + z^2 = t^2, where F is negative inside a rounded outline and
 * outside of holes. Random points of the box are moved to the surface along the gradient; one that
 * is too near to another is dropped, which makes samples of even density whatever the first had.
 */
#include "drivers/synth/surfaces_implicit.h"

#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#define THICKNESS 0.12 /* half of it */
#define MAX_HOLES 5
#define PACKING   0.73 /* squared distance over area of a point, where points are dense */
#define NONE      UINT32_MAX

struct plate {
    double half[2]; /* of the outline's straight part */
    double round;   /* radius of its corners */
    uint32_t n_holes;
    double hole[MAX_HOLES][3]; /* centre, radius */
};

static const struct plate double_torus = {{0.6, 0}, 0.75, 2, {{-0.6, 0, 0.35}, {0.6, 0, 0.35}}};
static const struct plate five_holes = {{0.8, 0.8},
                                        0.35,
                                        5,
                                        {{0, 0, 0.22},
                                         {-0.65, -0.65, 0.22},
                                         {0.65, -0.65, 0.22},
                                         {-0.65, 0.65, 0.22},
                                         {0.65, 0.65, 0.22}}};

/* How far (x, y) is from the nearest edge of the plate, negative on it. */
static double outline(const struct plate *p, double x, double y)
{
    const double dx = fabs(x) - p->half[0], dy = fabs(y) - p->half[1];
    const double ox = dx > 0 ? dx : 0, oy = dy > 0 ? dy : 0;
    const double most = dx > dy ? dx : dy;
    double f = sqrt(ox * ox + oy * oy) + (most < 0 ? most : 0) - p->round;

    for (uint32_t k = 0; k < p->n_holes; k++) {
        const double hx = x - p->hole[k][0], hy = y - p->hole[k][1];
        const double h = p->hole[k][2] - sqrt(hx * hx + hy * hy);

        f = h > f ? h : f;
    }
    return f;
}

/* Of the solid: the plate's middle sheet, shrunk by its thickness, swept by a ball. */
static double distance(const struct plate *p, const double at[3])
{
    const double f = outline(p, at[0], at[1]) + THICKNESS;
    const double beside = f > 0 ? f : 0;

    return sqrt(beside * beside + at[2] * at[2]) - THICKNESS;
}

static bool move_to_surface(const struct plate *p, double at[3])
{
    const double h = 1e-5;

    for (int step = 0; step < 30; step++) {
        const double d = distance(p, at);
        double g[3], gg = 0;

        for (int k = 0; k < 3; k++) {
            double a[3] = {at[0], at[1], at[2]}, b[3] = {at[0], at[1], at[2]};

            a[k] -= h;
            b[k] += h;
            g[k] = (distance(p, b) - distance(p, a)) / (2 * h);
            gg += g[k] * g[k];
        }
        if (gg < 0.1)
            return false;
        for (int k = 0; k < 3; k++)
            at[k] -= d * g[k] / gg;
        if (fabs(d) < 1e-9)
            return true;
    }
    return false;
}

/* Points by cells of a grid as wide as their distance. */
struct grid {
    double low[3], side;
    uint32_t size[3];
    uint32_t *first, *next; /* of a cell; of a point: the next in its cell */
};

static size_t cell_at(const struct grid *g, const int64_t c[3])
{
    return ((size_t)c[0] * g->size[1] + (size_t)c[1]) * g->size[2] + (size_t)c[2];
}

static void cell_of(int64_t c[3], const struct grid *g, const double at[3])
{
    for (int k = 0; k < 3; k++) {
        const double x = floor((at[k] - g->low[k]) / g->side);

        c[k] = x < 0 ? 0 : x >= g->size[k] ? g->size[k] - 1 : (int64_t)x;
    }
}

static bool is_alone(const struct grid *g, const double *xyz, const double at[3])
{
    int64_t c[3];

    cell_of(c, g, at);
    for (int64_t k = 0; k < 27; k++) {
        const int64_t d[3] = {c[0] + k / 9 - 1, c[1] + k / 3 % 3 - 1, c[2] + k % 3 - 1};

        if (d[0] < 0 || d[1] < 0 || d[2] < 0 || d[0] >= g->size[0] || d[1] >= g->size[1] ||
            d[2] >= g->size[2])
            continue;
        for (uint32_t v = g->first[cell_at(g, d)]; v != NONE; v = g->next[v]) {
            const double *q = xyz + 3 * (size_t)v;
            const double x = q[0] - at[0], y = q[1] - at[1], z = q[2] - at[2];

            if (x * x + y * y + z * z < g->side * g->side)
                return false;
        }
    }
    return true;
}

static void throw_darts(double *xyz, uint32_t *n, uint32_t max, const struct plate *p,
                        struct grid *g, struct dx_rng *rng)
{
    const uint64_t most = 40 * (uint64_t)max;

    for (uint64_t try = 0; try < most && *n < max; try++) {
        double at[3];
        int64_t c[3];

        for (int k = 0; k < 3; k++)
            at[k] = g->low[k] - 2 * g->low[k] * dx_rng_unit(rng);
        if (!move_to_surface(p, at) || !is_alone(g, xyz, at))
            continue;
        for (int k = 0; k < 3; k++)
            xyz[3 * (size_t)*n + (size_t)k] = at[k];
        cell_of(c, g, at);
        g->next[*n] = g->first[cell_at(g, c)];
        g->first[cell_at(g, c)] = (*n)++;
    }
}

/* Both sides of the sheet: enough to set the distance by. */
static double area_of(const struct plate *p)
{
    double holes = 0;
    const double x = 2 * p->half[0], y = 2 * p->half[1], r = p->round;

    for (uint32_t k = 0; k < p->n_holes; k++)
        holes += 3.14 * p->hole[k][2] * p->hole[k][2];
    return 2 * (x * y + 2 * r * (x + y) + 3.14 * r * r - holes);
}

int dx_implicit_sample(double *xyz, uint32_t *n, double *spacing, uint32_t max,
                       enum dx_surface surface, struct dx_rng *rng)
{
    const struct plate *p = surface == DX_SURFACE_PLATE ? &five_holes : &double_torus;
    struct grid g = {.low = {-p->half[0] - p->round, -p->half[1] - p->round, -THICKNESS}};
    size_t n_cells = 1;

    *spacing = sqrt(area_of(p) / max);
    g.side = sqrt(PACKING) * *spacing;
    for (int k = 0; k < 3; k++) {
        g.size[k] = (uint32_t)(-2 * g.low[k] / g.side) + 1;
        n_cells *= g.size[k];
    }
    g.first = malloc(n_cells * sizeof(*g.first));
    g.next = malloc(max * sizeof(*g.next));
    *n = 0;
    if (g.first && g.next) {
        for (size_t k = 0; k < n_cells; k++)
            g.first[k] = NONE;
        throw_darts(xyz, n, max, p, &g, rng);
    }
    free(g.first);
    free(g.next);
    return *n ? 0 : -ENOMEM;
}
