/* Feeding the watchdog. Loop thread. */
#include "daemon/watchdog.h"

#include <errno.h>
#include <stdlib.h>
#include <systemd/sd-daemon.h>

#include "daemon/clock.h"
#include "daemon/fault.h"
#include "daemon/heartbeat.h"
#include "daemon/log.h"
#include "daemon/server_priv.h"

#define USUAL_NS  10000000000u /* a step of a thread takes no longer, when nobody else says */
#define LOOK_NS   1000000000u
#define NS_PER_US 1000u
/* before everything else: only a loop that does not come back at all misses it */
#define PRIORITY (-20)

struct dx_watchdog {
    struct dx_server *server;
    sd_event_source *timer;
    uint64_t look_ns;  /* how often it looks, and feeds */
    uint64_t usual_ns; /* what a step may take */
    bool is_watched;   /* there is a manager to feed */
};

static const char *const names[DX_N_BEATS] = {
    [DX_BEAT_READER] = "reader",
    [DX_BEAT_MESHER] = "mesher",
    [DX_BEAT_RECORDER] = "recorder",
};

const char *dx_watchdog_thread(enum dx_beating thread)
{
    return names[thread];
}

static void tell(const struct dx_watchdog *w, const struct dx_server_stream *st,
                 enum dx_beating thread, uint64_t late_ns)
{
    const char *name = st->options.name;
    double seconds = (double)late_ns * 1e-9;

    if (!late_ns)
        dx_log_info("watchdog", "%s: the %s goes on", name, names[thread]);
    else if (thread == DX_BEAT_RECORDER)
        dx_log_error("watchdog",
                     "%s: the recorder waits for its disk, for %.1f s by now; what finds no room "
                     "in memory is lost",
                     name, seconds);
    else
        dx_log_error("watchdog", "%s: the %s hangs: no sign of it for %.1f s%s", name,
                     names[thread], seconds,
                     w->is_watched ? "; the service is to be started anew" : "");
}

/* Meshers take turns at the pool: each may have to wait for a commit of all others. */
static uint64_t turns_ns(const struct dx_server *s)
{
    uint64_t n_dexels = 0;

    for (const struct dx_server_stream *st = s->streams; st; st = st->next)
        if (st->loop->geometry)
            n_dexels += (uint64_t)st->loop->geometry->width * st->loop->geometry->height;
    return n_dexels * DX_HEARTBEAT_DEXEL_NS;
}

bool dx_watchdog_look(struct dx_watchdog *w, uint64_t now_ns)
{
    uint64_t turns = turns_ns(w->server);
    bool is_well = true;

    for (struct dx_server_stream *st = w->server->streams; st; st = st->next)
        for (int k = 0; st->options.beats && k < DX_N_BEATS; k++) {
            uint64_t late = dx_heartbeat_late_ns(&st->options.beats->of[k], now_ns);
            bool hangs = late > w->usual_ns + (k == DX_BEAT_MESHER ? turns : 0);

            if (hangs != st->hangs[k])
                tell(w, st, (enum dx_beating)k, hangs ? late : 0);
            st->hangs[k] = hangs;
            is_well &= !hangs || k == DX_BEAT_RECORDER;
        }
    return is_well;
}

static int on_timer(sd_event_source *source, uint64_t usec, void *watchdog)
{
    struct dx_watchdog *w = watchdog;

    (void)usec;
    dx_fault_point(DX_FAULT_LOOP);
    if (dx_watchdog_look(w, dx_clock_ns()) && w->is_watched)
        sd_notify(0, "WATCHDOG=1");
    sd_event_source_set_time_relative(source, w->look_ns / NS_PER_US);
    return sd_event_source_set_enabled(source, SD_EVENT_ONESHOT);
}

int dx_watchdog_new(struct dx_watchdog **out, struct dx_server *server)
{
    struct dx_watchdog *w = calloc(1, sizeof(*w));
    uint64_t usec = 0;
    int r;

    *out = NULL;
    if (!w)
        return -ENOMEM;
    w->server = server;
    w->look_ns = LOOK_NS;
    w->usual_ns = USUAL_NS;
    w->is_watched = sd_watchdog_enabled(0, &usec) > 0;
    if (w->is_watched) { /* half of its time for a thread, the other half for the manager */
        w->usual_ns = usec * NS_PER_US / 2;
        if (w->look_ns > w->usual_ns / 2)
            w->look_ns = w->usual_ns / 2;
    }
    r = sd_event_add_time(server->event, &w->timer, CLOCK_MONOTONIC, 0, NS_PER_US, on_timer, w);
    if (r >= 0)
        r = sd_event_source_set_priority(w->timer, PRIORITY);
    if (r < 0) {
        dx_watchdog_free(w);
        return r;
    }
    *out = w;
    return 0;
}

void dx_watchdog_free(struct dx_watchdog *w)
{
    if (!w)
        return;
    sd_event_source_disable_unref(w->timer);
    free(w);
}
