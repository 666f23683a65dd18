/*
 * The feed against a model: one thread interleaves, by a seeded generator, all that mesher, loop
 * and clients can do, in an arena so small that shortage is common. After each COMMIT a client
 * holds exactly the mesh of that epoch, by value; freed blocks are poisoned; pins stay within their
 * bound; a mesher that was refused goes on only when kicked; and at the end everything is home.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>

#include "core/base/rng.h"
#include "daemon/view.h"
#include "tests/unit/feed_body.h"
#include "tests/unit/rounds.h"

#define MAX_TILES   10
#define MAX_CLIENTS 9
#define HISTORY     64 /* epochs; more than can be published and not adopted */
/* Forms of which clients want one: f32 and two levels of detail, 0, 3 and 6. */
#define N_USED       3
#define USED(n)      ((n) * (DX_N_FORMS - 1) / (N_USED - 1))
#define FRAME_BLOCKS (MAX_TILES * 4 * N_USED)

struct mesh {
    uint32_t n_tiles;
    uint64_t version[MAX_TILES];
};

struct client {
    bool joined;
    struct dx_view view;
    uint32_t sent;        /* entries of the batch */
    struct mesh expected; /* of the batch's epoch */
    uint64_t held[MAX_TILES];
    uint64_t last_epoch; /* lossless: the next one must follow */
    bool stalled;
};

struct model {
    struct dx_rng rng;
    struct dx_feed *feed;
    struct dx_feed_loop *loop;
    uint64_t now_ns;
    bool lossless;
    bool nobody;

    /* mesher */
    uint64_t next_version;
    struct mesh truth;
    struct mesh history[HISTORY];
    bool for_nobody[HISTORY]; /* no lossless client was there when the epoch began */
    uint64_t epoch;           /* last committed */
    uint32_t served[DX_N_FORMS], generation[DX_N_FORMS];
    bool unsent[DX_N_FORMS][MAX_TILES];
    bool open, waiting, kicked; /* waiting: aborted, not kicked yet */
    uint32_t cursor;            /* over forms and tiles */

    uint32_t poisoned; /* home ring position */
    struct client client[MAX_CLIENTS];
};

/* What happened in all runs: a test in which nothing happens shows nothing. */
static struct {
    uint64_t n_epochs, n_batches, n_short, n_revoked;
} seen;

static uint32_t below(struct model *m, uint32_t n)
{
    return dx_rng_below(&m->rng, n);
}

static void on_kick(void *ctx)
{
    struct model *m = ctx;

    m->waiting = false;
    m->kicked = true;
}

static void on_dropped(struct dx_view *v, bool slow)
{
    struct client *c = (struct client *)((char *)v - offsetof(struct client, view));

    /* all that is not sent is still there to be copied from */
    for (uint32_t k = c->sent; v->in_batch && k < v->n_entries; k++)
        if (v->entry[k].chunk != DX_FEED_NONE)
            assert_true(feed_body_is(v->loop->feed, v->entry[k].chunk,
                                     c->expected.version[v->entry[k].tile]));
    if (slow)
        assert_true(v->in_batch);
    seen.n_revoked += slow;
    memset(c->held, 0, sizeof(c->held)); /* RESET */
    c->last_epoch = 0;
}

/* Fills the blocks of chunks that went home with a pattern that no body has. */
static void poison_home(struct model *m)
{
    struct dx_ring *r = &m->feed->home;
    uint32_t tail = atomic_load(&r->tail), head = atomic_load(&r->head);

    if ((int32_t)(m->poisoned - head) < 0)
        m->poisoned = head;
    for (; m->poisoned != tail; m->poisoned++) {
        uint32_t number = r->slot[m->poisoned & r->mask];
        const struct dx_feed_chunk *c = &m->feed->chunk[number];

        if (number >= m->feed->n_chunks)
            continue;
        for (uint32_t k = 0, b = c->first; k < c->n_blocks; k++, b = m->feed->next_block[b])
            memset(dx_feed_block(m->feed, b), 0xdd, 64);
    }
}

/* ---- mesher
 * -------------------------------------------------------------------------------------- */

static void set_tile(struct model *m, uint32_t tile)
{
    m->truth.version[tile] = below(m, 4) ? ++m->next_version : 0;
    for (int e = 0; e < DX_N_FORMS; e++)
        m->unsent[e][tile] = true;
}

static void mesher_reset(struct model *m)
{
    static const uint32_t sizes[][2] = {{65, 129}, {129, 193}, {100, 300}, {129, 321}};
    const uint32_t *size = sizes[below(m, 4)]; /* 2, 6, 10 and 10 tiles */
    struct dx_terrain_params params = {.cap_m = 1};
    struct dx_geometry *g;

    assert_int_equal(dx_geometry_new(&g, DX_MODEL_PINHOLE, size[0], size[1]), 0);
    dx_feed_reset(m->feed, g, &params, 0, "test");
    m->truth.n_tiles = ((size[0] + 62) / 64) * ((size[1] + 62) / 64);
    dx_geometry_unref(g);
    memset(m->truth.version, 0, sizeof(m->truth.version));
    for (uint32_t t = 0; t < m->truth.n_tiles; t++)
        set_tile(m, t);
    memset(m->served, 0, sizeof(m->served));
}

static bool mesher_may_begin(struct model *m)
{
    uint32_t generation[DX_N_FORMS];

    if (m->waiting || m->truth.n_tiles == 0)
        return false;
    dx_feed_wanted(m->feed, generation);
    for (int e = 0; e < DX_N_FORMS; e++)
        if (generation[e] && generation[e] != m->served[e])
            return true; /* someone waits for a form: also when the stream waits */
    return dx_feed_lossless_epoch(m->feed) >= m->epoch || !m->lossless;
}

static void mesher_begin(struct model *m)
{
    uint32_t n = below(m, 4) ? below(m, m->truth.n_tiles + 1) : 0;

    if (!mesher_may_begin(m))
        return;
    dx_feed_wanted(m->feed, m->generation);
    while (n--)
        set_tile(m, below(m, m->truth.n_tiles));
    dx_feed_begin(m->feed, m->epoch + 1, m->generation);
    m->nobody = dx_feed_lossless_epoch(m->feed) == UINT64_MAX;
    m->open = true;
    m->cursor = 0;
}

static void mesher_commit(struct model *m)
{
    struct dx_msg_commit commit = {.frame = m->epoch + 1};

    m->epoch++;
    m->history[m->epoch % HISTORY] = m->truth;
    m->for_nobody[m->epoch % HISTORY] = m->nobody;
    for (int e = 0; e < DX_N_FORMS; e++) {
        m->served[e] = m->generation[e];
        memset(m->unsent[e], 0, sizeof(m->unsent[e]));
    }
    dx_feed_commit(m->feed, &commit, NULL);
    seen.n_epochs++;
    m->open = false;
}

/* What every mesher does when kicked, whether or not it has anything new. */
static void mesher_look(struct model *m)
{
    uint32_t generation[DX_N_FORMS];

    if (!m->kicked || m->open)
        return;
    m->kicked = false;
    dx_feed_wanted(m->feed, generation);
}

static void mesher_step(struct model *m)
{
    uint32_t e = USED(m->cursor / MAX_TILES), tile = m->cursor % MAX_TILES;
    uint64_t version = tile < MAX_TILES ? m->truth.version[tile] : 0;
    uint8_t body[FEED_BODY_MAX];

    if (!m->open) {
        if (below(m, 400) == 0 && !m->waiting)
            mesher_reset(m);
        else if (below(m, 40) == 0)
            dx_feed_state(m->feed, (enum dx_stream_state)below(m, 4), "why");
        else
            mesher_begin(m);
        return;
    }
    if (m->cursor == N_USED * MAX_TILES) {
        mesher_commit(m);
        return;
    }
    m->cursor++;
    if (tile >= m->truth.n_tiles || !m->generation[e])
        return;
    /* a new generation: every tile, but an empty one need not be told */
    if (m->served[e] == m->generation[e] ? !m->unsent[e][tile] : version == 0)
        return;
    if (feed_add_body(m->feed, tile, e, body, feed_body_make(body, version)))
        return;
    m->waiting = true; /* before: the kick may come at once */
    seen.n_short++;
    dx_feed_abort(m->feed);
    m->open = false;
}

/* ---- clients
 * ------------------------------------------------------------------------------------- */

static void client_join(struct model *m, struct client *c)
{
    memset(c, 0, sizeof(*c));
    c->view = (struct dx_view){.loop = m->loop, .dropped = on_dropped};
    c->view.form = USED(below(m, N_USED));
    c->view.lossless = m->lossless && below(m, 2);
    if (below(m, 3) == 0)
        c->view.region = (struct dx_view_region){below(m, 2), below(m, 3), 1, 1 + below(m, 2)};
    assert_int_equal(dx_view_join(&c->view), 0);
    c->joined = true;
    c->stalled = below(m, 2);
}

static void client_leave(struct model *m, struct client *c)
{
    dx_view_leave(&c->view, m->now_ns);
    c->joined = false;
}

static bool inside(const struct model *m, const struct client *c, uint32_t tile)
{
    const struct dx_view_region *r = &c->view.region;
    uint32_t row = tile / m->loop->tiling.cols, col = tile % m->loop->tiling.cols;

    return !r->rows ||
           (row >= r->row0 && row < r->row0 + r->rows && col >= r->col0 && col < r->col0 + r->cols);
}

static void client_check(const struct model *m, const struct client *c)
{
    for (uint32_t t = 0; t < c->expected.n_tiles; t++)
        assert_int_equal(c->held[t], inside(m, c, t) ? c->expected.version[t] : 0);
}

static void client_send(struct model *m, struct client *c, uint32_t n)
{
    struct dx_view *v = &c->view;

    for (; n && c->sent < v->n_entries; n--, c->sent++) {
        struct dx_view_entry e = v->entry[c->sent];

        if (e.chunk == DX_FEED_NONE)
            assert_int_equal(c->expected.version[e.tile], 0);
        else
            assert_true(feed_body_is(m->feed, e.chunk, c->expected.version[e.tile]));
        c->held[e.tile] = c->expected.version[e.tile];
        dx_view_release(v, c->sent);
    }
    if (n == 0 || c->sent < v->n_entries)
        return;
    assert_int_equal(v->commit.frame, v->batch_epoch);
    client_check(m, c);
    if (v->lossless && c->last_epoch)
        for (uint64_t e = c->last_epoch + 1; e < v->batch_epoch; e++)
            assert_true(m->for_nobody[e % HISTORY]);
    c->last_epoch = v->batch_epoch;
    dx_view_end(v);
    seen.n_batches++;
}

static void client_step(struct model *m, struct client *c, uint32_t n)
{
    struct dx_view *v = &c->view;

    if (!v->in_batch) {
        if (!dx_view_ready(v) || !dx_view_begin(v, m->now_ns))
            return;
        c->sent = 0;
        c->expected = m->history[v->batch_epoch % HISTORY];
    }
    client_send(m, c, n);
}

static void clients_act(struct model *m)
{
    struct client *c = &m->client[below(m, MAX_CLIENTS)];

    if (!c->joined) {
        if (below(m, 4) == 0)
            client_join(m, c);
    } else if (below(m, 150) == 0) {
        client_leave(m, c);
    } else if (!c->stalled || below(m, 20) == 0) {
        client_step(m, c, 1 + below(m, c->stalled ? 3 : 2 * MAX_TILES));
    }
    dx_feed_loop_settle(m->loop);
}

/* ---- the run
 * ------------------------------------------------------------------------------------- */

static void check_pins(const struct model *m)
{
    uint64_t seq[MAX_CLIENTS];
    uint32_t n = 0;

    for (uint32_t k = 0; k < MAX_CLIENTS; k++) {
        const struct dx_view *v = &m->client[k].view;
        bool known =
            !m->client[k].joined || !v->in_batch || v->n_held == 0 || v->batch_seq == m->loop->seq;

        for (uint32_t i = 0; i < n; i++)
            known = known || seq[i] == v->batch_seq;
        if (!known)
            seq[n++] = v->batch_seq;
    }
    assert_true(n <= DX_FEED_MAX_PINS);
}

static void step(struct model *m)
{
    uint32_t what = below(m, 10);

    m->now_ns += below(m, 40000000);
    if (below(m, 500) == 0) { /* all go: forms are no longer wanted */
        for (uint32_t k = 0; k < MAX_CLIENTS; k++)
            if (m->client[k].joined)
                client_leave(m, &m->client[k]);
        m->now_ns += DX_FEED_LINGER_NS;
        dx_feed_loop_expire(m->loop, m->now_ns);
    }
    if (what < 5) {
        for (uint32_t n = 1 + below(m, 12); n; n--)
            mesher_step(m);
    } else if (what < 6) {
        dx_feed_loop_turn(m->loop);
        dx_feed_loop_expire(m->loop, m->now_ns);
    } else {
        clients_act(m);
    }
    check_pins(m);
    poison_home(m);
}

/* Whatever state the run left: with everyone willing, all reach the mesher's last mesh. */
static void settle(struct model *m)
{
    uint64_t goal;

    for (int round = 0; m->open; round++)
        mesher_step(m);
    goal = m->epoch + 1;
    for (int round = 0; round < 2000; round++) {
        bool done = m->epoch >= goal && !m->open;

        dx_feed_loop_turn(m->loop);
        for (uint32_t k = 0; k < MAX_CLIENTS; k++)
            if (m->client[k].joined) {
                client_step(m, &m->client[k], MAX_TILES + 1);
                done = done && m->client[k].view.done_epoch == m->epoch;
            }
        dx_feed_loop_settle(m->loop);
        poison_home(m);
        if (done || m->truth.n_tiles == 0)
            return;
        if (m->open)
            mesher_step(m);
        else if (m->epoch < goal)
            mesher_begin(m);
        mesher_look(m);
        m->now_ns += 1000000;
    }
    fail_msg("someone is stuck");
}

static void check_home(struct model *m)
{
    uint32_t generation[DX_N_FORMS];

    for (uint32_t k = 0; k < MAX_CLIENTS; k++)
        if (m->client[k].joined)
            client_leave(m, &m->client[k]);
    do
        dx_feed_wanted(m->feed, generation);
    while (dx_feed_loop_turn(m->loop));
    assert_int_equal(m->loop->n_pins, 0);
    dx_feed_loop_free(m->loop);
    dx_feed_wanted(m->feed, generation);
    assert_int_equal(m->feed->free_chunks.n, m->feed->n_chunks);
    assert_int_equal(m->feed->free_blocks.n, m->feed->memory_len / DX_FEED_BLOCK_LEN);
    assert_int_equal(m->feed->free_events.n, m->feed->n_events);
    dx_feed_free(m->feed);
}

static void run(uint64_t seed, uint32_t n_steps)
{
    struct model *m = calloc(1, sizeof(*m));
    uint32_t n_blocks, n_chunks;

    m->rng = dx_rng_init(seed, 0);
    m->lossless = below(m, 4) == 0;
    m->now_ns = 1000000000;
    /* Two frames of the longest bodies always fit, or a mesher could starve for good. Bodies are
     * mostly one block, so it is the number of chunks that runs short. */
    n_chunks = MAX_TILES * N_USED * 2 + below(m, MAX_TILES);
    n_blocks = 2 * FRAME_BLOCKS + below(m, FRAME_BLOCKS);
    assert_int_equal(dx_feed_new_sized(&m->feed, MAX_TILES, n_blocks, n_chunks,
                                       m->lossless ? 16 : 3 + below(m, 8), -1, on_kick, m),
                     0);
    assert_int_equal(dx_feed_loop_new(&m->loop, m->feed), 0);
    mesher_reset(m);
    while (n_steps--)
        step(m);
    settle(m);
    check_home(m);
    free(m);
}

static void test_model(void **state)
{
    const char *seeds = getenv("FEED_SEEDS");
    uint64_t n_seeds = seeds ? strtoull(seeds, NULL, 10) : ROUNDS(2000);

    (void)state;
    for (uint64_t seed = 0; seed < n_seeds; seed++)
        run(seed, 2000);
    printf("%llu seeds: %llu epochs, %llu batches, %llu shortages, %llu revoked\n",
           (unsigned long long)n_seeds, (unsigned long long)seen.n_epochs,
           (unsigned long long)seen.n_batches, (unsigned long long)seen.n_short,
           (unsigned long long)seen.n_revoked);
    /* the first seeds revoke less than the others */
    assert_true(seen.n_short > n_seeds && (n_seeds < 2000 ? 4 : 2) * seen.n_revoked > n_seeds);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_model)};

    return cmocka_run_group_tests(tests, NULL, NULL);
}
