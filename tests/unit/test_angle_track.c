/* The track of an encoder: angles between edges and a little on, doubt, thinning. */
#include "drivers/gpio/angle_track.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static struct dx_angle_track track;

static void stands_at(uint64_t t_ns, double counts, bool is_uncertain)
{
    struct dx_track_point p = dx_angle_track_at(&track, t_ns);

    if (p.counts < counts - 1e-9 || p.counts > counts + 1e-9)
        fail_msg("at %llu: %g, expected %g", (unsigned long long)t_ns, p.counts, counts);
    assert_int_equal(p.is_uncertain, is_uncertain);
}

static void runs_between_edges_and_a_little_on(void **state)
{
    (void)state;
    dx_angle_track_init(&track, 1000, 0.5, false);
    stands_at(1000, 0.5, false);
    stands_at(5000, 0.5, false);
    stands_at(999, 0.5, true); /* before the beginning */
    dx_angle_track_put(&track, 2000, 1, false);
    dx_angle_track_put(&track, 2100, 2, false);
    stands_at(2050, 1.5, false);
    stands_at(2100, 2, false);
    stands_at(2150, 2.5, false);
    stands_at(2300, 4, false); /* two periods */
    stands_at(2301, 4, true);  /* and no farther */
    dx_angle_track_know(&track, 2250);
    stands_at(2150, 2.5, false);
    stands_at(2240, 3, false); /* the next edge has not come: at most one count */
    dx_angle_track_know(&track, 9000);
    stands_at(9000, 3, false); /* it stands still */
    dx_angle_track_put(&track, 9100, 2, false);
    stands_at(9200, 2, false); /* it turned back: no speed */
    dx_angle_track_put(&track, 9300, 1, true);
    stands_at(9200, 1.5, true);
    stands_at(9350, 0.75, true);
    dx_angle_track_put(&track, 9290, 0, false); /* stamped before the last */
    stands_at(9300, 0, false);
}

static void forgets_the_oldest(void **state)
{
    (void)state;
    dx_angle_track_init(&track, 0, 0, false);
    for (uint64_t k = 1; k <= 3 * DX_ANGLE_TRACK_LEN; k++)
        dx_angle_track_put(&track, k * 10, (double)k, false);
    stands_at(30 * DX_ANGLE_TRACK_LEN, 3.0 * DX_ANGLE_TRACK_LEN, false);
    stands_at(20 * DX_ANGLE_TRACK_LEN + 15, 2.0 * DX_ANGLE_TRACK_LEN + 1.5, false);
    stands_at(20 * DX_ANGLE_TRACK_LEN, 2.0 * DX_ANGLE_TRACK_LEN + 1, true);
}

static void doubts_a_turn_that_was_wrong(void **state)
{
    (void)state;
    dx_angle_track_init(&track, 0, 0.5, false);
    for (uint64_t k = 1; k <= 30; k++) {
        if (k % 10 == 1)
            dx_angle_track_index(&track, k == 21);
        dx_angle_track_put(&track, k * 10, (double)k, false);
    }
    stands_at(55, 5.5, false);
    stands_at(125, 12.5, true); /* between the second and the third index */
    stands_at(205, 20.5, true);
    stands_at(215, 21.5, false);
}

static void thins_out_evenly(void **state)
{
    struct dx_track_point p[10];

    (void)state;
    dx_angle_track_init(&track, 0, 0, false);
    for (uint64_t k = 1; k <= 100; k++)
        dx_angle_track_put(&track, k * 10, (double)k, false);
    assert_int_equal(dx_angle_track_points(&track, 95, 905, p, 10), 10);
    assert_int_equal(p[0].host_ns, 95);
    assert_int_equal(p[9].host_ns, 905);
    for (int k = 0; k < 10; k++) {
        assert_true(p[k].counts == (double)p[k].host_ns / 10);
        assert_true(k == 0 ||
                    (p[k].host_ns > p[k - 1].host_ns && p[k].host_ns - p[k - 1].host_ns <= 115));
    }
    assert_int_equal(dx_angle_track_points(&track, 101, 121, p, 10), 4);
    assert_int_equal(p[1].host_ns, 110);
    assert_int_equal(p[2].host_ns, 120);
    assert_int_equal(dx_angle_track_points(&track, 101, 121, p, 2), 2);
    assert_int_equal(dx_angle_track_points(&track, 101, 101, p, 2), 1);
}

/* Edges that were put right lie at one instant: the last of them counts, and time ascends. */
static void points_ascend(void **state)
{
    struct dx_track_point p[10];
    size_t n;

    (void)state;
    dx_angle_track_init(&track, 0, 0, false);
    for (uint64_t k = 1; k <= 3; k++)
        dx_angle_track_put(&track, k * 10, (double)k, false);
    dx_angle_track_put(&track, 29, 2, true); /* late: it counts from 30 on */
    dx_angle_track_put(&track, 40, 3, true);
    n = dx_angle_track_points(&track, 5, 60, p, 10);
    for (size_t k = 1; k < n; k++)
        assert_true(p[k].host_ns > p[k - 1].host_ns);
    assert_int_equal(p[3].host_ns, 30);
    assert_true(p[3].counts == 2 && p[3].is_uncertain);
    n = dx_angle_track_points(&track, 30, 60, p, 10);
    assert_true(n >= 2 && p[1].host_ns > p[0].host_ns);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(runs_between_edges_and_a_little_on),
        cmocka_unit_test(forgets_the_oldest),
        cmocka_unit_test(doubts_a_turn_that_was_wrong),
        cmocka_unit_test(thins_out_evenly),
        cmocka_unit_test(points_ascend),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
