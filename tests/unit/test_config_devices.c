/* The keys of devices: what cannot be is refused when the configuration is read, at its place in
 * the file, and not when a device comes. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "daemon/config.h"
#include "drivers/usb/usb_port.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#define STREAM "streams:\n  - name: a\n    "
#define HOKUYO STREAM "hokuyo: {stage: {rpm: 1"
#define TURNED STREAM "hokuyo: {stage: {rpm: 1}}\n    gpio: "

static int parse(const char *text, struct dx_err *err)
{
    struct dx_config c;
    int r = dx_config_parse(&c, "t.yaml", text, strlen(text), err);

    dx_config_fini(&c);
    return r;
}

struct bad {
    const char *yaml, *text;
};

static void bad_all(const struct bad *bad, size_t n)
{
    for (size_t k = 0; k < n; k++) {
        struct dx_err err = {""};

        assert_int_equal(parse(bad[k].yaml, &err), -EINVAL);
        assert_string_equal(err.text, bad[k].text);
    }
}
#define BAD_ALL(list) bad_all(list, sizeof(list) / sizeof((list)[0]))

static void good(const char *yaml)
{
    struct dx_err err = {""};

    if (parse(yaml, &err))
        fail_msg("%s", err.text);
}

static void test_ports(void **state)
{
    static const struct bad bad[] = {
        {STREAM "hokuyo: {port: nonsense, stage: {rpm: 1}}\n",
         "t.yaml:3:20: streams[0].hokuyo.port: found 'nonsense', expected a USB port, as 1-2.3"},
        {STREAM "kinect: {port: nonsense}\n",
         "t.yaml:3:20: streams[0].kinect.port: found 'nonsense', expected a USB port, as 1-2.3"},
        {STREAM "v4l2: {fx: 4, port: 1.2}\n",
         "t.yaml:3:25: streams[0].v4l2.port: found '1.2', expected a USB port, as 1-2.3"},
    };
    static const char *const ports[] = {"1-2", "1-2.3", "12-1.2.3.4.5.6.7"};
    static const char *const none[] = {"",      "1",    "1-",   "-1",  "1-2.",
                                       "1-2-3", "1..2", "0-1",  "1-0", "1-2.x",
                                       " 1-2",  "1-2 ", "usb1", "1.2", "1-1.2.3.4.5.6.7.8",
                                       "1-2345"};

    (void)state;
    BAD_ALL(bad);
    good(STREAM "kinect: {port: 1-2.3}\n");
    good(STREAM "hokuyo: {port: 1-2.3, stage: {rpm: 1}}\n");
    for (size_t k = 0; k < sizeof(ports) / sizeof(ports[0]); k++)
        assert_true(dx_usb_is_port(ports[k]));
    for (size_t k = 0; k < sizeof(none) / sizeof(none[0]); k++)
        assert_false(dx_usb_is_port(none[k]));
}

/* A scan plane that lies level, whichever way it was laid so. */
static void test_mounts(void **state)
{
    static const struct bad bad[] = {
        {HOKUYO ", angles: [90, 0, 0]}}\n",
         "t.yaml:3:38: streams[0].hokuyo.stage.angles: angles lay the scan plane level, so that "
         "turning it sweeps nothing"},
        {HOKUYO ", angles: [-90, 0, 45]}}\n",
         "t.yaml:3:38: streams[0].hokuyo.stage.angles: angles lay the scan plane level, so that "
         "turning it sweeps nothing"},
        {HOKUYO ", angles: [0, 0]}}\n", "t.yaml:3:38: streams[0].hokuyo.stage.angles: found a list "
                                        "of 2, expected one of 3 numbers"},
        {HOKUYO ", offset: [1]}}\n", "t.yaml:3:38: streams[0].hokuyo.stage.offset: found a list of "
                                     "1, expected one of 3 numbers"},
    };

    (void)state;
    BAD_ALL(bad);
    good(HOKUYO ", angles: [80, 0, 0]}}\n"); /* it sweeps little, and something */
    good(HOKUYO ", angles: [0, 90, 0], offset: [0, 0, 0.1]}}\n");
    good(HOKUYO ", angles: 0}}\n");
}

static void test_lines(void **state)
{
    static const struct bad bad[] = {
        {TURNED "{interlock: {}}\n",
         "t.yaml:4:23: streams[0].gpio.interlock: found no line, expected one, or none"},
        {TURNED "{interlock: {line: ''}}\n", /* a template whose variable was not set */
         "t.yaml:4:23: streams[0].gpio.interlock: found no line, expected one, or none"},
        {TURNED "{interlock: {rearm_ms: 5}}\n",
         "t.yaml:4:23: streams[0].gpio.interlock: found no line, expected one, or none"},
        {TURNED "{led: {line: x}, trigger_in: {edge: falling}}\n",
         "t.yaml:4:40: streams[0].gpio.trigger_in: found no line, expected one, or none"},
        {HOKUYO ", encoder: {}}}\n",
         "t.yaml:3:39: streams[0].hokuyo.stage.encoder: found no a, expected one, or none"},
        {HOKUYO ", encoder: {a: x, b: x}}}\n",
         "t.yaml:3:49: streams[0].hokuyo.stage.encoder.b: an encoder has a line for each of a, b "
         "and z"},
        {HOKUYO ", encoder: {a: x, b: y, z: y}}}\n",
         "t.yaml:3:55: streams[0].hokuyo.stage.encoder.z: an encoder has a line for each of a, b "
         "and z"},
        {TURNED "{led: {line: gpiochip0:3}, pps: {line: /dev/gpiochip0:03}}\n",
         "t.yaml:4:24: streams[0].gpio.led.line: this line has another purpose already"},
        {TURNED "{led: {line: 'gpiochip0:-1'}}\n",
         "t.yaml:4:24: streams[0].gpio.led.line: the offset of a chip's line is from 0 to 65535"},
        {HOKUYO ", encoder: {a: x, b: 'gpiochip0:-1'}}}\n",
         "t.yaml:3:49: streams[0].hokuyo.stage.encoder.b: the offset of a chip's line is from 0 to "
         "65535"},
        {TURNED
         "{led: {line: x}}\n  - name: b\n    hokuyo: {tty: /t, stage: {encoder: {a: x, b: y}}}\n",
         "t.yaml:6:44: streams[1].hokuyo.stage.encoder.a: found a line of another stream, expected "
         "its own"},
        {TURNED "{led: {line: x}}\n  - name: b\n    hokuyo: {tty: /t, stage: {rpm: 1}}\n"
                "    gpio: {led: {line: x}}\n",
         "t.yaml:7:24: streams[1].gpio.led.line: found a line of another stream, expected its own"},
        {HOKUYO ", encoder: {a: x, b: y}}}\n    gpio: {interlock: {line: y}}\n",
         "t.yaml:3:49: streams[0].hokuyo.stage.encoder.b: this line has another purpose already"},
    };

    (void)state;
    BAD_ALL(bad);
    good(TURNED "{}\n");
    good(TURNED "{interlock: {line: none}}\n"); /* as the configuration is printed */
    good(HOKUYO ", encoder: {a: x, b: y, z: z}}}\n    gpio: {interlock: {line: i}}\n");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_ports),
        cmocka_unit_test(test_mounts),
        cmocka_unit_test(test_lines),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
