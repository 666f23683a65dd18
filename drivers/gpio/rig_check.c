/* Which rigs cannot be, or would not be safe. Pure. */
#include "drivers/rig.h"

#define N_LINES DX_RIG_N_LINES

void dx_rig_list(const struct dx_rig_config *c, struct dx_rig_line lines[N_LINES])
{
    lines[0] = (struct dx_rig_line){"interlock.line", c->interlock.line};
    lines[1] = (struct dx_rig_line){"laser.line", c->laser.line};
    lines[2] = (struct dx_rig_line){"trigger_in.line", c->trigger_in.line};
    lines[3] = (struct dx_rig_line){"trigger_out.line", c->trigger_out.line};
    lines[4] = (struct dx_rig_line){"pps.line", c->pps.line};
    lines[5] = (struct dx_rig_line){"led.line", c->led.line};
}

bool dx_rig_is_wanted(const struct dx_rig_config *c)
{
    struct dx_rig_line lines[N_LINES];
    bool any = false;

    dx_rig_list(c, lines);
    for (unsigned k = 0; k < N_LINES; k++)
        any |= dx_gpio_where_given(lines[k].where);
    return any;
}

static const char *check_lines(const struct dx_rig_config *c, const char **key)
{
    struct dx_rig_line lines[N_LINES];

    dx_rig_list(c, lines);
    for (unsigned k = 0; k < N_LINES; k++) {
        *key = lines[k].key;
        if (!dx_gpio_where_given(lines[k].where))
            continue;
        if (dx_gpio_where_check(lines[k].where))
            return dx_gpio_where_check(lines[k].where);
        for (unsigned i = 0; i < k; i++)
            if (dx_gpio_where_same(lines[i].where, lines[k].where))
                return "this line has another purpose already";
    }
    return NULL;
}

const char *dx_rig_check(const struct dx_rig_config *c, const char **key)
{
    const char *why = check_lines(c, key);

    if (why)
        return why;
    *key = "interlock.bias";
    if (dx_gpio_where_given(c->interlock.line) && c->interlock.active_low &&
        c->interlock.bias == DX_GPIO_PULL_UP)
        return "with pull-up a broken wire would be high: no stop";
    if (dx_gpio_where_given(c->interlock.line) && !c->interlock.active_low &&
        c->interlock.bias == DX_GPIO_PULL_DOWN)
        return "with pull-down a broken wire would be low: no stop";
    *key = "laser.line";
    if (dx_gpio_where_given(c->laser.line) && !dx_gpio_where_given(c->interlock.line))
        return "a laser line needs an interlock";
    *key = "laser.heartbeat";
    if (!(c->laser.heartbeat_hz >= 0 && c->laser.heartbeat_hz <= 1000))
        return "a heartbeat is from 0 to 1000 Hz";
    *key = "trigger_out.hz";
    if (dx_gpio_where_given(c->trigger_out.line) &&
        !(c->trigger_out.hz >= 0.001 && c->trigger_out.hz <= 1000))
        return "a trigger has 0.001 to 1000 pulses a second";
    *key = "trigger_out.pulse_us";
    if (dx_gpio_where_given(c->trigger_out.line) &&
        (double)c->trigger_out.pulse_us * 1e-6 * c->trigger_out.hz >= 1)
        return "the pulse is longer than the time from one to the next";
    return NULL;
}
