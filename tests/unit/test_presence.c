/* Presence with the uevents of a umockdev testbed: who is poked by what, and how often. */
#include "umock_fixture.h"

#include "daemon/log.h"
#include "daemon/presence.h"

#include <systemd/sd-event.h>

#define SPEC(subsystem, name)                                                                      \
    "P: /devices/platform/x/" subsystem "/" name "\nE: SUBSYSTEM=" subsystem "\n\n"

#define VIDEO "/sys/devices/platform/x/video4linux/video2"

struct rig {
    UMockdevTestbed *bed;
    sd_event *event;
    struct dx_presence *p;
    unsigned n_video, n_usb;
};

static void count(void *n)
{
    ++*(unsigned *)n;
}

static const char *const video[] = {"video4linux", NULL};
static const char *const usb[] = {"usb", "tty", NULL};

static void start(struct rig *r)
{
    *r = (struct rig){.bed = umockdev_testbed_new()};
    dx_log_set_level(-1);
    assert_true(sd_event_new(&r->event) >= 0);
    assert_int_equal(dx_presence_new(&r->p), 0);
    assert_int_equal(dx_presence_add(r->p, video, count, &r->n_video), 0);
    assert_int_equal(dx_presence_add(r->p, usb, count, &r->n_usb), 0);
}

static void end(struct rig *r)
{
    dx_presence_free(r->p);
    sd_event_unref(r->event);
    g_object_unref(r->bed);
}

/* Turns the loop until there were so many pokes; test_presence hangs if they never come. */
static void await(struct rig *r, const unsigned *n, unsigned expected)
{
    while (*n < expected)
        assert_true(sd_event_run(r->event, UINT64_MAX) >= 0);
}

static void attach(struct rig *r, const char *device)
{
    assert_true(umockdev_testbed_add_from_string(r->bed, device, NULL));
}

static void pokes_who_is_of_the_subsystem(void **state)
{
    struct rig r;

    (void)state;
    start(&r);
    dx_presence_start(r.p, r.event);
    attach(&r, SPEC("video4linux", "video2")); /* a uevent each */
    await(&r, &r.n_video, 1);
    umockdev_testbed_uevent(r.bed, VIDEO, "add"); /* a duplicate is a poke more */
    await(&r, &r.n_video, 2);
    attach(&r, SPEC("sound", "card0"));
    umockdev_testbed_uevent(r.bed, VIDEO, "remove");
    await(&r, &r.n_video, 3);
    assert_int_equal(r.n_usb, 0);
    attach(&r, SPEC("tty", "ttyACM0"));
    await(&r, &r.n_usb, 1);
    assert_int_equal(r.n_video, 3);
    end(&r);
}

/* As the streams of a reload are: added while it runs, or to one that had nothing to watch. */
static void who_comes_later_is_poked_as_well(void **state)
{
    static const char *const sound[] = {"sound", NULL};
    struct rig r = {.bed = umockdev_testbed_new()};
    unsigned n_sound = 0;

    (void)state;
    dx_log_set_level(-1);
    assert_true(sd_event_new(&r.event) >= 0);
    assert_int_equal(dx_presence_new(&r.p), 0);
    dx_presence_start(r.p, r.event);
    assert_int_equal(dx_presence_add(r.p, video, count, &r.n_video), 0);
    attach(&r, SPEC("video4linux", "video2"));
    await(&r, &r.n_video, 1);
    assert_int_equal(dx_presence_add(r.p, sound, count, &n_sound), 0);
    attach(&r, SPEC("sound", "card0"));
    await(&r, &n_sound, 1);
    dx_presence_remove(r.p, &r.n_video);
    umockdev_testbed_uevent(r.bed, VIDEO, "change");
    umockdev_testbed_uevent(r.bed, "/sys/devices/platform/x/sound/card0", "change");
    await(&r, &n_sound, 2);
    assert_int_equal(r.n_video, 1); /* it was no longer asked for */
    end(&r);
}

static void starts_nothing_for_nobody(void **state)
{
    struct dx_presence *p;

    (void)state;
    assert_int_equal(dx_presence_new(&p), 0);
    dx_presence_start(p, NULL);
    dx_presence_free(p);
    dx_presence_free(NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pokes_who_is_of_the_subsystem),
        cmocka_unit_test(who_comes_later_is_poked_as_well),
        cmocka_unit_test(starts_nothing_for_nobody),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
