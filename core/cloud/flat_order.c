/* Ordering by angle. */
#include "core/cloud/flat_order.h"

#include <stdbool.h>

#define UNSURE 1e-12 /* keys this near may be in the wrong order: sin^2 rounds by 2^-52 */

static int quadrant(struct dx_flat p)
{
    if (p.x > 0 && p.y >= 0)
        return 0;
    if (p.x <= 0 && p.y > 0)
        return 1;
    return p.x < 0 ? 2 : 3;
}

double dx_angle_key(struct dx_flat p)
{
    const double x = p.x, y = p.y, rr = x * x + y * y;
    const int k = quadrant(p);

    /* sin^2 falls in the second and the fourth quadrant: there that of the angle from the y axis */
    return k + (k & 1 ? x * x : y * y) / rr;
}

static bool is_before(const struct dx_angle *a, const struct dx_angle *b)
{
    const double d = a->key - b->key;
    const int qa = quadrant(a->at), qb = quadrant(b->at);
    int64_t turn, aa, bb;

    if (d < -UNSURE || d > UNSURE)
        return d < 0;
    if (qa != qb)
        return qa < qb;
    turn = dx_flat_cross(a->at, b->at);
    if (turn != 0)
        return turn > 0;
    aa = dx_flat_dot(a->at, a->at);
    bb = dx_flat_dot(b->at, b->at);
    return aa != bb ? aa < bb : a->number < b->number;
}

void dx_angle_sort(struct dx_angle *v, uint32_t n)
{
    for (uint32_t k = 1; k < n; k++) {
        const struct dx_angle x = v[k];
        uint32_t j = k;

        for (; j > 0 && is_before(&x, &v[j - 1]); j--)
            v[j] = v[j - 1];
        v[j] = x;
    }
}
