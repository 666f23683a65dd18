/*
 * Requests of the control socket about one of several streams: which one is meant, what each takes,
 * and that one that was refused has changed nothing. The streams are a scene that can be recorded,
 * a scene that cannot, a recording that plays over and over, and one that has ended.
 */
#include "tests/unit/service_child.h"

static void write_streams(const struct place *p)
{
    FILE *f = fopen(p->config, "w");

    assert_non_null(f);
    fprintf(f,
            "socket: %s\ncontrol_socket: %s\nmax_requests: 10000\nlog_level: error\nstreams:\n"
            "  - {name: hall, synthetic: {scene: hall, size: 96x80}, record: {path: %s/new.mcap, "
            "start: no}}\n"
            "  - {name: bare, synthetic: {scene: hall, size: 96x80}}\n"
            "  - {name: tape, file: {path: %s/rec.mcap, rate: 1, loop: yes}}\n"
            "  - {name: over, file: {path: %s/rec.mcap, rate: max}}\n",
            p->mesh, p->control, p->dir, p->dir, p->dir);
    assert_int_equal(fclose(f), 0);
}

static void stop(pid_t pid)
{
    kill(pid, SIGTERM);
    await_end(pid, 0);
}

static pid_t start_ready(const struct place *p)
{
    int ready_fd;
    const pid_t pid = start(p, 0, &ready_fd);

    if (!is_ready(ready_fd, 0)) {
        await_end(pid, 0);
        fail_msg("the service did not start: %s", p->outcome->text);
    }
    return pid;
}

/* The recording is that of the place's own configuration. */
static int record_first(void **state)
{
    const struct place *p;
    pid_t pid;

    make_place(state);
    p = *state;
    pid = start_ready(p);
    assert_int_equal(subscribe(p, NULL), 1);
    stop(pid);
    write_streams(p);
    return 0;
}

static void expect(const struct place *p, const char *members, const char *text)
{
    char request[256];
    const char *answer;

    snprintf(request, sizeof(request), "{\"request\":%s}\n", members);
    answer = ask(p, request);
    if (!answer || !strstr(answer, text))
        fail_msg("%s is answered %s expected: %s", request, answer ? answer : "nothing,", text);
}

static void refusals_say_what_was_expected(void **state)
{
    static const struct {
        const char *members, *text;
    } refused[] = {
        {"\"record\"", "expected \\\"stream\\\", one of hall, bare, tape, over"},
        {"\"record\",\"stream\":7", "\\\"stream\\\": expected a text"},
        {"\"record\",\"stream\":\"none\"", "no stream 'none'"},
        {"\"record\",\"stream\":\"bare\",\"do\":\"start\"",
         "stream 'bare' has no record.path in the configuration"},
        {"\"record\",\"stream\":\"hall\",\"do\":\"begin\"",
         "\\\"do\\\": expected start, stop or status"},
        {"\"replay\"", "expected \\\"stream\\\", one of hall, bare, tape, over"},
        {"\"replay\",\"stream\":\"hall\",\"do\":\"pause\"", "stream 'hall' replays no recording"},
        {"\"replay\",\"stream\":\"tape\",\"do\":\"rewind\"",
         "\\\"do\\\": expected pause, resume, seek, rate, step or status"},
        {"\"replay\",\"stream\":\"tape\",\"do\":\"seek\"",
         "\\\"seconds\\\": expected a number from 0"},
        {"\"replay\",\"stream\":\"tape\",\"do\":\"seek\",\"seconds\":-1",
         "\\\"seconds\\\": expected a number from 0"},
        {"\"replay\",\"stream\":\"tape\",\"do\":\"seek\",\"seconds\":1e10",
         "\\\"seconds\\\": expected a number from 0"},
        {"\"replay\",\"stream\":\"tape\",\"do\":\"rate\",\"rate\":\"fast\"",
         "\\\"rate\\\": expected real, max or a number from 0.001 to 1000"},
        {"\"replay\",\"stream\":\"tape\",\"do\":\"rate\",\"rate\":1001",
         "\\\"rate\\\": expected real, max or a number from 0.001 to 1000"},
        {"\"replay\",\"stream\":\"tape\",\"do\":\"step\",\"frames\":0",
         "\\\"frames\\\": expected a whole number from 1"},
        {"\"replay\",\"stream\":\"tape\",\"do\":\"step\",\"frames\":\"2\"",
         "\\\"frames\\\": expected a whole number from 1"},
        {"\"metrics\",\"format\":\"xml\"", "\\\"format\\\": expected openmetrics or prometheus"},
        {"\"nothing\"", "unknown request 'nothing', expected status, "},
    };
    const struct place *p = *state;
    const pid_t pid = start_ready(p);

    for (size_t k = 0; k < sizeof(refused) / sizeof(*refused); k++)
        expect(p, refused[k].members, refused[k].text);
    expect(p, "\"record\",\"stream\":\"hall\",\"do\":\"status\"", "\"started\":false");
    expect(p, "\"replay\",\"stream\":\"tape\",\"do\":\"status\"", "\"paused\":false");
    expect(p, "\"replay\",\"stream\":\"tape\",\"do\":\"status\"", "\"rate\":1.0");
    stop(pid);
}

static void the_stream_that_is_named_obeys(void **state)
{
    const struct place *p = *state;
    const pid_t pid = start_ready(p);

    expect(p, "\"replay\",\"stream\":\"tape\",\"do\":\"rate\",\"rate\":\"max\"",
           "\"rate\":\"max\"");
    expect(p, "\"replay\",\"stream\":\"tape\",\"do\":\"rate\",\"rate\":\"real\"", "\"rate\":1.0");
    expect(p, "\"replay\",\"stream\":\"tape\",\"do\":\"pause\"", "\"paused\":true");
    expect(p, "\"record\",\"stream\":\"hall\",\"do\":\"start\"", "\"started\":true");
    expect(p, "\"record\",\"stream\":\"hall\",\"do\":\"stop\"", "\"started\":false");
    stop(pid);
}

static void await_ended(const struct place *p, const char *stream)
{
    const struct dexel_callbacks callbacks = {.state = on_state};
    const struct dexel_options options = {.socket = p->mesh, .stream = stream};
    struct dexel *d;

    assert_int_equal(dexel_open(&d, &options, &callbacks, NULL), 0);
    assert_int_equal(dexel_run(d, PATIENCE_MS), 2);
    dexel_close(d);
}

static void a_replay_that_has_ended_is_left_alone(void **state)
{
    const struct place *p = *state;
    const pid_t pid = start_ready(p);

    await_ended(p, "over");
    expect(p, "\"replay\",\"stream\":\"over\",\"do\":\"status\"", "\"ended\":true");
    expect(p, "\"replay\",\"stream\":\"over\",\"do\":\"seek\",\"seconds\":0",
           "the replay has ended, and so has its stream");
    stop(pid);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(refusals_say_what_was_expected, record_first, remove_place),
        cmocka_unit_test_setup_teardown(the_stream_that_is_named_obeys, record_first, remove_place),
        cmocka_unit_test_setup_teardown(a_replay_that_has_ended_is_left_alone, record_first,
                                        remove_place),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
