/* The recorder, turn by turn, against a disk that fails: what is lost, what is told, what is whole.
 */
#include "recorder_fixture.h"

#include "core/base/hash.h"

#include <math.h>
#include <pthread.h>

static void records_blocks_of_any_length(void **state)
{
    const size_t lens[] = {16, 0, 1, DX_RECORDING_PIECE, DX_RECORDING_PIECE + 1, 700000, 5};
    struct disk d = {0};
    struct dx_recorder_config c = recorder_config(&d);
    struct dx_recorder *r;
    struct seen s;

    (void)state;
    c.ring_len = 4 << 20;
    r = new_recorder(&c);
    for (uint64_t n = 0; n < 7; n++)
        feed(r, n, lens[n], n % 2 == 0);
    finish(r);
    dx_recorder_free(r);
    s = see(&d);
    assert_int_equal(d.n_files, 1);
    assert_int_equal(s.n_blocks, 7);
    assert_int_equal(s.first, 0);
    assert_int_equal(s.n_missing, 0);
    assert_int_equal(s.n_starts, 4);
    assert_int_equal(s.last_len, 5);
    disk_free(&d);
}

/* Full: the file is whole while it waits, memory takes what it can, the rest is told. */
static void outlives_a_full_disk(void **state)
{
    struct disk d = {0};
    struct dx_recorder_config c = recorder_config(&d);
    struct dx_recorder *r = new_recorder(&c);
    struct dx_recorder_status status;
    struct seen s = {0};
    uint64_t n = 0, lost;

    (void)state;
    for (; n < 20; n++)
        feed(r, n, 1000, true);
    assert_int_equal(dx_recorder_turn(r, dx_clock_ns()), 0);
    newest(&d)->budget = 5000;
    for (; n < 200; n++)
        feed(r, n, 1000, true);
    assert_int_equal(dx_recorder_turn(r, dx_clock_ns() + 2000000000u), -ENOSPC);
    assert_int_equal(dx_recorder_turn(r, dx_clock_ns() + 2000000000u), -ENOSPC);
    see_file(&s, newest(&d), false); /* nothing torn is left in it */
    lost = dropped(r);
    assert_in_range(lost, 100, 180);
    dx_recorder_status(r, &status);
    assert_int_equal(status.error, -ENOSPC);
    assert_string_equal(status.path, "file 0");

    newest(&d)->budget = UINT64_MAX;
    assert_int_equal(dx_recorder_turn(r, dx_clock_ns() + 2000000000u), 0);
    for (; n < 210; n++)
        feed(r, n, 1000, true);
    finish(r);
    dx_recorder_status(r, &status);
    assert_int_equal(status.error, 0);
    assert_int_equal(status.n_blocks, 210 - lost);
    dx_recorder_free(r);
    s = see(&d);
    assert_int_equal(s.n_blocks, 210 - lost);
    assert_int_equal(s.n_missing, lost);
    assert_int_equal(s.n_told, lost);
    disk_free(&d);
}

/* Stalled: the thread does not come back from a write, so nothing is taken. */
static void outlives_a_stalled_disk(void **state)
{
    struct disk d = {0};
    struct dx_recorder_config c = recorder_config(&d);
    struct dx_recorder *r = new_recorder(&c);
    struct seen s;
    uint64_t lost;

    (void)state;
    for (uint64_t n = 0; n < 1000; n++)
        feed(r, n, 500, true);
    lost = dropped(r);
    assert_in_range(lost, 800, 950);
    assert_int_equal(dx_recorder_turn(r, dx_clock_ns()), 0);
    for (uint64_t n = 1000; n < 1010; n++)
        feed(r, n, 500, true);
    assert_int_equal(dropped(r), lost);
    for (uint64_t n = 1010; n < 2000; n++) /* and again, up to its end */
        feed(r, n, 500, true);
    lost = dropped(r);
    finish(r);
    dx_recorder_free(r);
    s = see(&d);
    assert_int_equal(s.n_blocks, 2000 - lost);
    assert_int_equal(s.n_told, lost); /* those at the end as well, though no block follows */
    assert_int_equal(s.next - s.n_blocks, s.n_missing);
    disk_free(&d);
}

static void waits_for_its_folder(void **state)
{
    struct disk d = {.create_error = -ENOENT};
    struct dx_recorder_config c = recorder_config(&d);
    struct dx_recorder *r = new_recorder(&c);
    struct seen s;

    (void)state;
    for (uint64_t n = 0; n < 10; n++)
        feed(r, n, 100, true);
    assert_int_equal(dx_recorder_turn(r, dx_clock_ns()), -ENOENT);
    d.create_error = 0;
    finish(r);
    dx_recorder_free(r);
    s = see(&d);
    assert_int_equal(s.n_blocks, 10);
    assert_int_equal(s.first, 0);
    disk_free(&d);
}

/* Stopped while there was no file for them: they are lost, and counted. */
static void counts_what_never_had_a_file(void **state)
{
    struct disk d = {.create_error = -ENOENT};
    struct dx_recorder_config c = recorder_config(&d);
    struct dx_recorder *r = new_recorder(&c);
    struct dx_recorder_status s;

    (void)state;
    for (uint64_t n = 0; n < 10; n++)
        feed(r, n, 100, true);
    assert_int_equal(dx_recorder_turn(r, dx_clock_ns()), -ENOENT);
    dx_recorder_stop_file(r);
    assert_int_equal(dx_recorder_turn(r, dx_clock_ns()), 0);
    dx_recorder_status(r, &s);
    assert_int_equal(s.n_dropped, 10);
    assert_int_equal(s.n_blocks, 0);
    assert_int_equal(s.error, 0);
    assert_int_equal(s.waiting, 0);
    assert_string_equal(s.path, ""); /* it was never made */
    finish(r);
    dx_recorder_free(r);
    disk_free(&d);
}

/* The same where it is the next file that cannot be made. */
static void gives_up_a_next_file(void **state)
{
    struct disk d = {0};
    struct dx_recorder_config c = recorder_config(&d);
    struct dx_recorder *r;
    struct dx_recorder_status s;
    struct seen seen;

    (void)state;
    c.split_len = 20000;
    r = new_recorder(&c);
    feed(r, 0, 1000, true);
    assert_int_equal(dx_recorder_turn(r, dx_clock_ns()), 0);
    d.create_error = -ENOENT;
    for (uint64_t n = 1; n < 50; n++)
        feed(r, n, 1000, true);
    assert_int_equal(dx_recorder_turn(r, dx_clock_ns()), -ENOENT);
    dx_recorder_stop_file(r);
    assert_int_equal(dx_recorder_turn(r, dx_clock_ns()), 0);
    dx_recorder_status(r, &s);
    assert_in_range(s.n_blocks, 10, 30);
    assert_int_equal(s.n_dropped, 50 - s.n_blocks);
    assert_true(s.error == 0 && !s.writing && s.waiting == 0);
    assert_string_equal(s.path, "");
    d.create_error = 0; /* and another one begins anew */
    dx_recorder_start_file(r);
    feed(r, 50, 1000, true);
    finish(r);
    dx_recorder_free(r);
    seen = see(&d);
    assert_int_equal(seen.n_blocks, s.n_blocks + 1);
    disk_free(&d);
}

/* No file was ever made, and none can be at the end: nothing to close, and it comes back. */
static void ends_without_a_folder(void **state)
{
    struct disk d = {.create_error = -ENOENT};
    struct dx_recorder_config c = recorder_config(&d);
    struct dx_recorder *r = new_recorder(&c);
    struct dx_recorder_status s;

    (void)state;
    feed(r, 0, 100, true);
    dx_recorder_stop(r, true);
    dx_recorder_run(r);
    dx_recorder_status(r, &s);
    assert_int_equal(s.n_files, 0);
    assert_int_equal(s.error, -ENOENT);
    dx_recorder_free(r);
    disk_free(&d);
}

/* A chunk is closed a second after it was opened, though nothing follows. */
static void closes_chunks_in_time(void **state)
{
    struct disk d = {0};
    struct dx_recorder_config c = recorder_config(&d);
    struct dx_recorder *r = new_recorder(&c);
    struct seen s = {0};

    (void)state;
    for (uint64_t n = 0; n < 3; n++)
        feed(r, n, 100, true);
    assert_int_equal(dx_recorder_turn(r, dx_clock_ns()), 0);
    see_file(&s, newest(&d), false);
    assert_int_equal(s.n_blocks, 0);
    assert_int_equal(dx_recorder_turn(r, dx_clock_ns() + 1000000000u), 0);
    see_file(&s, newest(&d), false);
    assert_int_equal(s.n_blocks, 3);
    dx_recorder_free(r);
    disk_free(&d);
}

static struct dx_geometry *make_geometry(void)
{
    struct dx_geometry *g = NULL;

    assert_int_equal(dx_geometry_new_pinhole(&g, 6, 8, 5, 5, 4, 3), 0);
    return g;
}

/* By size and by time, at frames; each file has the geometry of before. */
static void rotates_without_loss(void **state)
{
    struct disk d = {0};
    struct dx_recorder_config c = recorder_config(&d);
    struct dx_geometry *g = make_geometry();
    struct dx_recorder *r;
    struct seen s = {0};

    (void)state;
    c.ring_len = 1 << 20;
    c.split_len = 20000;
    c.split_ns = 50000000; /* 50 blocks */
    r = new_recorder(&c);
    for (uint64_t n = 0; n < 300; n++) {
        feed(r, n, n < 150 ? 1000 : 10, n % 4 == 0);
        if (n == 0)
            dx_recorder_geometry(r, g, 1);
    }
    finish(r);
    dx_recorder_free(r);
    assert_in_range(d.n_files, 8, 16);
    for (unsigned k = 0; k < d.n_files; k++) {
        assert_int_equal(see_file(&s, &d.files[k], true), 2);
        assert_true(s.first_starts_frame);
    }
    assert_int_equal(s.n_blocks, 300);
    assert_int_equal(s.n_missing, 0);
    dx_geometry_unref(g);
    disk_free(&d);
}

/* A device whose frames never end is split as well, later. */
static void rotates_in_the_middle_of_a_frame(void **state)
{
    struct disk d = {0};
    struct dx_recorder_config c = recorder_config(&d);
    struct dx_recorder *r;
    struct seen s;

    (void)state;
    c.ring_len = 1 << 20;
    c.split_len = 20000;
    r = new_recorder(&c);
    for (uint64_t n = 0; n < 300; n++)
        feed(r, n, 1000, n == 0);
    finish(r);
    dx_recorder_free(r);
    assert_in_range(d.n_files, 5, 9); /* 300 kB in files of twice 20 kB */
    s = see(&d);
    assert_int_equal(s.n_blocks, 300);
    disk_free(&d);
}

/* So many gaps that the index of a file has no room for one more: the next file takes it. */
static void begins_a_file_when_the_index_is_full(void **state)
{
    struct disk d = {0};
    struct dx_recorder_config c = recorder_config(&d);
    struct dx_recorder *r;
    uint64_t n = 0, lost;
    struct seen s;

    (void)state;
    c.ring_len = 4096;
    r = new_recorder(&c);
    for (unsigned turn = 0; turn < 8000; turn++) {
        for (unsigned k = 0; k < 4; k++) {
            feed(r, n, 1200, n == 0);
            n++;
        }
        assert_int_equal(dx_recorder_turn(r, dx_clock_ns()), 0);
    }
    lost = dropped(r);
    finish(r);
    dx_recorder_free(r);
    assert_int_equal(d.n_files, 2);
    s = see(&d);
    assert_int_equal(s.n_blocks, n - lost);
    assert_int_equal(s.n_told, lost);
    disk_free(&d);
}

/* Started and stopped: files begin with a frame, and what was fed before the stop is there. */
static void starts_and_stops(void **state)
{
    struct disk d = {0};
    struct dx_recorder_config c = recorder_config(&d);
    struct dx_recorder *r;
    struct seen s = {0};

    (void)state;
    c.start = false;
    r = new_recorder(&c);
    for (uint64_t n = 0; n < 10; n++)
        feed(r, n, 100, n % 4 == 0);
    assert_int_equal(dx_recorder_turn(r, dx_clock_ns()), 0);
    assert_int_equal(d.n_files, 0);
    dx_recorder_start_file(r);
    for (uint64_t n = 10; n < 20; n++)
        feed(r, n, 100, n % 4 == 0);
    assert_int_equal(dx_recorder_turn(r, dx_clock_ns()), 0);
    for (uint64_t n = 20; n < 30; n++)
        feed(r, n, 100, n % 4 == 0);
    dx_recorder_stop_file(r);
    feed(r, 30, 100, true);
    assert_int_equal(dx_recorder_turn(r, dx_clock_ns()), 0);
    assert_false(d.is_open);
    see_file(&s, newest(&d), true);
    assert_int_equal(s.first, 12);
    assert_int_equal(s.n_blocks, 18);
    dx_recorder_start_file(r);
    feed(r, 31, 100, false);
    feed(r, 32, 100, true);
    finish(r);
    dx_recorder_free(r);
    assert_int_equal(d.n_files, 2);
    s = (struct seen){0};
    see_file(&s, newest(&d), true);
    assert_int_equal(s.first, 32);
    disk_free(&d);
}

static void keeps_geometry(void **state)
{
    struct dx_geometry *g = make_geometry(), *back = NULL;
    size_t len = dx_recording_geometry_len(g);
    uint8_t *bytes = malloc(len), attr_bytes = 0;

    (void)state;
    assert_non_null(bytes);
    g->pose[3] = 4.5;
    g->wrap = true;
    dx_recording_put_geometry(bytes, g, 2);
    assert_int_equal(dx_recording_get_geometry(&back, &attr_bytes, bytes, len), 0);
    assert_int_equal(attr_bytes, 2);
    assert_true(back->wrap && back->unit_m == g->unit_m && back->range_bytes == g->range_bytes);
    assert_memory_equal(back->pose, g->pose, sizeof(g->pose));
    assert_memory_equal(back->table, g->table, 4 * g->n_table);
    dx_geometry_unref(back);
    for (size_t n = 0; n < len; n++)
        assert_int_equal(dx_recording_get_geometry(&back, &attr_bytes, bytes, n), -EBADMSG);
    bytes[8]++; /* a row more */
    assert_int_equal(dx_recording_get_geometry(&back, &attr_bytes, bytes, len), -EBADMSG);
    g->pose[11] = NAN;
    dx_recording_put_geometry(bytes, g, 2);
    assert_int_equal(dx_recording_get_geometry(&back, &attr_bytes, bytes, len), -EBADMSG);
    free(bytes);
    dx_geometry_unref(g);
}

/* Any order of faults: what was not dropped is there once, in order; what was dropped is told. */
static void loses_nothing_else(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 60; seed++) {
        struct disk d = {0};
        struct dx_recorder_config c = recorder_config(&d);
        struct dx_recorder *r;
        struct seen s;
        uint64_t draw = seed, lost;

        c.split_len = seed % 2 ? 40000 : 0;
        c.compression = (enum dx_mcap_compression)(seed % 3);
        r = new_recorder(&c);
        for (uint64_t n = 0; n < 400; n++) {
            draw = dx_hash_u64(draw, n);
            feed(r, n, draw % 1500, n == 0 || draw % 3 == 0);
            if (draw >> 8 & 1)
                continue;
            d.create_error = draw >> 10 & 1 ? 0 : -EIO;
            if (d.is_open)
                newest(&d)->budget = draw >> 11 & 1 ? UINT64_MAX : draw >> 20 & 0xfff;
            (void)dx_recorder_turn(r, dx_clock_ns() + (draw >> 12 & 1) * 2000000000u);
        }
        d.create_error = 0;
        if (d.is_open)
            newest(&d)->budget = UINT64_MAX;
        lost = dropped(r);
        finish(r);
        dx_recorder_free(r);
        s = see(&d);
        assert_int_equal(s.n_blocks, 400 - lost);
        assert_int_equal(s.n_told, lost);
        disk_free(&d);
    }
}

static void *run_recorder(void *r)
{
    dx_recorder_run(r);
    return NULL;
}

/* Two threads; the ring is small, so that it is full at times. */
static void runs_beside_the_reader(void **state)
{
    struct disk d = {0};
    struct dx_recorder_config c = recorder_config(&d);
    struct dx_recorder *r = new_recorder(&c);
    pthread_t thread;
    struct seen s;
    uint64_t lost;

    (void)state;
    assert_int_equal(pthread_create(&thread, NULL, run_recorder, r), 0);
    for (uint64_t n = 0; n < 20000; n++)
        feed(r, n, n % 700, n % 3 == 0);
    lost = dropped(r);
    dx_recorder_stop(r, true);
    pthread_join(thread, NULL);
    dx_recorder_free(r);
    s = see(&d);
    assert_int_equal(s.n_blocks, 20000 - lost);
    assert_int_equal(s.n_told, lost);
    disk_free(&d);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(records_blocks_of_any_length),
        cmocka_unit_test(outlives_a_full_disk),
        cmocka_unit_test(outlives_a_stalled_disk),
        cmocka_unit_test(waits_for_its_folder),
        cmocka_unit_test(counts_what_never_had_a_file),
        cmocka_unit_test(gives_up_a_next_file),
        cmocka_unit_test(ends_without_a_folder),
        cmocka_unit_test(closes_chunks_in_time),
        cmocka_unit_test(rotates_without_loss),
        cmocka_unit_test(rotates_in_the_middle_of_a_frame),
        cmocka_unit_test(begins_a_file_when_the_index_is_full),
        cmocka_unit_test(starts_and_stops),
        cmocka_unit_test(keeps_geometry),
        cmocka_unit_test(loses_nothing_else),
        cmocka_unit_test(runs_beside_the_reader),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
