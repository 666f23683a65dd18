/*
 * The configuration: the exact text of every error.
 */
#include "daemon/config.h"

#include <errno.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#define STREAM    "streams:\n  - name: a\n"
#define SYNTHETIC STREAM "    synthetic:\n"

static void bad_bytes(const void *bytes, size_t len, const char *text)
{
    struct dx_config config;
    struct dx_err err = {""};

    assert_int_equal(dx_config_parse(&config, "t.yaml", bytes, len, &err), -EINVAL);
    assert_string_equal(err.text, text);
    assert_null(config.streams);
    dx_config_fini(&config);
}

struct bad {
    const char *yaml, *text;
};

static void bad_all(const struct bad *bad, size_t n)
{
    for (size_t i = 0; i < n; i++)
        bad_bytes(bad[i].yaml, strlen(bad[i].yaml), bad[i].text);
}
#define BAD_ALL(list) bad_all(list, sizeof(list) / sizeof((list)[0]))

static void test_scalars(void **state)
{
    static const struct bad bad[] = {
        {"threads: x\n", "t.yaml:1:10: threads: found 'x', expected a whole number from 0 to 256"},
        {"threads: 4 x\n",
         "t.yaml:1:10: threads: found '4 x', expected a whole number from 0 to 256"},
        {"threads: 257",
         "t.yaml:1:10: threads: found '257', expected a whole number from 0 to 256"},
        {"threads: -1", "t.yaml:1:10: threads: found '-1', expected a whole number from 0 to 256"},
        {"threads: 1.5",
         "t.yaml:1:10: threads: found '1.5', expected a whole number from 0 to 256"},
        {"threads: 99999999999999999999", "t.yaml:1:10: threads: found '99999999999999999999', "
                                          "expected a whole number from 0 to 256"},
        {"threads:", "t.yaml:1:9: threads: found nothing, expected a whole number from 0 to 256"},
        {"threads: ~",
         "t.yaml:1:10: threads: found nothing, expected a whole number from 0 to 256"},
        {"threads: [1]",
         "t.yaml:1:10: threads: found a list, expected a whole number from 0 to 256"},
        {"threads: {a: 1}",
         "t.yaml:1:10: threads: found a map, expected a whole number from 0 to 256"},
        {"max_clients_per_uid: 4097", "t.yaml:1:22: max_clients_per_uid: found '4097', expected a "
                                      "whole number from 0 to 4096"},
        {"client_memory_mib: 0",
         "t.yaml:1:20: client_memory_mib: found '0', expected a whole number from 1 to 65536"},
        {"max_requests: often",
         "t.yaml:1:15: max_requests: found 'often', expected a whole number from 1 to 100000"},
        {"max_clients: 0",
         "t.yaml:1:14: max_clients: found '0', expected a whole number from 1 to 4096"},
        {"log_level: loud",
         "t.yaml:1:12: log_level: found 'loud', expected error, warning, notice, "
         "info or debug"},
        {"socket: ''", "t.yaml:1:9: socket: found '', expected a path of 1 to 107 bytes"},
        {"streams:\n  - name: a b\n",
         "t.yaml:2:11: streams[0].name: found 'a b', expected 1 to 63 letters, digits and . _ -"},
        {"streams:\n  - name: \xc3\xa9\n", "t.yaml:2:11: streams[0].name: found '\xc3\xa9', "
                                           "expected 1 to 63 letters, digits and . _ -"},
        {"threads: 'aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa\xc3\xa9zzzzz'",
         "t.yaml:1:10: threads: found "
         "'aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa...', "
         "expected a whole number from 0 to 256"},
        {"threads: \"a\\e[1m\\u009b1m\\Lb\"",
         "t.yaml:1:10: threads: found 'a?[1m?1m?b', expected a whole number from 0 to 256"},
        {"threads: \"a\\0b\"", "t.yaml:1:10: threads: found a text with a NUL character in it"},
    };
    char name[100] = "streams: [{name: ";
    size_t len = strlen(name);

    (void)state;
    BAD_ALL(bad);
    memset(name + len, 'n', 64 - 1);
    strcpy(name + len + 63, "}]");
    bad_bytes(name, strlen(name),
              "t.yaml:1:11: streams[0]: found no driver, expected one of "
              "synthetic, file, v4l2, hokuyo, kinect");
    strcpy(name + len + 63, "n}]");
    bad_bytes(name, strlen(name),
              "t.yaml:1:18: streams[0].name: found "
              "'nnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnn...', expected 1 to 63 "
              "letters, digits and . _ -");
}

static void test_stream_scalars(void **state)
{
    static const struct bad bad[] = {
        {STREAM "    mesh: {tilt: 95}",
         "t.yaml:3:18: streams[0].mesh.tilt: found '95', expected a number from 0 to 89"},
        {STREAM "    mesh: {tilt: .nan}",
         "t.yaml:3:18: streams[0].mesh.tilt: found '.nan', expected a number from 0 to 89"},
        {STREAM "    mesh: {tilt: inf}",
         "t.yaml:3:18: streams[0].mesh.tilt: found 'inf', expected a number from 0 to 89"},
        {STREAM "    mesh: {tilt: 1e999}",
         "t.yaml:3:18: streams[0].mesh.tilt: found '1e999', expected a number from 0 to 89"},
        {STREAM "    mesh: {tilt: 0x10}",
         "t.yaml:3:18: streams[0].mesh.tilt: found '0x10', expected a number from 0 to 89"},
        {STREAM "    mesh: {tilt: '1,5'}",
         "t.yaml:3:18: streams[0].mesh.tilt: found '1,5', expected a number from 0 to 89"},
        {STREAM "    mesh: {paper: maybe}",
         "t.yaml:3:19: streams[0].mesh.paper: found 'maybe', expected yes or no"},
        {STREAM "    mesh: {diag: long}",
         "t.yaml:3:18: streams[0].mesh.diag: found 'long', expected fixed, short or bend"},
        {STREAM "    ingest: {filter: best}",
         "t.yaml:3:22: streams[0].ingest.filter: found 'best', expected off, mean or median3"},
        {STREAM "    ingest: {frames: 0}",
         "t.yaml:3:22: streams[0].ingest.frames: found '0', expected a whole number from 1 to 255"},
        {STREAM "    ingest: {hold: -1}", "t.yaml:3:20: streams[0].ingest.hold: found '-1', "
                                          "expected auto or a number from 0 to 100"},
        {STREAM "    file: {path: x, rate: fast}",
         "t.yaml:3:27: streams[0].file.rate: found 'fast', expected real, max or a number from "
         "0.001 to 1000"},
        {STREAM "    synthetic: {size: 70000x3}",
         "t.yaml:3:23: streams[0].synthetic.size: found '70000x3', expected auto or COLUMNSxROWS, "
         "each from 8 to 65535, at most 268435456 dexels"},
        {STREAM "    synthetic: {size: 65535x65535}",
         "t.yaml:3:23: streams[0].synthetic.size: found '65535x65535', expected auto or "
         "COLUMNSxROWS, "
         "each from 8 to 65535, at most 268435456 dexels"},
        {STREAM "    synthetic: {size: 3x3x}", "t.yaml:3:23: streams[0].synthetic.size: found "
                                               "'3x3x', expected auto or COLUMNSxROWS, each "
                                               "from 8 to 65535, at most 268435456 dexels"},
    };

    (void)state;
    BAD_ALL(bad);
}

/* The names are the scenes' own. */
static void test_scene_names(void **state)
{
    char text[400] = "t.yaml:3:24: streams[0].synthetic.scene: found 'x', expected ";

    (void)state;
    for (unsigned i = 0; dx_scene_name(i); i++) {
        if (i)
            strcat(text, dx_scene_name(i + 1) ? ", " : " or ");
        strcat(text, dx_scene_name(i));
    }
    bad_all(&(struct bad){STREAM "    synthetic: {scene: x}", text}, 1);
}

static void test_lists(void **state)
{
    static const struct bad bad[] = {
        {STREAM "    mesh: {sigma: [1, 2, 3, 4]}",
         "t.yaml:3:29: streams[0].mesh.sigma: found more than 3 numbers"},
        {STREAM "    mesh: {sigma: []}",
         "t.yaml:3:19: streams[0].mesh.sigma: found an empty list, "
         "expected auto, a number or a list of up to 3, each from 0 to 1000"},
        {STREAM "    mesh: {sigma: [1, x]}",
         "t.yaml:3:23: streams[0].mesh.sigma[1]: found 'x', expected a number from 0 to 1000"},
        {STREAM "    mesh: {sigma: [[[[[[[[1]]]]]]]]}",
         "t.yaml:3:20: streams[0].mesh.sigma[0]: found a list, expected a number from 0 to 1000"},
        {STREAM "    mesh: {sigma: often}",
         "t.yaml:3:19: streams[0].mesh.sigma: found 'often', "
         "expected auto, a number or a list of up to 3, each from 0 to 1000"},
        {STREAM "    synthetic: {noise: auto}",
         "t.yaml:3:24: streams[0].synthetic.noise: found 'auto', expected a number or a list of "
         "up to 3, each from 0 to 1000"},
        {"streams: []", "t.yaml:1:10: streams: found an empty list, expected a list of 1 to 64 "
                        "streams"},
        {"streams:", "t.yaml:1:9: streams: found nothing, expected a list of 1 to 64 streams"},
        {"streams: {a: b}",
         "t.yaml:1:10: streams: found a map, expected a list of 1 to 64 streams"},
        {"streams: [a]", "t.yaml:1:11: streams[0]: found 'a', expected a map of keys"},
    };
    char many[65 * 32] = "streams:\n";

    (void)state;
    BAD_ALL(bad);
    for (unsigned i = 0; i < 65; i++)
        sprintf(many + strlen(many), "- {name: s%u, synthetic: }\n", i);
    bad_bytes(many, strlen(many), "t.yaml:66:3: streams: found more than 64 streams");
}

static void test_keys(void **state)
{
    static const struct bad bad[] = {
        {"threds: 1", "t.yaml:1:1: threds: unknown key; did you mean 'threads'?"},
        {STREAM "    mesh:\n      tlit: 1",
         "t.yaml:4:7: streams[0].mesh.tlit: unknown key; did you mean 'tilt'?"},
        {STREAM "    mesh: {seam: on}",
         "t.yaml:3:12: streams[0].mesh.seam: unknown key, expected one of sigma, tilt, cap, diag, "
         "rescue, mixed, bridge, caps, normals, smooth, paper, noise_gate"},
        {STREAM "    usb: {}", "t.yaml:3:5: streams[0].usb: unknown key, expected one of name, "
                               "commit_ms, ingest, mesh, gpio, record, synthetic, file, v4l2, "
                               "hokuyo, kinect"},
        {"threads: 1\nmax_clients: 5\nthreads: 1\n",
         "t.yaml:3:1: threads: duplicate key, already on line 1"},
        {SYNTHETIC "    mesh:\n      cap: 1\n      cap: 2\n",
         "t.yaml:6:7: streams[0].mesh.cap: duplicate key, already on line 5"},
        {"threads: 1", "t.yaml:1:1: streams: missing, expected a list of 1 to 64 streams"},
        {"streams:\n  - synthetic:\n", "t.yaml:2:5: streams[0].name: missing, expected 1 to 63 "
                                       "letters, digits and . _ -"},
        {STREAM "    file:\n",
         "t.yaml:3:10: streams[0].file.path: missing, expected a path of 1 to 4095 bytes"},
        {STREAM, "t.yaml:2:5: streams[0]: found no driver, expected one of synthetic, file, v4l2, "
                 "hokuyo, kinect"},
        {STREAM "    file: {path: x}\n    synthetic:\n",
         "t.yaml:4:5: streams[0].synthetic: found a second driver beside 'file', expected one"},
        {"[threads]", "t.yaml:1:1: found a list, expected a map of keys"},
        {"threads", "t.yaml:1:1: found 'threads', expected a map of keys"},
        {"? [a]\n: b", "t.yaml:1:3: found a list, expected the name of a key"},
        {"? {a: b}\n: b", "t.yaml:1:3: found a map, expected the name of a key"},
    };

    (void)state;
    BAD_ALL(bad);
}

/* Keys of devices, and of the lines about them, that do not go together. */
static void test_device_keys(void **state)
{
    static const struct bad bad[] = {
        {STREAM "    hokuyo: {tty: /dev/x, tcp: y, stage: {rpm: 1}}\n",
         "t.yaml:3:32: streams[0].hokuyo.tcp: found several of tty, tcp and port, expected one"},
        {STREAM "    hokuyo: {tty: /dev/x, stage: {rpm: 1, sweep: swing}}\n",
         "t.yaml:3:50: streams[0].hokuyo.stage.sweep: sweeps back and forth need a swing"},
        {STREAM "    hokuyo: {tty: /dev/x, stage: {columns: 4}}\n",
         "t.yaml:3:34: streams[0].hokuyo.stage.rpm: a stage needs its rpm, or the lines of its "
         "encoder"},
        {STREAM "    hokuyo: {stage: {encoder: {a: enc-a}}}\n",
         "t.yaml:3:31: streams[0].hokuyo.stage.encoder.b: an encoder needs its lines a and b"},
        {STREAM "    hokuyo: {stage: {encoder: {a: enc-a, b: chip:1, counts: 10}}}\n",
         "t.yaml:3:61: streams[0].hokuyo.stage.encoder.counts: counts of an encoder are a multiple "
         "of four, at most 16777216"},
        {STREAM "    hokuyo: {tty: /dev/x, baud: 9600, stage: {rpm: 1}}\n",
         "t.yaml:3:33: streams[0].hokuyo.baud: found '9600', expected 19200, 38400, 57600, 115200, "
         "230400 or 500000"},
        {STREAM "    hokuyo: {first_step: 9, last_step: 9, stage: {rpm: 1}}\n",
         "t.yaml:3:40: streams[0].hokuyo.last_step: found a last_step that is not behind "
         "first_step"},
        {STREAM "    hokuyo: {tcp: 'host:', stage: {rpm: 1}}\n",
         "t.yaml:3:19: streams[0].hokuyo.tcp: found a tcp that is no address, expected HOST or "
         "HOST:PORT"},
        {STREAM "    hokuyo: {stage: {rpm: 1, columns: 5}}\n",
         "t.yaml:3:39: streams[0].hokuyo.stage.columns: expected an even number of columns, so "
         "that "
         "half a turn is a whole number"},
        {STREAM "    v4l2: {fx: 300, size: 640x480, k1: -1}\n",
         "t.yaml:3:40: streams[0].v4l2.k1: the lens folds the image before pixel (0, 0): k1 -1, "
         "k2 0, p1 0, p2 0, k3 0"},
        {STREAM "    v4l2: {fx: 300, size: 640x480, k3: -9}\n",
         "t.yaml:3:40: streams[0].v4l2.k3: the lens folds the image before pixel (0, 0): k1 0, "
         "k2 0, p1 0, p2 0, k3 -9"},
        {STREAM "    synthetic: {}\n    gpio: {led: {line: led}}\n",
         "t.yaml:4:11: streams[0].gpio: found lines, which need a driver of a device"},
        {STREAM "    hokuyo: {stage: {rpm: 1}}\n    gpio: {laser: {line: laser}}\n",
         "t.yaml:4:26: streams[0].gpio.laser.line: a laser line needs an interlock"},
        {STREAM
         "    hokuyo: {stage: {rpm: 1}}\n    gpio: {interlock: {line: x}, laser: {line: x}}\n",
         "t.yaml:4:48: streams[0].gpio.laser.line: this line has another purpose already"},
        {STREAM "    hokuyo: {stage: {rpm: 1}}\n    gpio: {interlock: {line: x, bias: pull-up}}\n",
         "t.yaml:4:39: streams[0].gpio.interlock.bias: with pull-up a broken wire would be high: "
         "no "
         "stop"},
        {STREAM "    hokuyo: {stage: {rpm: 1}}\n    gpio: {pps: {line: /dev/gpiochip0}}\n",
         "t.yaml:4:24: streams[0].gpio.pps.line: a path of a chip needs the line's offset behind "
         "it: "
         "/dev/gpiochip0:17"},
        {STREAM "    hokuyo: {stage: {rpm: 1, exact: yes}}\n    ingest: {filter: mean}\n",
         "t.yaml:3:37: streams[0].hokuyo.stage.exact: exact points need filter off: an estimate is "
         "no sample"},
    };

    (void)state;
    BAD_ALL(bad);
}

static void test_together(void **state)
{
    static const struct bad bad[] = {
        {SYNTHETIC "  - name: a\n    synthetic:\n",
         "t.yaml:4:11: streams[1].name: found 'a', already the name of streams[0] (line 2)"},
        {SYNTHETIC "    record: {path: /r.mcap}\n"
                   "  - name: b\n    synthetic:\n    record: {path: /r.mcap}\n",
         "t.yaml:7:20: streams[1].record.path: found that of another stream, expected its own"},
        {STREAM "    hokuyo: {tty: /dev/x, stage: {rpm: 1}}\n"
                "  - name: b\n    hokuyo: {tty: /dev/x, stage: {rpm: 1}}\n",
         "t.yaml:5:19: streams[1].hokuyo.tty: found that of another stream, expected its own"},
        {"socket: /a\ncontrol_socket: /a\n" SYNTHETIC,
         "t.yaml:2:17: control_socket: found the path of socket, expected another"},
        {"socket: /run/dexeld/control.sock\n" SYNTHETIC,
         "t.yaml:1:9: control_socket: found the path of socket, expected another"},
        {"metrics_file: /run/dexeld/mesh.sock\n" SYNTHETIC,
         "t.yaml:1:15: metrics_file: found the path of socket, expected another"},
        {"control_socket: /c\nmetrics_file: /c\n" SYNTHETIC,
         "t.yaml:2:15: metrics_file: found the path of control_socket, expected another"},
        {"metrics_file: t.yaml\n" SYNTHETIC,
         "t.yaml:1:15: metrics_file: found the path of this file, expected another"},
        {SYNTHETIC "    mesh: {paper: yes}\n",
         "t.yaml:4:11: streams[0].mesh: the paper's mode needs a cap: the radius of its sphere of "
         "influence"},
        {STREAM "    file: {path: x, lossless: yes}\n",
         "t.yaml:3:31: streams[0].file.lossless: found yes, which needs rate: max"},
        {STREAM "    file: {path: x, keep: nearest}\n",
         "t.yaml:3:27: streams[0].file.keep: found nearest, which needs a size"},
        {STREAM "    file: {path: x, size: 1x100}\n",
         "t.yaml:3:27: streams[0].file.size: found '1x100', expected auto or COLUMNSxROWS, each "
         "from "
         "2 to 65535, at most 268435456 dexels"},
        {STREAM "    file: {path: x}\n    record: {path: /rec/hall}\n",
         "t.yaml:4:20: streams[0].record.path: expected a name that ends in .mcap"},
        {STREAM "    file: {path: x}\n    record: {path: /rec/%Y/hall.mcap}\n",
         "t.yaml:4:20: streams[0].record.path: found % in the folder, expected it in the file's "
         "name alone"},
        {STREAM "    file: {path: x}\n    record: {path: x.mcap, keep_mib: 2000}\n",
         "t.yaml:4:38: streams[0].record.keep_mib: expected at least twice split_mib, which may "
         "not be 0 then"},
        {"max_clients: 3\n" STREAM "    file: {path: x, wait: 4}\n",
         "t.yaml:4:27: streams[0].file.wait: found 4, expected at most max_clients, which is 3"},
    };

    (void)state;
    BAD_ALL(bad);
}

static void test_yaml(void **state)
{
    static const struct bad bad[] = {
        {"", "t.yaml:1:1: found an empty file, expected at least the key 'streams'"},
        {"# nothing\n", "t.yaml:2:1: found an empty file, expected at least the key 'streams'"},
        {"---\n", "t.yaml:2:1: streams: missing, expected a list of 1 to 64 streams"},
        {SYNTHETIC "---\n" SYNTHETIC, "t.yaml:4:1: found a second document, expected one"},
        {"streams: &all\n",
         "t.yaml:1:10: streams: found anchor 'all'; anchors and aliases are not supported"},
        {"streams: *all\n",
         "t.yaml:1:10: streams: found alias 'all'; anchors and aliases are not supported"},
        {"threads: !!int 4\n",
         "t.yaml:1:10: threads: found tag 'tag:yaml.org,2002:int'; tags are not supported"},
        {"threads: !mine [4]\n", "t.yaml:1:10: threads: found tag '!mine'; tags are not supported"},
        {"threads: 1\n\tmax_clients: 1\n", "t.yaml:2:1: not YAML: found a tab, expected spaces"},
        {STREAM "   \tname: 1\n", "t.yaml:3:4: not YAML: found a tab, expected spaces"},
        {SYNTHETIC "   mesh:\n",
         "t.yaml:4:4: not YAML: did not find expected '-' indicator (while parsing a block "
         "collection, line 2)"},
        {"socket: \"/run\nthreads: 1",
         "t.yaml:2:11: not YAML: found unexpected end of stream (while scanning a quoted scalar, "
         "line 1)"},
        {"socket: /a\nsocket \xff\n",
         "t.yaml:2:8: found 0xff, expected UTF-8 text (invalid leading UTF-8 octet)"},
        {"# \xc3\xa9\xc3\xa9 \x01\n",
         "t.yaml:1:6: found 0x01, expected UTF-8 text (control characters are not allowed)"},
        {"socket: \xc3", "t.yaml:1:9: found the end, expected the rest of a UTF-8 character"},
        {"\xff\xfe", "t.yaml:1:1: found 0xff, expected UTF-8 text (invalid leading UTF-8 octet)"},
    };

    (void)state;
    BAD_ALL(bad);
}

static void test_too_deep(void **state)
{
    char *deep = malloc(DX_CONFIG_MAX_LEN);

    (void)state;
    assert_non_null(deep);
    memset(deep, '[', DX_CONFIG_MAX_LEN);
    bad_bytes(deep, DX_CONFIG_MAX_LEN, "t.yaml:1:1: found a list, expected a map of keys");
    memcpy(deep, "streams: ", 9);
    bad_bytes(deep, DX_CONFIG_MAX_LEN,
              "t.yaml:1:11: streams[0]: found a list, expected a map of keys");
    for (size_t i = 0; i < DX_CONFIG_MAX_LEN; i += 2)
        memcpy(deep + i, "- ", 2);
    bad_bytes(deep, DX_CONFIG_MAX_LEN, "t.yaml:1:1: found a list, expected a map of keys");
    free(deep);
}

static void test_too_long(void **state)
{
    size_t len = DX_CONFIG_MAX_LEN + 1;
    char *big = malloc(len);
    struct dx_config c;
    struct dx_err err;

    (void)state;
    assert_non_null(big);
    memset(big, '\n', len);
    memcpy(big, SYNTHETIC, strlen(SYNTHETIC));
    bad_bytes(big, len, "t.yaml: found more than 1048576 bytes, expected at most that");
    assert_int_equal(dx_config_parse(&c, "t.yaml", big, len - 1, &err), 0);
    dx_config_fini(&c);
    free(big);
}

static void test_bad_replay(void **state)
{
    static const struct {
        struct dx_config_replay replay;
        const char *text;
    } bad[] = {
        {{.path = "a", .socket = "s", .rate = "0"},
         "--rate: found '0', expected real, max or a number from 0.001 to 1000"},
        {{.path = "a", .socket = "s", .wait = "some"},
         "--wait: found 'some', expected a whole number from 0 to 4096"},
        {{.path = "a", .socket = "s", .wait = "257"},
         "--wait: found 257, expected at most 256 (connections at once)"},
        {{.path = "", .socket = "s"}, "--replay: found '', expected a path of 1 to 4095 bytes"},
        {{.path = "a", .socket = ""}, "--socket: found '', expected a path of 1 to 99 bytes"},
        {{.path = "a",
          .socket = "/ssssssssssssssssssssssssssssssssssssssssssssssssssssssssssssssssssssss"
                    "sssssssssssssssssssssssssssss"},
         "--socket: found '/sssssssssssssssssssssssssssssssssssssssssssssssssssssssss...', "
         "expected a "
         "path of 1 to 99 bytes"},
    };

    (void)state;
    for (size_t i = 0; i < sizeof(bad) / sizeof(bad[0]); i++) {
        struct dx_config c;
        struct dx_err err = {""};

        assert_int_equal(dx_config_for_replay(&c, &bad[i].replay, &err), -EINVAL);
        assert_string_equal(err.text, bad[i].text);
        assert_null(c.streams);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_scalars),     cmocka_unit_test(test_stream_scalars),
        cmocka_unit_test(test_scene_names), cmocka_unit_test(test_lists),
        cmocka_unit_test(test_keys),        cmocka_unit_test(test_device_keys),
        cmocka_unit_test(test_together),    cmocka_unit_test(test_yaml),
        cmocka_unit_test(test_too_deep),    cmocka_unit_test(test_too_long),
        cmocka_unit_test(test_bad_replay),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
