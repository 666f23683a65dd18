/*
 * The device half of a reader. `lock` guards what other threads look at: which device is open, to
 * wake it, and the status.
 */
#include "daemon/reader_device.h"

#include "daemon/clock.h"
#include "daemon/log.h"
#include "daemon/reader_rig.h"

#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

#define HEALTH_NS  1000000000u
#define OPEN_NS    60000000000u /* a camera that is there and does not answer has 5 s a question */
#define LOG_BURST  6            /* lines at once, and then */
#define LOG_ONE_NS 10000000000u /* one in so long */

struct dx_reader_device {
    const char *name;
    const struct dx_driver *driver;
    const void *config;
    struct dx_mailbox *mailbox;
    struct dx_rig *rig; /* NULL: none */
    struct dx_heartbeat *beat;
    struct dx_life life;
    int fd; /* eventfd that ends a wait */
    atomic_bool poked;

    /* of this stay */
    struct dx_device *device; /* NULL: closed */
    bool is_reached;          /* it is more than begun to be opened */
    bool any_block;
    uint64_t health_due_ns;
    uint64_t n_lost_before;  /* the block before this one */
    uint64_t n_damaged_then; /* of this stay, when the last block came */

    uint64_t n_blocks;
    uint64_t n_lost, n_damaged; /* of the stays before */
    char serial[64];            /* of the last stay that had one */
    struct dx_err why;          /* of what went wrong last */

    /* the log's share */
    uint64_t log_ns; /* each line moves it on, at most so far ahead of now as the burst allows */
    uint32_t n_unsaid;

    pthread_mutex_t lock;
    struct dx_device *wakes; /* as `device` */
    struct dx_reader_device_status status;
};

int dx_reader_device_new(struct dx_reader_device **out, const char *name,
                         const struct dx_driver *driver, const void *driver_config,
                         struct dx_mailbox *mailbox, struct dx_err *err)
{
    struct dx_reader_device *d = calloc(1, sizeof(*d));

    if (!d)
        return dx_err_set(err, -ENOMEM, "no memory");
    d->name = name;
    d->driver = driver;
    d->config = driver_config;
    d->mailbox = mailbox;
    d->fd = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
    pthread_mutex_init(&d->lock, NULL);
    dx_life_init(&d->life, dx_clock_ns());
    d->status.state = d->life.state;
    d->status.since_ns = d->life.since_ns;
    if (d->fd < 0) {
        int r = dx_err_set(err, -errno, "eventfd: %s", strerror(errno));

        dx_reader_device_free(d);
        return r;
    }
    *out = d;
    return 0;
}

void dx_reader_device_free(struct dx_reader_device *d)
{
    if (!d)
        return;
    if (d->fd >= 0)
        close(d->fd);
    pthread_mutex_destroy(&d->lock);
    free(d);
}

void dx_reader_device_rig(struct dx_reader_device *d, struct dx_rig *rig)
{
    d->rig = rig;
}

void dx_reader_device_watch(struct dx_reader_device *d, struct dx_heartbeat *beat)
{
    d->beat = beat;
}

struct dx_rig *dx_reader_device_lines(struct dx_reader_device *d)
{
    return d->rig;
}

/* ---- other threads ---------------------------------------------------------------------------
 */

static void end_wait(struct dx_reader_device *d)
{
    uint64_t one = 1;
    ssize_t r = write(d->fd, &one, sizeof(one));

    (void)r; /* EAGAIN: it is raised */
}

void dx_reader_device_wake(struct dx_reader_device *d)
{
    end_wait(d);
    pthread_mutex_lock(&d->lock);
    if (d->wakes)
        d->driver->wake(d->wakes);
    pthread_mutex_unlock(&d->lock);
}

void dx_reader_device_poke(struct dx_reader_device *d)
{
    /* release: before the wait is ended by the eventfd */
    atomic_store_explicit(&d->poked, true, memory_order_release);
    end_wait(d);
}

void dx_reader_device_status(struct dx_reader_device *d, struct dx_reader_device_status *out)
{
    pthread_mutex_lock(&d->lock);
    *out = d->status;
    pthread_mutex_unlock(&d->lock);
}

/* ---- telling ---------------------------------------------------------------------------------
 */

static bool has_line(const struct dx_reader_device *d, uint64_t now)
{
    return d->log_ns < now + (uint64_t)LOG_BURST * LOG_ONE_NS;
}

void dx_reader_device_log(struct dx_reader_device *d, int level, const char *text)
{
    uint64_t now = dx_clock_ns();
    char more[64] = "";

    if (!has_line(d, now)) {
        d->n_unsaid++;
        return;
    }
    d->log_ns = (d->log_ns > now ? d->log_ns : now) + LOG_ONE_NS;
    if (d->n_unsaid)
        snprintf(more, sizeof(more), " (%u lines before were left out)", d->n_unsaid);
    d->n_unsaid = 0;
    dx_log_at(level, "reader", "%s: %.700s%s", d->name, text, more);
}

static enum dx_stream_state told_as(enum dx_life_state state)
{
    switch (state) {
    case DX_LIFE_STREAMING:
        return DX_STREAM_LIVE;
    case DX_LIFE_STALLED:
        return DX_STREAM_STALLED;
    case DX_LIFE_FAULTED:
        return DX_STREAM_FAULTED;
    case DX_LIFE_ABSENT:
    case DX_LIFE_GONE:
        return DX_STREAM_GONE;
    default:
        return DX_STREAM_OPENING;
    }
}

static void copy_reason(char to[DX_WIRE_TEXT], const char *from)
{
    snprintf(to, DX_WIRE_TEXT, "%.*s", DX_WIRE_TEXT - 1, from);
}

static void count_change(struct dx_reader_device_status *s, enum dx_life_state from,
                         enum dx_life_state to)
{
    bool was_open = from == DX_LIFE_OPENING || from == DX_LIFE_STREAMING || from == DX_LIFE_STALLED;

    s->n_stalls += to == DX_LIFE_STALLED;
    s->n_went += to == DX_LIFE_GONE && was_open;
}

static void log_change(struct dx_reader_device *d)
{
    enum dx_life_state state = d->life.state;
    char text[700];

    if (state == DX_LIFE_STREAMING)
        snprintf(text, sizeof(text), "streaming: %.63s at %.127s",
                 *d->status.health.serial ? d->status.health.serial : "no serial",
                 *d->status.health.place ? d->status.health.place : "an unknown place");
    else
        snprintf(text, sizeof(text), "%s%s%s", dx_life_state_name(state), *d->why.text ? ": " : "",
                 d->why.text);
    dx_reader_device_log(
        d, state == DX_LIFE_STREAMING || state == DX_LIFE_OPENING ? LOG_INFO : LOG_WARNING, text);
}

/* The state as it is now, wherever it is looked at. That frames come again is told to subscribers
 * with the first of them (reader.c). */
static void show(struct dx_reader_device *d)
{
    struct dx_reader_device_status *s = &d->status;
    enum dx_life_state state = d->life.state;
    bool changed = state != s->state;

    if (state == DX_LIFE_STREAMING || state == DX_LIFE_OPENING)
        d->why.text[0] = '\0';
    if (!changed && strncmp(s->reason, d->why.text, sizeof(s->reason) - 1) == 0)
        return; /* so it is with each block; and only this thread writes the status */
    pthread_mutex_lock(&d->lock);
    if (changed)
        count_change(s, s->state, state);
    s->state = state;
    s->since_ns = d->life.since_ns;
    copy_reason(s->reason, d->why.text);
    pthread_mutex_unlock(&d->lock);
    log_change(d);
    dx_reader_rig_show(d->rig, state, *s->health.trouble);
    if (state != DX_LIFE_STREAMING)
        dx_mailbox_put_state(d->mailbox, told_as(state), s->reason);
}

/* ---- health ----------------------------------------------------------------------------------
 */

/* Who it is stays known when it no longer says so: that is the one that is missed. */
static void ask_health(struct dx_reader_device *d)
{
    struct dx_device_health h = {0};
    bool is_new;

    d->driver->health(d->device, &h);
    dx_reader_rig_trouble(d->rig, &h);
    if (!*h.serial && d->any_block)
        memcpy(h.serial, d->status.health.serial, sizeof(h.serial));
    if (!*h.place && d->any_block)
        memcpy(h.place, d->status.health.place, sizeof(h.place));
    is_new = *h.trouble && strcmp(d->status.health.trouble, h.trouble) != 0;
    h.n_lost += d->n_lost;
    h.n_damaged += d->n_damaged;
    pthread_mutex_lock(&d->lock);
    d->status.health = h;
    pthread_mutex_unlock(&d->lock);
    dx_reader_rig_show(d->rig, d->life.state, *h.trouble);
    if (is_new)
        dx_reader_device_log(d, LOG_WARNING, h.trouble);
}

static void poll_health(struct dx_reader_device *d, uint64_t now)
{
    if (now < d->health_due_ns)
        return;
    d->health_due_ns = now + HEALTH_NS;
    ask_health(d);
    if (d->n_unsaid && has_line(d, now)) /* it flaps no more */
        dx_reader_device_log(d, LOG_INFO, dx_life_state_name(d->life.state));
}

/* A stream that is configured loosely may get another unit than before. */
static void know_unit(struct dx_reader_device *d)
{
    const char *serial = d->status.health.serial;
    char text[200];

    if (*serial && *d->serial && strcmp(serial, d->serial) != 0) {
        snprintf(text, sizeof(text), "another unit: %s, before it was %s", serial, d->serial);
        dx_reader_device_log(d, LOG_WARNING, text);
    }
    if (*serial)
        memcpy(d->serial, serial, sizeof(d->serial));
    dx_log_about_device(*d->serial ? d->serial : d->status.health.place);
}

/* ---- opening and closing ---------------------------------------------------------------------
 */

static void set_device(struct dx_reader_device *d, struct dx_device *device)
{
    d->device = device;
    pthread_mutex_lock(&d->lock);
    d->wakes = device;
    pthread_mutex_unlock(&d->lock);
}

void dx_reader_device_close(struct dx_reader_device *d)
{
    struct dx_device *device = d->device;

    if (!device)
        return;
    if (d->is_reached) {
        ask_health(d);
        dx_reader_rig_close(d->rig);
        d->n_lost = d->status.health.n_lost;
        d->n_damaged = d->status.health.n_damaged;
        d->is_reached = false;
    }
    set_device(d, NULL); /* before it is closed: nobody wakes it any more */
    d->driver->stop(device);
    d->driver->close(device);
}

/* Tells the life cycle, and closes what it has given up. */
static void tell(struct dx_reader_device *d, enum dx_life_event event, uint64_t now)
{
    dx_life_tell(&d->life, event, now);
    if (event == DX_LIFE_FAILED || (event == DX_LIFE_QUIET && !d->life.is_open)) {
        pthread_mutex_lock(&d->lock);
        d->status.n_faults++;
        pthread_mutex_unlock(&d->lock);
    }
    if (!d->life.is_open)
        dx_reader_device_close(d);
    show(d);
}

/* 0: it runs. AGAIN: it is not reached yet, which may be asked again. */
static int open_device(struct dx_reader_device *d)
{
    struct dx_device *device = NULL;
    int r = 0;

    if (!d->device) {
        atomic_store_explicit(&d->poked, false, memory_order_relaxed); /* this look sees it */
        d->why.text[0] = '\0';
        r = d->driver->open(&device, d->config, &d->why);
        if (r != 0)
            return r;
        set_device(d, device); /* from now on it can be woken */
    }
    if (d->driver->connect)
        r = d->driver->connect(d->device, &d->why);
    if (r != 0)
        return r;
    d->is_reached = true;
    dx_reader_rig_open(d->rig, d->driver, d->device);
    return d->driver->start(d->device, &d->why);
}

/* Frames of before are not of this stay. */
static void begin_stay(struct dx_reader_device *d)
{
    d->any_block = false;
    d->n_lost_before = d->n_damaged_then = 0;
    d->health_due_ns = dx_clock_ns() + HEALTH_NS;
    pthread_mutex_lock(&d->lock);
    d->status.n_opens++;
    pthread_mutex_unlock(&d->lock);
    ask_health(d);
    know_unit(d);
    dx_life_opened(&d->life, d->driver->silence_ns(d->device), dx_clock_ns());
    show(d);
}

static void look(struct dx_reader_device *d)
{
    int r;

    dx_heartbeat_allow(d->beat, dx_clock_ns(), OPEN_NS);
    r = open_device(d);
    if (r == 0)
        begin_stay(d);
    else if (r != DX_DRIVER_E_AGAIN)
        tell(d, r == DX_DRIVER_E_GONE ? DX_LIFE_NOT_THERE : DX_LIFE_FAILED, dx_clock_ns());
}

/* ---- the turns -------------------------------------------------------------------------------
 */

static uint64_t count_damaged(const struct dx_reader_device *d)
{
    struct dx_device_health h = {0};

    d->driver->health(d->device, &h);
    return h.n_damaged;
}

static void take_block(struct dx_reader_device *d, struct dx_block *block, uint64_t now)
{
    block->number = d->n_blocks++;
    block->first = !d->any_block;
    d->any_block = true;
    if (block->first) { /* now it knows who it is, and how fast */
        ask_health(d);
        know_unit(d);
    }
    dx_life_expect(&d->life, d->driver->silence_ns(d->device));
    dx_reader_rig_stamp(d->rig, d->driver, d->device, &d->n_lost_before, block);
    d->n_damaged_then = count_damaged(d);
    tell(d, DX_LIFE_BLOCK, now);
}

/* Why no block comes: nothing does, or nothing that can be used. */
static void explain_silence(struct dx_reader_device *d, uint64_t now)
{
    double silent_s = (double)(now - d->life.heard_ns) * 1e-9;
    uint64_t n_damaged = count_damaged(d) - d->n_damaged_then;

    if (n_damaged > 0)
        dx_err_set(&d->why, 0, "for %.1f s nothing but damaged data: %llu frames or scans",
                   silent_s, (unsigned long long)n_damaged);
    else
        dx_err_set(&d->why, 0, "no data for %.1f s", silent_s);
}

static void take_silence(struct dx_reader_device *d, uint64_t now)
{
    struct dx_life next;
    char held[96];

    dx_life_expect(&d->life, d->driver->silence_ns(d->device)); /* it may have told why */
    next = d->life;
    if (dx_reader_rig_holds(d->rig, now, held) && d->life.state == DX_LIFE_STALLED)
        return; /* it is not to be opened anew for that */
    dx_life_tell(&next, DX_LIFE_QUIET, now);
    if (next.state != d->life.state && *held)
        dx_err_set(&d->why, 0, "%s", held);
    else if (next.state != d->life.state)
        explain_silence(d, now);
    tell(d, DX_LIFE_QUIET, now);
}

static int read_block(struct dx_reader_device *d, struct dx_block *block)
{
    struct dx_err err = {""};
    int r = d->driver->read(d->device, block, &err);
    uint64_t now = dx_clock_ns();

    if (r == 0) {
        take_block(d, block, now);
    } else if (r == DX_DRIVER_E_AGAIN) {
        take_silence(d, now);
    } else {
        d->why = err;
        tell(d, r == DX_DRIVER_E_GONE ? DX_LIFE_WENT : DX_LIFE_FAILED, now);
    }
    if (d->device)
        poll_health(d, now);
    return r == 0 ? 0 : DX_DRIVER_E_AGAIN;
}

/* Until it is time to look, or somebody ends it. */
static void wait_closed(struct dx_reader_device *d)
{
    uint64_t now = dx_clock_ns(), left = d->life.due_ns > now ? d->life.due_ns - now : 0, n;
    const struct timespec t = {(time_t)(left / 1000000000u), (long)(left % 1000000000u)};
    struct pollfd p = {d->fd, POLLIN, 0};

    dx_heartbeat_allow(d->beat, now, left);
    if (ppoll(&p, 1, &t, NULL) > 0 && read(d->fd, &n, sizeof(n)) < 0)
        return;
    if (atomic_exchange_explicit(&d->poked, false, memory_order_acquire))
        tell(d, DX_LIFE_POKE, dx_clock_ns());
}

int dx_reader_device_read(struct dx_reader_device *d, struct dx_block *block)
{
    switch (dx_life_step(&d->life, dx_clock_ns())) {
    case DX_LIFE_READ:
        return read_block(d, block);
    case DX_LIFE_OPEN:
        look(d);
        break;
    case DX_LIFE_WAIT:
        wait_closed(d);
        break;
    }
    return DX_DRIVER_E_AGAIN;
}

bool dx_reader_device_streams(const struct dx_reader_device *d)
{
    return d->life.state == DX_LIFE_STREAMING;
}
