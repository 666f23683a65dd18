/*
 * Lines of GPIO chips: what a line may be called, the script back end with its faults, and an
 * encoder on it. (libgpiod's back end: test_gpio_kernel.c.)
 */
#include "drivers/angle.h"
#include "drivers/gpio/gpio_script.h"
#include "drivers/gpio/line_thread.h"
#include "drivers/monotonic.h"
#include "drivers/stage_encoder.h"

#include "core/base/trig.h"

#include <errno.h>
#include <math.h>
#include <poll.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define MS 1000000u

static void knows_what_a_line_is(void **state)
{
    static const char *const good[] = {"gpiochip0:17", "/dev/gpiochip12:0", "encoder-a",
                                       "GPIO17",       "usb:expander:3",    "P9.12"};
    static const char *const bad[] = {
        "",       "encoder a",    "/dev/gpiochip0",  "a-name-of-more-than-thirty-one-bytes",
        "line\n", "gpiochip0:-1", "gpiochip0:65536", "gpiochip0:"};
    struct dx_gpio_place place;

    (void)state;
    for (size_t k = 0; k < sizeof(good) / sizeof(good[0]); k++)
        assert_null(dx_gpio_where_check(good[k]));
    for (size_t k = 0; k < sizeof(bad) / sizeof(bad[0]); k++)
        assert_non_null(dx_gpio_where_check(bad[k]));
    assert_non_null(dx_gpio_where_check(NULL));
    assert_true(dx_gpio_where_split("gpiochip0:17", place.chip, sizeof(place.chip), &place.offset));
    assert_string_equal(place.chip, "/dev/gpiochip0");
    assert_int_equal(place.offset, 17);
    assert_true(dx_gpio_where_split("/dev/x:65535", place.chip, sizeof(place.chip), &place.offset));
    assert_string_equal(place.chip, "/dev/x");
    assert_false(dx_gpio_where_split("x:65536", place.chip, sizeof(place.chip), &place.offset));
    assert_false(dx_gpio_where_split("x:1a", place.chip, sizeof(place.chip), &place.offset));
    assert_false(dx_gpio_where_split("x:", place.chip, sizeof(place.chip), &place.offset));
    assert_false(dx_gpio_where_split(":1", place.chip, sizeof(place.chip), &place.offset));
    assert_false(dx_gpio_where_split("gpiochip0:1", place.chip, 14, &place.offset));
    assert_true(dx_gpio_where_same("gpiochip0:7", "/dev/gpiochip0:07"));
    assert_true(dx_gpio_where_same("encoder-a", "encoder-a"));
    assert_false(dx_gpio_where_same("gpiochip0:7", "gpiochip1:7"));
    assert_false(dx_gpio_where_same("none", "none"));
    assert_false(dx_gpio_where_same("", ""));
    assert_false(dx_gpio_where_same(NULL, "x"));
}

/* ---- the script
 * --------------------------------------------------------------------------------- */

static const struct dx_gpio_script_step two_lines[] = {
    {100, 0, true, 0},  {200, 1, true, 0}, {300, 0, false, 0},
    {400, 1, false, 0}, {500, 0, true, 0}, {600, 1, true, 0},
};
#define N_STEPS (sizeof(two_lines) / sizeof(two_lines[0]))

static const struct dx_gpio_line inputs[2] = {{.where = "gpiochip0:1", .edges = DX_GPIO_BOTH},
                                              {.where = "gpiochip0:2", .edges = DX_GPIO_BOTH}};

static struct dx_gpio_port *open_script(struct dx_gpio_script **script,
                                        const struct dx_gpio_script_faults *faults)
{
    const struct dx_gpio_bank *bank;
    struct dx_gpio_port *port;

    assert_int_equal(dx_gpio_script_new(script, two_lines, N_STEPS, faults), 0);
    bank = dx_gpio_script_bank(*script);
    assert_int_equal(bank->ops->request(&port, bank, inputs, 2, "test", NULL), 0);
    return port;
}

static void close_script(struct dx_gpio_script *script, struct dx_gpio_port *port)
{
    port->ops->release(port);
    dx_gpio_script_free(script);
}

static int is_readable(const struct dx_gpio_port *port)
{
    int fds[DX_GPIO_MAX_LINES];
    struct pollfd p = {.events = POLLIN};

    assert_int_equal(port->ops->descriptors(port, fds), 1);
    p.fd = fds[0];
    return poll(&p, 1, 0);
}

static void hands_out_in_order(void **state)
{
    struct dx_gpio_event e[16];
    struct dx_gpio_script *script;
    struct dx_gpio_port *port = open_script(&script, NULL), *second;
    const struct dx_gpio_bank *bank = dx_gpio_script_bank(script);
    struct dx_err err;

    (void)state;
    assert_true(port->is_ordered);
    assert_int_equal(is_readable(port), 0);
    assert_int_equal(port->ops->read(port, e, 16, NULL), 0);
    dx_gpio_script_advance(script, 400);
    assert_int_equal(is_readable(port), 1);
    assert_int_equal(port->ops->read(port, e, 16, NULL), 4);
    assert_int_equal(is_readable(port), 0);
    for (uint32_t k = 0; k < 4; k++) {
        assert_int_equal(e[k].timestamp_ns, two_lines[k].t_ns);
        assert_int_equal(e[k].line, two_lines[k].line);
        assert_int_equal(e[k].rising, two_lines[k].rising);
        assert_int_equal(e[k].seqno, k + 1);
        assert_false(e[k].overflow);
    }
    dx_gpio_script_advance(script, 500);
    assert_int_equal(port->ops->get(port, 0, NULL), 1);
    assert_int_equal(port->ops->get(port, 1, NULL), 0);
    assert_int_equal(port->ops->set(port, 0, true, &err), -EPERM);
    assert_int_equal(bank->ops->request(&second, bank, inputs, 2, "test", &err), -EBUSY);
    assert_non_null(strstr(err.text, "gpiochip0:1"));
    close_script(script, port);
}

static void faults_are_as_the_kernels(void **state)
{
    struct dx_gpio_event e[16];
    struct dx_gpio_script *script;
    struct dx_gpio_port *port;

    (void)state;
    /* the oldest are dropped, and the numbers tell */
    port = open_script(&script, &(struct dx_gpio_script_faults){.fifo = 3});
    dx_gpio_script_advance(script, 600);
    assert_int_equal(port->ops->read(port, e, 16, NULL), 3);
    assert_int_equal(e[0].timestamp_ns, 400);
    assert_true(e[0].overflow);
    assert_false(e[1].overflow);
    close_script(script, port);

    /* a queue for each line: the newest are dropped, and nothing tells */
    port = open_script(&script, &(struct dx_gpio_script_faults){.fifo = 2, .per_line = true});
    assert_false(port->is_ordered);
    dx_gpio_script_advance(script, 600);
    assert_int_equal(port->ops->read(port, e, 16, NULL), 4);
    assert_int_equal(e[0].timestamp_ns, 100);
    assert_int_equal(e[1].timestamp_ns, 300);
    assert_int_equal(e[2].timestamp_ns, 200);
    assert_int_equal(e[3].timestamp_ns, 400);
    assert_int_equal(e[1].seqno, 0);
    assert_false(e[1].overflow);
    close_script(script, port);

    port = open_script(&script, &(struct dx_gpio_script_faults){
                                    .lose_at = 1, .n_lose = 2, .bounce_ns = 3, .gone_at = 5});
    dx_gpio_script_advance(script, 200);
    assert_int_equal(port->ops->read(port, e, 16, NULL), 4);
    assert_int_equal(e[0].timestamp_ns, 100);
    assert_int_equal(e[1].timestamp_ns, 200); /* two of the first edge's three are lost */
    assert_int_equal(e[3].timestamp_ns, 206);
    assert_true(e[1].overflow);
    dx_gpio_script_advance(script, 300);
    assert_int_equal(port->ops->read(port, e, 16, NULL), 1);
    assert_int_equal(port->ops->read(port, e, 16, NULL), -ENODEV);
    close_script(script, port);

    port = open_script(&script, &(struct dx_gpio_script_faults){.swap_at = 2});
    dx_gpio_script_advance(script, 600);
    assert_int_equal(port->ops->read(port, e, 16, NULL), 6);
    assert_int_equal(e[0].timestamp_ns, 200);
    assert_int_equal(e[1].timestamp_ns, 100);
    close_script(script, port);
}

/* ---- an encoder
 * --------------------------------------------------------------------------------- */

#define COUNTS 40
#define STEP   100000u /* ns from edge to edge */

static struct dx_encoder_config encoder_config(bool has_index)
{
    static char a[] = "gpiochip0:0", b[] = "gpiochip0:1", z[] = "gpiochip0:2";

    return (struct dx_encoder_config){
        .a = a, .b = b, .z = has_index ? z : NULL, .counts = COUNTS, .gear = 1};
}

/* Edges of a stage that turns `n` counts up from count 0 at `t0_ns`, the index high over counts 0
 * to 2 of each turn. Returns how many. */
static size_t turn(struct dx_gpio_script_step *steps, uint64_t t0_ns, uint32_t n)
{
    static const struct {
        uint32_t line;
        bool rising;
    } cycle[4] = {{1, false}, {0, true}, {1, true}, {0, false}}; /* into counts 0, 1, 2, 3 */
    size_t k = 0;

    for (uint32_t count = 1; count <= n; count++) {
        uint64_t t = t0_ns + (uint64_t)count * STEP;

        steps[k++] =
            (struct dx_gpio_script_step){t, cycle[count % 4].line, cycle[count % 4].rising, 0};
        if (count % COUNTS == 0 || count % COUNTS == 3)
            steps[k++] = (struct dx_gpio_script_step){t + STEP / 10, 2, count % COUNTS == 0, 0};
    }
    return k;
}

struct rig {
    struct dx_gpio_script *script;
    struct dx_angle_source *source;
    uint64_t t0_ns;
};

/* `n` counts have been turned, all a while ago. */
static struct rig turned(uint32_t n, const struct dx_gpio_script_faults *faults, bool has_index)
{
    struct dx_gpio_script_step *steps = calloc(2 * n + 2, sizeof(*steps));
    struct dx_encoder_config config = encoder_config(has_index);
    size_t n_steps = turn(steps, 0, n);
    struct rig r;

    if (!has_index) {
        size_t kept = 0;

        for (size_t k = 0; k < n_steps; k++)
            if (steps[k].line < 2)
                steps[kept++] = steps[k];
        n_steps = kept;
    }
    assert_int_equal(dx_gpio_script_new(&r.script, steps, n_steps, faults), 0);
    free(steps);
    assert_int_equal(dx_encoder_open_on(&r.source, &config, dx_gpio_script_bank(r.script), NULL),
                     0);
    r.t0_ns = dx_clock_ns();
    dx_gpio_script_begin(r.script, r.t0_ns);
    return r;
}

static void close_rig(struct rig *r)
{
    dx_angle_close(r->source);
    assert_false(dx_gpio_script_is_open(r->script));
    dx_gpio_script_free(r->script);
}

/* Waits until the events up to a count are old enough to be ordered. */
static void pass(struct rig *r, uint32_t counts)
{
    uint64_t until = r->t0_ns + (uint64_t)counts * STEP + STEP / 2;

    while (dx_clock_ns() < until + MS)
        poll(NULL, 0, 1);
    dx_gpio_script_advance(r->script, until);
    assert_int_equal(r->source->ops->pump(r->source, NULL), 0);
}

static void expect_angle(struct rig *r, double count, double turned_by, bool uncertain)
{
    struct dx_angle_sample s[4];
    uint64_t t = r->t0_ns + (uint64_t)(count * STEP);
    size_t n = r->source->ops->samples(r->source, t, t + 1, s, 4);

    assert_true(n >= 2);
    assert_int_equal(s[0].host_ns, t);
    if (fabs(s[0].angle_rad - turned_by * 2 * DX_PI) > 1e-6)
        fail_msg("at count %g: %g turns, expected %g", count, s[0].angle_rad / (2 * DX_PI),
                 turned_by);
    assert_int_equal(s[0].uncertain, uncertain);
}

static void tells_the_angle(bool per_line)
{
    struct rig r = turned(100, &(struct dx_gpio_script_faults){.per_line = per_line}, true);
    struct dx_encoder_status status;
    struct dx_angle_sample s[64];
    char text[96];
    size_t n;

    r.source->ops->trouble(r.source, text, sizeof(text));
    assert_string_equal(text, "the encoder's index was not passed yet");
    pass(&r, 39);
    expect_angle(&r, 20, 0.5, true);
    pass(&r, 100);
    dx_encoder_tell(r.source, &status);
    assert_int_equal(status.count, 100);
    assert_int_equal(status.n_index, 2);
    assert_int_equal(status.n_doubts, 0);
    assert_int_equal(status.n_mismatch, 0);
    assert_int_equal(status.n_edges, 105);
    r.source->ops->trouble(r.source, text, sizeof(text));
    assert_string_equal(text, "");
    expect_angle(&r, 50, 1.25, false);
    expect_angle(&r, 50.5, 1.2625, false);
    expect_angle(&r, 20.25, 0.50625, true); /* before the index */
    n = r.source->ops->samples(r.source, r.t0_ns + 50 * STEP + 1, r.t0_ns + 60 * STEP - 1, s, 64);
    assert_int_equal(n, 11); /* nine edges, and the ends */
    for (size_t k = 1; k < n; k++)
        assert_true(s[k].host_ns > s[k - 1].host_ns && s[k].angle_rad > s[k - 1].angle_rad);
    close_rig(&r);
}

static void one_queue_tells_the_angle(void **state)
{
    (void)state;
    tells_the_angle(false);
}

static void queues_of_lines_tell_the_angle(void **state)
{
    (void)state;
    tells_the_angle(true);
}

/* Gear, sign and zero. */
static void angles_are_the_stages(void **state)
{
    struct dx_encoder_config config = encoder_config(false);
    struct dx_gpio_script_step steps[8];
    struct dx_angle_sample s[2];
    struct dx_gpio_script *script;
    struct dx_angle_source *source;
    uint64_t t0;

    (void)state;
    config.gear = 10;
    config.zero_deg = 90;
    config.reverse = true;
    assert_int_equal(dx_gpio_script_new(&script, steps, turn(steps, 0, 2), NULL), 0);
    assert_int_equal(dx_encoder_open_on(&source, &config, dx_gpio_script_bank(script), NULL), 0);
    t0 = dx_clock_ns();
    dx_gpio_script_begin(script, t0);
    dx_gpio_script_advance(script, UINT64_MAX);
    assert_int_equal(source->ops->samples(source, t0 + 2 * STEP, t0 + 2 * STEP, s, 2), 1);
    assert_true(fabs(s[0].angle_rad - dx_rad(90 - 360.0 * 2 / COUNTS / 10)) < 1e-9);
    assert_false(s[0].uncertain);
    dx_angle_close(source);
    dx_gpio_script_free(script);
}

static void doubt_ends_at_the_index(const struct dx_gpio_script_faults *faults, int64_t mismatch)
{
    struct rig r = turned(140, faults, true);
    struct dx_encoder_status status;
    char text[96];

    pass(&r, 45);
    dx_encoder_tell(r.source, &status);
    assert_false(status.is_uncertain);
    pass(&r, 79);
    dx_encoder_tell(r.source, &status);
    assert_true(status.is_uncertain);
    assert_true(status.n_doubts > 0);
    r.source->ops->trouble(r.source, text, sizeof(text));
    assert_non_null(strstr(text, "missed"));
    pass(&r, 140);
    dx_encoder_tell(r.source, &status);
    assert_false(status.is_uncertain);
    assert_int_equal(status.count, 140);
    assert_int_equal(status.last_mismatch, mismatch);
    expect_angle(&r, 60, 1.5 + (double)mismatch / COUNTS, true);
    expect_angle(&r, 100, 2.5, false);
    close_rig(&r);
}

/* A whole cycle is lost, or two edges, or one: the next ones then seem to go back. */
static void losses_are_doubts_until_the_index(void **state)
{
    (void)state;
    doubt_ends_at_the_index(&(struct dx_gpio_script_faults){.lose_at = 52, .n_lose = 4}, -4);
    doubt_ends_at_the_index(&(struct dx_gpio_script_faults){.lose_at = 52, .n_lose = 2}, -4);
    doubt_ends_at_the_index(&(struct dx_gpio_script_faults){.lose_at = 52, .n_lose = 1}, -4);
}

/* Two edges in the wrong order. */
static void a_wrong_order_is_a_doubt_until_the_index(void **state)
{
    (void)state;
    doubt_ends_at_the_index(&(struct dx_gpio_script_faults){.swap_at = 52}, -4);
}

static void bounce_is_no_loss(void **state)
{
    struct rig r = turned(100, &(struct dx_gpio_script_faults){.bounce_ns = 10}, true);
    struct dx_encoder_status status;

    (void)state;
    pass(&r, 100);
    dx_encoder_tell(r.source, &status);
    assert_int_equal(status.count, 100);
    assert_int_equal(status.n_doubts, 0);
    assert_int_equal(status.n_edges, 315);
    close_rig(&r);
}

/* An edge without an event, where the kernel drops without a word: levels are read after the
 * doubt, and the count is in step with the lines again. */
static void looks_at_levels_after_a_doubt(void **state)
{
    struct dx_encoder_config config = encoder_config(false);
    struct dx_gpio_script *script;
    struct dx_angle_source *source;
    struct dx_encoder_status status;
    uint64_t t = dx_clock_ns();
    char text[96];

    (void)state;
    assert_int_equal(dx_gpio_script_new(&script, NULL, 0, NULL), 0);
    assert_int_equal(dx_encoder_open_on(&source, &config, dx_gpio_script_bank(script), NULL), 0);
    dx_gpio_script_set_level(script, 0, true, t);
    dx_encoder_tell(source, &status);
    assert_int_equal(status.count, 1);
    dx_gpio_script_slip(script, 0, false);
    dx_gpio_script_slip(script, 1, true); /* went on by two without an event */
    dx_gpio_script_set_level(script, 0, true, t + 1000);
    dx_encoder_tell(source, &status);
    assert_int_equal(status.count, 2); /* B by its level, A by its edge */
    assert_true(status.is_uncertain);
    source->ops->trouble(source, text, sizeof(text));
    assert_string_equal(text, "edges of the encoder were missed, and there is no index");
    dx_angle_close(source);
    dx_gpio_script_free(script);
}

static void a_chip_that_goes_is_a_failure(void **state)
{
    struct rig r = turned(10, NULL, true);
    struct dx_angle_sample s[2];
    struct dx_err err = {""};
    char text[96];

    (void)state;
    pass(&r, 5);
    dx_gpio_script_unplug(r.script, true);
    assert_int_equal(r.source->ops->pump(r.source, &err), -ENODEV);
    assert_non_null(strstr(err.text, "gone"));
    assert_int_equal(r.source->ops->pump(r.source, &err), -ENODEV);
    assert_int_equal(r.source->ops->samples(r.source, r.t0_ns, r.t0_ns, s, 2), 0);
    r.source->ops->trouble(r.source, text, sizeof(text));
    assert_non_null(strstr(text, "gone"));
    close_rig(&r);
}

static void refuses_what_cannot_be(void **state)
{
    struct dx_encoder_config config = encoder_config(true);
    struct dx_gpio_script *script;
    struct dx_angle_source *source;
    const char *key;
    struct dx_err err;

    (void)state;
    assert_int_equal(
        dx_gpio_script_new(&script, NULL, 0, &(struct dx_gpio_script_faults){.refuse = -EBUSY}), 0);
    assert_int_equal(dx_encoder_open_on(&source, &config, dx_gpio_script_bank(script), &err),
                     -EBUSY);
    config.counts = 42;
    assert_int_equal(dx_encoder_open_on(&source, &config, dx_gpio_script_bank(script), &err),
                     -EINVAL);
    assert_non_null(strstr(err.text, "multiple of four"));
    config = encoder_config(true);
    config.gear = 0;
    assert_non_null(dx_encoder_check(&config, &key));
    config = encoder_config(true);
    config.b = NULL;
    assert_non_null(dx_encoder_check(&config, &key));
    assert_string_equal(key, "stage.encoder.b");
    dx_gpio_script_free(script);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(knows_what_a_line_is),
        cmocka_unit_test(hands_out_in_order),
        cmocka_unit_test(faults_are_as_the_kernels),
        cmocka_unit_test(one_queue_tells_the_angle),
        cmocka_unit_test(queues_of_lines_tell_the_angle),
        cmocka_unit_test(angles_are_the_stages),
        cmocka_unit_test(losses_are_doubts_until_the_index),
        cmocka_unit_test(a_wrong_order_is_a_doubt_until_the_index),
        cmocka_unit_test(bounce_is_no_loss),
        cmocka_unit_test(looks_at_levels_after_a_doubt),
        cmocka_unit_test(a_chip_that_goes_is_a_failure),
        cmocka_unit_test(refuses_what_cannot_be),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
