/* Inside a rig: what its parts share. Owned by rig.c. */
#ifndef DX_RIG_PRIV_H
#define DX_RIG_PRIV_H

#include "drivers/gpio/interlock_guard.h"
#include "drivers/gpio/led.h"
#include "drivers/gpio/line_thread.h"
#include "drivers/gpio/pps.h"
#include "drivers/gpio/trigger_queue.h"
#include "drivers/rig.h"

enum dx_rig_role {
    DX_RIG_INTERLOCK_LINE = 0,
    DX_RIG_LASER_LINE,
    DX_RIG_TRIGGER_IN_LINE,
    DX_RIG_TRIGGER_OUT_LINE,
    DX_RIG_PPS_LINE,
    DX_RIG_LED_LINE,
    DX_RIG_N_ROLES
};

/* An output as it is driven. */
struct dx_rig_output {
    bool level;
    uint64_t due_ns; /* when it is to change; UINT64_MAX: when something else does */
};

struct dx_rig {
    struct dx_interlock interlock; /* what dx_rig_interlock() gives: its state() needs the rig */
    const struct dx_rig_config *config;
    const struct dx_gpio_bank *bank;
    struct dx_line_thread thread;

    /* the thread's own; after it has ended, the owner's */
    struct dx_gpio_port *port; /* NULL: not ours */
    uint64_t retry_ns;         /* then the lines are asked for again */
    uint32_t line_of[DX_RIG_N_ROLES];
    enum dx_rig_role role_of[DX_GPIO_MAX_LINES];
    struct dx_rig_output laser, led, trigger;
    uint64_t trigger_start_ns; /* of the pulse before */

    pthread_mutex_t mutex; /* what follows */
    struct dx_interlock_guard guard;
    struct dx_trigger_queue queue;
    struct dx_pps pps;
    bool runs, has_ended, has_lines, is_laser_on;
    enum dx_rig_show show;
    uint64_t n_triggers, n_unpaired_now; /* frames in a row without an edge */
    struct dx_err err;                   /* why the lines are not ours */
};

static inline bool dx_rig_has(const struct dx_rig *r, enum dx_rig_role role)
{
    return r->line_of[role] != UINT32_MAX;
}

/* Numbers the lines there are; line_of is UINT32_MAX for the others. Returns how many. */
size_t dx_rig_lines(struct dx_rig *r, struct dx_gpio_line lines[DX_RIG_N_ROLES]);

/* Takes the events that wait, and the interlock's level. 0 or negative: the lines are lost. The
 * mutex is held. */
int dx_rig_listen(struct dx_rig *r, uint64_t now_ns, struct dx_err *err);

/* Sets outputs as they should be now; the same. *due_ns becomes earlier where one is to change. */
int dx_rig_drive(struct dx_rig *r, uint64_t now_ns, uint64_t *due_ns, struct dx_err *err);

/* All outputs off; errors do not matter any more. */
void dx_rig_silence(struct dx_rig *r);

#endif
