/*
 * The encoder's decoder: golden sequences, bounce, lost and reordered edges, gaps, the index; a
 * million random steps against a model; the order of events of several queues.
 */
#include "drivers/gpio/edge_merge.h"
#include "drivers/gpio/quadrature.h"

#include "core/base/rng.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#define TURN  40
#define WIDTH 3 /* counts that the index line is high */

static unsigned edge(struct dx_quadrature *q, char line)
{
    /* A, B, Z rise; a, b, z fall */
    bool rising = line < 'a';
    char up = (char)(rising ? line : line - 'a' + 'A');

    return dx_quadrature_edge(q,
                              up == 'A'   ? DX_QUADRATURE_A
                              : up == 'B' ? DX_QUADRATURE_B
                                          : DX_QUADRATURE_Z,
                              rising, false);
}

static void feed(struct dx_quadrature *q, const char *edges)
{
    for (; *edges; edges++)
        edge(q, *edges);
}

static void counts_golden_sequences(void **state)
{
    static const struct {
        const char *edges;
        int64_t count;
    } golden[] = {
        {"ABab", 4},         /* a cycle up */
        {"BAba", -4},        /* and down */
        {"ABabABab", 8},     /* two */
        {"ABabBAba", 0},     /* up and back */
        {"AaAaAa", 0},       /* it trembles on one edge */
        {"ABbB", 2},         /* bounce of B */
        {"AaABbBaAabBb", 4}, /* bounce of each */
        {"A", 1},
        {"B", -1},
        {"AB", 2},
        {"BA", -2},
    };

    (void)state;
    for (size_t k = 0; k < sizeof(golden) / sizeof(golden[0]); k++) {
        struct dx_quadrature q;

        dx_quadrature_init(&q, TURN, false, false, false);
        feed(&q, golden[k].edges);
        if (q.count != golden[k].count)
            fail_msg("%s: %lld", golden[k].edges, (long long)q.count);
        assert_false(q.is_uncertain);
        assert_int_equal(q.n_doubts, 0);
    }
}

/* From each of the four states, each of the four that can follow. */
static void knows_sixteen_transitions(void **state)
{
    static const int want[4][4] = {{0, -1, 1, 9}, {1, 0, 9, -1}, {-1, 9, 0, 1}, {9, 1, -1, 0}};

    (void)state;
    for (unsigned from = 0; from < 4; from++)
        for (unsigned to = 0; to < 4; to++) {
            struct dx_quadrature q;
            unsigned r;

            dx_quadrature_init(&q, TURN, false, from & 2, from & 1);
            r = dx_quadrature_levels(&q, to & 2, to & 1);
            if (want[from][to] == 9) {
                assert_int_equal(r, DX_QUADRATURE_DOUBT | DX_QUADRATURE_MOVED);
                assert_int_equal(q.count, 0); /* no direction yet: it is not known which way */
                assert_true(q.is_uncertain);
            } else {
                assert_int_equal(q.count, want[from][to]);
                assert_int_equal(r, want[from][to] ? DX_QUADRATURE_MOVED : 0);
                assert_false(q.is_uncertain);
            }
        }
}

static void doubts_until_the_index(void **state)
{
    struct dx_quadrature q;

    (void)state;
    dx_quadrature_init(&q, TURN, true, false, false);
    assert_true(q.is_uncertain); /* not passed yet */
    feed(&q, "ABabAZ");
    assert_true(q.is_uncertain); /* it may still turn back */
    assert_int_equal(edge(&q, 'B'),
                     DX_QUADRATURE_MOVED | DX_QUADRATURE_INDEX | DX_QUADRATURE_REZEROED);
    assert_int_equal(q.count, 1); /* the zero is one before */
    assert_false(q.is_uncertain);
    assert_int_equal(q.n_mismatch, 0);
    for (int turn = 1; turn <= 3; turn++) {
        feed(&q, "azbA");
        for (int k = 1; k < TURN / 4; k++)
            feed(&q, "BabA");
        assert_int_equal(q.count, turn * TURN);
        edge(&q, 'Z');
        assert_int_equal(edge(&q, 'B'), DX_QUADRATURE_MOVED | DX_QUADRATURE_INDEX);
    }
    assert_int_equal(q.n_index, 4);
    assert_int_equal(q.n_mismatch, 0);

    /* an edge is lost: the same edge comes twice */
    assert_int_equal(edge(&q, 'B'), DX_QUADRATURE_DOUBT);
    assert_true(q.is_uncertain);
    /* a cycle is lost as well: nobody can see that, but the index */
    feed(&q, "azb");
    for (int k = 2; k < TURN / 4; k++)
        feed(&q, "ABab");
    feed(&q, "AZ");
    assert_int_equal(edge(&q, 'B'),
                     DX_QUADRATURE_MOVED | DX_QUADRATURE_INDEX | DX_QUADRATURE_REZEROED);
    assert_int_equal(q.count, 4 * TURN + 1);
    assert_int_equal(q.n_mismatch, 1);
    assert_int_equal(q.last_mismatch, -4);
    assert_false(q.is_uncertain);
}

/* The index's other side, and turns back on top of it, are no turn. */
static void an_index_is_passed_one_way(void **state)
{
    static const struct {
        const char *edges;
        uint64_t n;
    } ways[] = {
        {"ABaZb", 1},     /* up, over its beginning */
        {"BAbZa", 0},     /* down, into its end */
        {"BAbZazB", 1},   /* down, and out at its beginning */
        {"ABaZzb", 0},    /* it trembles */
        {"ABaZzZb", 1},   /* ... and comes in */
        {"ABaZA", 0},     /* up to it, and back */
        {"ABaZbzA", 1},   /* over it, out at its end */
        {"ABaZbzBZA", 1}, /* ... in again from there */
        {"BAbZzB", 0},    /* down to its end, and back */
    };

    (void)state;
    for (size_t k = 0; k < sizeof(ways) / sizeof(ways[0]); k++) {
        struct dx_quadrature q;

        dx_quadrature_init(&q, TURN, true, false, false);
        feed(&q, ways[k].edges);
        if (q.n_index != ways[k].n || q.n_doubts)
            fail_msg("%s: %llu", ways[k].edges, (unsigned long long)q.n_index);
    }
}

static void gaps_and_overflows_are_doubts(void **state)
{
    struct dx_quadrature q;

    (void)state;
    dx_quadrature_init(&q, TURN, false, false, false);
    assert_int_equal(dx_quadrature_edge(&q, DX_QUADRATURE_A, true, true),
                     DX_QUADRATURE_DOUBT | DX_QUADRATURE_MOVED);
    assert_true(q.is_uncertain);
    assert_int_equal(q.n_doubts, 1);
    /* a repeated edge after a gap is the same doubt, once */
    assert_int_equal(dx_quadrature_edge(&q, DX_QUADRATURE_A, true, true), DX_QUADRATURE_DOUBT);
    assert_int_equal(q.n_doubts, 2);
    feed(&q, "BabA");
    assert_true(q.is_uncertain); /* without an index for good */
}

/* At one time A and B changed: two counts, the way it went before. */
static void an_unknown_order_goes_on(void **state)
{
    struct dx_quadrature q;

    (void)state;
    dx_quadrature_init(&q, TURN, false, false, false);
    feed(&q, "ABab");
    assert_int_equal(dx_quadrature_both(&q, true, true), DX_QUADRATURE_DOUBT | DX_QUADRATURE_MOVED);
    assert_int_equal(q.count, 6);
    feed(&q, "abBAba"); /* up to 8, and back */
    assert_int_equal(q.count, 4);
    assert_int_equal(dx_quadrature_both(&q, true, true), DX_QUADRATURE_DOUBT | DX_QUADRATURE_MOVED);
    assert_int_equal(q.count, 2);
    assert_true(q.is_uncertain);
}

/* ---- against a model
 * ---------------------------------------------------------------------------- */

/* An encoder at a position in counts: its lines, and the index over WIDTH counts of each turn. */
struct model {
    int64_t at;
    bool a, b, z;
};

static void put_model(struct model *m, int64_t at)
{
    int64_t cell = at & 3, in_turn = ((at % TURN) + TURN) % TURN;

    m->at = at;
    m->a = cell == 1 || cell == 2;
    m->b = cell == 2 || cell == 3;
    m->z = in_turn < WIDTH;
}

/* One count on; its edges reach the decoder, the index's first or last. */
static void move(struct model *m, struct dx_quadrature *q, int step, bool z_first)
{
    struct model was = *m;

    put_model(m, m->at + step);
    if (z_first && m->z != was.z)
        dx_quadrature_edge(q, DX_QUADRATURE_Z, m->z, false);
    if (m->a != was.a)
        dx_quadrature_edge(q, DX_QUADRATURE_A, m->a, false);
    if (m->b != was.b)
        dx_quadrature_edge(q, DX_QUADRATURE_B, m->b, false);
    if (!z_first && m->z != was.z)
        dx_quadrature_edge(q, DX_QUADRATURE_Z, m->z, false);
}

/* It wanders, trembles and turns on; once it has passed the index, its count is the model's up to
 * whole turns, and no edge of the index says otherwise. */
static void follows_a_million_steps(void **state)
{
    struct dx_rng rng = dx_rng_init(5, 0);
    struct dx_quadrature q;
    struct model m;
    int dir = 1, left = 0;
    int64_t off = 0;

    (void)state;
    put_model(&m, 17);
    dx_quadrature_init(&q, TURN, true, m.a, m.b);
    for (int k = 0; k < 1000000; k++) {
        bool was_indexed = q.is_indexed;

        if (left-- == 0) {
            dir = dx_rng_u64(&rng) & 1 ? 1 : -1;
            left = (int)(dx_rng_u64(&rng) % (dx_rng_u64(&rng) % 4 ? 200 : 4));
        }
        move(&m, &q, dir, dx_rng_u64(&rng) & 1);
        if (!was_indexed && q.is_indexed)
            off = q.count - m.at;
        if (q.is_indexed && q.count - m.at != off)
            fail_msg("step %d: %lld at %lld", k, (long long)q.count, (long long)m.at);
    }
    assert_true(q.is_indexed);
    assert_true(off % TURN >= -1 && off % TURN <= 1);
    assert_int_equal(q.n_doubts, 0);
    assert_int_equal(q.n_mismatch, 0);
    assert_true(q.n_index > 1000);
}

/* The same with edges that get lost: whenever the index has been passed after the last loss by two
 * edges in turn, the count is right again. */
static void recovers_from_losses(void **state)
{
    struct dx_rng rng = dx_rng_init(5, 0);
    struct dx_quadrature q;
    struct model m;
    int n_lost = 0, n_right = 0;

    (void)state;
    put_model(&m, 0);
    dx_quadrature_init(&q, TURN, true, m.a, m.b);
    for (int turn = 0; turn < 2000; turn++) {
        int lose_at = (int)(dx_rng_u64(&rng) % TURN), n_lose = (int)(dx_rng_u64(&rng) % 7);

        if (turn % 3) /* a good turn or two after each bad one */
            n_lose = 0;
        for (int k = 0; k < TURN; k++) {
            if (k > WIDTH && k >= lose_at && k < lose_at + n_lose && k + 2 < TURN) {
                put_model(&m, m.at + 1);
                n_lost++;
            } else {
                move(&m, &q, 1, false);
            }
        }
        if (turn % 3 == 2) {
            int64_t off = (q.count - m.at) % TURN;

            assert_true(off >= -1 && off <= 1);
            assert_false(q.is_uncertain);
            n_right++;
        }
    }
    assert_true(n_lost > 1000);
    assert_int_equal(n_right, 666);
    assert_true(q.n_doubts > 300);
    assert_true(q.n_mismatch > 50);
}

/* ---- the order of queues
 * ------------------------------------------------------------------------ */

static void push(struct dx_edge_merge *m, uint32_t line, uint64_t t_ns)
{
    const struct dx_gpio_event e = {.timestamp_ns = t_ns, .line = line};

    assert_true(dx_edge_merge_push(m, &e));
}

static void expect(struct dx_edge_merge *m, uint64_t horizon_ns, uint32_t line, uint64_t t_ns,
                   bool is_late)
{
    struct dx_edge_merged out;

    assert_true(dx_edge_merge_pop(m, horizon_ns, &out));
    assert_int_equal(out.n, 1);
    assert_int_equal(out.event[0].line, line);
    assert_int_equal(out.event[0].timestamp_ns, t_ns);
    assert_int_equal(out.is_late, is_late);
}

static void merges_by_time(void **state)
{
    struct dx_edge_merge m;
    struct dx_edge_merged out;

    (void)state;
    dx_edge_merge_init(&m, 2);
    assert_false(dx_edge_merge_pop(&m, UINT64_MAX, &out));
    push(&m, 0, 10);
    push(&m, 0, 30);
    assert_false(dx_edge_merge_pop(&m, 10, &out)); /* line 1 may still tell of one before */
    push(&m, 1, 20);
    expect(&m, 0, 0, 10, false); /* its next event is later: nothing can come between */
    expect(&m, 0, 1, 20, false);
    assert_false(dx_edge_merge_pop(&m, 30, &out));
    expect(&m, 31, 0, 30, false); /* nothing before 31 will come */
    assert_false(dx_edge_merge_waits(&m));
    push(&m, 1, 25); /* but it does */
    expect(&m, 40, 1, 25, true);
    push(&m, 0, 50);
    expect(&m, 60, 0, 50, false);
}

static void tells_what_it_cannot_order(void **state)
{
    struct dx_edge_merge m;
    struct dx_edge_merged out;

    (void)state;
    dx_edge_merge_init(&m, 3);
    push(&m, 1, 10);
    push(&m, 0, 10);
    push(&m, 2, 10); /* the index beside them needs no order */
    assert_true(dx_edge_merge_pop(&m, 11, &out));
    assert_int_equal(out.n, 2);
    assert_int_equal(out.event[0].line, 0);
    assert_int_equal(out.event[1].line, 1);
    expect(&m, 11, 2, 10, false);
    push(&m, 1, 20);
    expect(&m, 21, 1, 20, false);
    push(&m, 0, 20); /* it came after the other had been given out */
    expect(&m, 21, 0, 20, true);
    for (uint32_t k = 0; k < DX_EDGE_MERGE_DEPTH; k++)
        push(&m, 0, 30 + k);
    assert_false(dx_edge_merge_push(&m, &(struct dx_gpio_event){.timestamp_ns = 99}));
    assert_true(dx_edge_merge_push(&m, &(struct dx_gpio_event){.line = 7})); /* of no interest */
    expect(&m, 31, 0, 30, false);
    push(&m, 0, 99);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(counts_golden_sequences),
        cmocka_unit_test(knows_sixteen_transitions),
        cmocka_unit_test(doubts_until_the_index),
        cmocka_unit_test(an_index_is_passed_one_way),
        cmocka_unit_test(gaps_and_overflows_are_doubts),
        cmocka_unit_test(an_unknown_order_goes_on),
        cmocka_unit_test(follows_a_million_steps),
        cmocka_unit_test(recovers_from_losses),
        cmocka_unit_test(merges_by_time),
        cmocka_unit_test(tells_what_it_cannot_order),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
