/* Subscribers that do not keep up: what they get, and that nobody else notices. */
#include "tests/unit/server_client.h"

#define MS   1000000u
#define LAST 600 /* frame, at most */

static void wait_hangup(int fd)
{
    struct pollfd p = {fd, 0, 0};

    assert_int_equal(poll(&p, 1, 300000), 1);
    assert_true(p.revents & POLLHUP);
}

static void test_who_never_reads_is_dropped(void **state)
{
    struct fixture *fx = fixture_start(
        &(struct fixture_options){.grid = 1, .body_len = 60000, .server = {.stall_ns = 300 * MS}});
    struct client *good = client_start(fx, NULL), *stuck = client_start(fx, NULL);
    uint32_t n;

    (void)state;
    client_until_frame(good, 3);
    n = good->n_commits;
    for (uint64_t f = 4; f < 60; f++) {
        fixture_frames(fx, f);
        client_until_frame(good, f);
    }
    assert_int_equal(good->n_resets, 0);
    assert_int_equal(good->n_commits, n + 56); /* each of them */
    wait_hangup(stuck->fd);
    assert_int_equal(atomic_load(&fx->n_subscribers), 1);
    fixture_frames(fx, 61);
    client_until_frame(good, 61);
    client_until_closed(stuck); /* whole messages up to the end, or the torn last one */
    client_close(stuck);
    client_close(good);
    fixture_stop(fx);
}

static void test_byte_at_a_time(void **state)
{
    struct fixture *fx = fixture_start(&(struct fixture_options){.body_len = 3000});
    struct client *slow = client_connect(fx), *good = client_start(fx, NULL);
    uint64_t f = 4;

    (void)state;
    close(slow->fd);
    slow->fd = client_socket(fx->mesh, 0);
    slow->slow_reader = true;
    client_hello(slow, DX_WIRE_MAJOR, 1);
    client_subscribe(slow, &(struct dx_msg_subscribe){0});
    client_until_frame(good, 3);
    while (slow->n_commits < 5) { /* each COMMIT is checked against its frame, whole */
        client_step(slow);
        fixture_frames(fx, ++f);
        client_until_frame(good, f);
    }
    client_until_frame(slow, f);
    client_close(slow);
    client_close(good);
    fixture_stop(fx);
}

/* Blocks of a tile's body, as the fixture makes it. */
static uint32_t n_blocks(uint64_t version, uint32_t t, uint32_t body_len)
{
    static uint8_t body[DX_WIRE_MAX_BODY];
    size_t len = fixture_body(body, version, DX_ENCODING_F32, 4, t, body_len, 0);

    return version ? (uint32_t)((len + DX_FEED_BLOCK_LEN - 1) / DX_FEED_BLOCK_LEN) : 0;
}

/* The least arena in which frames up to n can follow each other: the current one and what changes.
 */
static uint32_t least_arena(uint64_t n, uint32_t body_len)
{
    uint32_t most = 0;

    for (uint64_t f = 1; f <= n; f++) {
        uint32_t sum = 0;

        for (uint32_t t = 0; t < fixture_n_tiles(1); t++) {
            uint64_t before = fixture_version(f - 1, t), now = fixture_version(f, t);

            sum += n_blocks(before, t, body_len);
            sum += before != now ? n_blocks(now, t, body_len) : 0;
        }
        most = sum > most ? sum : most;
    }
    return most;
}

/* With a small arena, and patience with who stops reading. */
static struct fixture *start_small(void)
{
    return fixture_start(&(struct fixture_options){.body_len = 60000,
                                                   .grid = 1,
                                                   .n_blocks = least_arena(LAST, 60000),
                                                   .server = {.stall_ns = 60000u * (uint64_t)MS}});
}

/* A small arena: the mesher takes the pin of who has stopped reading, and it begins anew. */
static void test_revoked_begins_anew(void **state)
{
    struct fixture *fx = start_small();
    struct client *good = client_start(fx, NULL), *slow;
    uint64_t f = 4;

    (void)state;
    client_until_frame(good, 3);
    slow = client_start(fx, NULL);
    client_until(slow, DX_MSG_SNAPSHOT_END);
    /* It is silent until the mesher has run short, which costs it its pin; it cannot take another,
     * for its socket is full, so that the mesher is short once or twice in all. */
    while (dx_get(&fx->counters.n_short_of_chunks) == 0 && f < LAST / 2) {
        fixture_frames(fx, ++f);
        client_until_frame(good, f);
    }
    assert_true(f < LAST / 2);
    for (uint64_t end = f + LAST / 2; f < end;) {
        fixture_frames(fx, ++f);
        client_until_frame(good, f);
    }
    do
        assert_int_not_equal(client_step(slow), 0);
    while (!slow->n_resets);
    assert_string_equal(slow->reset.reason, "too slow");
    client_until_frame(slow, f);
    assert_int_equal(good->n_resets, 0);
    client_close(slow);
    client_close(good);
    fixture_stop(fx);
}

/* Frames, each of which `good` gets, until so many batches have been taken from others. */
static uint64_t frames_until_slow(struct fixture *fx, struct client *good, uint64_t f, uint64_t n)
{
    const uint64_t end = f + LAST / 2;

    while (dx_get(&fx->counters.n_slow) < n && f < end) {
        fixture_frames(fx, ++f);
        client_until_frame(good, f);
    }
    assert_int_equal(dx_get(&fx->counters.n_slow), n);
    return f;
}

/* One that has begun anew and stops reading again, before it has all of it, is told why it must go.
 */
static void test_revoked_twice_must_go(void **state)
{
    struct fixture *fx = start_small();
    struct client *good = client_start(fx, NULL), *slow;
    uint64_t f;

    (void)state;
    client_until_frame(good, 3);
    slow = client_start(fx, NULL);
    client_until(slow, DX_MSG_SNAPSHOT_END);
    f = frames_until_slow(fx, good, 4, 1);
    client_until(slow, DX_MSG_RESET);
    assert_string_equal(slow->reset.reason, "too slow");
    client_until(slow, DX_MSG_SNAPSHOT_BEGIN);
    f = frames_until_slow(fx, good, f, 2);
    client_until_closed(slow);
    assert_int_equal(slow->n_resets, 1); /* no other beginning */
    assert_int_equal(atomic_load(&fx->n_subscribers), 1);
    fixture_frames(fx, ++f);
    client_until_frame(good, f);
    assert_int_equal(good->n_resets, 0);
    client_close(slow);
    client_close(good);
    fixture_stop(fx);
}

/* Several stop in batches of different epochs: pins are bounded, the good one gets every frame. */
static void test_many_stuck(void **state)
{
    struct fixture *fx = fixture_start(&(struct fixture_options){
        .body_len = 60000, .grid = 1, .server = {.stall_ns = 2000u * (uint64_t)MS}});
    struct client *good = client_start(fx, NULL), *stuck[8];
    uint64_t f = 4;

    (void)state;
    client_until_frame(good, 3);
    for (int k = 0; k < 8; k++) {
        stuck[k] = client_start(fx, NULL);
        for (int n = 0; n < 20; n++) {
            fixture_frames(fx, ++f);
            client_until_frame(good, f);
        }
    }
    assert_int_equal(good->n_resets, 0);
    for (int k = 0; k < 8; k++) {
        wait_hangup(stuck[k]->fd);
        client_close(stuck[k]);
    }
    fixture_frames(fx, ++f);
    client_until_frame(good, f);
    client_close(good);
    fixture_stop(fx);
}

/* The rule of ten seconds also frees the others of a lossless replay from one that is stuck. */
static void test_stuck_lossless(void **state)
{
    const struct dx_msg_subscribe lossless = {.mode = DX_MODE_LOSSLESS};
    struct fixture *fx = fixture_start(&(struct fixture_options){
        .lossless = true, .no_mesh = true, .body_len = 60000, .server = {.stall_ns = 2000 * MS}});
    struct client *good = client_start(fx, &lossless), *stuck = client_start(fx, &lossless);

    (void)state;
    client_until(stuck, DX_MSG_STREAM_STATE);
    client_until(good, DX_MSG_STREAM_STATE);
    fixture_frames(fx, 100);
    for (uint64_t f = 1; f <= 100; f++) {
        client_until(good, DX_MSG_COMMIT);
        assert_int_equal(good->commit.frame, f);
    }
    wait_hangup(stuck->fd);
    client_close(stuck);
    client_close(good);
    fixture_stop(fx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_who_never_reads_is_dropped),
        cmocka_unit_test(test_byte_at_a_time),
        cmocka_unit_test(test_revoked_begins_anew),
        cmocka_unit_test(test_revoked_twice_must_go),
        cmocka_unit_test(test_many_stuck),
        cmocka_unit_test(test_stuck_lossless),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
