/* Where values are from; configurations beside each other, and what of one stays at a reload. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdlib.h>
#include <string.h>
#include <syslog.h>

#include "daemon/config_table.h"

static const char text[] = "socket: /tmp/a\n"
                           "streams:\n"
                           "  - name: hall\n"
                           "    synthetic: {scene: hall,\n"
                           "                noise: [0.002, 0, 0.0001]}\n"
                           "    mesh:\n"
                           "      tilt: 75\n"
                           "  - file: {path: /tmp/b.ptx}\n"
                           "    name: scan\n";

static void parse(struct dx_config *c, const char *file, const char *bytes)
{
    struct dx_err err;

    if (dx_config_parse(c, file, bytes, strlen(bytes), &err) < 0)
        fail_msg("%s", err.text);
}

static void print_in_force(FILE *out, const struct dx_config *c)
{
    dx_config_print_in_force(out, c, c->log_level);
}

static void print_quiet(FILE *out, const struct dx_config *c)
{
    dx_config_print_in_force(out, c, LOG_ERR);
}

static char *print(const struct dx_config *c, void (*how)(FILE *, const struct dx_config *))
{
    char *out_text;
    size_t len;
    FILE *out = open_memstream(&out_text, &len);

    assert_non_null(out);
    how(out, c);
    assert_int_equal(fclose(out), 0);
    return out_text;
}

static void assert_has(const char *all, const char *line)
{
    if (!strstr(all, line))
        fail_msg("found no '%s' in:\n%s", line, all);
}

static void test_lines(void **state)
{
    struct dx_config c, again;
    char *origins, *plain, *read_back;

    (void)state;
    parse(&c, "t\n.yaml", text);
    origins = print(&c, print_in_force);
    assert_has(origins, "socket: \"/tmp/a\"  # t?.yaml:1\n");
    assert_has(origins, "threads: 0  # default\n");
    assert_has(origins, "  - name: \"hall\"  # t?.yaml:3\n");
    assert_has(origins, "    mesh:\n      sigma: auto  # default\n      tilt: 75  # t?.yaml:7\n");
    assert_has(origins, "      noise: [0.002, 0, 0.0001]  # t?.yaml:5\n");
    assert_has(origins, "  - name: \"scan\"  # t?.yaml:9\n");
    assert_has(origins, "      tilt: 78.69  # default\n");
    assert_has(origins, "      path: \"/tmp/b.ptx\"  # t?.yaml:8\n");
    parse(&again, "again.yaml", origins);
    plain = print(&c, dx_config_print);
    read_back = print(&again, dx_config_print);
    assert_string_equal(plain, read_back);
    free(origins);
    origins = print(&c, print_quiet);
    assert_has(origins, "log_level: error  # set while the service runs\n");
    free(origins);
    origins = print(&c, print_in_force);
    assert_has(origins, "log_level: info  # default\n");
    free(origins);
    free(plain);
    free(read_back);
    dx_config_fini(&c);
    dx_config_fini(&again);
}

static void test_replay(void **state)
{
    const struct dx_config_replay replay = {
        .path = "/tmp/b.ptx", .socket = "/tmp/a", .rate = "max", .loop = true};
    struct dx_config c;
    struct dx_err err;
    char *origins;

    (void)state;
    assert_int_equal(dx_config_for_replay(&c, &replay, &err), 0);
    origins = print(&c, print_in_force);
    assert_has(origins, "control_socket: \"/tmp/a.control\"  # the command line\n");
    assert_has(origins, "max_clients: 256  # default\n");
    assert_has(origins, "      rate: max  # the command line\n");
    assert_has(origins, "      loop: yes  # the command line\n");
    assert_has(origins, "      lossless: yes  # the command line\n");
    assert_has(origins, "      fps: 10  # default\n");
    free(origins);
    dx_config_fini(&c);
}

static bool is_text(const struct dx_config_key *key)
{
    return key->type == DX_CONFIG_NAME || key->type == DX_CONFIG_PATH;
}

/* Gives a key some value that it allows and that it does not have. False: none of these is one. */
static bool change(const struct dx_config_key *key, struct dx_stream_config *s)
{
    static const char *const values[] = {"yes", "no",   "0",  "1",    "2",   "5",  "12",
                                         "0.5", "off",  "on", "mean", "max", "16", "20x20",
                                         "32",  "bend", "cw", "last", "new", "400"};
    const struct dx_stream_config before = *s;

    if (is_text(key))
        return dx_config_value_set(key, s, "another") == 0;
    for (size_t k = 0; k < sizeof(values) / sizeof(values[0]); k++)
        if (dx_config_value_set(key, s, values[k]) == 0 && !dx_config_value_same(key, &before, s))
            return true;
    return false;
}

/* Every key counts: two streams that differ in one value alone are not the same. */
static void every_key_counts(const char *yaml)
{
    struct dx_stream_config *copy;
    const struct dx_config_key *key;
    unsigned n = 0, n_left_out = 0;
    struct dx_config c;

    parse(&c, "t.yaml", yaml);
    for (key = dx_config_keys; key->path; key++) {
        if (!dx_config_key_applies(key, c.streams[0].driver) || key->type == DX_CONFIG_MAP ||
            key->type == DX_CONFIG_DRIVER)
            continue;
        assert_int_equal(dx_config_stream_copy(&copy, &c.streams[0]), 0);
        assert_true(dx_config_stream_same(copy, &c.streams[0]));
        if (!change(key, copy))
            n_left_out++;
        else if (dx_config_stream_same(copy, &c.streams[0]))
            fail_msg("%s does not count", key->path);
        n++;
        dx_config_stream_free(copy);
    }
    assert_true(n > 20 && n_left_out < n / 8); /* words that are not tried here */
    dx_config_fini(&c);
}

static void test_same(void **state)
{
    struct dx_config a, b;

    (void)state;
    every_key_counts("streams:\n  - name: a\n    synthetic:\n");
    every_key_counts("streams:\n  - name: a\n    file: {path: /tmp/b}\n");
    every_key_counts("streams:\n  - name: a\n    v4l2: {fx: 400}\n");
    every_key_counts("streams:\n  - name: a\n    hokuyo: {tcp: 192.168.0.10, stage: {rpm: 6}}\n");
    every_key_counts("streams:\n  - name: a\n    kinect:\n");
    parse(&a, "a.yaml", "streams:\n  - name: a\n    synthetic:\n");
    parse(&b, "b.yaml",
          "# elsewhere\nthreads: 1\nstreams:\n  - commit_ms: 33\n"
          "    synthetic: {scene: hall}\n    name: 'a'\n");
    assert_true(dx_config_stream_same(&a.streams[0], &b.streams[0]));
    dx_config_fini(&b);
    parse(&b, "b.yaml", "streams:\n  - name: a\n    kinect:\n");
    assert_false(dx_config_stream_same(&a.streams[0], &b.streams[0]));
    dx_config_fini(&a);
    dx_config_fini(&b);
}

static void test_keep_fixed(void **state)
{
    const char *differing[DX_CONFIG_MAX_FIXED];
    struct dx_config now, next;
    const char *socket;
    char *origins;

    (void)state;
    parse(&now, "t.yaml", "socket: /tmp/a\nthreads: 2\nstreams:\n  - name: a\n    synthetic:\n");
    parse(&next, "t.yaml",
          "max_clients: 3\nsocket: /tmp/b\nstreams:\n  - name: a\n    synthetic:\n");
    socket = now.socket;
    assert_int_equal(dx_config_keep_fixed(&next, &now, differing), 2);
    assert_string_equal(differing[0], "socket");
    assert_string_equal(differing[1], "threads");
    dx_config_fini(&now);
    assert_ptr_equal(next.socket, socket);
    assert_string_equal(socket, "/tmp/a");
    assert_int_equal(next.threads, 2);
    assert_int_equal(next.max_clients, 3);
    origins = print(&next, print_in_force);
    assert_has(origins, "socket: \"/tmp/a\"  # as at the start; from the next on: t.yaml:2\n");
    assert_has(origins, "threads: 2  # as at the start; from the next on: default\n");
    assert_has(origins, "max_clients: 3  # t.yaml:1\n");
    free(origins);
    dx_config_fini(&next);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_lines),
        cmocka_unit_test(test_replay),
        cmocka_unit_test(test_same),
        cmocka_unit_test(test_keep_fixed),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
