/*
 * The reader's thread with a device that comes and goes: what subscribers are told, frames that go
 * on upwards, what is left behind, and stopping at any moment.
 */
#include "fake_driver.h"

#include "daemon/block_ring.h"
#include "daemon/clock.h"
#include "daemon/log.h"
#include "daemon/reader.h"

#include <dirent.h>
#include <malloc.h>
#include <pthread.h>
#include <semaphore.h>

#define JOIN_S 20 /* less than the least wait that a stop could sit through */

/* The test's thread is the mesher. */
struct rig {
    struct dx_mailbox *mailbox;
    struct dx_stream_reader *reader;
    struct dx_counters counters;
    pthread_t thread;
    sem_t mail;
    unsigned n_geometries, n_frames;
    bool any_frame;
    uint64_t frame; /* the newest */
    bool told[DX_STREAM_FAULTED + 1];
    char reason[DX_WIRE_TEXT]; /* of the last state */
};

static void on_mail(void *rig)
{
    struct rig *r = rig;

    sem_post(&r->mail);
}

static void *run(void *rig)
{
    struct rig *r = rig;

    dx_stream_reader_run(r->reader);
    return NULL;
}

static void start(struct rig *r)
{
    struct dx_err err = {""};

    *r = (struct rig){0};
    dx_log_set_level(-1);
    sem_init(&r->mail, 0, 0);
    assert_int_equal(dx_mailbox_new(&r->mailbox, false, on_mail, r), 0);
    assert_int_equal(
        dx_stream_reader_new(&r->reader, "t", &fake_driver, NULL, r->mailbox, &r->counters, &err),
        0);
    assert_int_equal(pthread_create(&r->thread, NULL, run, r), 0);
}

static void join(struct rig *r)
{
    struct timespec due;

    dx_mailbox_close(r->mailbox);
    dx_stream_reader_stop(r->reader);
    clock_gettime(CLOCK_REALTIME, &due);
    due.tv_sec += JOIN_S;
    assert_int_equal(pthread_timedjoin_np(r->thread, NULL, &due), 0);
    assert_int_equal(fake.n_open, 0);
    dx_stream_reader_free(r->reader);
    dx_mailbox_free(r->mailbox);
    sem_destroy(&r->mail);
    fake = (struct fake_world){0};
}

static void take(struct rig *r)
{
    struct dx_mail_item item;

    sem_wait(&r->mail);
    while (dx_mailbox_take(r->mailbox, &item) != DX_MAIL_NONE) {
        if (item.kind == DX_MAIL_GEOMETRY) {
            dx_geometry_unref(item.geometry);
            r->n_geometries++;
        } else if (item.kind == DX_MAIL_STATE) {
            r->told[item.state] = true;
            memcpy(r->reason, item.reason, sizeof(r->reason));
        } else {
            assert_true(!r->any_frame || item.frame >= r->frame);
            r->any_frame = true;
            r->frame = item.frame;
            r->n_frames += item.complete;
            dx_mailbox_release(r->mailbox);
        }
    }
}

/* Until subscribers are told that it is so. */
static void await(struct rig *r, enum dx_stream_state state)
{
    memset(r->told, 0, sizeof(r->told));
    while (!r->told[state])
        take(r);
}

static struct dx_reader_device_status status(struct rig *r)
{
    struct dx_reader_device_status s;

    dx_reader_device_status(dx_stream_reader_attached(r->reader), &s);
    return s;
}

static void poke(struct rig *r)
{
    dx_reader_device_poke(dx_stream_reader_attached(r->reader));
}

static unsigned n_entries(const char *folder)
{
    DIR *d = opendir(folder);
    unsigned n = 0;

    assert_non_null(d);
    while (readdir(d))
        n++;
    closedir(d);
    return n;
}

static void a_hundred_unpluggings_leave_nothing_behind(void **state)
{
    struct dx_reader_device_status s;
    unsigned n_fds, n_threads;
    size_t n_bytes;
    struct rig r;

    (void)state;
    fake.present = true;
    start(&r); /* once: the first thread makes ThreadSanitizer start one of its own */
    await(&r, DX_STREAM_LIVE);
    join(&r);
    n_fds = n_entries("/proc/self/fd");
    n_threads = n_entries("/proc/self/task");
    n_bytes = mallinfo2().uordblks;
    fake.present = true;
    start(&r);
    await(&r, DX_STREAM_LIVE);
    for (unsigned k = 0; k < 100; k++) {
        uint64_t frame = r.frame;

        fake.present = false;
        poke(&r);
        await(&r, DX_STREAM_GONE);
        if (strcmp(r.reason, "no fake is attached")) /* it may have been looked for since */
            assert_string_equal(r.reason, "the fake was unplugged");
        fake.present = true;
        poke(&r);
        poke(&r);
        await(&r, DX_STREAM_LIVE);
        assert_true(r.frame > frame || k == 0);
    }
    s = status(&r);
    assert_int_equal(s.state, DX_LIFE_STREAMING);
    assert_int_equal(s.n_opens, 101);
    assert_int_equal(s.n_went, 100);
    assert_int_equal(s.n_faults, 0);
    assert_true(s.health.n_lost >= 300);
    assert_string_equal(s.health.serial, "F0");
    assert_int_equal(r.n_geometries, 1);
    assert_int_equal(dx_get(&r.counters.n_corrupt), 0);
    join(&r);
    assert_int_equal(n_entries("/proc/self/fd"), n_fds);
    assert_int_equal(n_entries("/proc/self/task"), n_threads);
    /* free() keeps some for the next malloc(); 60 bytes a stay would show */
    assert_true(mallinfo2().uordblks < n_bytes + 6000);
}

/* Lines of standard error while a device flaps: a few, and how many there would have been. */
static void a_flapping_device_does_not_flood_the_log(void **state)
{
    FILE *log = tmpfile();
    int saved = dup(STDERR_FILENO);
    uint64_t start_ns = dx_clock_ns(), passed_s;
    unsigned n_lines = 0, n_unsaid = 0;
    char line[1200];
    struct rig r;

    (void)state;
    assert_non_null(log);
    assert_true(dup2(fileno(log), STDERR_FILENO) >= 0);
    fake.present = true;
    start(&r);
    dx_log_set_level(LOG_INFO);
    for (unsigned k = 0; k < 10; k++) {
        await(&r, DX_STREAM_LIVE);
        fake.present = false;
        await(&r, DX_STREAM_GONE);
        fake.present = true;
        poke(&r);
    }
    join(&r);
    dx_log_set_level(-1);
    passed_s = (dx_clock_ns() - start_ns) / 1000000000u;
    assert_true(dup2(saved, STDERR_FILENO) >= 0);
    close(saved);
    rewind(log);
    while (fgets(line, sizeof(line), log)) {
        n_lines += strstr(line, "reader: t: ") != NULL;
        n_unsaid += strstr(line, "left out") != NULL;
    }
    fclose(log);
    assert_true(n_lines >= 6);
    assert_true(n_lines <= 6 + 1 + passed_s / 10);
    assert_true(n_unsaid <= n_lines - 6);
}

static void another_geometry_is_told(void **state)
{
    struct rig r;

    (void)state;
    fake.present = true;
    start(&r);
    await(&r, DX_STREAM_LIVE);
    fake.present = false;
    await(&r, DX_STREAM_GONE);
    fake.variant = 1;
    fake.serial = 1;
    fake.present = true;
    poke(&r);
    await(&r, DX_STREAM_LIVE);
    assert_int_equal(r.n_geometries, 2);
    assert_string_equal(status(&r).health.serial, "F1");
    join(&r);
}

static void silence_is_told_and_its_end(void **state)
{
    struct rig r;

    (void)state;
    fake.present = true;
    start(&r);
    await(&r, DX_STREAM_LIVE);
    fake.silent = true;
    await(&r, DX_STREAM_STALLED);
    assert_non_null(strstr(r.reason, "no data for"));
    assert_int_equal(status(&r).n_stalls, 1);
    fake.silent = false;
    await(&r, DX_STREAM_LIVE);
    assert_int_equal(status(&r).n_opens, 1);
    join(&r);
}

/* Silence of another kind: somebody should look at the cable, not at the switch. */
static void damage_alone_is_told_as_that(void **state)
{
    struct rig r;

    (void)state;
    fake.present = true;
    start(&r);
    await(&r, DX_STREAM_LIVE);
    fake.spoils = true;
    fake.silent = true;
    await(&r, DX_STREAM_STALLED);
    assert_non_null(strstr(r.reason, "nothing but damaged data: "));
    assert_string_equal(status(&r).reason, r.reason);
    await(&r, DX_STREAM_FAULTED);
    assert_non_null(strstr(r.reason, "nothing but damaged data: "));
    fake.spoils = false;
    do
        await(&r, DX_STREAM_STALLED); /* opened anew: now it is silent */
    while (!strstr(r.reason, "no data for"));
    join(&r);
}

/* A device that must be waited for is not there until it is, and the wait shows nobody anything. */
static void one_that_is_not_reached_is_waited_for(void **state)
{
    struct rig r;

    (void)state;
    fake.present = fake.distant = true;
    start(&r);
    while (!fake.n_open)
        sched_yield();
    assert_int_equal(status(&r).n_opens, 0);
    poke(&r);
    fake.distant = false;
    await(&r, DX_STREAM_LIVE);
    assert_int_equal(status(&r).n_opens, 1);
    assert_int_equal(fake.n_opens, 1);
    fake.present = false;
    await(&r, DX_STREAM_GONE);
    fake.present = fake.distant = true;
    poke(&r);
    while (!fake.n_open)
        sched_yield();
    assert_int_equal(status(&r).state, DX_LIFE_GONE);
    fake.present = false; /* and is not there after all */
    while (fake.n_open)
        sched_yield();
    assert_int_equal(status(&r).n_opens, 1);
    join(&r);
}

static void a_fault_is_told_and_tried_again(void **state)
{
    struct rig r;

    (void)state;
    fake.present = true;
    fake.open_error = -EACCES;
    start(&r);
    await(&r, DX_STREAM_FAULTED);
    assert_string_equal(r.reason, "fake: Permission denied");
    assert_int_equal(status(&r).state, DX_LIFE_FAULTED);
    assert_int_equal(status(&r).n_opens, 0);
    fake.open_error = 0;
    await(&r, DX_STREAM_LIVE);
    fake.read_error = -EIO;
    await(&r, DX_STREAM_FAULTED);
    fake.read_error = 0;
    await(&r, DX_STREAM_LIVE);
    assert_true(status(&r).n_faults >= 2);
    assert_string_equal(status(&r).reason, "");
    join(&r);
}

static void stops_at_once_in_any_state(void **state)
{
    struct rig r;

    (void)state;
    start(&r); /* absent: it would look in 30 s */
    await(&r, DX_STREAM_GONE);
    assert_string_equal(r.reason, "no fake is attached");
    assert_int_equal(status(&r).state, DX_LIFE_ABSENT);
    join(&r);
    fake.present = fake.silent = true; /* opening */
    start(&r);
    while (!fake.n_open)
        sched_yield();
    join(&r);
    fake.present = fake.distant = true; /* not reached */
    start(&r);
    while (!fake.n_open)
        sched_yield();
    join(&r);
    fake.present = true;
    start(&r); /* stalled */
    await(&r, DX_STREAM_LIVE);
    fake.silent = true;
    await(&r, DX_STREAM_STALLED);
    join(&r);
    fake.present = true;
    start(&r); /* before anything is known */
    join(&r);
}

/* A recording must know where a stay begins. */
static void the_first_block_of_a_stay_is_marked(void **state)
{
    struct dx_block block = {.bytes = (const uint8_t *)"x", .len = 1, .source = "s"};
    struct dx_block_ring ring;

    (void)state;
    assert_int_equal(dx_block_ring_init(&ring, 4096), 0);
    for (unsigned k = 0; k < 4; k++) {
        struct dx_recording_piece piece;
        struct dx_ring_entry e;

        block.first = k & 1;
        assert_true(dx_block_ring_put(&ring, &block, k & 2));
        assert_true(dx_block_ring_peek(&ring, &e));
        assert_int_equal(dx_recording_get_piece(&piece, e.bytes, e.len), 0);
        assert_int_equal(piece.flags, (k & 2 ? DX_RECORDING_STARTS_FRAME : 0) |
                                          (k & 1 ? DX_RECORDING_FIRST : 0));
        dx_block_ring_pop(&ring);
    }
    dx_block_ring_fini(&ring);
}

static bool points_away(const void *config)
{
    return *(const bool *)config;
}

/* The loop watches for devices of those alone that udev knows. */
static void one_on_the_network_has_no_subsystems(void **state)
{
    struct dx_driver driver = fake_driver;
    struct dx_stream_reader *reader;
    struct dx_counters counters = {0};
    struct dx_mailbox *mailbox;
    struct dx_err err;
    bool is_remote = false;

    (void)state;
    driver.is_remote = points_away;
    assert_int_equal(dx_mailbox_new(&mailbox, false, NULL, NULL), 0);
    for (int k = 0; k < 2; k++) {
        assert_int_equal(
            dx_stream_reader_new(&reader, "t", &driver, &is_remote, mailbox, &counters, &err), 0);
        if (is_remote)
            assert_null(*dx_stream_reader_subsystems(reader));
        else
            assert_string_equal(*dx_stream_reader_subsystems(reader), "fake");
        dx_stream_reader_free(reader);
        is_remote = true;
    }
    dx_mailbox_free(mailbox);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_hundred_unpluggings_leave_nothing_behind),
        cmocka_unit_test(a_flapping_device_does_not_flood_the_log),
        cmocka_unit_test(another_geometry_is_told),
        cmocka_unit_test(silence_is_told_and_its_end),
        cmocka_unit_test(damage_alone_is_told_as_that),
        cmocka_unit_test(one_that_is_not_reached_is_waited_for),
        cmocka_unit_test(a_fault_is_told_and_tried_again),
        cmocka_unit_test(stops_at_once_in_any_state),
        cmocka_unit_test(the_first_block_of_a_stay_is_marked),
        cmocka_unit_test(one_on_the_network_has_no_subsystems),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
