/*
 * Lines through libgpiod 1, on a chip of umockdev that answers the kernel's first GPIO ioctls. It
 * is our idea of the kernel: what is proved is what is asked of it, and what becomes of its
 * answers. Levels of lines with edges cannot be asked for here (their descriptors are pipes); the
 * guest does that (tests/hil).
 */
#include "drivers/gpio/gpio_port.h"
#include "drivers/gpio/line_thread.h"
#include "drivers/monotonic.h"

#include "tests/unit/umock_fixture.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/gpio.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <time.h>

#define N_LINES 4

static const char *const names[N_LINES] = {"encoder-a", "encoder-b", "", "laser"};

/* What the kernel knows of a line. */
struct line {
    int events; /* the end to write to; -1: not requested with edges */
    uint32_t handle_flags, event_flags;
    uint8_t level;
    char consumer[32];
};

static struct chip {
    UMockdevTestbed *bed;
    UMockdevIoctlBase *handler;
    GMainContext *context;
    atomic_bool stop;
    pthread_t thread;
    struct line line[N_LINES];
    int last; /* the line whose handle was given last: set and get are about it */
    int busy; /* a line that is somebody else's; -1 */
} chip;

static int chip_info(struct gpiochip_info *info)
{
    strcpy(info->name, "gpiochip0");
    strcpy(info->label, "umock");
    info->lines = N_LINES;
    return 0;
}

static int line_info(struct gpioline_info *info)
{
    strcpy(info->name, names[info->line_offset]);
    info->flags = chip.busy == (int)info->line_offset ? GPIOLINE_FLAG_KERNEL : 0;
    return 0;
}

static int line_event(struct gpioevent_request *r)
{
    struct line *l = &chip.line[r->lineoffset];
    int p[2];

    if (chip.busy == (int)r->lineoffset)
        return EBUSY;
    if (pipe(p))
        return errno;
    l->events = p[1];
    l->handle_flags = r->handleflags;
    l->event_flags = r->eventflags;
    strcpy(l->consumer, r->consumer_label);
    r->fd = p[0];
    return 0;
}

static int line_handle(struct gpiohandle_request *r)
{
    struct line *l = &chip.line[r->lineoffsets[0]];

    if (r->lines != 1)
        return EINVAL;
    l->handle_flags = r->flags;
    l->level = r->default_values[0];
    strcpy(l->consumer, r->consumer_label);
    chip.last = (int)r->lineoffsets[0];
    r->fd = open("/dev/gpiochip0", O_RDWR); /* so that its ioctls come here as well */
    return r->fd < 0 ? errno : 0;
}

static int answer(gulong request, void *data)
{
    struct gpiohandle_data *values = data;

    switch (request) {
    case GPIO_GET_CHIPINFO_IOCTL:
        return chip_info(data);
    case GPIO_GET_LINEINFO_IOCTL:
        return line_info(data);
    case GPIO_GET_LINEEVENT_IOCTL:
        return line_event(data);
    case GPIO_GET_LINEHANDLE_IOCTL:
        return line_handle(data);
    case GPIOHANDLE_SET_LINE_VALUES_IOCTL:
        chip.line[chip.last].level = values->values[0];
        return 0;
    case GPIOHANDLE_GET_LINE_VALUES_IOCTL:
        values->values[0] = chip.line[chip.last].level;
        return 0;
    default:
        return ENOTTY;
    }
}

/* The chip is the testbed's thread's during an ioctl, and the test's between two. This hands it
 * over, where ThreadSanitizer can see it. */
static struct chip *hand_over(void)
{
    static atomic_int turn;

    atomic_fetch_add(&turn, 1);
    return &chip;
}

static gboolean on_ioctl(UMockdevIoctlBase *base, UMockdevIoctlClient *client, gpointer user)
{
    gulong request = umockdev_ioctl_client_get_request(client);
    UMockdevIoctlData *data = umockdev_ioctl_data_resolve(umockdev_ioctl_client_get_arg(client), 0,
                                                          _IOC_SIZE((unsigned)request), NULL);
    int err;

    (void)base;
    (void)user;
    hand_over();
    err = answer(request, data->data);
    hand_over();
    umockdev_ioctl_client_complete(client, err ? -1 : 0, err);
    g_object_unref(data);
    return TRUE;
}

static void *serve(void *arg)
{
    (void)arg;
    g_main_context_push_thread_default(chip.context);
    while (!atomic_load(&chip.stop))
        g_main_context_iteration(chip.context, TRUE);
    return NULL;
}

static int setup(void **state)
{
    (void)state;
    chip = (struct chip){.busy = -1};
    for (int k = 0; k < N_LINES; k++)
        chip.line[k].events = -1;
    chip.bed = umockdev_testbed_new();
    assert_true(umockdev_testbed_add_from_string(
        chip.bed,
        "P: /devices/platform/g/gpiochip0\nN: gpiochip0=00\nE: SUBSYSTEM=gpio\n"
        "E: DEVNAME=/dev/gpiochip0\nE: MAJOR=254\nE: MINOR=0\nA: dev=254:0\\n\n",
        NULL));
    umock_link(chip.bed, "sys/bus/gpio/devices", "gpiochip0",
               "../../../devices/platform/g/gpiochip0");
    chip.context = g_main_context_new();
    g_main_context_push_thread_default(chip.context);
    chip.handler = umockdev_ioctl_base_new();
    g_signal_connect(chip.handler, "handle-ioctl", G_CALLBACK(on_ioctl), NULL);
    assert_true(umockdev_testbed_attach_ioctl(chip.bed, "/dev/gpiochip0", chip.handler, NULL));
    g_main_context_pop_thread_default(chip.context);
    assert_int_equal(pthread_create(&chip.thread, NULL, serve, NULL), 0);
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    atomic_store(&chip.stop, true);
    g_main_context_wakeup(chip.context);
    pthread_join(chip.thread, NULL);
    umockdev_testbed_detach_ioctl(chip.bed, "/dev/gpiochip0", NULL);
    g_object_unref(chip.handler);
    g_main_context_unref(chip.context);
    g_object_unref(chip.bed);
    for (int k = 0; k < N_LINES; k++)
        if (chip.line[k].events >= 0)
            close(chip.line[k].events);
    return 0;
}

static void happen(int line, bool rising, uint64_t t_ns)
{
    const struct gpioevent_data e = {.timestamp = t_ns,
                                     .id = rising ? GPIOEVENT_EVENT_RISING_EDGE
                                                  : GPIOEVENT_EVENT_FALLING_EDGE};

    assert_int_equal(write(hand_over()->line[line].events, &e, sizeof(e)), sizeof(e));
}

static struct dx_gpio_port *open_lines(const struct dx_gpio_line *lines, size_t n)
{
    struct dx_gpio_port *port = NULL;
    struct dx_err err = {""};
    int r = dx_gpio_kernel.ops->request(&port, &dx_gpio_kernel, lines, n, "test", &err);

    if (r)
        print_message("%s\n", err.text);
    assert_int_equal(r, 0);
    return port;
}

static void finds_lines(void **state)
{
    struct dx_gpio_place place;
    struct dx_err err;

    (void)state;
    assert_int_equal(dx_gpio_kernel.ops->find(&dx_gpio_kernel, "encoder-b", &place, &err), 0);
    assert_string_equal(place.chip, "/dev/gpiochip0");
    assert_int_equal(place.offset, 1);
    assert_int_equal(dx_gpio_kernel.ops->find(&dx_gpio_kernel, "gpiochip0:3", &place, &err), 0);
    assert_int_equal(place.offset, 3);
    assert_int_equal(dx_gpio_kernel.ops->find(&dx_gpio_kernel, "door", &place, &err), -ENOENT);
    assert_non_null(strstr(err.text, "gpio line door"));
    assert_int_equal(dx_gpio_kernel.ops->find(&dx_gpio_kernel, "/dev/gpiochip0", &place, &err),
                     -EINVAL);
}

static void asks_for_what_is_wanted(void **state)
{
    static const struct dx_gpio_line lines[] = {
        {.where = "encoder-a", .edges = DX_GPIO_BOTH, .bias = DX_GPIO_PULL_UP},
        {.where = "gpiochip0:1", .edges = DX_GPIO_FALLING, .active_low = true},
        {.where = "laser", .output = true, .value = true},
    };
    struct dx_gpio_port *port;
    int fds[DX_GPIO_MAX_LINES];

    (void)state;
    port = open_lines(lines, 3);
    assert_false(port->is_ordered);
    assert_false(port->is_debounced);
    assert_string_equal(hand_over()->line[0].consumer, "test");
    assert_int_equal(hand_over()->line[0].event_flags, GPIOEVENT_REQUEST_BOTH_EDGES);
    assert_int_equal(hand_over()->line[0].handle_flags,
                     GPIOHANDLE_REQUEST_INPUT | GPIOHANDLE_REQUEST_BIAS_PULL_UP);
    assert_int_equal(hand_over()->line[1].event_flags, GPIOEVENT_REQUEST_FALLING_EDGE);
    assert_int_equal(hand_over()->line[1].handle_flags,
                     GPIOHANDLE_REQUEST_INPUT | GPIOHANDLE_REQUEST_ACTIVE_LOW);
    assert_int_equal(hand_over()->line[3].handle_flags, GPIOHANDLE_REQUEST_OUTPUT);
    assert_int_equal(hand_over()->line[3].level, 1);
    assert_int_equal(port->ops->set(port, 2, false, NULL), 0);
    assert_int_equal(hand_over()->line[3].level, 0);
    assert_int_equal(port->ops->get(port, 2, NULL), 0);
    assert_int_equal(port->ops->descriptors(port, fds), 2);
    port->ops->release(port);
}

static void reads_events(void **state)
{
    static const struct dx_gpio_line lines[] = {
        {.where = "gpiochip0:0", .edges = DX_GPIO_BOTH},
        {.where = "gpiochip0:1", .edges = DX_GPIO_BOTH},
    };
    struct dx_gpio_port *port = open_lines(lines, 2);
    uint64_t now = dx_clock_ns(), real_ns;
    struct dx_gpio_event e[64];
    struct timespec real;

    (void)state;
    assert_int_equal(port->ops->read(port, e, 64, NULL), 0); /* nothing, and no wait */
    happen(1, true, now + 1);
    happen(0, true, now + 2);
    happen(1, false, now + 3);
    assert_int_equal(port->ops->read(port, e, 64, NULL), 3);
    assert_int_equal(e[0].line, 0); /* line by line */
    assert_int_equal(e[0].timestamp_ns, now + 2);
    assert_int_equal(e[1].line, 1);
    assert_true(e[1].rising);
    assert_false(e[2].rising);
    assert_int_equal(e[2].seqno, 0);
    /* the kernel's sixteen: there may have been more */
    for (uint64_t k = 0; k < 16; k++)
        happen(0, k % 2, now + k);
    assert_int_equal(port->ops->read(port, e, 64, NULL), 16);
    assert_true(e[15].overflow);
    for (int k = 0; k < 15; k++)
        assert_false(e[k].overflow);
    /* an old kernel's stamps are of the other clock */
    clock_gettime(CLOCK_REALTIME, &real);
    real_ns = (uint64_t)real.tv_sec * 1000000000u + (uint64_t)real.tv_nsec;
    happen(0, true, real_ns);
    assert_int_equal(port->ops->read(port, e, 64, NULL), 1);
    assert_true(e[0].timestamp_ns >= now && e[0].timestamp_ns <= dx_clock_ns());
    port->ops->release(port);
}

static void a_chip_that_goes(void **state)
{
    static const struct dx_gpio_line line = {.where = "gpiochip0:0", .edges = DX_GPIO_BOTH};
    struct dx_gpio_port *port = open_lines(&line, 1);
    struct dx_gpio_event e[64];
    struct dx_err err;

    (void)state;
    happen(0, true, dx_clock_ns());
    close(hand_over()->line[0].events);
    chip.line[0].events = -1;
    hand_over();
    assert_int_equal(port->ops->read(port, e, 64, &err), -ENODEV);
    assert_non_null(strstr(err.text, "gpiochip0:0"));
    port->ops->release(port);
}

static void refuses(const char *where, int want, const char *text)
{
    const struct dx_gpio_line lines[] = {{.where = "gpiochip0:0", .edges = DX_GPIO_BOTH},
                                         {.where = where, .edges = DX_GPIO_BOTH}};
    struct dx_gpio_port *port;
    struct dx_err err = {""};

    assert_int_equal(dx_gpio_kernel.ops->request(&port, &dx_gpio_kernel, lines, 2, "test", &err),
                     want);
    if (!strstr(err.text, text))
        fail_msg("%s: %s", where, err.text);
}

static void says_why_a_line_is_refused(void **state)
{
    (void)state;
    refuses("gpiochip0:4", -ENOENT, "4 lines");
    refuses("gpiochip7:1", -ENOENT, "the chip cannot be opened");
    refuses("door", -ENOENT, "no chip has a line of this name");
    hand_over()->busy = 1;
    hand_over();
    refuses("encoder-b", -EBUSY, "gpio line encoder-b");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(finds_lines, setup, teardown),
        cmocka_unit_test_setup_teardown(asks_for_what_is_wanted, setup, teardown),
        cmocka_unit_test_setup_teardown(reads_events, setup, teardown),
        cmocka_unit_test_setup_teardown(a_chip_that_goes, setup, teardown),
        cmocka_unit_test_setup_teardown(says_why_a_line_is_refused, setup, teardown),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
