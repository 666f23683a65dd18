/* The plane of a reference point: predicates beside wide integers, order of angle, principal axes.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "core/base/rng.h"
#include "core/base/trig.h"
#include "core/cloud/flat_order.h"
#include "core/cloud/sym3.h"

#include <math.h>

/* Few values, so that points fall on common lines and circles; or many. */
static struct dx_flat draw(struct dx_rng *g, int32_t most)
{
    const uint32_t span = 2 * (uint32_t)most + 1;

    return (struct dx_flat){(int32_t)dx_rng_below(g, span) - most,
                            (int32_t)dx_rng_below(g, span) - most};
}

static int sign(__int128 x)
{
    return (x > 0) - (x < 0);
}

static void circles_are_exact(void **state)
{
    static const int32_t most[] = {4, 1000, 1 << 22, DX_FLAT_MAX - 1};
    struct dx_rng g = dx_rng_init(5, 0);
    uint32_t n_on = 0;

    (void)state;
    for (uint32_t k = 0; k < 400000; k++) {
        struct dx_flat a = draw(&g, most[k % 4]), b = draw(&g, most[k % 4]),
                       d = draw(&g, most[k % 4]);
        __int128 det;
        int in;

        if (dx_flat_cross(a, b) <= 0)
            continue;
        if (k % 8 == 3) /* the fourth corner of a square: on the circle, far from the origin */
            d = (struct dx_flat){a.x - a.y, a.y + a.x}, b = d, d = (struct dx_flat){-a.y, a.x};
        if (dx_flat_cross(a, b) <= 0 || d.x >= DX_FLAT_MAX || b.x >= DX_FLAT_MAX)
            continue;
        det = (__int128)dx_flat_dot(a, a) * dx_flat_cross(b, d) -
              (__int128)dx_flat_dot(b, b) * dx_flat_cross(a, d) +
              (__int128)dx_flat_dot(d, d) * dx_flat_cross(a, b);
        in = dx_flat_in_circle(a, b, d);
        n_on += in == 0;
        if (in != -sign(det))
            fail_msg("(%d %d) (%d %d) (%d %d)", a.x, a.y, b.x, b.y, d.x, d.y);
    }
    assert_true(n_on > 10000);
}

/* Angles of small vectors differ by far more than a double's rounding. */
static double angle(struct dx_flat a, struct dx_flat b)
{
    const double t = dx_atan2((double)dx_flat_cross(a, b), (double)dx_flat_dot(a, b));

    return t < -1e-12 ? t + 2 * DX_PI : t < 0 ? 0 : t;
}

static void sectors_hold_what_is_between(void **state)
{
    struct dx_rng g = dx_rng_init(6, 0);

    (void)state;
    for (uint32_t k = 0; k < 200000; k++) {
        const struct dx_flat a = draw(&g, 3), b = draw(&g, 3), d = draw(&g, 3);
        double end, at;

        if (!dx_flat_dot(a, a) || !dx_flat_dot(b, b) || !dx_flat_dot(d, d))
            continue;
        end = angle(a, b) < 1e-9 ? 2 * DX_PI : angle(a, b);
        at = angle(a, d);
        assert_int_equal(dx_flat_in_sector(a, b, d), at > 1e-9 && at < end - 1e-9);
    }
}

static void crossings_are_proper(void **state)
{
    const struct dx_flat o = {0, 0}, a = {4, 4}, b = {0, 4}, c = {4, 0}, m = {2, 2}, f = {1, 3};

    (void)state;
    assert_true(dx_flat_cross_inside(o, a, b, c));
    assert_false(dx_flat_cross_inside(o, a, b, m)); /* touches */
    assert_false(dx_flat_cross_inside(o, a, a, b)); /* shares an end */
    assert_false(dx_flat_cross_inside(o, m, m, a)); /* one line */
    assert_false(dx_flat_cross_inside(o, a, b, f));
    assert_false(dx_flat_cross_inside(o, b, c, a));
}

static void angles_are_ordered(void **state)
{
    struct dx_rng g = dx_rng_init(7, 0);
    const struct dx_flat x = {1, 0};

    (void)state;
    for (uint32_t round = 0; round < 4000; round++) {
        struct dx_angle v[24];
        uint32_t n = 0;

        while (n < 24) {
            const struct dx_flat p = draw(&g, round % 2 ? 3 : 1 << 22);

            if (p.x || p.y) {
                v[n] = (struct dx_angle){dx_angle_key(p), p, n};
                n++;
            }
        }
        dx_angle_sort(v, n);
        for (uint32_t k = 1; k < n; k++) {
            const double before = angle(x, v[k - 1].at), after = angle(x, v[k].at);
            const int64_t turn = dx_flat_cross(v[k - 1].at, v[k].at);

            assert_true(before < after + 1e-12);
            if (turn || dx_flat_dot(v[k - 1].at, v[k].at) < 0)
                continue;
            assert_true(dx_flat_dot(v[k - 1].at, v[k - 1].at) < dx_flat_dot(v[k].at, v[k].at) ||
                        (dx_flat_dot(v[k - 1].at, v[k - 1].at) == dx_flat_dot(v[k].at, v[k].at) &&
                         v[k - 1].number < v[k].number));
        }
    }
}

/* Directions that sin^2 cannot tell apart in a double. */
static void near_angles_are_ordered_exactly(void **state)
{
    const int32_t far = DX_FLAT_MAX - 8;
    struct dx_angle v[6];

    (void)state;
    for (int32_t k = 0; k < 6; k++) {
        const struct dx_flat p = {far + k, far - 5}; /* the farther in x, the flatter */

        v[k] = (struct dx_angle){dx_angle_key(p), p, (uint32_t)k};
    }
    dx_angle_sort(v, 6);
    for (uint32_t k = 0; k < 6; k++)
        assert_int_equal(v[k].number, 5 - k);
}

static void axes_are_principal(void **state)
{
    struct dx_rng g = dx_rng_init(8, 0);

    (void)state;
    for (uint32_t round = 0; round < 2000; round++) {
        struct dx_sym3 s;
        struct dx_eigen3 e;
        double size = 0;

        for (int k = 0; k < 6; k++) {
            s.m[k] = round % 5 == 0 && k != 3 ? 0 : dx_rng_normal(&g);
            size += fabs(s.m[k]);
        }
        dx_sym3_eigen(&e, &s);
        assert_true(e.value[0] <= e.value[1] && e.value[1] <= e.value[2]);
        for (int k = 0; k < 3; k++) {
            const double *v = e.vector[k], *m = s.m;
            const double mv[3] = {m[0] * v[0] + m[1] * v[1] + m[2] * v[2],
                                  m[1] * v[0] + m[3] * v[1] + m[4] * v[2],
                                  m[2] * v[0] + m[4] * v[1] + m[5] * v[2]};

            assert_true(fabs(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] - 1) < 1e-12);
            for (int i = 0; i < 3; i++)
                assert_true(fabs(mv[i] - e.value[k] * v[i]) < 1e-12 * (1 + size));
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(circles_are_exact),
        cmocka_unit_test(sectors_hold_what_is_between),
        cmocka_unit_test(crossings_are_proper),
        cmocka_unit_test(angles_are_ordered),
        cmocka_unit_test(near_angles_are_ordered_exactly),
        cmocka_unit_test(axes_are_principal),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
