/*
 * Lines of GPIO chips: one small table of functions, so that those who use lines know nothing of
 * the library behind it (libgpiod 1 or 2, chosen by the Makefile) and tests can put a script in its
 * place. A port belongs to one thread at a time.
 */
#ifndef DX_GPIO_PORT_H
#define DX_GPIO_PORT_H

#include "core/base/err.h"
#include "drivers/gpio_line.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define DX_GPIO_MAX_LINES  8 /* of a port */
#define DX_GPIO_MIN_EVENTS 16

struct dx_gpio_line {
    const char *where; /* gpio_line.h */
    bool output;
    bool active_low;
    bool value; /* outputs: the logical level from the request on */
    enum dx_gpio_bias bias;
    enum dx_gpio_edges edges; /* inputs */
    uint32_t debounce_us;     /* 0: none */
};

/* Where a line is. */
struct dx_gpio_place {
    char chip[80]; /* "/dev/gpiochip0" */
    uint32_t offset;
};

/* Logical edges and levels: active_low is applied. */
struct dx_gpio_event {
    uint64_t timestamp_ns; /* CLOCK_MONOTONIC */
    uint32_t line;         /* index in the request */
    bool rising;
    bool overflow;  /* events next to this one may be missing */
    uint32_t seqno; /* 1, 2, ... over the lines of one chip; 0: the back end has none */
};

struct dx_gpio_bank;
struct dx_gpio_port;

struct dx_gpio_ops {
    /* -ENOENT: there is no such line; -EINVAL: `where` is none; or what opening the chip gives. */
    int (*find)(const struct dx_gpio_bank *bank, const char *where, struct dx_gpio_place *place,
                struct dx_err *err);
    /* Takes n lines for `consumer` (a word for people who list lines). As find(); -EBUSY: one is in
     * use; -ENOMEM. */
    int (*request)(struct dx_gpio_port **out, const struct dx_gpio_bank *bank,
                   const struct dx_gpio_line *lines, size_t n, const char *consumer,
                   struct dx_err *err);
    /* Takes what waits, at most `max` events (not under DX_GPIO_MIN_EVENTS), without waiting: how
     * many. 0: there were no more. -ENODEV: the chip is gone. */
    int (*read)(struct dx_gpio_port *port, struct dx_gpio_event *out, size_t max,
                struct dx_err *err);
    /* The logical level, 0 or 1. */
    int (*get)(struct dx_gpio_port *port, size_t line, struct dx_err *err);
    int (*set)(struct dx_gpio_port *port, size_t line, bool value, struct dx_err *err);
    /* Descriptors that are readable when read() has something: how many. */
    size_t (*descriptors)(const struct dx_gpio_port *port, int fds[DX_GPIO_MAX_LINES]);
    /* Gives the lines back. What level outputs have from then on is the chip's affair. */
    void (*release)(struct dx_gpio_port *port);
};

/* Where lines come from: the kernel, or a script (gpio_script.h). */
struct dx_gpio_bank {
    const struct dx_gpio_ops *ops;
};
extern const struct dx_gpio_bank dx_gpio_kernel;

struct dx_gpio_port {
    const struct dx_gpio_ops *ops;
    bool is_ordered;   /* read() gives events of all lines in their order; else of each line */
    bool is_debounced; /* debounce_us is obeyed */
};

/* ---- for back ends
 * ------------------------------------------------------------------------------ */

/* "CHIP:OFFSET" in two; false: it is a line's name. */
bool dx_gpio_where_split(const char *where, char *chip, size_t chip_len, uint32_t *offset);

/* The find() of dx_gpio_ops: `offset_on` tells the offset of a line of this name on a chip, or -1.
 * NULL: lines have no names. */
int dx_gpio_find(const char *where, int (*offset_on)(const char *path, const char *name),
                 struct dx_gpio_place *place, struct dx_err *err);

/* "gpio line WHERE: what: why"; a code of 0 becomes -EIO. */
int dx_gpio_fail(struct dx_err *err, int code, const char *where, const char *what);

#endif
