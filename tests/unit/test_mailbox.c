/*
 * The mailbox: order, newest wins, parts in place, geometry and state in their turn; and a stress
 * of both threads, in which every delivered column must arrive, for the thread sanitizer too.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "core/base/rng.h"
#include "daemon/clock.h"
#include "daemon/mailbox.h"

#include <pthread.h>

enum { ROWS = 4, COLS = 100 };

static void wake(void *sem)
{
    sem_post(sem);
}

struct rig {
    sem_t sem;
    struct dx_mailbox *m;
    struct dx_frame_sink sink;
};

static void rig_init(struct rig *r, bool lossless)
{
    struct dx_mail_item item;
    struct dx_geometry *g;

    sem_init(&r->sem, 0, 0);
    assert_int_equal(dx_mailbox_new(&r->m, lossless, wake, &r->sem), 0);
    r->sink = dx_mailbox_sink(r->m);
    assert_int_equal(dx_geometry_new_pinhole(&g, ROWS, COLS, 100, 100, 50, 2), 0);
    assert_int_equal(r->sink.geometry(r->sink.ctx, g, 0), 0);
    assert_int_equal(dx_mailbox_take(r->m, &item), DX_MAIL_GEOMETRY);
    assert_ptr_equal(item.geometry, g);
    dx_geometry_unref(item.geometry);
    dx_geometry_unref(g);
}

static void rig_fini(struct rig *r)
{
    dx_mailbox_free(r->m);
    sem_destroy(&r->sem);
}

/* Columns of a frame, each dexel holding the frame's number plus one. */
static void put(struct rig *r, uint64_t frame, uint32_t col0, uint32_t n, bool last)
{
    struct dx_frame_part part = {.frame = frame, .col0 = col0, .n_cols = n, .last = last};
    struct dx_plane *p = r->sink.plane(r->sink.ctx, frame);

    if (!p)
        return;
    for (uint32_t i = 0; i < ROWS; i++)
        for (uint32_t j = col0; j < col0 + n; j++) {
            assert_int_equal(dx_plane_range(p, (size_t)i * COLS + j), 0);
            dx_plane_set_range(p, (size_t)i * COLS + j, (uint32_t)frame + 1);
        }
    r->sink.deliver(r->sink.ctx, &part);
}

/* The taken columns hold their frame; returns how many they are. */
static uint32_t check_columns(const struct dx_mail_item *item)
{
    uint32_t n = 0;

    for (uint32_t j = 0; j < COLS; j++) {
        if (!(item->columns[j / 64] >> (j % 64) & 1))
            continue;
        n++;
        for (uint32_t i = 0; i < ROWS; i++)
            assert_int_equal(dx_plane_range(item->plane, (size_t)i * COLS + j), item->frame + 1);
    }
    return n;
}

static void expect(struct rig *r, uint64_t frame, uint32_t n_cols, bool complete)
{
    struct dx_mail_item item;

    assert_int_equal(dx_mailbox_take(r->m, &item), DX_MAIL_COLUMNS);
    assert_int_equal(item.frame, frame);
    assert_int_equal(check_columns(&item), n_cols);
    assert_int_equal(item.complete, complete);
    dx_mailbox_release(r->m);
}

static void expect_none(struct rig *r)
{
    struct dx_mail_item item;

    assert_int_equal(dx_mailbox_take(r->m, &item), DX_MAIL_NONE);
}

static void the_newest_frame_wins(void **state)
{
    struct rig r;

    (void)state;
    rig_init(&r, false);
    put(&r, 0, 0, COLS, true);
    expect(&r, 0, COLS, true);
    for (uint64_t f = 1; f < 10; f++)
        put(&r, f, 0, COLS, true);
    expect(&r, 9, COLS, true);
    expect_none(&r);
    assert_int_equal(dx_mailbox_n_skipped(r.m), 8);
    rig_fini(&r);
}

static void parts_of_a_frame_add_up(void **state)
{
    struct rig r;

    (void)state;
    rig_init(&r, false);
    put(&r, 0, 0, 10, false);
    put(&r, 0, 30, 5, false);
    expect(&r, 0, 15, false);
    expect_none(&r);
    put(&r, 0, 10, 20, false);
    put(&r, 0, 35, COLS - 35, true);
    put(&r, 1, 0, 1, false); /* the next frame has begun: the complete one comes first, whole */
    expect(&r, 0, COLS - 15, true);
    expect(&r, 1, 1, false);
    assert_int_equal(dx_mailbox_n_skipped(r.m), 0);
    rig_fini(&r);
}

static void a_frame_without_its_last_part_ends_with_the_next(void **state)
{
    struct rig r;

    (void)state;
    rig_init(&r, true);
    put(&r, 0, 0, 10, false);
    put(&r, 1, 0, COLS, true);
    expect(&r, 0, 10, true);
    expect(&r, 1, COLS, true);
    rig_fini(&r);
}

static void states_come_after_the_frames_before_them(void **state)
{
    struct dx_mail_item item;
    struct rig r;

    (void)state;
    rig_init(&r, false);
    put(&r, 0, 0, COLS, true);
    dx_mailbox_put_state(r.m, DX_STREAM_ENDED, "the end");
    expect(&r, 0, COLS, true);
    assert_int_equal(dx_mailbox_take(r.m, &item), DX_MAIL_STATE);
    assert_int_equal(item.state, DX_STREAM_ENDED);
    assert_string_equal(item.reason, "the end");
    expect_none(&r);
    rig_fini(&r);
}

/* ---- two threads ----------------------------------------------------------------------------- */

enum { FRAMES = 2000 };

struct producer {
    struct rig *rig;
    uint64_t seed;
};

/* A mesher that never catches up is told all the same: live, then gone while frames still come. */
static void states_do_not_wait_for_later_frames(void **state)
{
    struct dx_mail_item item;
    struct rig r;

    (void)state;
    rig_init(&r, false);
    put(&r, 0, 0, COLS, true);
    dx_mailbox_put_state(r.m, DX_STREAM_LIVE, "");
    expect(&r, 0, COLS, true);
    put(&r, 1, 0, COLS, true);
    put(&r, 2, 0, COLS, true);
    assert_int_equal(dx_mailbox_take(r.m, &item), DX_MAIL_STATE);
    assert_int_equal(item.state, DX_STREAM_LIVE);
    dx_mailbox_put_state(r.m, DX_STREAM_GONE, "unplugged");
    put(&r, 3, 0, COLS, true);
    expect(&r, 3, COLS, true); /* the newest wins; what was before the state has gone with it */
    assert_int_equal(dx_mailbox_take(r.m, &item), DX_MAIL_STATE);
    assert_int_equal(item.state, DX_STREAM_GONE);
    expect_none(&r);
    rig_fini(&r);
}

static void *produce(void *arg)
{
    struct producer *p = arg;
    struct dx_rng rng = dx_rng_init(p->seed, 1);

    for (uint64_t f = 0; f < FRAMES; f++)
        for (uint32_t j = 0; j < COLS;) {
            uint32_t n = 1 + dx_rng_below(&rng, COLS - j);

            put(p->rig, f, j, n, j + n == COLS);
            j += n;
        }
    dx_mailbox_put_state(p->rig->m, DX_STREAM_ENDED, "");
    return NULL;
}

/* Takes until the end; frames in order, columns of a frame once each; how many frames came whole.
 */
static uint32_t consume(struct rig *r)
{
    uint32_t n_whole = 0, n_cols = 0;
    uint64_t frame = 0;

    for (;;) {
        struct dx_mail_item item;
        enum dx_mail kind = dx_mailbox_take(r->m, &item);

        if (kind == DX_MAIL_NONE) {
            dx_clock_sem_wait(&r->sem, 0);
            continue;
        }
        if (kind == DX_MAIL_STATE)
            return n_whole;
        assert_true(item.frame >= frame);
        n_cols = item.frame == frame ? n_cols : 0;
        frame = item.frame;
        n_cols += check_columns(&item);
        assert_true(n_cols <= COLS);
        n_whole += item.complete && n_cols == COLS;
        dx_mailbox_release(r->m);
    }
}

static void threads(bool lossless, uint64_t seed)
{
    struct producer p;
    pthread_t thread;
    struct rig r;
    uint32_t n_whole;

    rig_init(&r, lossless);
    p = (struct producer){&r, seed};
    assert_int_equal(pthread_create(&thread, NULL, produce, &p), 0);
    n_whole = consume(&r);
    pthread_join(thread, NULL);
    if (lossless)
        assert_int_equal(n_whole, FRAMES);
    else
        assert_true(n_whole + dx_mailbox_n_skipped(r.m) >= FRAMES);
    rig_fini(&r);
}

static void nothing_is_lost_between_threads(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 5; seed++) {
        threads(true, seed);
        threads(false, seed);
    }
}

static void *close_it(void *mailbox)
{
    dx_mailbox_close(mailbox);
    return NULL;
}

static void close_frees_a_waiting_reader(void **state)
{
    pthread_t thread;
    struct rig r;

    (void)state;
    rig_init(&r, true);
    for (uint64_t f = 0; f < 3; f++)
        put(&r, f, 0, COLS, true);
    assert_int_equal(pthread_create(&thread, NULL, close_it, r.m), 0);
    assert_null(r.sink.plane(r.sink.ctx, 3)); /* waits for room until the close */
    pthread_join(thread, NULL);
    rig_fini(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_newest_frame_wins),
        cmocka_unit_test(parts_of_a_frame_add_up),
        cmocka_unit_test(a_frame_without_its_last_part_ends_with_the_next),
        cmocka_unit_test(states_come_after_the_frames_before_them),
        cmocka_unit_test(states_do_not_wait_for_later_frames),
        cmocka_unit_test(nothing_is_lost_between_threads),
        cmocka_unit_test(close_frees_a_waiting_reader),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
