/* Metrics from a status: what a status says stands in the text, escaped and by the rules of each
 * format. tests/system/metrics.sh reads those of a service. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "daemon/latency.h"
#include "daemon/metrics.h"

/* The text of a status; the caller's to free. */
static char *printed(const char *status, enum dx_metrics_format format)
{
    json_error_t where;
    json_t *o = json_loads(status, 0, &where);
    char *text = NULL;
    size_t len;
    FILE *out = open_memstream(&text, &len);

    assert_non_null(o);
    dx_metrics_print(out, o, format);
    fclose(out);
    json_decref(o);
    return text;
}

static void has(const char *text, const char *line)
{
    const char *at = strstr(text, line);

    if (!at || (at != text && at[-1] != '\n') || at[strlen(line)] != '\n')
        fail_msg("expected the line '%s' in:\n%s", line, text);
}

static void has_not(const char *text, const char *part)
{
    if (strstr(text, part))
        fail_msg("expected no '%s' in:\n%s", part, text);
}

static void test_heads(void **state)
{
    char *text = printed("{}", DX_METRICS_OPENMETRICS);

    (void)state;
    has(text, "# TYPE dexeld_stream_frames counter");
    has(text, "# UNIT dexeld_uptime_seconds seconds");
    assert_string_equal(text + strlen(text) - 6, "# EOF\n");
    for (const char *at = text; *at; at = strchr(at, '\n') + 1)
        assert_int_equal(*at, '#'); /* of nothing there are no samples */
    free(text);
    text = printed("{}", DX_METRICS_PROMETHEUS);
    has(text, "# TYPE dexeld_stream_frames_total counter");
    has(text, "# TYPE dexeld_uptime_seconds gauge");
    has_not(text, "# UNIT");
    has_not(text, "# EOF");
    free(text);
}

static void test_values(void **state)
{
    char *text =
        printed("{\"version\": \"1.2\", \"uptime_s\": 0.25, \"rss_bytes\": 123456789012,"
                " \"streams\": [{\"name\": \"a\", \"state\": \"stalled\", \"frames\": 7,"
                "  \"mesh_ns_per_dexel\": 2.5, \"drops\": {\"mailbox\": 1, \"corrupt\": 2},"
                "  \"recording\": {\"started\": true, \"error_text\": \"full\"}},"
                "  {\"name\": \"b\", \"recording\": {\"started\": false}}],"
                " \"clients\": [{\"number\": 3, \"pid\": 44, \"stream\": \"a\","
                "  \"encoding\": \"f32\", \"bytes\": 9}, {\"number\": 4, \"uid\": 5}]}",
                DX_METRICS_OPENMETRICS);

    (void)state;
    has(text, "dexeld_build_info{version=\"1.2\"} 1");
    has(text, "dexeld_uptime_seconds 0.25");
    has(text, "dexeld_resident_memory_bytes 123456789012");
    has(text, "dexeld_stream_frames_total{stream=\"a\"} 7");
    has(text, "dexeld_stream_mesh_dexel_seconds{stream=\"a\"} 2.5e-09");
    has(text, "dexeld_stream_drops_total{stream=\"a\",cause=\"corrupt\"} 2");
    has(text, "dexeld_stream_state{stream=\"a\",state=\"stalled\"} 1");
    has(text, "dexeld_stream_state{stream=\"a\",state=\"live\"} 0");
    has_not(text, "dexeld_stream_state{stream=\"b\"");
    has(text, "dexeld_recording_started{stream=\"a\"} 1");
    has(text, "dexeld_recording_failing{stream=\"a\"} 1");
    has(text, "dexeld_recording_failing{stream=\"b\"} 0");
    has_not(text, "dexeld_device_info{");
    has(text, "dexeld_client_sent_bytes_total{client=\"3\",pid=\"44\",stream=\"a\"} 9");
    has(text,
        "dexeld_client_info{client=\"4\",pid=\"\",stream=\"\",uid=\"5\",encoding=\"\",mode=\"\","
        "lod=\"\",stride=\"\"} 1");
    free(text);
}

static void test_device(void **state)
{
    char *text =
        printed("{\"streams\": [{\"name\": \"a\", \"device\": {\"state\": \"gone\","
                " \"since_s\": 12.5, \"serial\": \"x\\\"\\\\\\n\\u00fc\", \"place\": \"1-2\","
                " \"lost\": 5, \"opens\": 2, \"gpio\": {\"laser\": false,"
                " \"pps_offset_us\": -3}}}]}",
                DX_METRICS_PROMETHEUS);

    (void)state;
    has(text, "dexeld_device_info{stream=\"a\",serial=\"x\\\"\\\\\\n\xc3\xbc\",place=\"1-2\"} 1");
    has(text, "dexeld_device_state{stream=\"a\",state=\"gone\"} 1");
    has(text, "dexeld_device_state{stream=\"a\",state=\"streaming\"} 0");
    has(text, "dexeld_device_state_duration_seconds{stream=\"a\"} 12.5");
    has(text, "dexeld_device_opens_total{stream=\"a\"} 2");
    has(text, "dexeld_stream_drops_total{stream=\"a\",cause=\"lost\"} 5");
    has(text, "dexeld_gpio_laser_on{stream=\"a\"} 0");
    has(text, "dexeld_gpio_pps_offset_seconds{stream=\"a\"} -3e-06");
    free(text);
}

/* The coarse histogram forgets nothing, and a latency at a bound counts to it. */
static void test_histogram(void **state)
{
    char status[1024], *text;
    struct dx_latency h = {0};
    uint64_t n = 0;
    size_t len;

    (void)state;
    for (int k = 1; k < DX_LATENCY_BOUNDS; k++)
        assert_true(dx_latency_bounds[k].ns > dx_latency_bounds[k - 1].ns);
    for (int k = 0; k < DX_LATENCY_BOUNDS; k++)
        assert_true((uint64_t)(strtod(dx_latency_bounds[k].seconds, NULL) * 1e9 + 0.5) ==
                    dx_latency_bounds[k].ns);
    for (int k = 0; k < 3 * (int)DX_LATENCY_FULL; k++)
        dx_latency_add(&h, 1000000);
    dx_latency_add(&h, 1000001);
    dx_latency_add(&h, 6000000000u);
    for (int k = 0; k <= DX_LATENCY_BOUNDS; k++)
        n += h.n_within[k];
    assert_int_equal(n, 3 * DX_LATENCY_FULL + 2);
    assert_true(h.sum_ns == 3ull * DX_LATENCY_FULL * 1000000u + 1000001u + 6000000000u);
    len = (size_t)snprintf(status, sizeof(status),
                           "{\"streams\": [{\"name\": \"a\", \"latency_ms\": {\"sum_s\": 18.5,"
                           " \"within\": [");
    for (int k = 0; k <= DX_LATENCY_BOUNDS; k++)
        len += (size_t)snprintf(status + len, sizeof(status) - len, "%s%u", k ? ", " : "",
                                (unsigned)h.n_within[k]);
    snprintf(status + len, sizeof(status) - len, "]}}]}");
    text = printed(status, DX_METRICS_OPENMETRICS);
    has(text, "dexeld_stream_latency_seconds_bucket{stream=\"a\",le=\"0.0005\"} 0");
    has(text, "dexeld_stream_latency_seconds_bucket{stream=\"a\",le=\"0.001\"} 12288");
    has(text, "dexeld_stream_latency_seconds_bucket{stream=\"a\",le=\"0.002\"} 12289");
    has(text, "dexeld_stream_latency_seconds_bucket{stream=\"a\",le=\"5.0\"} 12289");
    has(text, "dexeld_stream_latency_seconds_bucket{stream=\"a\",le=\"+Inf\"} 12290");
    has(text, "dexeld_stream_latency_seconds_sum{stream=\"a\"} 18.5");
    has(text, "dexeld_stream_latency_seconds_count{stream=\"a\"} 12290");
    has_not(text, "dexeld_stream_stage_seconds_bucket");
    free(text);
}

static void test_table(void **state)
{
    (void)state;
    assert_string_equal(dx_metrics_format_name(DX_METRICS_PROMETHEUS), "prometheus");
    for (const struct dx_metric *m = dx_metrics; m->name; m++) {
        bool first = m == dx_metrics || strcmp(m->name, m[-1].name);

        assert_true(first == (m->help != NULL));
        assert_true(first || (m->kind == m[-1].kind && m->label));
        assert_true((m->kind == DX_METRIC_STATE) == (m->word != NULL));
        assert_true(!m->unit || !strcmp(m->name + strlen(m->name) - strlen(m->unit), m->unit));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_heads),  cmocka_unit_test(test_values),
        cmocka_unit_test(test_device), cmocka_unit_test(test_histogram),
        cmocka_unit_test(test_table),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
