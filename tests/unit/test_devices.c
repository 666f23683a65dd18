/* `dexel devices`: what drivers find, as YAML that the service reads and as JSON; refusals;
 * nothing. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "tools/devices.h"

#include <errno.h>
#include <jansson.h>
#include <stdlib.h>
#include <string.h>

static int probe_two(void (*found)(void *ctx, const struct dx_device_found *device), void *ctx,
                     struct dx_err *err)
{
    (void)err;
    found(ctx, &(struct dx_device_found){"Depth One", "/dev/no_such_node", "84", "1-2",
                                         "serial: \"84\"\nsize: 640x480\n", 0});
    found(ctx,
          &(struct dx_device_found){"Depth Two", "/dev/no_such_other", "", "1-3", "", -EACCES});
    return 0;
}

static int probe_nothing(void (*found)(void *ctx, const struct dx_device_found *device), void *ctx,
                         struct dx_err *err)
{
    (void)found;
    (void)ctx;
    (void)err;
    return 0;
}

static int probe_badly(void (*found)(void *ctx, const struct dx_device_found *device), void *ctx,
                       struct dx_err *err)
{
    (void)found;
    (void)ctx;
    return dx_err_set(err, -EIO, "no list");
}

static const struct dx_driver no_device = {.name = "file"};
static const struct dx_driver two = {.name = "two", .probe = probe_two};
static const struct dx_driver empty = {.name = "empty", .probe = probe_nothing};
static const struct dx_driver broken = {.name = "broken", .probe = probe_badly};

static char *print(const struct dx_driver *const *drivers, bool json, int expected)
{
    char *text = NULL;
    size_t len;
    FILE *f = open_memstream(&text, &len);

    assert_non_null(f);
    assert_int_equal(dx_devices_print(f, drivers, json), expected);
    fclose(f);
    return text;
}

static void lists_streams_to_paste(void **state)
{
    static const struct dx_driver *const drivers[] = {&no_device, &two, &empty, NULL};
    char *text = print(drivers, false, 0);

    (void)state;
    assert_string_equal(text,
                        "streams:\n"
                        "  # Depth One\n"
                        "  # node /dev/no_such_node, serial 84, at 1-2\n"
                        "  - name: two-1\n"
                        "    two:\n"
                        "      serial: \"84\"\n"
                        "      size: 640x480\n"
                        "  # Depth Two\n"
                        "  # node /dev/no_such_other, no serial, at 1-3\n"
                        "  # /dev/no_such_other cannot be opened: Permission denied\n"
                        "  # a udev rule grants it: KERNEL==\"no_such_other\", MODE=\"0660\", "
                        "GROUP=\"dexeld\", TAG+=\"uaccess\"\n"
                        "  - name: two-2\n"
                        "    two: {}\n");
    free(text);
}

static void lists_json(void **state)
{
    static const struct dx_driver *const drivers[] = {&two, NULL};
    char *text = print(drivers, true, 0);
    json_t *o = json_loads(text, 0, NULL), *d = json_object_get(o, "devices");

    (void)state;
    assert_int_equal(json_array_size(d), 2);
    assert_true(json_is_true(json_object_get(json_array_get(d, 0), "usable")));
    assert_null(json_object_get(json_array_get(d, 0), "rule"));
    d = json_array_get(d, 1);
    assert_string_equal(json_string_value(json_object_get(d, "driver")), "two");
    assert_string_equal(json_string_value(json_object_get(d, "error")), "Permission denied");
    assert_non_null(strstr(json_string_value(json_object_get(d, "rule")), "KERNEL=="));
    json_decref(o);
    free(text);
}

static void says_that_nothing_is_attached(void **state)
{
    static const struct dx_driver *const some[] = {&no_device, &empty, NULL};
    static const struct dx_driver *const none[] = {&no_device, NULL};
    char *text = print(some, false, 0);

    (void)state;
    assert_string_equal(text, "# no device is attached that this build has a driver for (empty)\n");
    free(text);
    text = print(none, false, 0);
    assert_non_null(strstr(text, "(none)"));
    free(text);
    text = print(some, true, 0);
    assert_string_equal(text, "{\"devices\":[]}\n");
    free(text);
}

static void a_driver_that_fails_hides_no_other(void **state)
{
    static const struct dx_driver *const drivers[] = {&broken, &two, NULL};
    char *text = print(drivers, false, -EIO);

    (void)state;
    assert_non_null(strstr(text, "name: two-1"));
    free(text);
}

/* What a service answers is as what this process finds, and tells which stream has what. */
static void a_service_names_its_streams(void **state)
{
    json_t *reply = json_pack(
        "{s:[{s:s,s:s,s:s,s:s,s:s,s:s,s:s},{s:s,s:s,s:s,s:s,s:s,s:s,s:s}],s:[]}", "devices",
        "driver", "two", "name", "Depth One", "node", "/dev/a", "serial", "84", "place", "1-2",
        "yaml", "serial: \"84\"\n", "stream", "hall", "driver", "two", "name", "Depth Two", "node",
        "/dev/b", "serial", "", "place", "1-3", "yaml", "", "error", "not allowed", "errors");
    char *text = NULL;
    size_t len;
    FILE *f = open_memstream(&text, &len);

    (void)state;
    assert_non_null(reply);
    assert_int_equal(dx_devices_print_reply(f, reply), 0);
    fclose(f);
    assert_string_equal(text, "streams:\n"
                              "  # Depth One\n"
                              "  # node /dev/a, serial 84, at 1-2\n"
                              "  # stream hall has it open\n"
                              "  - name: two-1\n"
                              "    two:\n"
                              "      serial: \"84\"\n"
                              "  # Depth Two\n"
                              "  # node /dev/b, no serial, at 1-3\n"
                              "  # the service cannot open it: not allowed\n"
                              "  - name: two-2\n"
                              "    two: {}\n");
    free(text);
    json_decref(reply);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_service_names_its_streams),
        cmocka_unit_test(lists_streams_to_paste),
        cmocka_unit_test(lists_json),
        cmocka_unit_test(says_that_nothing_is_attached),
        cmocka_unit_test(a_driver_that_fails_hides_no_other),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
