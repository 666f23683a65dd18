/* The predicates that are too long for a header. */
#include "core/cloud/predicates.h"

#include <math.h>

bool dx_flat_in_sector(struct dx_flat a, struct dx_flat b, struct dx_flat d)
{
    const int64_t turn = dx_flat_cross(a, b);
    const int64_t after_a = dx_flat_cross(a, d), before_b = dx_flat_cross(d, b);

    if (turn > 0)
        return after_a > 0 && before_b > 0;
    if (turn < 0) /* the rest is less than half a turn */
        return after_a > 0 || before_b > 0;
    if (dx_flat_dot(a, b) < 0) /* half a turn */
        return after_a > 0;
    return after_a != 0 || dx_flat_dot(a, d) < 0;
}

/*
 * The sign of the determinant of rows (x, y, x^2 + y^2), which have up to 120 bits. In doubles its
 * error is below the bound: each coordinate is exact, cross products and squares round once or
 * twice, products and sums four times, each by 2^-53 of their size.
 */
int dx_flat_in_circle(struct dx_flat a, struct dx_flat b, struct dx_flat d)
{
    const double ax = a.x, ay = a.y, bx = b.x, by = b.y, dx = d.x, dy = d.y;
    const double aa = ax * ax + ay * ay, bb = bx * bx + by * by, dd = dx * dx + dy * dy;
    const double bd = bx * dy - by * dx, ad = ax * dy - ay * dx, ab = ax * by - ay * bx;
    const double det = aa * bd - bb * ad + dd * ab;
    const double size = aa * (fabs(bx * dy) + fabs(by * dx)) +
                        bb * (fabs(ax * dy) + fabs(ay * dx)) + dd * (fabs(ax * by) + fabs(ay * bx));
    __int128 exact;

    /* the determinant is positive outside: the origin is one of the three */
    if (fabs(det) > 0x1p-49 * size)
        return det > 0 ? -1 : 1;
    exact = (__int128)dx_flat_dot(a, a) * dx_flat_cross(b, d) -
            (__int128)dx_flat_dot(b, b) * dx_flat_cross(a, d) +
            (__int128)dx_flat_dot(d, d) * dx_flat_cross(a, b);
    return exact > 0 ? -1 : exact < 0;
}
