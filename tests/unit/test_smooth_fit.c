/* The robust operator Q at one place (M1 to M3 of the design): its cost never grows, exact planes
 * are kept, rigid motions of the points move the result alike. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "core/base/rng.h"
#include "core/base/trig.h"
#include "core/cloud/smooth_fit.h"

#include <math.h>
#include <string.h>

#define SW 2.0

/* A patch of a sphere with R = 20, with noise; some points anywhere. */
static void draw(struct dx_robust_points *p, uint32_t n, double noise, double outliers,
                 uint64_t seed)
{
    struct dx_rng g = dx_rng_init(seed, n);

    p->n = n;
    for (uint32_t k = 0; k < n; k++) {
        const double r = 3 * SW * sqrt(dx_rng_unit(&g)), angle = 2 * DX_PI * dx_rng_unit(&g);

        p->x[k] = r * dx_cos(angle);
        p->y[k] = r * dx_sin(angle);
        p->z[k] = -r * r / 40 + noise * dx_rng_normal(&g);
        if (dx_rng_unit(&g) < outliers)
            p->z[k] = 12 * dx_rng_unit(&g) - 6;
    }
    dx_robust_weigh(p, SW);
}

static double cost(const struct dx_robust_points *p, const struct dx_robust_plane *plane, double sr)
{
    double f = 0;

    for (uint32_t k = 0; k < p->n; k++) {
        const double h = plane->normal[0] * p->x[k] + plane->normal[1] * p->y[k] +
                         plane->normal[2] * p->z[k] - plane->t;

        f += p->w[k] * (1 - dx_exp(-h * h / (2 * sr * sr)));
    }
    return f;
}

static void the_cost_never_grows(void **state)
{
    static const double noises[] = {0, 0.1, 0.3, 0.5}, widths[] = {0.3, 0.5, 1, 2};
    static struct dx_robust_points p;

    (void)state;
    for (uint64_t seed = 0; seed < 20; seed++)
        for (int i = 0; i < 4; i++)
            for (int j = 0; j < 4; j++) {
                struct dx_robust_plane plane = {.t = 0};
                double before;

                draw(&p, 30 + (uint32_t)seed, noises[i], 0.05, seed);
                assert_true(dx_robust_step(&plane, &p, 0));
                before = cost(&p, &plane, widths[j]);
                for (int step = 0; step < 12; step++) {
                    double after;

                    assert_true(dx_robust_step(&plane, &p, widths[j]));
                    after = cost(&p, &plane, widths[j]);
                    assert_true(after <= before + 1e-6);
                    before = after;
                }
            }
}

static void planes_are_kept(void **state)
{
    static const double n[3] = {2.0 / 7, -3.0 / 7, 6.0 / 7};
    static struct dx_robust_points p;

    (void)state;
    for (uint64_t seed = 0; seed < 20; seed++) {
        struct dx_rng g = dx_rng_init(seed, 1);
        struct dx_robust_plane plane;
        struct dx_robust_quadric q;
        uint32_t n_steps;

        p.n = 41;
        for (uint32_t k = 0; k < p.n; k++) {
            const double x = 8 * dx_rng_unit(&g) - 4, y = 8 * dx_rng_unit(&g) - 4;

            p.x[k] = x;
            p.y[k] = y;
            p.z[k] = -(n[0] * x + n[1] * y) / n[2];
        }
        dx_robust_weigh(&p, SW);
        assert_int_equal(dx_robust_plane(&plane, &n_steps, &p, SW, 0.5, DX_ROBUST_SETTLED),
                         DX_ROBUST_DONE);
        assert_true(fabs(plane.t) < 1e-12);
        assert_true(
            1 - fabs(n[0] * plane.normal[0] + n[1] * plane.normal[1] + n[2] * plane.normal[2]) <
            1e-12);
        assert_true(dx_robust_quadric(&q, &p, &plane, 0.5));
        assert_true(fabs(q.term[0]) < 1e-12);
    }
}

/* Turned about an axis by angles, none of which is special. */
static void turn(double v[3])
{
    static const double s[2] = {0.28, 0.6}, c[2] = {0.96, 0.8};

    for (size_t k = 0; k < 2; k++) {
        const double x = v[k], y = v[k + 1];

        v[k] = c[k] * x - s[k] * y;
        v[k + 1] = s[k] * x + c[k] * y;
    }
}

static void motions_move_the_result(void **state)
{
    static struct dx_robust_points p, moved;

    (void)state;
    for (uint64_t seed = 0; seed < 30; seed++) {
        struct dx_robust_plane a, b;
        struct dx_robust_quadric qa, qb;
        uint32_t n_steps;
        double dot = 0, v[3];

        draw(&p, 60, 0.3, 0.05, seed);
        moved.n = p.n;
        for (uint32_t k = 0; k < p.n; k++) {
            memcpy(v, (double[3]){p.x[k], p.y[k], p.z[k]}, sizeof(v));
            turn(v);
            moved.x[k] = v[0];
            moved.y[k] = v[1];
            moved.z[k] = v[2];
        }
        dx_robust_weigh(&moved, SW);
        assert_int_equal(dx_robust_plane(&a, &n_steps, &p, SW, 1, DX_ROBUST_SETTLED),
                         DX_ROBUST_DONE);
        assert_int_equal(dx_robust_plane(&b, &n_steps, &moved, SW, 1, DX_ROBUST_SETTLED),
                         DX_ROBUST_DONE);
        memcpy(v, a.normal, sizeof(v));
        turn(v);
        for (int k = 0; k < 3; k++)
            dot += v[k] * b.normal[k];
        assert_true(1 - fabs(dot) < 1e-9);
        assert_true(fabs(a.t - (dot < 0 ? -b.t : b.t)) < 1e-9);
        assert_true(dx_robust_quadric(&qa, &p, &a, 1) && dx_robust_quadric(&qb, &moved, &b, 1));
        assert_true(fabs(qa.term[0] - (dot < 0 ? -qb.term[0] : qb.term[0])) < 1e-9);
    }
}

/* What the plane takes away of a curved surface, the paraboloid gives back. */
static void paraboloids_are_exact(void **state)
{
    static struct dx_robust_points p;

    (void)state;
    for (uint64_t seed = 0; seed < 20; seed++) {
        struct dx_robust_plane plane = {.normal = {0, 0, 1}};
        struct dx_robust_quadric q;

        draw(&p, 60, 0, 0, seed);
        assert_true(dx_robust_step(&plane, &p, 1));
        assert_true(fabs(plane.t) > 0.05);
        plane = (struct dx_robust_plane){.normal = {0, 0, 1}};
        assert_true(dx_robust_quadric(&q, &p, &plane, 1));
        assert_true(fabs(q.term[0]) < 1e-9);
        assert_true(fabs(q.term[3] + 1.0 / 40) < 1e-9 && fabs(q.term[4]) < 1e-9);
    }
}

static void too_little_makes_no_plane(void **state)
{
    static struct dx_robust_points p;
    struct dx_robust_plane plane;
    uint32_t n_steps;

    (void)state;
    for (uint32_t n = 0; n < 3; n++) {
        draw(&p, n, 0, 0, 1);
        assert_int_equal(dx_robust_plane(&plane, &n_steps, &p, SW, 1, DX_ROBUST_SETTLED),
                         DX_ROBUST_NONE);
    }
    for (uint32_t n = 3; n < 40; n += 12)
        for (int line = 0; line < 2; line++) { /* one place, a line */
            p.n = n;
            for (uint32_t k = 0; k < n; k++) {
                p.x[k] = line * 0.1 * k;
                p.y[k] = line * 0.3 * k;
                p.z[k] = line * 0.2 * k;
            }
            dx_robust_weigh(&p, SW);
            assert_int_equal(dx_robust_plane(&plane, &n_steps, &p, SW, 1, DX_ROBUST_SETTLED),
                             DX_ROBUST_NONE);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_cost_never_grows),      cmocka_unit_test(planes_are_kept),
        cmocka_unit_test(motions_move_the_result),   cmocka_unit_test(paraboloids_are_exact),
        cmocka_unit_test(too_little_makes_no_plane),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
