/* Ordering by angle. */
#include "core/cloud/flat_order.h"

#include <stdbool.h>

#define UNSURE 1e-12 /* keys this near may be in the wrong order: sin^2 rounds by 2^-52 */

/* 0 to 3 from the x axis on, which is in the first; without branches: which it is, cannot be
 * foretold. */
static int quadrant(struct dx_flat p)
{
    const int below = p.y < 0 || (p.y == 0 && p.x < 0);
    const int left = below ? p.x >= 0 : p.x <= 0;

    return 2 * below + left;
}

double dx_angle_key(struct dx_flat p)
{
    const double x = p.x, y = p.y, xx = x * x, yy = y * y;
    const int k = quadrant(p);

    /* sin^2 falls in the second and the fourth quadrant: there that of the angle from the y axis */
    return k + (k & 1 ? xx : yy) / (xx + yy);
}

/* Where the keys do not tell. */
static bool is_before_exactly(const struct dx_angle *a, const struct dx_angle *b)
{
    const int qa = quadrant(a->at), qb = quadrant(b->at);
    int64_t turn, aa, bb;

    if (qa != qb)
        return qa < qb;
    turn = dx_flat_cross(a->at, b->at);
    if (turn != 0)
        return turn > 0;
    aa = dx_flat_dot(a->at, a->at);
    bb = dx_flat_dot(b->at, b->at);
    return aa != bb ? aa < bb : a->number < b->number;
}

static inline bool is_before(const struct dx_angle *a, const struct dx_angle *b)
{
    const double d = a->key - b->key;

    return d < -UNSURE || (d <= UNSURE && is_before_exactly(a, b));
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
