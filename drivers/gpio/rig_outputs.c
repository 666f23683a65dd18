/* What a rig's outputs do: laser enable, trigger, LED. Its thread. */
#include "drivers/gpio/rig_priv.h"

#include <math.h>

#define NS 1e9

static int put(struct dx_rig *r, enum dx_rig_role role, struct dx_rig_output *o, bool level,
               struct dx_err *err)
{
    int result = 0;

    if (o->level != level)
        result = r->port->ops->set(r->port, r->line_of[role], level, err);
    if (!result)
        o->level = level;
    return result;
}

static void sooner(uint64_t *due_ns, uint64_t t_ns)
{
    *due_ns = t_ns < *due_ns ? t_ns : *due_ns;
}

static int drive_laser(struct dx_rig *r, uint64_t now_ns, struct dx_err *err)
{
    double hz = r->config->laser.heartbeat_hz;
    bool may = r->runs && !r->guard.is_open, was_on = r->is_laser_on;
    bool level = may;

    r->is_laser_on = may;
    if (!may || !(hz > 0)) {
        r->laser.due_ns = UINT64_MAX;
    } else if (!was_on || now_ns >= r->laser.due_ns) {
        level = !was_on || !r->laser.level;
        r->laser.due_ns = now_ns + (uint64_t)(NS / hz / 2);
    } else {
        level = r->laser.level;
    }
    return put(r, DX_RIG_LASER_LINE, &r->laser, level, err);
}

static int drive_trigger(struct dx_rig *r, uint64_t now_ns, struct dx_err *err)
{
    struct dx_rig_output *o = &r->trigger;
    uint64_t period_ns = (uint64_t)rint(NS / r->config->trigger_out.hz);
    bool level = o->level;

    if (!r->runs) {
        o->due_ns = UINT64_MAX;
        return put(r, DX_RIG_TRIGGER_OUT_LINE, o, false, err);
    }
    if (o->due_ns == UINT64_MAX)
        r->trigger_start_ns = o->due_ns = now_ns;
    if (now_ns >= o->due_ns) {
        level = !level;
        if (level) {
            /* the beat is kept; beats that were missed are left out */
            r->trigger_start_ns += (now_ns - r->trigger_start_ns) / period_ns * period_ns;
            o->due_ns = now_ns + (uint64_t)r->config->trigger_out.pulse_us * 1000;
            r->n_triggers++;
        } else {
            o->due_ns = r->trigger_start_ns + period_ns;
        }
    }
    return put(r, DX_RIG_TRIGGER_OUT_LINE, o, level, err);
}

static int drive_led(struct dx_rig *r, uint64_t now_ns, struct dx_err *err)
{
    enum dx_rig_show show = r->show;
    bool is_lit;

    if (dx_rig_has(r, DX_RIG_INTERLOCK_LINE) && r->guard.is_open)
        show = DX_RIG_INTERLOCK;
    is_lit = dx_led_is_lit(show, now_ns, &r->led.due_ns);
    return put(r, DX_RIG_LED_LINE, &r->led, is_lit, err);
}

int dx_rig_drive(struct dx_rig *r, uint64_t now_ns, uint64_t *due_ns, struct dx_err *err)
{
    int result = 0;

    if (dx_rig_has(r, DX_RIG_LASER_LINE)) {
        result = drive_laser(r, now_ns, err);
        sooner(due_ns, r->laser.due_ns);
    }
    if (!result && dx_rig_has(r, DX_RIG_TRIGGER_OUT_LINE)) {
        result = drive_trigger(r, now_ns, err);
        sooner(due_ns, r->trigger.due_ns);
    }
    if (!result && dx_rig_has(r, DX_RIG_LED_LINE)) {
        result = drive_led(r, now_ns, err);
        sooner(due_ns, r->led.due_ns);
    }
    return result;
}

void dx_rig_silence(struct dx_rig *r)
{
    static const enum dx_rig_role outputs[] = {DX_RIG_LASER_LINE, DX_RIG_TRIGGER_OUT_LINE,
                                               DX_RIG_LED_LINE};

    for (unsigned k = 0; k < sizeof(outputs) / sizeof(outputs[0]); k++)
        if (dx_rig_has(r, outputs[k]))
            (void)r->port->ops->set(r->port, r->line_of[outputs[k]], false, NULL);
    r->laser = r->led = r->trigger = (struct dx_rig_output){false, UINT64_MAX};
    r->is_laser_on = false;
}
