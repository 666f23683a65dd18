/* The figures of a still scene, small enough to be quick: the bars of docs/terrain.md hold, and the
 * filter is what makes them hold. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "tools/quality_static.h"

#include <errno.h>

static void small(struct dx_quality_static_config *c)
{
    dx_quality_static_default(c);
    c->scene.height = 130;
    c->scene.width = 200;
    c->n_frames = 100;
}

static void the_bars_hold(void **state)
{
    struct dx_quality_static_config c;
    struct dx_quality_static q;

    (void)state;
    small(&c);
    assert_int_equal(dx_quality_static_run(&q, &c, NULL), 0);
    assert_int_equal(q.n_tiles, 12); /* 3 x 4 */
    assert_true(q.settling <= 0.15 && q.settled <= 0.02);
    assert_true(q.rms_sigma <= 0.25 && q.rms_sigma >= 0.1); /* 16 frames give 0.18 at best */
}

static void without_a_filter_every_tile_changes(void **state)
{
    struct dx_quality_static_config c;
    struct dx_quality_static q;

    (void)state;
    small(&c);
    c.params.ingest.filter = DX_FILTER_OFF;
    c.settled = 20;
    c.n_frames = 25;
    assert_int_equal(dx_quality_static_run(&q, &c, NULL), 0);
    assert_true(q.settling == 1 && q.settled == 1);
    assert_true(q.rms_sigma > 0.95 && q.rms_sigma < 1.05);
}

static void bad_configurations_are_refused(void **state)
{
    struct dx_quality_static_config c;
    struct dx_quality_static q;

    (void)state;
    small(&c);
    c.settled = c.warm;
    assert_int_equal(dx_quality_static_run(&q, &c, NULL), -EINVAL);
    small(&c);
    c.scene.width = 0;
    assert_int_equal(dx_quality_static_run(&q, &c, NULL), -EINVAL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_bars_hold),
        cmocka_unit_test(without_a_filter_every_tile_changes),
        cmocka_unit_test(bad_configurations_are_refused),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
