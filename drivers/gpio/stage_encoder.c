/*
 * The encoder: its lines, the decoder behind them, and the track of where it stood. Events are
 * taken by a thread of its own and, before an answer, by the reader; `mutex` is held for that long.
 */
#include "drivers/stage_encoder.h"

#include "core/base/trig.h"
#include "drivers/angle.h"
#include "drivers/gpio/angle_track.h"
#include "drivers/gpio/edge_merge.h"
#include "drivers/gpio/line_thread.h"
#include "drivers/gpio/quadrature.h"
#include "drivers/monotonic.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define BATCH 256 /* events taken at once */
/* An edge that is stamped has reached its queue after this time, for all that is known of kernels:
 * the interrupt's thread puts it there. */
#define SETTLE_NS  500000u
#define MAX_POINTS 64 /* for one answer: a scan's time is short */
#define MAX_LOOKS  16 /* at the levels, for a moment without an edge */

struct encoder {
    struct dx_angle_source source;
    struct dx_encoder_config config;
    struct dx_line_thread thread;
    pthread_mutex_t mutex; /* what follows */
    struct dx_gpio_port *port;
    struct dx_quadrature quadrature;
    struct dx_edge_merge merge;
    struct dx_angle_track track;
    bool must_look; /* after a doubt: at the levels, when no event waits */
    int failure;    /* < 0: the lines are lost, as `err` says */
    struct dx_err err;
    uint64_t n_edges;
    struct dx_gpio_event events[BATCH];
};

/* ---- events to counts
 * --------------------------------------------------------------------------- */

/* What an edge has meant, for the track: it stands between two counts now, at the upper one. */
static void follow(struct encoder *e, uint64_t t_ns, unsigned result)
{
    const struct dx_quadrature *q = &e->quadrature;
    double at = (double)(q->dir > 0 ? q->count : q->count + 1);

    e->must_look |= (result & DX_QUADRATURE_DOUBT) != 0;
    if (result & DX_QUADRATURE_INDEX)
        dx_angle_track_index(&e->track, (result & DX_QUADRATURE_REZEROED) != 0);
    if (!(result & DX_QUADRATURE_MOVED))
        at = dx_angle_track_at(&e->track, t_ns).counts;
    if (result & (DX_QUADRATURE_MOVED | DX_QUADRATURE_DOUBT))
        dx_angle_track_put(&e->track, t_ns, at, q->is_uncertain);
}

static void one_edge(struct encoder *e, const struct dx_gpio_event *event, bool doubt)
{
    unsigned result = dx_quadrature_edge(&e->quadrature, (enum dx_quadrature_line)event->line,
                                         event->rising, doubt || event->overflow);

    e->n_edges++;
    follow(e, event->timestamp_ns, result);
}

/* A and B at one time. */
static void two_edges(struct encoder *e, const struct dx_gpio_event event[2])
{
    e->n_edges += 2;
    follow(e, event[0].timestamp_ns,
           dx_quadrature_both(&e->quadrature, event[0].rising, event[1].rising));
}

static void merged(struct encoder *e, uint64_t horizon_ns)
{
    struct dx_edge_merged m;

    while (dx_edge_merge_pop(&e->merge, horizon_ns, &m)) {
        if (m.n == 2)
            two_edges(e, m.event);
        else
            one_edge(e, &m.event[0], m.is_late);
    }
}

static void sort_in(struct encoder *e, const struct dx_gpio_event *event, uint64_t horizon_ns)
{
    if (e->port->is_ordered) {
        one_edge(e, event, false);
        return;
    }
    if (!dx_edge_merge_push(&e->merge, event)) {
        merged(e, horizon_ns);
        if (!dx_edge_merge_push(&e->merge, event)) {
            merged(e, UINT64_MAX);
            dx_edge_merge_push(&e->merge, event);
        }
    }
}

static int look_at_levels(struct encoder *e, uint64_t now_ns)
{
    int a = e->port->ops->get(e->port, DX_QUADRATURE_A, &e->err);
    int b = a < 0 ? a : e->port->ops->get(e->port, DX_QUADRATURE_B, &e->err);

    if (b < 0)
        return b;
    follow(e, now_ns, dx_quadrature_levels(&e->quadrature, a, b));
    e->must_look = false;
    return 0;
}

/* Takes what has come; the mutex is held. 0 or e->failure. */
static int take_in(struct encoder *e)
{
    uint64_t now = dx_clock_ns();
    uint64_t horizon = e->port->is_ordered ? now : now - SETTLE_NS;
    int n = 1;

    while (n > 0 && !e->failure) {
        n = e->port->ops->read(e->port, e->events, BATCH, &e->err);
        for (int k = 0; k < n; k++)
            sort_in(e, &e->events[k], horizon);
        e->failure = n < 0 ? n : 0;
    }
    merged(e, horizon);
    if (!e->failure)
        dx_angle_track_know(&e->track, horizon);
    if (e->must_look && !e->failure && !dx_edge_merge_waits(&e->merge))
        e->failure = look_at_levels(e, now);
    return e->failure;
}

/* ---- the thread
 * --------------------------------------------------------------------------------- */

static uint64_t run(void *ctx, uint64_t now_ns)
{
    struct encoder *e = ctx;
    uint64_t due = UINT64_MAX;

    pthread_mutex_lock(&e->mutex);
    if (!e->failure && !take_in(e) && dx_edge_merge_waits(&e->merge))
        due = now_ns + 2 * SETTLE_NS;
    pthread_mutex_unlock(&e->mutex);
    return due;
}

static size_t descriptors(void *ctx, int fds[DX_GPIO_MAX_LINES])
{
    struct encoder *e = ctx;
    size_t n = 0;

    pthread_mutex_lock(&e->mutex);
    if (!e->failure)
        n = e->port->ops->descriptors(e->port, fds);
    pthread_mutex_unlock(&e->mutex);
    return n;
}

/* ---- the angle source
 * --------------------------------------------------------------------------- */

static int encoder_pump(struct dx_angle_source *source, struct dx_err *err)
{
    struct encoder *e = (struct encoder *)source;
    int r;

    pthread_mutex_lock(&e->mutex);
    r = e->failure ? e->failure : take_in(e);
    if (r && err)
        *err = e->err;
    pthread_mutex_unlock(&e->mutex);
    return r;
}

static double angle_of(const struct encoder *e, double counts)
{
    double turns = counts / ((double)e->config.counts * e->config.gear);

    return dx_rad(e->config.zero_deg) + 2 * DX_PI * (e->config.reverse ? -turns : turns);
}

static size_t encoder_samples(struct dx_angle_source *source, uint64_t from_ns, uint64_t until_ns,
                              struct dx_angle_sample *out, size_t max)
{
    struct encoder *e = (struct encoder *)source;
    struct dx_track_point points[MAX_POINTS];
    size_t n = 0;

    pthread_mutex_lock(&e->mutex);
    if (!e->failure)
        take_in(e);
    if (!e->failure)
        n = dx_angle_track_points(&e->track, from_ns, until_ns, points,
                                  max < MAX_POINTS ? max : MAX_POINTS);
    pthread_mutex_unlock(&e->mutex);
    for (size_t k = 0; k < n; k++)
        out[k] = (struct dx_angle_sample){points[k].host_ns, angle_of(e, points[k].counts),
                                          points[k].is_uncertain};
    return n;
}

static void encoder_trouble(const struct dx_angle_source *source, char *text, size_t len)
{
    struct encoder *e = (struct encoder *)(uintptr_t)source;
    const struct dx_quadrature *q = &e->quadrature;

    pthread_mutex_lock(&e->mutex);
    if (e->failure)
        snprintf(text, len, "%s", e->err.text);
    else if (!q->is_uncertain)
        snprintf(text, len, "%s", "");
    else if (q->n_doubts && !q->has_index)
        snprintf(text, len, "edges of the encoder were missed, and there is no index");
    else if (q->is_indexed || q->n_doubts)
        snprintf(text, len, "edges of the encoder were missed: angles uncertain until its index");
    else
        snprintf(text, len, "the encoder's index was not passed yet");
    pthread_mutex_unlock(&e->mutex);
}

static void encoder_close(struct dx_angle_source *source)
{
    struct encoder *e = (struct encoder *)source;

    dx_line_thread_stop(&e->thread);
    e->port->ops->release(e->port);
    pthread_mutex_destroy(&e->mutex);
    free(e);
}

static const struct dx_angle_ops encoder_ops = {encoder_pump, encoder_samples, encoder_trouble,
                                                encoder_close};

void dx_encoder_tell(struct dx_angle_source *source, struct dx_encoder_status *status)
{
    struct encoder *e = (struct encoder *)source;
    const struct dx_quadrature *q = &e->quadrature;

    pthread_mutex_lock(&e->mutex);
    if (!e->failure)
        take_in(e);
    *status = (struct dx_encoder_status){q->count,   q->is_uncertain, e->n_edges,      q->n_doubts,
                                         q->n_index, q->n_mismatch,   q->last_mismatch};
    pthread_mutex_unlock(&e->mutex);
}

/* ---- opening
 * ------------------------------------------------------------------------------------ */

static const char *check_lines(const struct dx_encoder_config *c, const char **key)
{
    *key = "stage.encoder.a";
    if (!dx_gpio_where_given(c->a))
        return "an encoder needs its lines a and b";
    if (dx_gpio_where_check(c->a))
        return dx_gpio_where_check(c->a);
    *key = "stage.encoder.b";
    if (!dx_gpio_where_given(c->b))
        return "an encoder needs its lines a and b";
    if (dx_gpio_where_check(c->b))
        return dx_gpio_where_check(c->b);
    if (dx_gpio_where_same(c->a, c->b))
        return "an encoder has a line for each of a, b and z";
    *key = "stage.encoder.z";
    if (dx_gpio_where_given(c->z) && dx_gpio_where_check(c->z))
        return dx_gpio_where_check(c->z);
    if (dx_gpio_where_same(c->a, c->z) || dx_gpio_where_same(c->b, c->z))
        return "an encoder has a line for each of a, b and z";
    return NULL;
}

const char *dx_encoder_check(const struct dx_encoder_config *c, const char **key)
{
    const char *why = check_lines(c, key);

    if (why)
        return why;
    *key = "stage.encoder.counts";
    if (c->counts < 4 || c->counts > 1u << 24 || c->counts % 4)
        return "counts of an encoder are a multiple of four, at most 16777216";
    *key = "stage.encoder.gear";
    if (!(c->gear >= 1e-3 && c->gear <= 1e6))
        return "gear is from 0.001 to 1000000";
    return NULL;
}

/* The levels at a moment from which on every edge is waiting to be read. */
static int first_levels(struct encoder *e, bool levels[2], struct dx_err *err)
{
    int n = 1;

    for (int tries = 0; n > 0 && tries < MAX_LOOKS; tries++) {
        do
            n = e->port->ops->read(e->port, e->events, BATCH, err);
        while (n > 0);
        for (uint32_t k = 0; k < 2 && n >= 0; k++) {
            n = e->port->ops->get(e->port, k, err);
            levels[k] = n > 0;
        }
        if (n >= 0)
            n = e->port->ops->read(e->port, e->events, BATCH, err);
    }
    return n < 0 ? n : 0;
}

static int request_lines(struct encoder *e, const struct dx_gpio_bank *bank, struct dx_err *err)
{
    const struct dx_encoder_config *c = &e->config;
    uint32_t n = dx_gpio_where_given(c->z) ? 3 : 2;
    const char *where[3] = {c->a, c->b, c->z};
    struct dx_gpio_line lines[3];
    bool levels[2] = {false, false};
    int r;

    for (int k = 0; k < 3; k++)
        lines[k] = (struct dx_gpio_line){.where = where[k],
                                         .bias = c->bias,
                                         .edges = DX_GPIO_BOTH,
                                         .debounce_us = c->debounce_us};
    r = bank->ops->request(&e->port, bank, lines, n, "dexeld encoder", err);
    if (r)
        return r;
    r = first_levels(e, levels, err);
    if (r) {
        e->port->ops->release(e->port);
        return r;
    }
    dx_quadrature_init(&e->quadrature, c->counts, n == 3, levels[DX_QUADRATURE_A],
                       levels[DX_QUADRATURE_B]);
    dx_edge_merge_init(&e->merge, n);
    /* somewhere in the first count */
    dx_angle_track_init(&e->track, dx_clock_ns(), 0.5, n == 3);
    return 0;
}

int dx_encoder_open_on(struct dx_angle_source **out, const struct dx_encoder_config *config,
                       const struct dx_gpio_bank *bank, struct dx_err *err)
{
    const char *key, *why = dx_encoder_check(config, &key);
    struct encoder *e;
    int r;

    if (why)
        return dx_err_set(err, -EINVAL, "encoder: %s", why);
    e = calloc(1, sizeof(*e));
    if (!e)
        return dx_err_set(err, -ENOMEM, "encoder: no memory");
    e->source.ops = &encoder_ops;
    e->source.pump_ms = 100;
    e->config = *config;
    r = request_lines(e, bank, err);
    if (r)
        goto err_encoder;
    e->config.a = e->config.b = e->config.z = NULL;
    pthread_mutex_init(&e->mutex, NULL);
    r = dx_line_thread_start(&e->thread, &(struct dx_line_work){e, run, descriptors}, "encoder");
    if (r) {
        dx_err_set(err, r, "encoder: no thread");
        goto err_port;
    }
    *out = &e->source;
    return 0;

err_port:
    e->port->ops->release(e->port);
    pthread_mutex_destroy(&e->mutex);
err_encoder:
    free(e);
    return r;
}

int dx_encoder_open(struct dx_angle_source **out, const struct dx_encoder_config *config,
                    struct dx_err *err)
{
    return dx_encoder_open_on(out, config, &dx_gpio_kernel, err);
}
