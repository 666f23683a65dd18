/*
 * Brown's model, there and back. The way back has no closed form: Newton's, led from the middle of
 * the image outwards so that it stays on the branch that the lens has.
 *
 * Why a table of ranges and not of depths when the lens is bent: the points would be right with
 * directions (x, y, 1), but the rules of the terrain take the inverse of what a table's dexel holds
 * for linear in the unit direction (core/grid/lines.h), which is so of ranges only.
 */
#include "drivers/lens.h"

#include <errno.h>
#include <math.h>

#define LEGS      4  /* from the middle to the pixel */
#define MAX_STEPS 20 /* of Newton's in each; six are usual */
#define CLOSE     1e-13
#define TESTED    128 /* rows, and columns */

bool dx_lens_is_straight(const struct dx_lens *lens)
{
    return lens->k1 == 0 && lens->k2 == 0 && lens->p1 == 0 && lens->p2 == 0 && lens->k3 == 0;
}

void dx_lens_settle(struct dx_lens *lens, uint32_t height, uint32_t width)
{
    if (lens->fy == 0)
        lens->fy = lens->fx;
    if (lens->cx == DX_LENS_CENTRE)
        lens->cx = (width - 1.0) / 2;
    if (lens->cy == DX_LENS_CENTRE)
        lens->cy = (height - 1.0) / 2;
}

void dx_lens_distort(const struct dx_lens *lens, const double ray[2], double bent[2])
{
    double x = ray[0], y = ray[1], r2 = x * x + y * y;
    double radial = 1 + r2 * (lens->k1 + r2 * (lens->k2 + r2 * lens->k3));

    bent[0] = x * radial + 2 * lens->p1 * x * y + lens->p2 * (r2 + 2 * x * x);
    bent[1] = y * radial + lens->p1 * (r2 + 2 * y * y) + 2 * lens->p2 * x * y;
}

/* Derivatives of dx_lens_distort(): d bent[0] / d x, d bent[0] / d y = d bent[1] / d x, d bent[1] /
 * d y. */
static void slopes(const struct dx_lens *lens, const double ray[2], double d[3])
{
    double x = ray[0], y = ray[1], r2 = x * x + y * y;
    double radial = 1 + r2 * (lens->k1 + r2 * (lens->k2 + r2 * lens->k3));
    double by_r2 = lens->k1 + r2 * (2 * lens->k2 + r2 * 3 * lens->k3);

    d[0] = radial + 2 * x * x * by_r2 + 2 * lens->p1 * y + 6 * lens->p2 * x;
    d[1] = 2 * x * y * by_r2 + 2 * lens->p1 * x + 2 * lens->p2 * y;
    d[2] = radial + 2 * y * y * by_r2 + 6 * lens->p1 * y + 2 * lens->p2 * x;
}

/* From a ray near by to the one that is bent to (x, y). */
static int approach(const struct dx_lens *lens, double x, double y, double ray[2])
{
    for (int k = 0; k < MAX_STEPS; k++) {
        double bent[2], d[3], det, off[2];

        dx_lens_distort(lens, ray, bent);
        slopes(lens, ray, d);
        off[0] = bent[0] - x;
        off[1] = bent[1] - y;
        det = d[0] * d[2] - d[1] * d[1];
        if (!(det > 0 && d[0] > 0))
            return -ERANGE; /* where the image folds over, and beyond */
        if (fabs(off[0]) < CLOSE && fabs(off[1]) < CLOSE)
            return 0;
        ray[0] -= (d[2] * off[0] - d[1] * off[1]) / det;
        ray[1] -= (d[0] * off[1] - d[1] * off[0]) / det;
    }
    return -ERANGE;
}

int dx_lens_ray(const struct dx_lens *lens, double row, double col, double ray[2])
{
    double x = (col - lens->cx) / lens->fx, y = (row - lens->cy) / lens->fy;
    int r = 0;

    ray[0] = ray[1] = 0;
    if (dx_lens_is_straight(lens)) {
        ray[0] = x;
        ray[1] = y;
        return 0;
    }
    for (int leg = 1; leg <= LEGS && r == 0; leg++)
        r = approach(lens, x * leg / LEGS, y * leg / LEGS, ray);
    return r;
}

/* The ray of a pixel, from that of the one to its left, which is near; column 0 from nothing. */
static int next_ray(const struct dx_lens *lens, uint32_t i, uint32_t j, double ray[2])
{
    if (j > 0 && approach(lens, (j - lens->cx) / lens->fx, (i - lens->cy) / lens->fy, ray) == 0)
        return 0;
    return dx_lens_ray(lens, i, j, ray);
}

static int folds(const struct dx_lens *lens, uint32_t i, uint32_t j, struct dx_err *err)
{
    return dx_err_set(err, -EINVAL,
                      "the lens folds the image before pixel (%u, %u): k1 %g, k2 %g, p1 %g, p2 %g, "
                      "k3 %g",
                      j, i, lens->k1, lens->k2, lens->p1, lens->p2, lens->k3);
}

/* From one tested row or column to the next, and to the last. */
static uint32_t next_tested(uint32_t k, uint32_t n)
{
    uint32_t step = n / TESTED + 1;

    return k + step < n || k + 1 == n ? k + step : n - 1;
}

int dx_lens_check(const struct dx_lens *lens, uint32_t height, uint32_t width, struct dx_err *err)
{
    struct dx_lens l = *lens;
    double ray[2];

    dx_lens_settle(&l, height, width);
    if (dx_lens_is_straight(&l))
        return 0;
    for (uint32_t i = 0; i < height; i = next_tested(i, height))
        for (uint32_t j = 0; j < width; j = next_tested(j, width))
            if (dx_lens_ray(&l, i, j, ray))
                return folds(&l, i, j, err);
    return 0;
}

static int fill_table(struct dx_geometry *g, const struct dx_lens *lens, struct dx_err *err)
{
    float *d = g->table;

    for (uint32_t i = 0; i < g->height; i++) {
        double ray[2] = {0, 0};

        for (uint32_t j = 0; j < g->width; j++, d += 3) {
            double len;

            if (next_ray(lens, i, j, ray))
                return folds(lens, i, j, err);
            len = sqrt(ray[0] * ray[0] + ray[1] * ray[1] + 1);
            d[0] = (float)(ray[0] / len);
            d[1] = (float)(ray[1] / len);
            d[2] = (float)(1 / len);
        }
    }
    dx_geometry_orient(g);
    return 0;
}

int dx_lens_geometry(struct dx_geometry **out, const struct dx_lens *lens, uint32_t height,
                     uint32_t width, struct dx_err *err)
{
    struct dx_lens l = *lens;
    int r;

    dx_lens_settle(&l, height, width);
    if (!(l.fx > 0 && l.fy > 0))
        return dx_err_set(err, -EINVAL, "focal lengths %g and %g, expected more than 0", l.fx,
                          l.fy);
    if (dx_lens_is_straight(&l))
        r = dx_geometry_new_pinhole(out, height, width, l.fx, l.fy, l.cx, l.cy);
    else
        r = dx_geometry_new(out, DX_MODEL_TABLE, height, width);
    if (r)
        return dx_err_set(err, r, r == -ENOMEM ? "no memory for %ux%u dexels" : "%ux%u dexels",
                          width, height);
    if ((*out)->model == DX_MODEL_TABLE)
        r = fill_table(*out, &l, err);
    if (r) {
        dx_geometry_unref(*out);
        *out = NULL;
    }
    return r;
}

void dx_lens_stretch(float *stretch, const struct dx_geometry *g)
{
    size_t n = (size_t)g->height * g->width;

    for (size_t k = 0; k < n; k++)
        stretch[k] = (float)(1 / (double)g->table[3 * k + 2]);
}
