/*
 * Lines of no hardware: a script of edges with their times, handed out as a kernel would, and the
 * faults that kernels and wires have. For tests. Any thread, one at a time, but for set_level() and
 * advance(), which may come from another than the port's.
 */
#ifndef DX_GPIO_SCRIPT_H
#define DX_GPIO_SCRIPT_H

#include "drivers/gpio/gpio_port.h"

struct dx_gpio_script_step {
    uint64_t t_ns;
    uint32_t line; /* index in the request */
    bool rising;
    uint32_t seqno; /* 0: numbered by the script, where it numbers */
};

struct dx_gpio_script_faults {
    bool per_line;      /* as libgpiod 1: a queue for each line, no numbers, the newest is dropped
                         * without a word; else one queue, numbers, the oldest is dropped */
    uint32_t fifo;      /* events that a queue holds; 0: as many as there are */
    uint32_t bounce_ns; /* each edge comes three times, so far apart */
    uint32_t lose_at, n_lose; /* the kernel loses so many events from this one on; they count in the
                               * numbers */
    uint32_t swap_at;         /* > 0: this event and the one before change places, stamps and all */
    uint32_t gone_at;         /* > 0: after so many events read() says that the chip is gone */
    int refuse;               /* request() fails so: -EBUSY */
};

struct dx_gpio_script;

/* -ENOMEM. The steps are copied; their times ascend. */
int dx_gpio_script_new(struct dx_gpio_script **out, const struct dx_gpio_script_step *steps,
                       size_t n, const struct dx_gpio_script_faults *faults);
/* Its ports must be released. NULL is fine. */
void dx_gpio_script_free(struct dx_gpio_script *script);

const struct dx_gpio_bank *dx_gpio_script_bank(struct dx_gpio_script *script);

/* Moves the times of the steps to come: they count from here. */
void dx_gpio_script_begin(struct dx_gpio_script *script, uint64_t base_ns);

/* Steps up to this time have happened: levels change, events wait to be read. */
void dx_gpio_script_advance(struct dx_gpio_script *script, uint64_t until_ns);

/* A line changes without a step; the event is stamped `t_ns`. For inputs. */
void dx_gpio_script_set_level(struct dx_gpio_script *script, uint32_t line, bool level,
                              uint64_t t_ns);
/* The same without an event: the edge was lost. */
void dx_gpio_script_slip(struct dx_gpio_script *script, uint32_t line, bool level);
/* The chip goes. false: it is back for the next request(). */
void dx_gpio_script_unplug(struct dx_gpio_script *script, bool gone);

bool dx_gpio_script_level(struct dx_gpio_script *script, uint32_t line); /* of outputs too */
bool dx_gpio_script_is_open(struct dx_gpio_script *script);              /* a port is */
uint64_t dx_gpio_script_n_sets(struct dx_gpio_script *script, uint32_t line);

#endif
