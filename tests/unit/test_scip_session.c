/* The talk with a scanner: each way to start, each fault, the clock, and the end. */
#include "scip_rig.h"

#include "core/base/rng.h"
#include "drivers/hokuyo/scip_code.h"

#include <stdio.h>

static void starts(void **state)
{
    struct rig r;

    (void)state;
    rig_init(&r, "utm-30lx", ALL_STEPS);
    rig_run(&r, 2 * S);
    assert_int_equal(r.session.state, DX_SCIP_STREAM);
    assert_true(strstr(r.said, "\nQT\nVV\nPP\nII\nTM0\nTM1\n") == r.said);
    assert_int_equal(rig_said(&r, "TM1"), 16);
    assert_int_equal(rig_said(&r, "TM2"), 1);
    assert_int_equal(rig_said(&r, "MD0000108000000"), 1);
    assert_int_equal(rig_said(&r, "SCIP2.0"), 0);
    assert_string_equal(r.session.identity.serial, "H0614967");
    assert_string_equal(r.session.trouble, "");
    assert_true(r.n_scans > 60);
    assert_int_equal(r.session.counts.n_bad + r.session.counts.n_lost, 0);
    assert_true(r.worst_ns < (int64_t)(3 * MS / 2));
    assert_false(r.session.scan.unsure);
    rig_fini(&r);
}

/* Whatever pieces the bytes come in. */
static void starts_in_pieces(void **state)
{
    (void)state;
    for (size_t piece = 1; piece < 70; piece += piece < 8 ? 1 : 13) {
        struct rig r;

        rig_init(&r, "urg-04lx", ALL_STEPS);
        r.piece = piece;
        rig_run(&r, 3 * S);
        assert_int_equal(r.session.state, DX_SCIP_STREAM);
        assert_int_equal(rig_said(&r, "SCIP2.0"), 1); /* it speaks 1.1 when it is switched on */
        assert_true(r.n_scans > 10);
        assert_int_equal(r.session.counts.n_bad, 0);
        rig_fini(&r);
    }
}

/* An earlier program has left it streaming. */
static void starts_from_a_stream(void **state)
{
    struct rig r;

    (void)state;
    rig_init(&r, "utm-30lx", ALL_STEPS);
    r.sim.faults.stale = true;
    scip_sim_open(&r.sim, r.now);
    rig_run(&r, 2 * S);
    assert_int_equal(r.session.state, DX_SCIP_STREAM);
    assert_int_equal(rig_said(&r, "QT"), 1);
    assert_true(r.n_scans > 50);
    assert_int_equal(r.session.counts.n_bad, 0);
    rig_fini(&r);
}

static void starts_without_time(void **state)
{
    struct rig r;

    (void)state;
    rig_init(&r, "ust-20lx", ALL_STEPS);
    r.sim.faults.no_time = true;
    rig_run(&r, 3 * S);
    assert_int_equal(rig_said(&r, "TM0"), 1);
    assert_int_equal(rig_said(&r, "TM1"), 0);
    assert_int_equal(r.session.state, DX_SCIP_STREAM);
    assert_true(r.session.scan.unsure);
    assert_true(r.worst_ns < (int64_t)(3 * MS)); /* by arrivals, transfer included */
    rig_fini(&r);
}

static void repeats_what_is_busy(void **state)
{
    struct rig r;

    (void)state;
    rig_init(&r, "utm-30lx", ALL_STEPS);
    r.sim.faults.busy_at = 3; /* PP */
    rig_run(&r, 2 * S);
    assert_int_equal(rig_said(&r, "PP"), 2);
    assert_int_equal(r.session.state, DX_SCIP_STREAM);
    rig_fini(&r);
}

static void asks_for_what_is_wanted(void **state)
{
    struct rig r;

    (void)state;
    rig_init(&r, "utm-30lx-ew",
             (struct dx_scip_want){.intensity = true,
                                   .echoes = true,
                                   .first_step = 180,
                                   .last_step = 900,
                                   .cluster = 3,
                                   .skip = 1});
    rig_run(&r, 2 * S);
    assert_int_equal(rig_said(&r, "NE0180090003100"), 1);
    assert_true(r.n_scans > 20 && r.n_scans < 45); /* every second */
    assert_int_equal(r.session.counts.n_lost, 0);
    rig_fini(&r);

    rig_init(
        &r, "utm-30lx",
        (struct dx_scip_want){.echoes = true, .first_step = -1, .last_step = -1, .cluster = 1});
    rig_run(&r, 1500 * MS); /* it cannot, and is asked again after pauses that grow */
    assert_string_equal(r.session.trouble, "ND0000108000000 refused: status 0E");
    assert_int_equal(r.session.state, DX_SCIP_PAUSE);
    rig_run(&r, 8 * S);
    assert_int_equal(rig_said(&r, "ND0000108000000"), 4);
    rig_fini(&r);

    rig_init(&r, "utm-30lx",
             (struct dx_scip_want){.first_step = 0, .last_step = 1081, .cluster = 1});
    rig_run(&r, S);
    assert_string_equal(r.session.trouble, "steps 0 to 1081 asked for, it has 0 to 1080");
    rig_fini(&r);
}

/* ---- damage -----------------------------------------------------------------------------------
 */

/* A damaged scan is dropped, alone: the connection stays, and the next scan comes. */
static void drops_damaged_scans(void **state)
{
    (void)state;
    for (unsigned line = 1; line < 52; line += 10) {
        struct rig r;

        rig_init(&r, "utm-30lx", ALL_STEPS);
        r.sim.faults.bad_sum_every = 10;
        r.sim.faults.bad_sum_line = line;
        rig_run(&r, 4 * S);
        assert_int_equal(r.session.counts.n_restarts, 0);
        assert_int_equal(r.session.counts.n_bad, r.sim.n_scans / 10);
        assert_int_equal(r.n_scans, r.sim.n_scans - r.sim.n_scans / 10);
        assert_int_equal(r.session.counts.n_lost, 0); /* they did come */
        rig_fini(&r);
    }
}

static void finds_its_way_after_lost_bytes(void **state)
{
    (void)state;
    for (int twice = 0; twice < 2; twice++) {
        struct rig r;
        uint64_t bad;

        rig_init(&r, "utm-30lx", ALL_STEPS);
        *(twice ? &r.sim.faults.double_every : &r.sim.faults.drop_every) = 54321;
        rig_run(&r, 20 * S);
        bad = r.sim.n_bytes / 54321;
        assert_int_equal(r.session.counts.n_restarts, 0);
        assert_true(r.n_scans + 2 * bad >= r.sim.n_scans); /* a lost empty line takes two */
        assert_true(r.n_scans + bad / 2 <= r.sim.n_scans);
        rig_fini(&r);
    }
}

static void restarts_a_stream_of_rubbish(void **state)
{
    struct rig r;

    (void)state;
    rig_init(&r, "utm-30lx", ALL_STEPS);
    rig_run(&r, 2 * S);
    r.sim.faults.bad_sum_every = 1;
    rig_run(&r, S);
    assert_true(r.session.counts.n_restarts >= 1);
    assert_non_null(strstr(r.session.trouble, "damaged scans in a second"));
    r.sim.faults.bad_sum_every = 0;
    rig_run(&r, 2 * S);
    assert_int_equal(r.session.state, DX_SCIP_STREAM);
    assert_string_equal(r.session.trouble, "");
    rig_fini(&r);
}

/* ---- troubles of the scanner -------------------------------------------------------------------
 */

static void waits_while_it_verifies(void **state)
{
    struct rig r;

    (void)state;
    rig_init(&r, "utm-30lx", ALL_STEPS);
    r.sim.faults.suspend_at = 20;
    r.sim.faults.suspend_for = 80; /* two seconds: longer than the watchdog would wait */
    rig_run(&r, 1500 * MS);
    assert_string_equal(r.session.trouble, "measurement suspended by the scanner: status 21");
    assert_int_equal(r.n_scans, 19);
    rig_run(&r, 3 * S);
    assert_string_equal(r.session.trouble, "");
    assert_int_equal(r.session.counts.n_restarts, 0);
    assert_true(r.n_scans > 60);
    assert_int_equal(r.session.counts.n_lost, 81);
    rig_fini(&r);
}

/* A status instead of a scan, in the middle of a stream. */
static void tell_status(struct rig *r, unsigned status)
{
    char text[64];
    uint8_t digits[2] = {(uint8_t)('0' + status / 10), (uint8_t)('0' + status % 10)};
    int n = snprintf(text, sizeof(text), "%.13s00\n%c%c%c\n\n", r->session.request.command,
                     digits[0], digits[1], dx_scip_sum(digits, 2));

    for (int at = 0; at < n;)
        at += (int)dx_scip_session_feed(&r->session, (const uint8_t *)text + at, (size_t)(n - at),
                                        r->now);
}

/* Each number that there is: 21 to 49 are waited out until 98, 50 to 97 are faults, 0 says nothing,
 * and others end the stream. */
static void every_status_has_its_answer(void **state)
{
    (void)state;
    for (unsigned status = 0; status < 99; status++) {
        bool waits = status >= 21 && status <= 49, is_fault = status >= 50 && status <= 97;
        struct rig r;

        rig_init(&r, "utm-30lx",
                 (struct dx_scip_want){.first_step = 540, .last_step = 560, .cluster = 1});
        rig_run(&r, 1200 * MS);
        assert_int_equal(r.session.state, DX_SCIP_STREAM);
        tell_status(&r, status);
        assert_int_equal(r.session.state, is_fault                               ? DX_SCIP_FAULT_QT
                                          : waits || status == 0 || status == 98 ? DX_SCIP_STREAM
                                                                                 : DX_SCIP_FLUSH);
        assert_int_equal(r.session.suspended, waits);
        assert_int_equal(r.session.trouble[0] != 0, status != 0 && status != 98);
        if (waits)
            tell_status(&r, 98);
        assert_true(!waits || (!r.session.suspended && !r.session.trouble[0]));
        rig_run(&r, 3 * S); /* and it streams again */
        assert_int_equal(r.session.state, DX_SCIP_STREAM);
        assert_string_equal(r.session.trouble, "");
        assert_int_equal(r.session.counts.n_restarts > 0, is_fault || (status > 0 && status < 21));
        rig_fini(&r);
    }
}

/* Unplugged at any byte of a stream, and opened anew while the scanner streams on. */
static void comes_back_after_any_byte(void **state)
{
    struct dx_scip_want want = {.first_step = 540, .last_step = 640, .cluster = 1};
    struct dx_rng rng = dx_rng_init(5, 0);
    struct rig r;

    (void)state;
    rig_init(&r, "utm-30lx", want);
    for (unsigned k = 0; k < 100; k++) {
        size_t cut = dx_rng_below(&rng, 400);

        rig_forget(&r);
        rig_run(&r, 1500 * MS);
        assert_int_equal(r.session.state, DX_SCIP_STREAM);
        assert_true(r.n_scans > 5);
        assert_int_equal(r.session.counts.n_restarts + r.session.counts.n_bad, 0);
        while (r.sim.out_len == 0) {
            r.now += MS;
            scip_sim_tick(&r.sim, r.now);
        }
        r.sim.out_len = cut < r.sim.out_len ? cut : r.sim.out_len;
        rig_to_session(&r);
        dx_scip_session_fini(&r.session);
        assert_int_equal(dx_scip_session_init(&r.session, &want, 0, r.now), 0);
        r.last_device_ns = 0; /* each stay has its own */
    }
    rig_fini(&r);
}

static void resets_after_a_fault(void **state)
{
    struct rig r;

    (void)state;
    rig_init(&r, "utm-30lx", ALL_STEPS);
    r.sim.faults.fault_at = 20;
    rig_run(&r, 1300 * MS);
    assert_string_equal(r.session.trouble, "hardware fault: status 51");
    assert_int_equal(rig_said(&r, "RS"), 1);
    assert_int_equal(r.session.state, DX_SCIP_PAUSE);
    rig_run(&r, 2 * S);
    assert_int_equal(r.session.state, DX_SCIP_STREAM);
    assert_string_equal(r.session.trouble, "");
    assert_false(r.session.scan.unsure); /* RS has reset its clock: sampled anew */
    rig_forget(&r);
    rig_run(&r, S);
    assert_true(r.worst_ns < (int64_t)(3 * MS / 2));
    assert_false(r.backwards);
    r.sim.faults.fault_at = r.sim.n_scans + 1; /* again, soon: the pause is longer now */
    rig_run(&r, 1500 * MS);
    assert_int_equal(r.session.state, DX_SCIP_PAUSE);
    rig_run(&r, 3 * S);
    assert_int_equal(r.session.state, DX_SCIP_STREAM);
    rig_fini(&r);
}

static void reboots_what_is_abnormal(void **state)
{
    struct rig r;

    (void)state;
    rig_init(&r, "ust-20lx", ALL_STEPS);
    r.sim.faults.abnormal_at = 20;
    rig_run(&r, 1300 * MS);
    assert_int_equal(rig_said(&r, "RB"), 2);
    assert_true(r.sim.gone);
    assert_string_equal(r.session.trouble, "abnormal state (0L): rebooting");
    rig_run(&r, 4 * S);
    assert_int_equal(r.session.state, DX_SCIP_STREAM);
    rig_fini(&r);
}

static void gives_up_on_silence(void **state)
{
    struct rig r;

    (void)state;
    rig_init(&r, "utm-30lx", ALL_STEPS);
    r.sim.faults.mute = true;
    rig_run(&r, 4 * S);
    assert_false(r.session.dead);
    rig_run(&r, 10 * S);
    assert_true(r.session.dead);
    assert_string_equal(r.session.trouble, "no answer (VV)");
    rig_fini(&r);
}

/* In the middle of a stream: II after four periods, from the start again after sixteen. */
static void watches_the_stream(void **state)
{
    struct rig r;

    (void)state;
    rig_init(&r, "utm-30lx", ALL_STEPS);
    rig_run(&r, 2 * S);
    rig_forget(&r);
    r.sim.faults.mute = true;
    rig_run(&r, 95 * MS);
    assert_int_equal(rig_said(&r, "II"), 0);
    rig_run(&r, 100 * MS);
    assert_int_equal(rig_said(&r, "II"), 1);
    assert_int_equal(r.session.state, DX_SCIP_STREAM);
    rig_run(&r, 250 * MS);
    assert_int_equal(r.session.state, DX_SCIP_FLUSH);
    assert_non_null(strstr(r.session.trouble, "no scan for 0.4 s"));
    r.sim.faults.mute = false;
    rig_run(&r, 2 * S);
    assert_int_equal(r.session.state, DX_SCIP_STREAM);
    rig_fini(&r);
}

/* ---- time -------------------------------------------------------------------------------------
 */

/* 4.7 hours, over the wrap of the 24 bits, with a crystal that is 40 ppm fast. */
static void runs_over_the_wrap(void **state)
{
    struct rig r;

    (void)state;
    rig_init(&r, "utm-30lx",
             (struct dx_scip_want){.first_step = 540, .last_step = 545, .cluster = 1, .skip = 9});
    r.sim.skew = 40e-6;
    rig_run(&r, 17000 * S);
    assert_int_equal(r.session.state, DX_SCIP_STREAM);
    assert_true(r.session.clock.device_ms > DX_SCIP_WRAP_MS + 300000 / 2);
    assert_true(r.n_scans > 67000);
    assert_int_equal(r.session.counts.n_lost + r.session.counts.n_resets, 0);
    assert_false(r.backwards);
    assert_true(r.worst_ns < (int64_t)(2 * MS));
    rig_fini(&r);
}

/* Its clock begins anew in the middle of a stream, as after a brown-out. */
static void notices_a_reset(void **state)
{
    struct rig r;

    (void)state;
    rig_init(&r, "utm-30lx", ALL_STEPS);
    rig_run(&r, 3 * S);
    r.sim.offset_ms = 0;
    r.sim.epoch_ns = r.now;
    rig_forget(&r);
    rig_run(&r, S);
    assert_int_equal(r.session.counts.n_resets, 1);
    assert_true(r.session.scan.unsure);
    assert_false(r.backwards);
    assert_true(r.worst_ns < (int64_t)(30 * MS)); /* of the scan during which it happened */
    rig_forget(&r);
    rig_run(&r, S);
    assert_true(r.worst_ns < (int64_t)(3 * MS));
    rig_fini(&r);
}

/* ---- the end ----------------------------------------------------------------------------------
 */

static void stops(void **state)
{
    struct rig r;

    (void)state;
    rig_init(&r, "utm-30lx", ALL_STEPS);
    rig_run(&r, 2 * S);
    rig_forget(&r);
    dx_scip_session_stop(&r.session, r.now);
    rig_run(&r, 20 * MS);
    assert_int_equal(r.session.state, DX_SCIP_STOPPED);
    assert_int_equal(rig_said(&r, "QT"), 1);
    assert_int_equal(r.sim.state, SIM_IDLE);
    rig_fini(&r);

    rig_init(&r, "utm-30lx", ALL_STEPS);
    rig_run(&r, 2 * S);
    r.sim.faults.mute = true;
    dx_scip_session_stop(&r.session, r.now);
    rig_run(&r, 76 * MS); /* three periods, no longer */
    assert_int_equal(r.session.state, DX_SCIP_STOPPED);
    rig_fini(&r);
}

/* Whatever it answers, nothing begins anew: the laser would be on again. */
static void stops_whatever_is_answered(void **state)
{
    static const char *const answers[] = {"QT\n0Ll\n\n", "QT\n0Bb\n\n", "QT\n51V\n\n",
                                          "QT\n10Q\n\n", "QT\n0Ee\n\n"};

    (void)state;
    for (size_t k = 0; k < sizeof(answers) / sizeof(answers[0]); k++) {
        struct rig r;

        rig_init(&r, "utm-30lx", ALL_STEPS);
        rig_run(&r, 2 * S);
        r.sim.faults.mute = true;
        rig_forget(&r);
        dx_scip_session_stop(&r.session, r.now);
        rig_run(&r, MS); /* QT is out */
        for (const char *a = answers[k]; *a;)
            a += dx_scip_session_feed(&r.session, (const uint8_t *)a, strlen(a), r.now);
        rig_run(&r, 76 * MS);
        assert_int_equal(r.session.state, DX_SCIP_STOPPED);
        assert_int_equal(rig_said(&r, "RB") + rig_said(&r, "RS") + rig_said(&r, "MD"), 0);
        rig_fini(&r);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(starts),
        cmocka_unit_test(stops_whatever_is_answered),
        cmocka_unit_test(starts_in_pieces),
        cmocka_unit_test(starts_from_a_stream),
        cmocka_unit_test(starts_without_time),
        cmocka_unit_test(repeats_what_is_busy),
        cmocka_unit_test(asks_for_what_is_wanted),
        cmocka_unit_test(drops_damaged_scans),
        cmocka_unit_test(finds_its_way_after_lost_bytes),
        cmocka_unit_test(restarts_a_stream_of_rubbish),
        cmocka_unit_test(waits_while_it_verifies),
        cmocka_unit_test(every_status_has_its_answer),
        cmocka_unit_test(comes_back_after_any_byte),
        cmocka_unit_test(resets_after_a_fault),
        cmocka_unit_test(reboots_what_is_abnormal),
        cmocka_unit_test(gives_up_on_silence),
        cmocka_unit_test(watches_the_stream),
        cmocka_unit_test(runs_over_the_wrap),
        cmocka_unit_test(notices_a_reset),
        cmocka_unit_test(stops),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
