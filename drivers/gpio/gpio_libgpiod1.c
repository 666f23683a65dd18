/*
 * Lines through libgpiod 1: each line is a request of its own with a descriptor of its own, events
 * carry no number, and the kernel keeps sixteen for each line and drops what comes after them
 * without a word. Sixteen at once therefore mean that some may be missing.
 */
#include "drivers/gpio/gpio_port.h"

#include <errno.h>
#include <gpiod.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#define FIFO   16
#define NS     1000000000ull
#define FUTURE (10 * NS) /* a stamp so far ahead of CLOCK_MONOTONIC is not of that clock */

struct port {
    struct dx_gpio_port port;
    size_t n;
    struct {
        struct gpiod_chip *chip;
        struct gpiod_line *line;
        int fd; /* -1: no edges */
        char where[96];
    } line[DX_GPIO_MAX_LINES];
};

/* The offset of a line of this name on a chip, or -1. */
static int offset_on(const char *path, const char *name)
{
    struct gpiod_chip *chip = gpiod_chip_open(path);
    struct gpiod_line *line = chip ? gpiod_chip_find_line(chip, name) : NULL;
    int offset = line ? (int)gpiod_line_offset(line) : -1;

    if (chip)
        gpiod_chip_close(chip);
    return offset;
}

static int find(const struct dx_gpio_bank *bank, const char *where, struct dx_gpio_place *place,
                struct dx_err *err)
{
    (void)bank;
    return dx_gpio_find(where, offset_on, place, err);
}

static void release(struct dx_gpio_port *port)
{
    struct port *p = (struct port *)port;

    for (size_t k = 0; k < p->n; k++)
        if (p->line[k].chip)
            gpiod_chip_close(p->line[k].chip); /* and its line */
    free(p);
}

static int flags_of(const struct dx_gpio_line *l)
{
    static const int bias[] = {0, GPIOD_LINE_REQUEST_FLAG_BIAS_DISABLE,
                               GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_UP,
                               GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_DOWN};

    return bias[l->bias] | (l->active_low ? GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW : 0);
}

static int type_of(const struct dx_gpio_line *l)
{
    static const int edges[] = {
        GPIOD_LINE_REQUEST_DIRECTION_INPUT, GPIOD_LINE_REQUEST_EVENT_RISING_EDGE,
        GPIOD_LINE_REQUEST_EVENT_FALLING_EDGE, GPIOD_LINE_REQUEST_EVENT_BOTH_EDGES};

    return l->output ? GPIOD_LINE_REQUEST_DIRECTION_OUTPUT : edges[l->edges];
}

static int request_line(struct port *p, size_t k, const struct dx_gpio_line *l,
                        const char *consumer, struct dx_err *err)
{
    const struct gpiod_line_request_config config = {consumer, type_of(l), flags_of(l)};
    struct dx_gpio_place place;
    int r = find(NULL, l->where, &place, err);

    if (r)
        return r;
    snprintf(p->line[k].where, sizeof(p->line[k].where), "%s", l->where);
    p->line[k].fd = -1;
    p->line[k].chip = gpiod_chip_open(place.chip);
    if (!p->line[k].chip)
        return dx_gpio_fail(err, -errno, l->where, "the chip cannot be opened");
    if (place.offset >= gpiod_chip_num_lines(p->line[k].chip))
        return dx_err_set(err, -ENOENT, "gpio line %s: the chip has %u lines", l->where,
                          gpiod_chip_num_lines(p->line[k].chip));
    p->line[k].line = gpiod_chip_get_line(p->line[k].chip, place.offset);
    if (!p->line[k].line || gpiod_line_request(p->line[k].line, &config, l->value))
        return dx_gpio_fail(err, -errno, l->where, "the line is not given");
    if (!l->output && l->edges != DX_GPIO_NO_EDGE)
        p->line[k].fd = gpiod_line_event_get_fd(p->line[k].line);
    return 0;
}

static const struct dx_gpio_ops ops;

static int request(struct dx_gpio_port **out, const struct dx_gpio_bank *bank,
                   const struct dx_gpio_line *lines, size_t n, const char *consumer,
                   struct dx_err *err)
{
    struct port *p = calloc(1, sizeof(*p));
    int r = 0;

    (void)bank;
    if (!p)
        return dx_err_set(err, -ENOMEM, "gpio: no memory");
    p->port.ops = &ops;
    p->port.is_ordered = n < 2;
    for (size_t k = 0; k < n && !r; k++) {
        p->n++;
        r = request_line(p, k, &lines[k], consumer, err);
    }
    if (r) {
        release(&p->port);
        return r;
    }
    *out = &p->port;
    return 0;
}

static uint64_t clock_ns(clockid_t clock)
{
    struct timespec t;

    clock_gettime(clock, &t);
    return (uint64_t)t.tv_sec * NS + (uint64_t)t.tv_nsec;
}

/* Kernels before 5.7 stamp with CLOCK_REALTIME and do not say so. */
static uint64_t monotonic(const struct timespec *t)
{
    uint64_t ns = (uint64_t)t->tv_sec * NS + (uint64_t)t->tv_nsec;
    uint64_t now = clock_ns(CLOCK_MONOTONIC);

    return ns < now + FUTURE ? ns : ns - (clock_ns(CLOCK_REALTIME) - now);
}

/* 1: there is something; 0; negative. */
static int is_readable(const struct port *p, size_t k, struct dx_err *err)
{
    struct pollfd fd = {.fd = p->line[k].fd, .events = POLLIN};

    if (poll(&fd, 1, 0) < 0)
        return errno == EINTR ? 0 : dx_gpio_fail(err, -errno, p->line[k].where, "poll");
    if (fd.revents & POLLIN)
        return 1;
    if (fd.revents)
        return dx_gpio_fail(err, -ENODEV, p->line[k].where, "the chip is gone");
    return 0;
}

static int read_line(struct port *p, size_t k, struct dx_gpio_event *out, size_t max,
                     struct dx_err *err)
{
    struct gpiod_line_event events[FIFO];
    int n = max < FIFO ? 0 : is_readable(p, k, err);

    if (n <= 0)
        return n;
    n = gpiod_line_event_read_fd_multiple(p->line[k].fd, events, FIFO);
    if (n < 0)
        return errno == EINTR ? 0
                              : dx_gpio_fail(err, errno == EIO ? -ENODEV : -errno, p->line[k].where,
                                             "events cannot be read");
    for (int i = 0; i < n; i++)
        out[i] = (struct dx_gpio_event){
            .timestamp_ns = monotonic(&events[i].ts),
            .line = (uint32_t)k,
            .rising = events[i].event_type == GPIOD_LINE_EVENT_RISING_EDGE,
            .overflow = i == FIFO - 1,
        };
    return n;
}

static int read_events(struct dx_gpio_port *port, struct dx_gpio_event *out, size_t max,
                       struct dx_err *err)
{
    struct port *p = (struct port *)port;
    size_t n = 0;

    for (size_t k = 0; k < p->n; k++) {
        int got = 1;

        while (p->line[k].fd >= 0 && got > 0) {
            got = read_line(p, k, out + n, max - n, err);
            if (got < 0)
                return got;
            n += (size_t)got;
        }
    }
    return (int)n;
}

static int get(struct dx_gpio_port *port, size_t line, struct dx_err *err)
{
    struct port *p = (struct port *)port;
    int value = gpiod_line_get_value(p->line[line].line);

    return value < 0 ? dx_gpio_fail(err, -errno, p->line[line].where, "its level is not told")
                     : value;
}

static int set(struct dx_gpio_port *port, size_t line, bool value, struct dx_err *err)
{
    struct port *p = (struct port *)port;

    return gpiod_line_set_value(p->line[line].line, value)
               ? dx_gpio_fail(err, -errno, p->line[line].where, "it cannot be set")
               : 0;
}

static size_t descriptors(const struct dx_gpio_port *port, int fds[DX_GPIO_MAX_LINES])
{
    const struct port *p = (const struct port *)port;
    size_t n = 0;

    for (size_t k = 0; k < p->n; k++)
        if (p->line[k].fd >= 0)
            fds[n++] = p->line[k].fd;
    return n;
}

static const struct dx_gpio_ops ops = {find, request, read_events, get, set, descriptors, release};
const struct dx_gpio_bank dx_gpio_kernel = {&ops};
