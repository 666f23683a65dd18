/* What comes and goes. */
#include "daemon/presence.h"

#include "daemon/lifecycle.h"
#include "daemon/log.h"

#include <errno.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <systemd/sd-device.h>
#include <systemd/sd-event.h>
#include <unistd.h>

struct watcher {
    struct watcher *next;
    const char *const *subsystems;
    void (*poke)(void *);
    void *ctx;
};

struct dx_presence {
    sd_device_monitor *monitor;
    struct watcher *watchers;
    sd_event *event; /* NULL: not started */
};

int dx_presence_new(struct dx_presence **out)
{
    *out = calloc(1, sizeof(**out));
    return *out ? 0 : -ENOMEM;
}

void dx_presence_free(struct dx_presence *p)
{
    if (!p)
        return;
    sd_device_monitor_unref(p->monitor);
    while (p->watchers) {
        struct watcher *next = p->watchers->next;

        free(p->watchers);
        p->watchers = next;
    }
    free(p);
}

static bool is_of(const struct watcher *w, const char *subsystem)
{
    for (const char *const *s = w->subsystems; *s; s++)
        if (!strcmp(*s, subsystem))
            return true;
    return false;
}

static int on_device(sd_device_monitor *monitor, sd_device *device, void *presence)
{
    const struct dx_presence *p = presence;
    const char *subsystem, *name = "?";

    (void)monitor;
    if (sd_device_get_subsystem(device, &subsystem) < 0)
        return 0;
    sd_device_get_sysname(device, &name);
    dx_log_debug("presence", "%s %s has come, gone or changed", subsystem, name);
    for (const struct watcher *w = p->watchers; w; w = w->next)
        if (is_of(w, subsystem))
            w->poke(w->ctx);
    return 0;
}

static int match(struct dx_presence *p, const struct watcher *w)
{
    int r = 0;

    for (const char *const *s = w->subsystems; r >= 0 && *s; s++)
        r = sd_device_monitor_filter_add_match_subsystem_devtype(p->monitor, *s, NULL);
    return r;
}

static int start(struct dx_presence *p)
{
    int r = sd_device_monitor_new(&p->monitor);

    for (const struct watcher *w = p->watchers; r >= 0 && w; w = w->next)
        r = match(p, w);
    if (r >= 0)
        r = sd_device_monitor_attach_event(p->monitor, p->event);
    return r < 0 ? r : sd_device_monitor_start(p->monitor, on_device, p);
}

static void start_and_tell(struct dx_presence *p)
{
    int r = start(p);

    if (r >= 0 && access("/run/udev/control", F_OK) == 0)
        return;
    dx_log_warning("presence", "devices that come are found every %u s only: %s",
                   (unsigned)(DX_LIFE_LOOK_NS / 1000000000u),
                   r < 0 ? strerror(-r) : "no udevd runs");
}

void dx_presence_start(struct dx_presence *p, struct sd_event *event)
{
    p->event = event;
    if (p->watchers)
        start_and_tell(p);
}

/* One more, while it runs. What came before is seen by its first look. */
static void watch_also(struct dx_presence *p, const struct watcher *w)
{
    int r;

    if (!p->monitor) {
        start_and_tell(p);
        return;
    }
    r = match(p, w);
    if (r >= 0)
        r = sd_device_monitor_filter_update(p->monitor);
    if (r < 0)
        dx_log_warning("presence", "a device that comes is found every %u s only: %s",
                       (unsigned)(DX_LIFE_LOOK_NS / 1000000000u), strerror(-r));
}

int dx_presence_add(struct dx_presence *p, const char *const *subsystems, void (*poke)(void *ctx),
                    void *ctx)
{
    struct watcher *w;

    if (!*subsystems) /* a device on the network */
        return 0;
    w = calloc(1, sizeof(*w));
    if (!w)
        return -ENOMEM;
    *w = (struct watcher){p->watchers, subsystems, poke, ctx};
    p->watchers = w;
    if (p->event)
        watch_also(p, w);
    return 0;
}

void dx_presence_remove(struct dx_presence *p, const void *ctx)
{
    struct watcher **at = &p->watchers;

    while (*at) {
        struct watcher *w = *at;

        if (w->ctx != ctx) {
            at = &w->next;
            continue;
        }
        *at = w->next;
        free(w);
    }
}
