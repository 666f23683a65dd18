/*
 * The Kinect's bytes on the wire: control messages to the byte, and frames out of packets that are
 * lost, cut, changed, and come from the middle of a stream; the clock that wraps.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "core/base/bytes.h"
#include "drivers/kinect/kinect_clock.h"
#include "drivers/kinect/kinect_protocol.h"
#include "tests/hil/kinect_sim.h"

#include <stdlib.h>

/* ---- control messages
 * ---------------------------------------------------------------------------- */

static void the_start_is_the_known_one(void **state)
{
    static const uint8_t golden[DX_KINECT_N_START][12] = {
        {0x47, 0x4d, 2, 0, 3, 0, 0, 0, 0x05, 1, 0, 0},
        {0x47, 0x4d, 2, 0, 3, 0, 1, 0, 0x06, 0, 0, 0},
        {0x47, 0x4d, 2, 0, 3, 0, 2, 0, 0x12, 0, 3, 0},
        {0x47, 0x4d, 2, 0, 3, 0, 3, 0, 0x13, 0, 1, 0},
        {0x47, 0x4d, 2, 0, 3, 0, 4, 0, 0x14, 0, 30, 0},
        {0x47, 0x4d, 2, 0, 3, 0, 5, 0, 0x06, 0, 2, 0},
        {0x47, 0x4d, 2, 0, 3, 0, 6, 0, 0x17, 0, 0, 0},
    };
    struct dx_kinect_write writes[DX_KINECT_N_START];
    uint8_t bytes[DX_KINECT_MESSAGE_LEN + 2 * DX_KINECT_MAX_WORDS];

    (void)state;
    dx_kinect_start_writes(writes, 11);
    for (uint16_t k = 0; k < DX_KINECT_N_START; k++) {
        const uint16_t words[] = {writes[k].reg, writes[k].value};

        assert_int_equal(dx_kinect_request_put(bytes, DX_KINECT_WRITE, k, words, 2), 12);
        assert_memory_equal(bytes, golden[k], 12);
    }
    dx_kinect_start_writes(writes, 10);
    assert_int_equal(writes[2].value, 2);
}

static void constants_are_asked_for_and_read(void **state)
{
    static const uint8_t ask[] = {0x47, 0x4d, 5, 0, 0x16, 0, 8, 0, 0, 0, 0, 0, 1, 0, 30, 0, 0, 0};
    static const uint8_t shift[] = {0x52, 0x42, 2, 0, 0x16, 0, 8, 0, 0, 0, 0xc8, 0};
    static const uint8_t floats[] = {0, 0, 0xf0, 0x40, 0x33, 0x33, 0x13, 0x40,
                                     0, 0, 0xf0, 0x42, 0xcf, 0x66, 0xd5, 0x3d};
    uint8_t bytes[DX_KINECT_MESSAGE_LEN + 2 * DX_KINECT_MAX_WORDS], fixed[322] = {0};
    struct dx_kinect_constants c = {0};
    struct dx_err err;
    const uint8_t *payload;
    size_t len;

    (void)state;
    assert_int_equal(
        dx_kinect_request_put(bytes, DX_KINECT_ALGORITHM, 8, (const uint16_t[]){0, 0, 1, 30, 0}, 5),
        sizeof(ask));
    assert_memory_equal(bytes, ask, sizeof(ask));
    payload = dx_kinect_reply_get(shift, sizeof(shift), DX_KINECT_ALGORITHM, 8, &len, &err);
    assert_non_null(payload);
    assert_true(dx_kinect_shift_get(&c, payload, len));
    assert_int_equal(c.shift, 200);
    memcpy(fixed + 94, floats, sizeof(floats));
    assert_true(dx_kinect_fixed_get(&c, fixed, sizeof(fixed)));
    assert_true(c.emitter_cm == 7.5f && c.rcmos_cm == 2.3f && c.reference_mm == 120.0f &&
                c.pixel_mm == 0.1042f);
    assert_false(dx_kinect_fixed_get(&c, fixed, 109));
    assert_true(dx_kinect_fixed_get(&c, fixed, 110));
    assert_false(dx_kinect_shift_get(&c, fixed, 3));
}

static void a_reply_must_be_whole_and_ours(void **state)
{
    static const uint8_t good[] = {0x52, 0x42, 1, 0, 3, 0, 0, 0, 0, 0};
    struct dx_err err;
    uint8_t b[sizeof(good)];
    size_t len;

    (void)state;
    assert_ptr_equal(dx_kinect_reply_get(good, 10, DX_KINECT_WRITE, 0, &len, &err), good + 8);
    assert_int_equal(len, 2);
    for (size_t n = 0; n < sizeof(good); n++)
        assert_null(dx_kinect_reply_get(good, n, DX_KINECT_WRITE, 0, &len, &err));
    /* Any bit of the header. */
    for (unsigned bit = 0; bit < 64; bit++) {
        memcpy(b, good, sizeof(b));
        b[bit / 8] ^= (uint8_t)(1u << bit % 8);
        assert_null(dx_kinect_reply_get(b, sizeof(b), DX_KINECT_WRITE, 0, &len, &err));
    }
}

/* ---- frames
 * -------------------------------------------------------------------------------------- */

#define N_PACKETS 242
#define FRAME_LEN 422400

struct rig {
    struct kinect_sim sim;
    struct dx_kinect_assembler a;
    struct dx_kinect_frame got; /* the newest */
    unsigned n_got;
    uint64_t n_holes; /* of all */
    uint8_t bytes[FRAME_LEN], packet[DX_KINECT_PACKET_LEN];
};

/* Every byte of a frame is the camera's, or is in a hole that the frame tells. */
static uint8_t *check_frame(void *ctx, const struct dx_kinect_frame *frame)
{
    struct rig *rig = ctx;
    unsigned n_lost = 0;

    for (unsigned k = 0; k < rig->a.n_packets; k++) {
        size_t at = (size_t)k * DX_KINECT_PAYLOAD_LEN;
        size_t len = dx_kinect_payload_len(rig->a.frame_len, k);

        if (frame->lost[k / 8] >> k % 8 & 1) {
            n_lost++;
            for (size_t i = 0; i < len; i++)
                assert_int_equal(frame->bytes[at + i], 0xff);
        } else
            assert_memory_equal(frame->bytes + at, rig->sim.packed + at, len);
    }
    assert_int_equal(n_lost, frame->n_lost);
    rig->got = *frame;
    rig->n_got++;
    rig->n_holes += n_lost;
    memset(rig->bytes, 0x55, sizeof(rig->bytes)); /* nothing of this frame may show in the next */
    return rig->bytes;
}

static struct rig *rig_new(int bits)
{
    struct rig *rig = calloc(1, sizeof(*rig));

    kinect_sim_init(&rig->sim);
    rig->sim.registers[DX_KINECT_DEPTH_FORMAT] = bits == 11 ? 3 : 2;
    for (size_t k = 0; k < sizeof(rig->sim.packed); k++)
        rig->sim.packed[k] = (uint8_t)(k * 2654435761u >> 13);
    dx_kinect_assembler_init(&rig->a, bits, rig->bytes, check_frame, rig);
    return rig;
}

static void feed(struct rig *rig, unsigned n)
{
    while (n--) {
        size_t len = kinect_sim_packet(&rig->sim, rig->packet);

        if (len)
            dx_kinect_assembler_feed(&rig->a, rig->packet, len);
    }
}

static void packets_have_the_known_shape(void **state)
{
    (void)state;
    assert_int_equal(dx_kinect_n_packets(422400), 242);
    assert_int_equal(dx_kinect_payload_len(422400, 0), 1748);
    assert_int_equal(dx_kinect_payload_len(422400, 241), 1132);
    assert_int_equal(dx_kinect_n_packets(384000), 220);
    assert_int_equal(dx_kinect_payload_len(384000, 219), 1188);
}

static void frames_come_whole(void **state)
{
    struct rig *rig = rig_new(11);

    (void)state;
    feed(rig, 3 * N_PACKETS);
    assert_int_equal(rig->n_got, 3);
    assert_int_equal(rig->n_holes, 0);
    assert_int_equal(rig->got.ticks, 1000 + 2 * 2000000);
    assert_int_equal(rig->a.counts.n_packets, 3 * N_PACKETS);
    free(rig);
    rig = rig_new(10);
    feed(rig, 2 * 220);
    assert_int_equal(rig->n_got, 2);
    free(rig);
}

static void a_stream_is_joined_at_any_packet(void **state)
{
    (void)state;
    for (unsigned at = 0; at < N_PACKETS; at++) {
        struct rig *rig = rig_new(11);

        for (unsigned k = 0; k < at; k++)
            kinect_sim_packet(&rig->sim, rig->packet); /* nobody listens yet */
        feed(rig, 2 * N_PACKETS);
        assert_int_equal(rig->n_got, at == 0 ? 2 : 1);
        assert_int_equal(rig->n_holes, 0);
        free(rig);
    }
}

static void up_to_five_lost_are_a_hole_wherever(void **state)
{
    (void)state;
    for (unsigned n = 1; n <= 6; n++)
        for (unsigned at = 1; at + n <= N_PACKETS; at += at < 8 || at > 228 ? 1 : 37) {
            struct rig *rig = rig_new(11);

            feed(rig, N_PACKETS);
            rig->sim.faults.lose_at = at;
            rig->sim.faults.lose_n = n;
            while (rig->sim.n_frames < 2)
                feed(rig, 1);
            rig->sim.faults.lose_n = 0;
            feed(rig, 2 * N_PACKETS);
            assert_int_equal(rig->n_holes, n <= 5 ? n : 0);
            assert_int_equal(rig->n_got + rig->a.counts.n_frames_lost, rig->sim.n_frames);
            assert_int_equal(rig->a.counts.n_frames_lost, n > 5);
            assert_int_equal(rig->a.counts.n_lost, n);
            free(rig);
        }
}

/* The end of one frame and the beginning of the next, together. */
static void a_gap_over_a_border_holes_both(void **state)
{
    struct rig *rig = rig_new(11);

    (void)state;
    feed(rig, N_PACKETS - 2);
    for (unsigned k = 0; k < 4; k++)
        kinect_sim_packet(&rig->sim, rig->packet);
    feed(rig, 1);
    assert_int_equal(rig->n_got, 1);
    assert_int_equal(rig->got.n_lost, 2);
    feed(rig, N_PACKETS - 3);
    assert_int_equal(rig->n_got, 2);
    assert_int_equal(rig->got.n_lost, 2);
    assert_int_equal(rig->got.lost[0], 3);
    free(rig);
}

static void losses_by_chance_never_show_as_data(void **state)
{
    static const uint32_t ppm[] = {1000, 10000, 100000};

    (void)state;
    for (unsigned k = 0; k < 3; k++) {
        struct rig *rig = rig_new(11);

        rig->sim.faults.lose_ppm = ppm[k];
        rig->sim.faults.idle_every = 10;
        while (rig->sim.n_frames < 60)
            feed(rig, 1);
        /* A gap of six has one chance in a million at each packet, at a tenth lost. */
        assert_true(rig->n_got >= 55 && rig->n_got <= 60);
        assert_true(rig->n_holes > 60u * N_PACKETS * ppm[k] / 2000000);
        free(rig);
    }
}

static void what_is_cut_or_changed_is_left_out(void **state)
{
    struct rig *rig = rig_new(11);

    (void)state;
    rig->sim.faults = (struct kinect_sim_faults){.magic_ppm = 5000, .short_ppm = 5000};
    while (rig->sim.n_frames < 60)
        feed(rig, 1);
    assert_true(rig->n_got >= 59);
    assert_true(rig->n_holes > 0);
    assert_true(rig->a.counts.n_bad >= rig->n_holes);
    rig->sim.faults = (struct kinect_sim_faults){.flag_ppm = 2000};
    while (rig->sim.n_frames < 120)
        feed(rig, 1);
    /* A wrong flag is a frame that is not trusted; the next one is taken again. */
    assert_true(rig->a.counts.n_frames_damaged > 5);
    rig->sim.faults.flag_ppm = 0;
    rig->n_got = 0;
    feed(rig, 3 * N_PACKETS);
    assert_true(rig->n_got >= 2);
    free(rig);
}

/* Packets of two frames, of different content, in turn: nothing is given that mixes them. */
static void mixed_frames_are_not_given(void **state)
{
    struct rig *rig = rig_new(11), *other = rig_new(11);

    (void)state;
    memset(other->sim.packed, 0xa5, sizeof(other->sim.packed));
    other->sim.sequence = 128;
    feed(rig, 10);
    for (unsigned k = 0; k < 300; k++) {
        size_t len = kinect_sim_packet(&other->sim, other->packet);

        dx_kinect_assembler_feed(&rig->a, other->packet, len);
        feed(rig, 1);
    }
    assert_int_equal(rig->n_got, 0); /* check_frame would have seen the other's bytes */
    assert_true(rig->a.counts.n_frames_lost > 0);
    feed(rig, 2 * N_PACKETS);
    assert_int_equal(rig->n_got, 1);
    free(rig);
    free(other);
}

/* A packet cut to any length is a hole, the last one too; longer ones are none of ours. */
static void lengths_are_checked(void **state)
{
    static uint8_t long_one[DX_KINECT_PACKET_LEN + 1];

    (void)state;
    for (unsigned which = 1; which < N_PACKETS; which += N_PACKETS - 2)
        for (size_t cut = 0; cut <= DX_KINECT_PACKET_LEN; cut += cut < 16 ? 1 : 29) {
            struct rig *rig = rig_new(11);
            size_t len;

            feed(rig, which);
            len = kinect_sim_packet(&rig->sim, rig->packet);
            dx_kinect_assembler_feed(&rig->a, rig->packet, cut < len ? cut : len);
            feed(rig, N_PACKETS - which);
            assert_int_equal(rig->n_got, 1);
            assert_int_equal(rig->got.n_lost, cut < len);
            free(rig);
        }
    for (int last = 0; last < 2; last++) {
        struct rig *rig = rig_new(11);

        feed(rig, last ? N_PACKETS - 1 : 1);
        kinect_sim_packet(&rig->sim, rig->packet);
        memcpy(long_one, rig->packet, sizeof(rig->packet));
        dx_kinect_assembler_feed(&rig->a, long_one, sizeof(long_one));
        feed(rig, last ? 1 : N_PACKETS - 1);
        assert_int_equal(rig->n_got, 1);
        assert_int_equal(rig->got.n_lost, last ? 0 : 1);
        free(rig);
    }
}

/* ---- the clock
 * ----------------------------------------------------------------------------------- */

static void the_clock_goes_on_over_its_wrap(void **state)
{
    struct dx_kinect_clock c;
    uint64_t ns = 0, last = 0;
    uint32_t ticks = 0xffff0000u;

    (void)state;
    dx_kinect_clock_init(&c, 60e6);
    for (unsigned k = 0; k < 3 * 72 * 30; k++, ticks += 2000000) { /* 3.6 minutes: three wraps */
        ns = dx_kinect_clock_ns(&c, ticks, 1000 + k * UINT64_C(33333333));
        assert_true(k == 0 ? ns == 0 : ns > last);
        last = ns;
    }
    assert_true(llabs((long long)ns - 215966666667ll) < 1000);
    /* Silent for 200 s, in which it wrapped twice. */
    ns = dx_kinect_clock_ns(&c, ticks - 2000000 + (uint32_t)(UINT64_C(12000000000)),
                            1000 + 6479 * UINT64_C(33333333) + UINT64_C(200000000000));
    assert_true(llabs((long long)(ns - last) - 200000000000ll) < 1000);
}

/* Ticks that are damaged, and a camera that counts from 0 again. */
static void a_jump_of_the_counter_is_none_of_time(void **state)
{
    static const uint32_t ticks[] = {5000000,  7000000, 3000000000u, 11000000,
                                     13000000, 100,     2000100};
    struct dx_kinect_clock c;
    uint64_t last = 0;

    (void)state;
    dx_kinect_clock_init(&c, 60e6);
    for (unsigned k = 0; k < sizeof(ticks) / sizeof(ticks[0]); k++) {
        uint64_t ns = dx_kinect_clock_ns(&c, ticks[k], k * UINT64_C(33333333));

        assert_true(k == 0 || (ns - last > 33000000 && ns - last < 34000000));
        last = ns;
    }
}

/* A camera of another rate than is thought: soon its seconds are the host's, and never go back. */
static void the_rate_is_measured(void **state)
{
    struct dx_kinect_clock c;
    uint64_t last = 0, at_20 = 0;

    (void)state;
    dx_kinect_clock_init(&c, 0);
    for (unsigned k = 0; k <= 1200; k++) {
        uint64_t late = k % 7 * 300000; /* frames come up to 2 ms late */
        uint64_t ns = dx_kinect_clock_ns(&c, k * 1600000u, k * UINT64_C(33333333) + late);

        assert_true(ns >= last);
        last = ns;
        if (k == 600)
            at_20 = ns;
    }
    assert_true(c.tick_hz > 47.99e6 && c.tick_hz < 48.01e6);
    assert_true(llabs((long long)(last - at_20) - 20000000000ll) < 10000000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_start_is_the_known_one),
        cmocka_unit_test(constants_are_asked_for_and_read),
        cmocka_unit_test(a_reply_must_be_whole_and_ours),
        cmocka_unit_test(packets_have_the_known_shape),
        cmocka_unit_test(frames_come_whole),
        cmocka_unit_test(a_stream_is_joined_at_any_packet),
        cmocka_unit_test(up_to_five_lost_are_a_hole_wherever),
        cmocka_unit_test(a_gap_over_a_border_holes_both),
        cmocka_unit_test(losses_by_chance_never_show_as_data),
        cmocka_unit_test(what_is_cut_or_changed_is_left_out),
        cmocka_unit_test(mixed_frames_are_not_given),
        cmocka_unit_test(lengths_are_checked),
        cmocka_unit_test(the_clock_goes_on_over_its_wrap),
        cmocka_unit_test(a_jump_of_the_counter_is_none_of_time),
        cmocka_unit_test(the_rate_is_measured),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
