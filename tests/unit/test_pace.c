/* The pace of replays: waiting, waking, stamps. */
#include "file_fixture.h"

#include "drivers/monotonic.h"
#include "drivers/replay.h"

#include <errno.h>
#include <pthread.h>

static void *wake_it(void *arg)
{
    dx_file_driver.wake(arg);
    return NULL;
}

/* At one frame in 1000 s the second is never due: only a wake ends the wait, and nothing is lost.
 */
static void waits_and_wakes(void **state)
{
    char *folder = make_folder();
    struct dx_file_config config = file_config(folder);
    struct dx_device *dev;
    struct kept k = {0};
    pthread_t thread;

    (void)state;
    write_scan(folder, "a.ptx", 0, 5, 0);
    write_scan(folder, "b.ptx", 0, 5, 0);
    config.rate = 1;
    config.fps = 0.001;
    dev = open_device(&config);
    expect_step(dev, &k, 0, "");
    assert_int_equal(pthread_create(&thread, NULL, wake_it, dev), 0);
    expect_step(dev, &k, DX_DRIVER_E_AGAIN, "");
    pthread_join(thread, NULL);
    dx_file_driver.wake(dev); /* before the wait: it ends at once */
    expect_step(dev, &k, DX_DRIVER_E_AGAIN, "");
    dx_file_driver.start(dev, NULL); /* begins anew: what was waited for is due */
    expect_step(dev, &k, 0, "");
    assert_int_equal(k.part.frame, 1);
    expect_step(dev, &k, DX_DRIVER_E_EOF, "");
    close_device(dev);
    kept_fini(&k);
    remove_folder(folder);
}

static void paces_by_stamps(void **state)
{
    uint64_t begin = dx_clock_ns();
    struct dx_pace p;

    (void)state;
    assert_int_equal(dx_pace_init(&p, 100), 0);
    for (uint64_t n = 0; n <= 5; n++)
        assert_int_equal(dx_pace_wait(&p, 7000000000u + n * 100000000), 0);
    assert_true(dx_clock_ns() - begin >= 5000000); /* 0.5 s at 100 times */
    assert_int_equal(dx_pace_wait(&p, 0), 0);      /* the past is due */
    dx_pace_fini(&p);
    assert_int_equal(dx_pace_init(&p, 0), 0);
    assert_int_equal(dx_pace_wait(&p, 0), 0);
    assert_int_equal(dx_pace_wait(&p, UINT64_MAX), 0);
    dx_pace_fini(&p);
    assert_int_equal(dx_pace_init(&p, -1), -EINVAL);
    dx_pace_fini(&p);
}

/* ---- real scans -------------------------------------------------------------------------------
 */

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(waits_and_wakes),
        cmocka_unit_test(paces_by_stamps),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
