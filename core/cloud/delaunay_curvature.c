/*
 * The curvature tensor at a point from its neighbours' normals, as Taubin (1995) has it: the
 * eigenvalues of the mean of k(v) v v^T over all directions v in the plane tell the principal
 * curvatures. A neighbour counts as much as the angle between those beside it. The curvature
 * towards one is half of what the paper prints, which would be that of a height.
 */
#include "core/base/trig.h"
#include "core/cloud/delaunay_priv.h"

#include <math.h>

void dx_star_angles(double quarter_turns[DX_STAR_N_ANGLES])
{
    for (int k = 0; k < DX_STAR_N_ANGLES; k++) {
        const double s = k / (double)(DX_STAR_N_ANGLES - 1);

        quarter_turns[k] = dx_atan2(sqrt(s), sqrt(1 - s)) * (2 / DX_PI);
    }
}

/* In quarter turns, of a key: the quadrant, and sin^2 in it, by the paper's table. */
static double angle_of(double key, const double *quarter_turns)
{
    const int quadrant = (int)key;
    const double s = (key - quadrant) * (DX_STAR_N_ANGLES - 1);
    const int cell = (int)s;

    if (cell >= DX_STAR_N_ANGLES - 1)
        return quadrant + 1;
    return quadrant + quarter_turns[cell] +
           (s - cell) * (quarter_turns[cell + 1] - quarter_turns[cell]);
}

/* Normal curvature from the reference point towards a candidate. */
static double curvature(const struct dx_star_site *site, const struct dx_delaunay_run *run,
                        uint32_t rank)
{
    const int32_t *p = site->plane.at, *q = run->cloud->at[rank];
    const float *m = run->normals[rank];
    double bend = 0, d2 = 0;

    for (int k = 0; k < 3; k++) {
        const double d = q[k] - p[k];

        bend += (site->plane.n[k] - (double)m[k]) * d;
        d2 += d * d;
    }
    return bend / d2;
}

void dx_star_curvature(double *least, double *most, const struct dx_star_site *site,
                       const struct dx_delaunay_run *run)
{
    const uint32_t n = site->n;
    double xx = 0, xy = 0, yy = 0, before, here, root, k1, k2;

    *least = *most = 0;
    if (n < 3)
        return;
    before = angle_of(dx_angle_key(site->at[n - 1]), run->quarter_turns) - 4;
    here = angle_of(dx_angle_key(site->at[0]), run->quarter_turns);
    for (uint32_t k = 0; k < n; k++) {
        const bool last = k + 1 == n;
        const double after = angle_of(dx_angle_key(site->at[last ? 0 : k + 1]), run->quarter_turns);
        const double x = site->at[k].x, y = site->at[k].y;
        const double w = (after + (last ? 4 : 0) - before) / 8 *
                         curvature(site, run, site->rank[k]) / (x * x + y * y);

        xx += w * x * x;
        xy += w * x * y;
        yy += w * y * y;
        before = here;
        here = after;
    }
    root = sqrt((xx - yy) * (xx - yy) / 4 + xy * xy);
    /* 3 m1 - m2 and 3 m2 - m1, where m1 and m2 are (xx + yy) / 2 + root and - root */
    k1 = fabs(xx + yy + 4 * root);
    k2 = fabs(xx + yy - 4 * root);
    *least = k1 < k2 ? k1 : k2;
    *most = k1 < k2 ? k2 : k1;
}
