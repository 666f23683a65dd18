/* The log's limits, and the latency histogram. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "daemon/latency.h"
#include "daemon/log.h"

static int saved, out[2];

static int capture(void **state)
{
    (void)state;
    dx_log_set_level(LOG_INFO);
    saved = dup(STDERR_FILENO);
    return pipe2(out, O_NONBLOCK) < 0 || dup2(out[1], STDERR_FILENO) < 0 ? -1 : 0;
}

static int release(void **state)
{
    const int r = dup2(saved, STDERR_FILENO);

    (void)state;
    close(saved);
    close(out[0]);
    close(out[1]);
    return r < 0 ? -1 : 0;
}

/* What was logged so far, NUL-terminated. */
static const char *logged(void)
{
    static char text[1 << 16];
    ssize_t n = read(out[0], text, sizeof(text) - 1);

    text[n > 0 ? n : 0] = '\0';
    return text;
}

static void test_a_line(void **state)
{
    (void)state;
    dx_log_warning("room", "found %d, expected %s\n\x1b[2J", 7, "eight");
    assert_string_equal(logged(), "dexeld: room: found 7, expected eight  [2J\n");
    dx_log_warning("room", "caf\xc3\xa9 \xc2\xb5m \xc2\x9b"
                           "2J");
    assert_string_equal(logged(), "dexeld: room: caf\xc3\xa9 \xc2\xb5m   2J\n");
    dx_log_debug("room", "not at this level");
    assert_string_equal(logged(), "");
}

static void test_a_long_line_is_cut(void **state)
{
    char text[3000];
    const char *line;

    (void)state;
    memset(text, 'x', sizeof(text));
    text[sizeof(text) - 1] = '\0';
    dx_log_info("room", "%s", text);
    line = logged();
    assert_true(strlen(line) < 1024);
    assert_int_equal(line[strlen(line) - 1], '\n');
}

static void test_a_site_is_limited(void **state)
{
    const char *at;
    int n = 0;

    (void)state;
    for (int k = 0; k < 1000; k++)
        dx_log_info("room", "again");
    for (at = logged(); (at = strstr(at, "again")); at++)
        n++;
    assert_in_range(n, 10, 30); /* ten a second; a second may end meanwhile */
    dx_log_info("room", "another site");
    assert_non_null(strstr(logged(), "another site"));
}

static void test_a_full_pipe_does_not_block(void **state)
{
    char fill[4096] = {0};

    (void)state;
    while (write(out[1], fill, sizeof(fill)) > 0)
        ;
    fcntl(out[1], F_SETFL, 0); /* blocking, as a real standard error is */
    dx_log_error("room", "nobody reads");
    fcntl(out[1], F_SETFL, O_NONBLOCK);
}

static void test_latency(void **state)
{
    struct dx_latency h = {0};

    (void)state;
    assert_int_equal(dx_latency_quantile(&h, 0.5), 0);
    for (uint64_t ns = 0; ns < 8; ns++)
        assert_int_equal(dx_latency_bucket(ns), ns);
    for (unsigned k = 3; k < 64; k++)
        assert_in_range(dx_latency_bucket(UINT64_MAX >> (63 - k)), 0, DX_LATENCY_BUCKETS - 1);
    for (int k = 0; k < 10000; k++) /* 1..100 ms, evenly */
        dx_latency_add(&h, 1000000u * (uint64_t)(1 + k % 100));
    assert_in_range(dx_latency_quantile(&h, 0.5), 44000000, 51000000);
    assert_in_range(dx_latency_quantile(&h, 0.99), 87000000, 100000000);
    assert_true(h.n <= DX_LATENCY_FULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_a_line, capture, release),
        cmocka_unit_test_setup_teardown(test_a_long_line_is_cut, capture, release),
        cmocka_unit_test_setup_teardown(test_a_site_is_limited, capture, release),
        cmocka_unit_test_setup_teardown(test_a_full_pipe_does_not_block, capture, release),
        cmocka_unit_test(test_latency),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
