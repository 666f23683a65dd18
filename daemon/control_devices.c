/* devices, of the control socket. A probe is what loop and thread share: whoever lets go of it last
 * frees it, for a driver that is stuck in a device cannot be waited for at the end. */
#include "daemon/control_devices.h"

#include <errno.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "daemon/reader.h"
#include "daemon/server_priv.h"

struct dx_probe {
    atomic_int refs;
    int fd;             /* eventfd: `answer` is there */
    json_t *answer;     /* the thread's until then, the loop's after it */
    const char *driver; /* that is asked */

    /* loop */
    struct dx_server *server;
    sd_event_source *io;
    bool runs;
    int failed; /* -errno: no thread, when it was asked for last */
    void (*done)(void *ctx, json_t *answer);
    void *ctx;
};

static void let_go(struct dx_probe *p)
{
    /* release and acquire: what the other one did with it was before */
    if (atomic_fetch_sub_explicit(&p->refs, 1, memory_order_acq_rel) > 1)
        return;
    if (p->fd >= 0)
        close(p->fd);
    json_decref(p->answer);
    free(p);
}

/* ---- the thread ------------------------------------------------------------------------------
 */

static void on_found(void *probe, const struct dx_device_found *d)
{
    struct dx_probe *p = probe;
    char rule[512];
    json_t *o = json_pack("{s:s,s:s,s:s,s:s,s:s,s:s,s:b}", "driver", p->driver, "name", d->name,
                          "node", d->node, "serial", d->serial, "place", d->place, "yaml", d->yaml,
                          "usable", d->access == 0);

    if (d->access)
        json_object_set_new(o, "error", json_string(strerror(-d->access)));
    if (d->access == -EACCES || d->access == -EPERM) {
        dx_device_rule(d->node, rule, sizeof(rule));
        json_object_set_new(o, "rule", json_string(rule));
    }
    json_array_append_new(json_object_get(p->answer, "devices"), o);
}

static void ask_driver(struct dx_probe *p, const struct dx_driver *driver)
{
    struct dx_err err = {""};

    p->driver = driver->name;
    if (driver->probe && driver->probe(on_found, p, &err) < 0)
        json_array_append_new(json_object_get(p->answer, "errors"),
                              json_pack("{s:s,s:s}", "driver", driver->name, "error", err.text));
}

static void *ask_drivers(void *probe)
{
    struct dx_probe *p = probe;
    uint64_t one = 1;

    p->answer = json_pack("{s:[],s:[]}", "devices", "errors");
    for (const struct dx_driver *const *d = dx_drivers; p->answer && *d; d++)
        ask_driver(p, *d);
    (void)!write(p->fd, &one, sizeof(one));
    let_go(p);
    return NULL;
}

static int start(struct dx_probe *p)
{
    pthread_attr_t attr;
    pthread_t thread;
    int r = pthread_attr_init(&attr);

    if (r)
        return -r;
    atomic_fetch_add_explicit(&p->refs, 1, memory_order_relaxed);
    pthread_attr_setdetachstate(&attr, PTHREAD_CREATE_DETACHED);
    r = pthread_create(&thread, &attr, ask_drivers, p);
    pthread_attr_destroy(&attr);
    p->runs = r == 0;
    if (r) /* not the last: the loop has its own */
        atomic_fetch_sub_explicit(&p->refs, 1, memory_order_relaxed);
    return -r;
}

/* ---- the loop --------------------------------------------------------------------------------
 */

/* The stream that has the device at this place open; NULL: none. */
static const char *stream_at(const struct dx_server *server, const char *place)
{
    for (const struct dx_server_stream *st = server->streams; st && *place; st = st->next) {
        struct dx_reader_device *d =
            st->options.reader ? dx_stream_reader_attached(st->options.reader) : NULL;
        struct dx_reader_device_status s;

        if (!d)
            continue;
        dx_reader_device_status(d, &s);
        if (!strcmp(s.health.place, place) &&
            (s.state == DX_LIFE_STREAMING || s.state == DX_LIFE_STALLED))
            return st->options.name;
    }
    return NULL;
}

static void name_streams(const struct dx_probe *p)
{
    json_t *device;
    size_t k;

    json_array_foreach(json_object_get(p->answer, "devices"), k, device)
    {
        const char *place = json_string_value(json_object_get(device, "place"));
        const char *stream = stream_at(p->server, place ? place : "");

        if (stream)
            json_object_set_new(device, "stream", json_string(stream));
    }
}

static int on_answer(sd_event_source *source, int fd, uint32_t revents, void *probe)
{
    struct dx_probe *p = probe;
    json_t *answer;
    uint64_t n;

    (void)source;
    (void)revents;
    if (read(fd, &n, sizeof(n)) < 0)
        return 0;
    name_streams(p);
    answer = p->answer;
    p->answer = NULL;
    p->runs = false;
    p->done(p->ctx, answer);
    return 0;
}

uint64_t dx_control_begin_devices(struct dx_server *server)
{
    struct dx_probe *p = server->probe;

    p->failed = p->runs ? 0 : start(p);
    return p->failed ? 0 : DX_CONTROL_DEVICES;
}

json_t *dx_control_no_devices(struct dx_server *server, const json_t *request)
{
    (void)request;
    return json_pack("{s:o}", "error",
                     json_sprintf("no thread: %s", strerror(-server->probe->failed)));
}

int dx_probe_new(struct dx_probe **out, struct dx_server *server,
                 void (*done)(void *ctx, json_t *answer), void *ctx)
{
    struct dx_probe *p = calloc(1, sizeof(*p));
    int r;

    *out = NULL;
    if (!p)
        return -ENOMEM;
    atomic_init(&p->refs, 1);
    p->server = server;
    p->done = done;
    p->ctx = ctx;
    p->fd = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
    r = p->fd < 0 ? -errno : sd_event_add_io(server->event, &p->io, p->fd, EPOLLIN, on_answer, p);
    if (r < 0) {
        dx_probe_free(p);
        return r;
    }
    *out = p;
    return 0;
}

void dx_probe_free(struct dx_probe *p)
{
    if (!p)
        return;
    p->io = sd_event_source_disable_unref(p->io);
    let_go(p);
}
