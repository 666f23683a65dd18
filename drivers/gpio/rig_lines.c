/* What a rig's lines are asked for, and what the inputs have said. Its thread. */
#include "drivers/gpio/rig_priv.h"

#include "drivers/monotonic.h"

#include <time.h>

#define BATCH 64
#define TURNS 4
#define NS    1000000000u

static void add(struct dx_rig *r, struct dx_gpio_line *lines, size_t *n, enum dx_rig_role role,
                const struct dx_gpio_line *line)
{
    r->line_of[role] = UINT32_MAX;
    if (!dx_gpio_where_given(line->where))
        return;
    r->line_of[role] = (uint32_t)*n;
    r->role_of[*n] = role;
    lines[(*n)++] = *line;
}

size_t dx_rig_lines(struct dx_rig *r, struct dx_gpio_line lines[DX_RIG_N_ROLES])
{
    const struct dx_rig_config *c = r->config;
    size_t n = 0;

    add(r, lines, &n, DX_RIG_INTERLOCK_LINE,
        &(struct dx_gpio_line){.where = c->interlock.line,
                               .active_low = c->interlock.active_low,
                               .bias = c->interlock.bias,
                               .edges = DX_GPIO_BOTH,
                               .debounce_us = c->interlock.debounce_us});
    add(r, lines, &n, DX_RIG_LASER_LINE,
        &(struct dx_gpio_line){
            .where = c->laser.line, .output = true, .active_low = c->laser.active_low});
    add(r, lines, &n, DX_RIG_TRIGGER_IN_LINE,
        &(struct dx_gpio_line){.where = c->trigger_in.line,
                               .bias = c->trigger_in.bias,
                               .edges = c->trigger_in.falling ? DX_GPIO_FALLING : DX_GPIO_RISING});
    add(r, lines, &n, DX_RIG_TRIGGER_OUT_LINE,
        &(struct dx_gpio_line){
            .where = c->trigger_out.line, .output = true, .active_low = c->trigger_out.active_low});
    add(r, lines, &n, DX_RIG_PPS_LINE,
        &(struct dx_gpio_line){.where = c->pps.line, .edges = DX_GPIO_RISING});
    add(r, lines, &n, DX_RIG_LED_LINE,
        &(struct dx_gpio_line){
            .where = c->led.line, .output = true, .active_low = c->led.active_low});
    return n;
}

/* A time of CLOCK_MONOTONIC by CLOCK_REALTIME. */
static uint64_t real_ns(uint64_t mono_ns)
{
    struct timespec t;
    uint64_t now = dx_clock_ns(), real;

    clock_gettime(CLOCK_REALTIME, &t);
    real = (uint64_t)t.tv_sec * NS + (uint64_t)t.tv_nsec;
    return real - (now - mono_ns);
}

/* Logical: rising is stop. What was lost may have been one; in a queue of several lines, of any. */
static bool is_stop(const struct dx_rig *r, const struct dx_gpio_event *e)
{
    bool is_its = r->role_of[e->line] == DX_RIG_INTERLOCK_LINE;

    if (!dx_rig_has(r, DX_RIG_INTERLOCK_LINE))
        return false;
    return is_its ? e->rising || e->overflow : e->overflow && r->port->is_ordered;
}

static void hear(struct dx_rig *r, const struct dx_gpio_event *e)
{
    if (is_stop(r, e))
        dx_interlock_guard_break(&r->guard, e->timestamp_ns);
    switch (r->role_of[e->line]) {
    case DX_RIG_TRIGGER_IN_LINE:
        dx_trigger_queue_edge(&r->queue, e->timestamp_ns,
                              (uint64_t)r->config->trigger_in.min_gap_us * 1000, e->overflow);
        break;
    case DX_RIG_PPS_LINE:
        dx_pps_pulse(&r->pps, e->timestamp_ns, real_ns(e->timestamp_ns));
        break;
    default:
        break;
    }
}

int dx_rig_listen(struct dx_rig *r, uint64_t now_ns, struct dx_err *err)
{
    struct dx_gpio_event events[BATCH];
    int n = 1;

    /* a bounded share at a time: a line that never rests must not keep the laser on */
    for (int turn = 0; n > 0 && turn < TURNS; turn++) {
        n = r->port->ops->read(r->port, events, BATCH, err);
        for (int k = 0; k < n; k++)
            hear(r, &events[k]);
    }
    if (n < 0 || !dx_rig_has(r, DX_RIG_INTERLOCK_LINE))
        return n;
    /* the level decides, whatever edges came or were lost */
    n = r->port->ops->get(r->port, r->line_of[DX_RIG_INTERLOCK_LINE], err);
    if (n < 0)
        return n;
    dx_interlock_guard_contact(&r->guard, n == 0, now_ns);
    return 0;
}
