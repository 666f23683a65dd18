/* Attached devices, in a testbed of umockdev: what is told of each, choosing, permissions. */
#include "umock_fixture.h"

#include "drivers/driver.h"
#include "drivers/udev.h"

#include <errno.h>

#define CONTROLLER "P: /devices/pci0000:00/0000:00:14.0\nE: SUBSYSTEM=pci\n\n"
#define HUB                                                                                        \
    "P: /devices/pci0000:00/0000:00:14.0/usb1\nN: bus/usb/001/001\n"                               \
    "E: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\nE: DEVNAME=/dev/bus/usb/001/001\n"                   \
    "E: MAJOR=189\nE: MINOR=0\nA: idVendor=1d6b\nA: idProduct=0002\nA: busnum=1\nA: devnum=1\n"    \
    "A: devpath=0\n\n"
#define CAMERA                                                                                     \
    "P: /devices/pci0000:00/0000:00:14.0/usb1/1-2/1-2.3\nN: bus/usb/001/007\n"                     \
    "E: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\nE: DEVNAME=/dev/bus/usb/001/007\n"                   \
    "E: MAJOR=189\nE: MINOR=6\nA: idVendor=8086\nA: idProduct=0ad3\nA: busnum=1\nA: devnum=7\n"    \
    "A: devpath=2.3\nA: serial=8431\001220 \nA: manufacturer=Maker\nA: product=Depth One\n\n"
#define INTERFACE                                                                                  \
    "P: /devices/pci0000:00/0000:00:14.0/usb1/1-2/1-2.3/1-2.3:1.4\nE: SUBSYSTEM=usb\n"             \
    "E: DEVTYPE=usb_interface\nA: bInterfaceNumber=04\n\n"
#define VIDEO                                                                                      \
    "P: /devices/pci0000:00/0000:00:14.0/usb1/1-2/1-2.3/1-2.3:1.4/video4linux/video2\n"            \
    "N: video2\nS: v4l/by-id/depth\nE: SUBSYSTEM=video4linux\nE: DEVNAME=/dev/video2\nE: "         \
    "MAJOR=81\nE: MINOR=2\n"                                                                       \
    "A: name=Depth One: depth\nA: index=0\n\n"
#define SOLDERED                                                                                   \
    "P: /devices/platform/isp.0\nE: SUBSYSTEM=platform\n\n"                                        \
    "P: /devices/platform/isp.0/video4linux/video5\n"                                              \
    "N: video5\nE: SUBSYSTEM=video4linux\nE: DEVNAME=/dev/video5\nE: MAJOR=81\nE: MINOR=5\n\n"
#define KNOWN                                                                                      \
    "P: /devices/virtual/video4linux/video6\n"                                                     \
    "N: video6\nE: SUBSYSTEM=video4linux\nE: DEVNAME=/dev/video6\nE: MAJOR=81\nE: MINOR=6\n"       \
    "E: ID_PATH=as-udev-says\n\n"

static UMockdevTestbed *bed;

static int set_up(void **state)
{
    (void)state;
    bed = umockdev_testbed_new();
    umock_attach(bed, CONTROLLER, NULL);
    umock_attach(bed, HUB, "189:0");
    umock_attach(bed, CAMERA, "189:6");
    umock_attach(bed, INTERFACE, NULL);
    umock_attach(bed, VIDEO, "81:2");
    umock_attach(bed, SOLDERED, NULL);
    umock_attach(bed, KNOWN, "81:6");
    umock_number(bed, "v4l/by-id/depth", "81:2");
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    g_object_unref(bed);
    return 0;
}

struct seen {
    struct dx_udev_device d[8];
    unsigned n, at_most;
};

static bool see(void *ctx, const struct dx_udev_device *d)
{
    struct seen *s = ctx;

    s->d[s->n++] = *d;
    return s->n < s->at_most;
}

static struct seen list(const char *subsystem, unsigned at_most)
{
    struct seen s = {.at_most = at_most};
    struct dx_err err = {""};

    assert_int_equal(dx_udev_each(subsystem, see, &s, &err), 0);
    return s;
}

static void tells_what_a_device_is(void **state)
{
    struct seen s = list("video4linux", 8);
    char text[16];

    (void)state;
    assert_int_equal(s.n, 3);
    assert_string_equal(s.d[0].node, "/dev/video2");
    assert_string_equal(s.d[0].sysname, "video2");
    assert_string_equal(s.d[0].name, "Depth One: depth");
    assert_string_equal(s.d[0].serial, "8431?220");
    assert_string_equal(s.d[0].port, "1-2.3");
    assert_string_equal(s.d[0].place, "pci-0000:00:14.0-usb-0:2.3:1.4");
    assert_int_equal(s.d[0].vendor, 0x8086);
    assert_int_equal(s.d[0].product, 0x0ad3);
    assert_int_equal(s.d[0].bus, 1);
    assert_int_equal(s.d[0].address, 7);
    assert_int_equal(s.d[0].interface, 4);
    dx_udev_attribute(&s.d[0], "index", text, sizeof(text));
    assert_string_equal(text, "0");
    dx_udev_attribute(&s.d[0], "no_such", text, sizeof(text));
    assert_string_equal(text, "");
    assert_string_equal(s.d[1].place, "platform-isp.0");
    assert_string_equal(s.d[1].serial, "");
    assert_int_equal(s.d[1].interface, -1);
    assert_string_equal(s.d[2].place, "as-udev-says");
}

static void tells_usb_devices_without_their_interfaces(void **state)
{
    struct seen s = list("usb", 8);

    (void)state;
    assert_int_equal(s.n, 2);
    assert_string_equal(s.d[1].node, "/dev/bus/usb/001/007");
    assert_string_equal(s.d[1].name, "Maker Depth One");
    assert_string_equal(s.d[1].place, "pci-0000:00:14.0-usb-0:2.3");
    assert_int_equal(s.d[1].interface, -1);
    assert_int_equal(list("usb", 1).n, 1);
    assert_int_equal(list("no_such_subsystem", 8).n, 0);
}

static void finds_by_node(void **state)
{
    struct dx_udev_device d;
    struct dx_err err;

    (void)state;
    assert_int_equal(dx_udev_by_node(&d, "/dev/video2", &err), 0);
    assert_string_equal(d.sysname, "video2");
    assert_string_equal(d.serial, "8431?220");
    assert_int_equal(dx_udev_by_node(&d, "/dev/video3", &err), -ENODEV);
    assert_string_equal(err.text, "/dev/video3: no such device");
    assert_int_equal(dx_udev_by_node(&d, "/dev", &err), -ENODEV);
    assert_int_equal(dx_udev_by_node(&d, "/dev/v4l/by-id/depth", &err), 0);
    assert_string_equal(d.sysname, "video2");
    assert_int_equal(dx_udev_by_node(&d, "/dev/bus/usb/001/007", &err), 0);
    assert_string_equal(d.sysname, "1-2.3");
}

static void a_serial_goes_before_a_place(void **state)
{
    struct seen s = list("video4linux", 8);
    const struct dx_udev_device *usb = &s.d[0], *fixed = &s.d[1];

    (void)state;
    assert_true(dx_udev_is(usb, "", ""));
    assert_true(dx_udev_is(usb, "8431?220", ""));
    assert_true(dx_udev_is(usb, "8431?220", "another place"));
    assert_false(dx_udev_is(usb, "8431", ""));
    assert_false(dx_udev_is(usb, "8431", "1-2.3"));
    assert_true(dx_udev_is(usb, "", "1-2.3"));
    assert_true(dx_udev_is(usb, "", "pci-0000:00:14.0-usb-0:2.3:1.4"));
    assert_true(dx_udev_is(usb, "", "/dev/video2"));
    assert_true(dx_udev_is(usb, "", "/dev/v4l/by-id/depth"));
    assert_false(dx_udev_is(usb, "", "/dev/video5"));
    assert_false(dx_udev_is(usb, "", "1-2"));
    assert_true(dx_udev_is(fixed, "8431", "platform-isp.0"));
    assert_false(dx_udev_is(fixed, "8431", ""));
}

static void a_refusal_names_the_rule(void **state)
{
    struct dx_err err;
    char rule[256];

    (void)state;
    assert_int_equal(dx_udev_refused(&err, -EACCES, "/dev/video2"), -EACCES);
    assert_string_equal(err.text, "/dev/video2: Permission denied; a udev rule grants it: "
                                  "SUBSYSTEM==\"video4linux\", ATTRS{idVendor}==\"8086\", "
                                  "ATTRS{idProduct}==\"0ad3\", MODE=\"0660\", GROUP=\"dexeld\", "
                                  "TAG+=\"uaccess\"");
    assert_int_equal(dx_udev_refused(&err, -EBUSY, "/dev/video2"), -EBUSY);
    assert_string_equal(err.text, "/dev/video2: Device or resource busy");
    dx_device_rule("/dev/video5", rule, sizeof(rule));
    assert_non_null(strstr(rule, "KERNEL==\"video5\""));
    dx_device_rule("/dev/no_such", rule, sizeof(rule));
    assert_non_null(strstr(rule, "KERNEL==\"no_such\", MODE"));
    assert_int_equal(dx_udev_access("/dev/no_such"), -ENOENT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(tells_what_a_device_is, set_up, tear_down),
        cmocka_unit_test_setup_teardown(tells_usb_devices_without_their_interfaces, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(finds_by_node, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_serial_goes_before_a_place, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_refusal_names_the_rule, set_up, tear_down),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
