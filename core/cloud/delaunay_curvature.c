/*
 * The curvature tensor at a point from its neighbours' normals, as Taubin (1995) has it: the
 * eigenvalues of the mean of k(v) v v^T over all directions v in the plane tell the principal
 * curvatures. A neighbour counts as much as the angle between those beside it. The curvature towards
 * one is half of what the paper prints, which would be that of a height.
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

void dx_star_curvature(double *least, double *most, const struct dx_star_site *site,
                       const double *quarter_turns)
{
    const uint32_t n = site->n;
    double xx = 0, xy = 0, yy = 0, before, here, half, root, k1, k2;

    if (n < 3) {
        *least = *most = 0;
        return;
    }
    before = angle_of(site->order[n - 1].key, quarter_turns) - 4;
    here = angle_of(site->order[0].key, quarter_turns);
    for (uint32_t k = 0; k < n; k++) {
        const struct dx_angle *a = &site->order[k];
        const double after = angle_of(site->order[k + 1 < n ? k + 1 : 0].key, quarter_turns) +
                             (k + 1 < n ? 0 : 4);
        const double x = a->at.x, y = a->at.y;
        const double w = (after - before) / 8 * site->candidate[a->number].curvature /
                         (x * x + y * y);

        xx += w * x * x;
        xy += w * x * y;
        yy += w * y * y;
        before = here;
        here = after;
    }
    half = (xx + yy) / 2;
    root = sqrt((xx - yy) * (xx - yy) / 4 + xy * xy);
    k1 = fabs(2 * half + 4 * root); /* 3 m1 - m2, where m1 and m2 are half + root and half - root */
    k2 = fabs(2 * half - 4 * root);
    *least = k1 < k2 ? k1 : k2;
    *most = k1 < k2 ? k2 : k1;
}
