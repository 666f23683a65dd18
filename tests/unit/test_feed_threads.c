/*
 * The feed between two real threads, for ThreadSanitizer: a mesher publishes a counted number of
 * epochs as fast as the arena lets it; the loop adopts, starts batches, stalls some, and checks
 * every chunk by value.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <poll.h>
#include <pthread.h>
#include <semaphore.h>
#include <stdio.h>
#include <unistd.h>

#include "core/base/rng.h"
#include "daemon/view.h"
#include "tests/unit/feed_body.h"

#define N_TILES   10
#define N_EPOCHS  20000
#define N_CLIENTS 5

struct shared {
    struct dx_feed *feed;
    sem_t kicked;
    _Atomic uint32_t n_short;
};

struct client {
    struct dx_view view;
    uint32_t sent;
    uint64_t held[N_TILES];
};

/* A tile of an epoch: version 100 * epoch + tile of the last epoch that changed it, every third
 * empty. */
static uint64_t version_of(uint64_t epoch, uint32_t tile)
{
    uint64_t period = 1 + tile % 3, last = epoch - epoch % period;

    return last == 0 || (last + tile) % 5 == 0 ? 0 : 100 * last + tile;
}

static void on_kick(void *ctx)
{
    sem_post(&((struct shared *)ctx)->kicked);
}

static bool add_all(struct dx_feed *f, uint64_t epoch, uint64_t sent, const uint32_t *generation,
                    const uint32_t *served)
{
    uint8_t body[FEED_BODY_MAX];

    dx_feed_begin(f, epoch, generation);
    for (uint32_t k = 0; k < 3 * N_TILES; k++) {
        uint32_t e = 3 * (k / N_TILES), tile = k % N_TILES;
        uint64_t version = version_of(epoch, tile);
        bool all = generation[e] != served[e];

        if (!generation[e] || (!all && version_of(sent, tile) == version))
            continue;
        if (!feed_add_body(f, tile, e, body, feed_body_make(body, version)))
            return false;
    }
    return true;
}

static void *mesher(void *arg)
{
    struct shared *s = arg;
    uint32_t generation[DX_N_FORMS], served[DX_N_FORMS] = {0};
    uint64_t sent = 0;

    while (sent < N_EPOCHS) {
        struct dx_msg_commit commit = {.frame = sent + 1};

        dx_feed_wanted(s->feed, generation);
        if (!add_all(s->feed, sent + 1, sent, generation, served)) {
            dx_feed_abort(s->feed);
            atomic_fetch_add(&s->n_short, 1);
            sem_wait(&s->kicked);
            continue;
        }
        dx_feed_commit(s->feed, &commit, NULL);
        memcpy(served, generation, sizeof(served));
        sent++;
    }
    dx_feed_state(s->feed, DX_STREAM_ENDED, "done");
    return NULL;
}

static void on_dropped(struct dx_view *v, bool slow)
{
    struct client *c = (struct client *)((char *)v - offsetof(struct client, view));

    (void)slow;
    memset(c->held, 0, sizeof(c->held));
}

static void serve(struct client *c, uint64_t now, uint32_t n)
{
    struct dx_view *v = &c->view;

    if (!v->in_batch) {
        if (!dx_view_ready(v) || !dx_view_begin(v, now))
            return;
        c->sent = 0;
    }
    for (; n && c->sent < v->n_entries; n--, c->sent++) {
        struct dx_view_entry e = v->entry[c->sent];

        c->held[e.tile] = version_of(v->batch_epoch, e.tile);
        if (e.chunk != DX_FEED_NONE)
            assert_true(feed_body_is(v->loop->feed, e.chunk, c->held[e.tile]));
        dx_view_release(v, c->sent);
    }
    if (c->sent < v->n_entries)
        return;
    for (uint32_t t = 0; t < N_TILES; t++)
        assert_int_equal(c->held[t], version_of(v->batch_epoch, t));
    dx_view_end(v);
}

static void drain_wake(int fd)
{
    struct pollfd p = {fd, POLLIN, 0};
    uint64_t n;

    poll(&p, 1, 1);
    while (read(fd, &n, sizeof(n)) > 0)
        ;
}

static void loop(struct shared *s, struct dx_feed_loop *l, struct client *c)
{
    struct dx_rng rng = dx_rng_init(7, 0);
    uint64_t now = 1;

    while (l->state != DX_STREAM_ENDED) {
        drain_wake(s->feed->wake_fd);
        dx_feed_loop_turn(l);
        for (uint32_t k = 0; k < N_CLIENTS; k++)
            serve(&c[k], now, 1 + dx_rng_below(&rng, k < 3 ? 2 : 2 * N_TILES));
        dx_feed_loop_settle(l);
        now += 10000000;
        if (dx_rng_below(&rng, 50) == 0) { /* one leaves, one comes; forms come and go */
            struct client *one = &c[dx_rng_below(&rng, N_CLIENTS)];

            dx_view_leave(&one->view, now);
            dx_feed_loop_expire(l, now + DX_FEED_LINGER_NS);
            memset(one->held, 0, sizeof(one->held));
            one->view = (struct dx_view){.loop = l, .dropped = on_dropped};
            one->view.form = 3 * dx_rng_below(&rng, 3); /* f32, two levels of detail */
            assert_int_equal(dx_view_join(&one->view), 0);
        }
    }
}

static void test_threads(void **state)
{
    struct dx_terrain_params params = {.cap_m = 1};
    struct client c[N_CLIENTS] = {0};
    struct shared s = {0};
    struct dx_feed_loop *l;
    struct dx_geometry *g;
    uint32_t generation[DX_N_FORMS];
    pthread_t thread;

    (void)state;
    sem_init(&s.kicked, 0, 0);
    assert_int_equal(
        dx_feed_new_sized(&s.feed, N_TILES, 2 * 4 * 2 * N_TILES, 5 * N_TILES, 8, -1, on_kick, &s),
        0);
    assert_int_equal(dx_feed_loop_new(&l, s.feed), 0);
    assert_int_equal(dx_geometry_new(&g, DX_MODEL_PINHOLE, 100, 300), 0);
    dx_feed_reset(s.feed, g, &params, 0, "start");
    dx_geometry_unref(g);
    for (uint32_t k = 0; k < N_CLIENTS; k++) {
        c[k].view = (struct dx_view){.loop = l, .dropped = on_dropped, .form = 3 * (k % 2)};
        assert_int_equal(dx_view_join(&c[k].view), 0);
    }
    assert_int_equal(pthread_create(&thread, NULL, mesher, &s), 0);
    loop(&s, l, c);
    pthread_join(thread, NULL);
    for (uint32_t k = 0; k < N_CLIENTS; k++)
        dx_view_leave(&c[k].view, 0);
    printf("%u shortages in %d epochs\n", atomic_load(&s.n_short), N_EPOCHS);
    dx_feed_loop_turn(l);
    dx_feed_loop_free(l);
    dx_feed_wanted(s.feed, generation);
    assert_int_equal(s.feed->free_chunks.n, s.feed->n_chunks);
    dx_feed_free(s.feed);
    sem_destroy(&s.kicked);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_threads)};

    return cmocka_run_group_tests(tests, NULL, NULL);
}
