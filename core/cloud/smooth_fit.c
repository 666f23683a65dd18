/* Planes by iterated weights. Sums run over lanes in a fixed order: the same bits everywhere. */
#include "core/cloud/smooth_fit.h"

#include "core/cloud/least_axis.h"
#include "core/cloud/smooth_lanes.h"

#include <math.h>

#define ANNEAL  0.6 /* sr of a step over that of the one before */
#define MIN_SUM 3.0 /* effective points */
#define N_SUMS  10  /* 1 x y z xx xy xz yy yz zz */

void dx_robust_weigh(struct dx_robust_points *p, double sw)
{
    const dx_lanes k = dx_lanes_all(1 / (2 * sw * sw)), one = dx_lanes_all(1);

    if (p->n % 2)
        p->x[p->n] = p->y[p->n] = p->z[p->n] = 0;
    for (uint32_t i = 0; i < p->n; i += 2) {
        const dx_lanes x = dx_lanes_at(p->x, i), y = dx_lanes_at(p->y, i), z = dx_lanes_at(p->z, i);

        dx_lanes_put(p->w, i, dx_lanes_times_exp_minus(one, k * (x * x + y * y + z * z)));
    }
    if (p->n % 2) /* a lane without a point */
        p->w[p->n] = 0;
}

/* Weights by the heights over a plane, and their sums; k is 1 / (2 sr^2). */
static void weigh_and_sum(double out[N_SUMS], struct dx_robust_points *p,
                          const struct dx_robust_plane *plane, double k)
{
    const dx_lanes nx = dx_lanes_all(plane->normal[0]), ny = dx_lanes_all(plane->normal[1]);
    const dx_lanes nz = dx_lanes_all(plane->normal[2]), t = dx_lanes_all(plane->t);
    const dx_lanes kk = dx_lanes_all(k);
    dx_lanes s[N_SUMS] = {{0}};

    for (uint32_t i = 0; i < p->n; i += 2) {
        const dx_lanes x = dx_lanes_at(p->x, i), y = dx_lanes_at(p->y, i), z = dx_lanes_at(p->z, i);
        const dx_lanes h = nx * x + ny * y + nz * z - t;
        const dx_lanes w = dx_lanes_times_exp_minus(dx_lanes_at(p->w, i), kk * h * h);
        const dx_lanes wx = w * x, wy = w * y, wz = w * z;

        dx_lanes_put(p->weight, i, w);
        s[0] += w;
        s[1] += wx;
        s[2] += wy;
        s[3] += wz;
        s[4] += wx * x;
        s[5] += wx * y;
        s[6] += wx * z;
        s[7] += wy * y;
        s[8] += wy * z;
        s[9] += wz * z;
    }
    for (int i = 0; i < N_SUMS; i++)
        out[i] = s[i][0] + s[i][1];
}

bool dx_robust_step(struct dx_robust_plane *plane, struct dx_robust_points *p, double sr)
{
    double s[N_SUMS], c[3], share;
    struct dx_sym3 m;

    if (!(sr > 0))
        *plane = (struct dx_robust_plane){.t = 0};
    weigh_and_sum(s, p, plane, sr > 0 ? 1 / (2 * sr * sr) : 0);
    plane->sum = s[0];
    if (!(s[0] > 0))
        return false;
    for (int k = 0; k < 3; k++)
        c[k] = s[1 + k] / s[0];
    for (int i = 0, k = 0; i < 3; i++)
        for (int j = i; j < 3; j++, k++)
            m.m[k] = s[4 + k] - s[1 + i] * c[j];
    if (!dx_least_axis(plane->normal, &share, &m))
        return false;
    plane->t = plane->normal[0] * c[0] + plane->normal[1] * c[1] + plane->normal[2] * c[2];
    return true;
}

/* The planes are the same but for rounding; that they may look to opposite sides does not count. */
static bool is_settled(const struct dx_robust_plane *a, const struct dx_robust_plane *b,
                       double dt_max)
{
    const double cos_between =
        a->normal[0] * b->normal[0] + a->normal[1] * b->normal[1] + a->normal[2] * b->normal[2];
    const double dt = cos_between < 0 ? a->t + b->t : a->t - b->t;

    return fabs(dt) < dt_max && 1 - fabs(cos_between) < dt_max * dt_max;
}

int dx_robust_plane(struct dx_robust_plane *plane, uint32_t *n_steps, struct dx_robust_points *p,
                    double sw, double sr, double settled)
{
    double s = 4 * sr > 3 * sw ? 4 * sr : 3 * sw, all;

    *n_steps = 1;
    if (p->n < 3 || !dx_robust_step(plane, p, 0))
        return DX_ROBUST_NONE;
    all = plane->sum;
    while (*n_steps < DX_ROBUST_MAX_STEPS) {
        const struct dx_robust_plane before = *plane;
        const bool is_last = s <= sr;

        ++*n_steps;
        if (!dx_robust_step(plane, p, is_last ? sr : s))
            return DX_ROBUST_NONE;
        if (is_last && is_settled(plane, &before, settled))
            break;
        s *= ANNEAL;
    }
    plane->share = plane->sum / all;
    return plane->sum < MIN_SUM ? DX_ROBUST_NONE : DX_ROBUST_DONE;
}
