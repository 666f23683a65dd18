/*
 * A rig: its thread has the lines and looks after them; the reader and the daemon ask and tell
 * through the mutex, which is held for microseconds.
 */
#include "drivers/gpio/rig_priv.h"

#include "drivers/monotonic.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>

#define RETRY_NS     1000000000u
#define LOOK_NS      100000000u /* the interlock's level, even if no edge comes */
#define MAX_UNPAIRED 8          /* frames in a row without an edge that are no trouble yet */

/* ---- the thread
 * --------------------------------------------------------------------------------- */

/* Asks for the lines when it is time to. */
static void acquire(struct dx_rig *r, uint64_t now_ns)
{
    struct dx_gpio_line lines[DX_RIG_N_ROLES];
    struct dx_err err = {""};
    size_t n;
    int result;

    if (r->port || now_ns < r->retry_ns)
        return;
    n = dx_rig_lines(r, lines);
    result = r->bank->ops->request(&r->port, r->bank, lines, n, "dexeld", &err);
    if (result) {
        r->port = NULL;
        r->retry_ns = now_ns + RETRY_NS;
    } else {
        r->laser = r->led = r->trigger = (struct dx_rig_output){false, UINT64_MAX};
    }
    pthread_mutex_lock(&r->mutex);
    r->has_lines = r->port != NULL;
    r->err = err;
    pthread_mutex_unlock(&r->mutex);
}

static void lose(struct dx_rig *r, uint64_t now_ns, const struct dx_err *err)
{
    dx_rig_silence(r);
    r->port->ops->release(r->port);
    r->port = NULL;
    r->retry_ns = now_ns + RETRY_NS;
    r->has_lines = false;
    r->err = *err;
    dx_interlock_guard_fault(&r->guard, now_ns);
    dx_trigger_queue_restart(&r->queue);
}

static uint64_t run(void *ctx, uint64_t now_ns)
{
    struct dx_rig *r = ctx;
    struct dx_err err = {""};
    uint64_t due = UINT64_MAX;
    int result;

    acquire(r, now_ns);
    if (!r->port)
        return r->retry_ns;
    pthread_mutex_lock(&r->mutex);
    result = dx_rig_listen(r, now_ns, &err);
    if (!result)
        result = dx_rig_drive(r, now_ns, &due, &err);
    if (result)
        lose(r, now_ns, &err);
    if (dx_rig_has(r, DX_RIG_INTERLOCK_LINE)) {
        uint64_t closes = dx_interlock_guard_due(&r->guard);

        due = now_ns + LOOK_NS < due ? now_ns + LOOK_NS : due;
        due = closes < due ? closes : due;
    }
    pthread_mutex_unlock(&r->mutex);
    return due;
}

static size_t descriptors(void *ctx, int fds[DX_GPIO_MAX_LINES])
{
    struct dx_rig *r = ctx;

    return r->port ? r->port->ops->descriptors(r->port, fds) : 0;
}

/* ---- for others
 * --------------------------------------------------------------------------------- */

static void set_runs(struct dx_rig *r, bool runs, bool ends)
{
    pthread_mutex_lock(&r->mutex);
    r->has_ended |= ends;
    r->runs = runs && !r->has_ended;
    r->n_unpaired_now = 0;
    dx_trigger_queue_restart(&r->queue);
    pthread_mutex_unlock(&r->mutex);
    dx_line_thread_wake(&r->thread);
}

void dx_rig_run(struct dx_rig *r, bool runs)
{
    set_runs(r, runs, false);
}

void dx_rig_end(struct dx_rig *r)
{
    set_runs(r, false, true);
}

void dx_rig_show(struct dx_rig *r, enum dx_rig_show show)
{
    pthread_mutex_lock(&r->mutex);
    r->show = show;
    pthread_mutex_unlock(&r->mutex);
    dx_line_thread_wake(&r->thread);
}

bool dx_rig_pairs(const struct dx_rig *r)
{
    return dx_gpio_where_given(r->config->trigger_in.line);
}

bool dx_rig_frame(struct dx_rig *r, uint64_t arrival_ns, uint64_t n_missed, uint64_t *edge_ns)
{
    bool is_paired = false;

    if (!dx_rig_pairs(r))
        return false;
    pthread_mutex_lock(&r->mutex);
    is_paired = dx_trigger_queue_frame(&r->queue, arrival_ns, n_missed, edge_ns);
    r->n_unpaired_now = is_paired ? 0 : r->n_unpaired_now + 1;
    pthread_mutex_unlock(&r->mutex);
    return is_paired;
}

/* The mutex is held. */
static void why_open(const struct dx_rig *r, char *text, size_t len)
{
    if (!r->has_lines)
        snprintf(text, len, "interlock: %.84s", r->err.text[0] ? r->err.text : "not read yet");
    else if (r->guard.is_contact_closed)
        snprintf(text, len, "interlock closed again, laser still off");
    else if (r->guard.cause == DX_GUARD_FAULT)
        snprintf(text, len, "interlock cannot be read");
    else
        snprintf(text, len, "interlock open: laser off");
}

static void interlock_state(const struct dx_interlock *interlock, struct dx_interlock_state *out)
{
    struct dx_rig *r = (struct dx_rig *)(uintptr_t)interlock;

    pthread_mutex_lock(&r->mutex);
    *out = (struct dx_interlock_state){.is_open = r->guard.is_open,
                                       .since_ns = r->guard.since_ns,
                                       .n_openings = r->guard.n_openings};
    if (out->is_open)
        why_open(r, out->text, sizeof(out->text));
    pthread_mutex_unlock(&r->mutex);
}

const struct dx_interlock *dx_rig_interlock(const struct dx_rig *r)
{
    return dx_gpio_where_given(r->config->interlock.line) ? &r->interlock : NULL;
}

void dx_rig_trouble(struct dx_rig *r, char *text, size_t len)
{
    bool has_interlock = dx_rig_interlock(r) != NULL;

    pthread_mutex_lock(&r->mutex);
    if (has_interlock && r->guard.is_open)
        why_open(r, text, len);
    else if (!r->has_lines)
        snprintf(text, len, "%s", r->err.text);
    else if (r->n_unpaired_now > MAX_UNPAIRED)
        snprintf(text, len, "frames come without edges of the trigger");
    else
        snprintf(text, len, "%s", "");
    pthread_mutex_unlock(&r->mutex);
}

void dx_rig_tell(struct dx_rig *r, struct dx_rig_status *status)
{
    struct dx_pps_state pps;

    pthread_mutex_lock(&r->mutex);
    dx_pps_state(&r->pps, dx_clock_ns(), &pps);
    *status = (struct dx_rig_status){
        .has_lines = r->has_lines,
        .is_laser_on = r->is_laser_on,
        .n_openings = r->guard.n_openings,
        .n_edges = r->queue.n_edges,
        .n_pairs = r->queue.n_pairs,
        .n_unpaired = r->queue.n_frames - r->queue.n_pairs,
        .n_resyncs = r->queue.n_resyncs,
        .n_triggers = r->n_triggers,
        .is_pps_locked = pps.is_locked,
        .pps_offset_ns = pps.offset_ns,
        .pps_jitter_ns = pps.jitter_ns,
        .pps_rate_ppb = pps.rate_ppb,
    };
    pthread_mutex_unlock(&r->mutex);
}

/* ---- opening and closing
 * ------------------------------------------------------------------------ */

int dx_rig_open_on(struct dx_rig **out, const struct dx_rig_config *config,
                   const struct dx_gpio_bank *bank, struct dx_err *err)
{
    const char *key = "", *why = dx_rig_check(config, &key);
    struct dx_rig *r;
    int result;

    if (why)
        return dx_err_set(err, -EINVAL, "gpio.%s: %s", key, why);
    r = calloc(1, sizeof(*r));
    if (!r)
        return dx_err_set(err, -ENOMEM, "gpio: no memory");
    r->interlock.state = interlock_state;
    r->config = config;
    r->bank = bank;
    for (int k = 0; k < DX_RIG_N_ROLES; k++)
        r->line_of[k] = UINT32_MAX;
    dx_interlock_guard_init(&r->guard, (uint64_t)config->interlock.rearm_ms * 1000000,
                            dx_clock_ns());
    dx_trigger_queue_init(&r->queue, (uint64_t)config->trigger_in.max_delay_ms * 1000000);
    dx_pps_init(&r->pps);
    pthread_mutex_init(&r->mutex, NULL);
    result = dx_line_thread_start(&r->thread, &(struct dx_line_work){r, run, descriptors}, "rig");
    if (result) {
        pthread_mutex_destroy(&r->mutex);
        free(r);
        return dx_err_set(err, result, "gpio: no thread");
    }
    *out = r;
    return 0;
}

int dx_rig_open(struct dx_rig **out, const struct dx_rig_config *config, struct dx_err *err)
{
    return dx_rig_open_on(out, config, &dx_gpio_kernel, err);
}

void dx_rig_close(struct dx_rig *r)
{
    if (!r)
        return;
    dx_line_thread_stop(&r->thread);
    if (r->port) {
        dx_rig_silence(r);
        r->port->ops->release(r->port);
    }
    pthread_mutex_destroy(&r->mutex);
    free(r);
}
