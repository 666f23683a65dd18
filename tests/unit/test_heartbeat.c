/* Heartbeats: when a thread counts as hung, and that the waits of readers and meshers do not. */
#include "fake_driver.h"

#include "core/base/pool.h"
#include "daemon/clock.h"
#include "daemon/heartbeat.h"
#include "daemon/log.h"
#include "daemon/mesher.h"
#include "daemon/reader.h"
#include "daemon/server_priv.h"
#include "daemon/watchdog.h"

#include <pthread.h>
#include <sched.h>

#define SECOND 1000000000u
#define USUAL  (10ull * SECOND) /* without a service manager */

static void is_late_by_what_it_did_not_allow(void **state)
{
    struct dx_heartbeat h = {0};

    (void)state;
    assert_int_equal(dx_heartbeat_late_ns(&h, UINT64_MAX), 0); /* does not run */
    dx_heartbeat_beat(&h, 1000);
    assert_int_equal(dx_heartbeat_late_ns(&h, 900), 0); /* the loop looked at its clock before */
    assert_int_equal(dx_heartbeat_late_ns(&h, 1500), 500);
    dx_heartbeat_allow(&h, 1000, 700);
    assert_int_equal(dx_heartbeat_late_ns(&h, 1700), 0);
    assert_int_equal(dx_heartbeat_late_ns(&h, 2000), 300);
    dx_heartbeat_rest(&h);
    assert_int_equal(dx_heartbeat_late_ns(&h, UINT64_MAX), 0);
    dx_heartbeat_beat(NULL, 1);
    dx_heartbeat_rest(NULL);
}

/* ---- the watchdog ----------------------------------------------------------------------------
 */

struct bed {
    struct dx_heartbeats beats;
    struct dx_counters counters;
    struct dx_feed *feed;
    struct dx_server *server;
};

static void nothing(void *ctx)
{
    (void)ctx;
}

static void bed_open(struct bed *b)
{
    const struct dx_server_options options = {.signals = false};
    struct dx_server_stream_options stream = {.name = "t", .counters = &b->counters};
    struct dx_err err;

    *b = (struct bed){0};
    dx_log_set_level(-1);
    assert_int_equal(dx_server_new(&b->server, &options, &err), 0);
    assert_int_equal(dx_feed_new_sized(&b->feed, 4, 16, 16, 16, -1, nothing, NULL), 0);
    stream.feed = b->feed;
    stream.beats = &b->beats;
    assert_int_equal(dx_server_add_stream(b->server, &stream), 0);
}

static void bed_close(struct bed *b)
{
    dx_server_free(b->server);
    dx_feed_free(b->feed);
}

static bool is_well(struct bed *b, uint64_t now_ns)
{
    return dx_watchdog_look(b->server->watchdog, now_ns);
}

static void a_hung_thread_is_found_and_may_come_back(void **state)
{
    struct bed b;

    (void)state;
    bed_open(&b);
    assert_true(is_well(&b, UINT64_MAX)); /* nothing runs */
    for (int k = DX_BEAT_READER; k <= DX_BEAT_MESHER; k++) {
        dx_heartbeat_beat(&b.beats.of[k], SECOND);
        assert_true(is_well(&b, SECOND + USUAL));
        assert_false(is_well(&b, SECOND + USUAL + 1));
        assert_true(b.server->streams->hangs[k]);
        dx_heartbeat_beat(&b.beats.of[k], 2 * USUAL);
        assert_true(is_well(&b, 2 * USUAL));
        assert_false(b.server->streams->hangs[k]);
        dx_heartbeat_rest(&b.beats.of[k]);
        assert_true(is_well(&b, UINT64_MAX));
    }
    bed_close(&b);
}

/* It may wait for another stream's commit at the pool. */
static void a_mesher_has_the_time_of_all_grids(void **state)
{
    const uint64_t grid_ns = 1000ull * 2000 * DX_HEARTBEAT_DEXEL_NS;
    struct dx_geometry *g;
    struct bed b;

    (void)state;
    bed_open(&b);
    assert_int_equal(dx_geometry_new_pinhole(&g, 1000, 2000, 10, 10, 8, 4), 0);
    b.server->streams->loop->geometry = g;
    dx_heartbeat_beat(&b.beats.of[DX_BEAT_MESHER], SECOND);
    assert_true(is_well(&b, SECOND + USUAL + grid_ns));
    assert_false(is_well(&b, SECOND + USUAL + grid_ns + 1));
    bed_close(&b);
}

static void a_stuck_disk_is_told_and_no_fault_of_the_service(void **state)
{
    struct bed b;

    (void)state;
    bed_open(&b);
    dx_heartbeat_beat(&b.beats.of[DX_BEAT_RECORDER], SECOND);
    assert_true(is_well(&b, SECOND + USUAL + 1));
    assert_true(b.server->streams->hangs[DX_BEAT_RECORDER]);
    dx_heartbeat_rest(&b.beats.of[DX_BEAT_RECORDER]);
    assert_true(is_well(&b, SECOND + USUAL + 2));
    assert_false(b.server->streams->hangs[DX_BEAT_RECORDER]);
    bed_close(&b);
}

/* ---- threads that wait -----------------------------------------------------------------------
 */

static void *run_reader(void *reader)
{
    dx_stream_reader_run(reader);
    return NULL;
}

static void *run_mesher(void *mesher)
{
    dx_mesher_run(mesher);
    return NULL;
}

static uint64_t well_until(struct dx_heartbeat *h)
{
    return atomic_load(&h->well_until_ns);
}

/* Reads the fake device into a mailbox that nobody empties, if it is there. */
static void with_reader(bool lossless, bool present, void (*check)(struct dx_heartbeat *beat))
{
    struct dx_counters counters = {0};
    struct dx_heartbeat beat = {0};
    struct dx_stream_reader *reader;
    struct dx_mailbox *mailbox;
    struct dx_err err = {""};
    pthread_t thread;

    dx_log_set_level(-1);
    fake = (struct fake_world){.present = present};
    assert_int_equal(dx_mailbox_new(&mailbox, lossless, nothing, NULL), 0);
    assert_int_equal(
        dx_stream_reader_new(&reader, "t", &fake_driver, NULL, mailbox, &counters, &err), 0);
    dx_stream_reader_watch(reader, &beat);
    assert_int_equal(pthread_create(&thread, NULL, run_reader, reader), 0);
    check(&beat);
    dx_mailbox_close(mailbox);
    dx_stream_reader_stop(reader);
    pthread_join(thread, NULL);
    assert_int_equal(well_until(&beat), 0); /* ended */
    dx_stream_reader_free(reader);
    dx_mailbox_free(mailbox);
}

/* Each of these ends when the thread is where it is to be; else the test runs out of time. */
static void until_it_waits_for_its_device(struct dx_heartbeat *beat)
{
    while (fake.n_opens || well_until(beat) < dx_clock_ns() + DX_LIFE_LOOK_NS - SECOND)
        sched_yield();
}

static void until_it_goes_on(struct dx_heartbeat *beat)
{
    for (int k = 0; k < 5; k++) {
        uint64_t before = well_until(beat);

        while (well_until(beat) == before)
            sched_yield();
    }
}

static void until_it_rests(struct dx_heartbeat *beat)
{
    while (fake.n_opens == 0 || well_until(beat) != 0)
        sched_yield();
}

static void a_reader_that_waits_is_well(void **state)
{
    (void)state;
    with_reader(false, false, until_it_waits_for_its_device);
    with_reader(false, true, until_it_goes_on); /* live it waits for nobody */
    with_reader(true, true, until_it_rests);
}

static void a_mesher_that_waits_is_well(void **state)
{
    struct dx_heartbeat beat = {.well_until_ns = 1};
    struct dx_mesher_config config = {.name = "t", .max_tiles = 4, .beat = &beat};
    struct dx_counters counters = {0};
    struct dx_mailbox *mailbox;
    struct dx_mesher *mesher;
    struct dx_feed *feed;
    pthread_t thread;

    (void)state;
    assert_int_equal(dx_mailbox_new(&mailbox, false, nothing, NULL), 0);
    assert_int_equal(dx_feed_new_sized(&feed, 4, 16, 16, 16, -1, nothing, NULL), 0);
    assert_int_equal(dx_mesher_new(&mesher, &config, mailbox, feed, &counters, NULL), 0);
    assert_int_equal(pthread_create(&thread, NULL, run_mesher, mesher), 0);
    while (well_until(&beat) != 0)
        sched_yield();
    dx_mesher_stop(mesher);
    pthread_join(thread, NULL);
    assert_int_equal(well_until(&beat), 0);
    dx_mesher_free(mesher);
    dx_feed_free(feed);
    dx_mailbox_free(mailbox);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(is_late_by_what_it_did_not_allow),
        cmocka_unit_test(a_hung_thread_is_found_and_may_come_back),
        cmocka_unit_test(a_mesher_has_the_time_of_all_grids),
        cmocka_unit_test(a_stuck_disk_is_told_and_no_fault_of_the_service),
        cmocka_unit_test(a_reader_that_waits_is_well),
        cmocka_unit_test(a_mesher_that_waits_is_well),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
