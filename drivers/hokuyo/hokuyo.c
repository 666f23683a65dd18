/*
 * The driver: a talk with a scanner, which is found first where there may be several, and an angle
 * source; or a decoder. read() drives the talk until a scan is whole; the block is made around the
 * scan's bytes where they lie. Owned by the reader thread; wake() from any.
 */
#include "drivers/hokuyo/hokuyo.h"

#include "drivers/hokuyo/hokuyo_probe.h"
#include "drivers/hokuyo/hokuyo_seek.h"
#include "drivers/hokuyo/scip_decoder.h"
#include "drivers/hokuyo/scip_talk.h"

#include "drivers/monotonic.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SILENCE_NS   2000000000ull /* of a scanner whose speed is not known yet */
#define STOP_NS      (600 * MS)    /* whatever a scanner answers to QT, or not */
#define MS           1000000u
#define MAX_STRIDE   2.0 /* beyond it too few neighbours have values */
#define STRIDE_SHARE 0.1 /* of each new scan */

struct dx_device {
    struct dx_hokuyo_config config; /* without its texts */
    struct dx_scip_talk talk;
    struct dx_hokuyo_seek *seek;   /* while the scanner is looked for among several; else NULL */
    struct dx_angle_source *angle; /* NULL: not reached yet */
    const struct dx_interlock *interlock; /* NULL: none */
    bool started, is_dark;                /* by the interlock */
    char serial[64];                      /* that is wanted; "": any */
    uint64_t n_blocks;
    struct dx_angle_sample samples[DX_SCIP_BLOCK_ANGLES];
    double stride; /* columns that the stage goes on from scan to scan; about, of late */
    uint32_t turn; /* columns of a turn */

    struct dx_scip_decoder *decoder; /* NULL: this is the device's half */
};

static void hokuyo_close(struct dx_device *dev)
{
    if (!dev)
        return;
    dx_hokuyo_seek_free(dev->seek);
    dx_scip_talk_fini(&dev->talk);
    dx_angle_close(dev->angle);
    dx_scip_decoder_free(dev->decoder);
    free(dev);
}

static int new_device(struct dx_device **out, const struct dx_hokuyo_config *c, struct dx_err *err)
{
    const char *key, *why = dx_hokuyo_check(c, &key);
    struct dx_device *dev;

    if (why)
        return dx_err_set(err, -EINVAL, "hokuyo: %s", why);
    dev = calloc(1, sizeof(*dev));
    if (!dev)
        return dx_err_set(err, -ENOMEM, "hokuyo: no memory");
    dx_scip_talk_init(&dev->talk);
    dev->config = *c;
    dev->config.tty = dev->config.tcp = dev->config.port = dev->config.serial = NULL; /* not ours */
    *out = dev;
    return 0;
}

static int open_decoder(struct dx_device **out, const void *config, struct dx_err *err)
{
    struct dx_device *dev = NULL;
    int r = new_device(&dev, config, err);

    if (r)
        return r;
    r = dx_scip_decoder_new(&dev->decoder, &dev->config, err);
    if (r) {
        hokuyo_close(dev);
        return r;
    }
    *out = dev;
    return 0;
}

static struct dx_scip_want wanted(const struct dx_hokuyo_config *c)
{
    return (struct dx_scip_want){
        .intensity = c->attr_bytes > 0 || c->echo == DX_HOKUYO_ECHO_STRONGEST,
        .echoes = c->echo != DX_HOKUYO_ECHO_ONE,
        .first_step = (int32_t)c->first_step,
        .last_step = (int32_t)c->last_step,
        .cluster = c->cluster,
        .skip = c->skip,
    };
}

/* Of the scanners on USB one is to be found, unless their place is named. */
static int open_link(struct dx_device *dev, const struct dx_hokuyo_config *c, struct dx_err *err)
{
    struct dx_scip_link *link;
    int r;

    if (dx_hokuyo_is_sought(c))
        return dx_hokuyo_seek_new(&dev->seek, dev->serial, err);
    r = dx_scip_link_open(&link, c, err);
    if (r == 0)
        dx_scip_talk_set_link(&dev->talk, link);
    return r;
}

static int hokuyo_open(struct dx_device **out, const void *config, struct dx_err *err)
{
    const struct dx_hokuyo_config *c = config;
    struct dx_device *dev = NULL;
    int r = new_device(&dev, c, err);

    if (r)
        return r;
    if (c->serial)
        snprintf(dev->serial, sizeof(dev->serial), "%s", c->serial);
    r = open_link(dev, c, err);
    if (r) {
        hokuyo_close(dev);
        return r;
    }
    *out = dev;
    return 0;
}

static int hokuyo_connect(struct dx_device *dev, struct dx_err *err)
{
    struct dx_scip_link *link = dev->talk.link;
    int r = 0;

    if (dev->seek) {
        r = dx_hokuyo_seek_step(dev->seek, &dev->talk, err);
        if (r == 0) /* by the serial of USB, or its own */
            dev->serial[0] = 0;
    } else if (link->ops->connect) {
        r = link->ops->connect(link, DX_SCIP_READ_MS, err);
    }
    return r ? r : dx_angle_open(&dev->angle, &dev->config.stage.angle, err);
}

/* A talk from its beginning. The counts are those of the stay. */
static int begin(struct dx_device *dev, struct dx_err *err)
{
    struct dx_scip_want want = wanted(&dev->config);

    dev->started = true;
    return dx_scip_talk_begin(&dev->talk, &want, DX_SCIP_BLOCK_HEADROOM, err);
}

static int hokuyo_start(struct dx_device *dev, struct dx_err *err)
{
    dev->talk.session.counts = (struct dx_scip_counts){0};
    dev->n_blocks = 0;
    return begin(dev, err);
}

/* ---- read -------------------------------------------------------------------------------------
 */

/* Does the stage turn too fast for its columns? */
static void measure_stride(struct dx_device *dev, const struct dx_scip_block *b, size_t n_angles)
{
    const struct dx_angle_sample *from = dev->samples, *to = dev->samples + n_angles - 1;
    struct dx_line_shape shape = dx_scip_decoder_shape(b, 0);
    double rad_s, stride;

    if (n_angles < 2 || to->host_ns <= from->host_ns || from->uncertain || to->uncertain)
        return;
    rad_s = (to->angle_rad - from->angle_rad) * 1e9 / (double)(to->host_ns - from->host_ns);
    stride = dx_stage_stride(&dev->config.stage, &shape, rad_s, &dev->turn);
    dev->stride += (stride - dev->stride) * STRIDE_SHARE;
}

/* The scan in the session, with the angles that the stage had during it. */
static void make_block(struct dx_device *dev, struct dx_block *block)
{
    const struct dx_scip_session *s = &dev->talk.session;
    const struct dx_scip_scan *scan = &s->scan;
    double step_ns = dx_scip_period_ns(&s->params) / s->params.ares;
    uint64_t from_ns = scan->host_ns + (uint64_t)(step_ns * s->request.first);
    uint64_t until_ns = scan->host_ns + (uint64_t)(step_ns * (s->request.last + 1));
    struct dx_scip_block b = {
        .flags = (scan->degraded ? DX_SCIP_BLOCK_DEGRADED : 0) |
                 (scan->unsure ? DX_SCIP_BLOCK_UNSURE : 0),
        .status = scan->head.status,
        .params = s->params,
        .first = s->request.first,
        .last = s->request.last,
        .cluster = s->request.cluster,
        .skip = s->request.skip,
        .command = {(uint8_t)s->request.command[0], (uint8_t)s->request.command[1]},
        .device_ns = scan->device_ns,
        .host_ns = scan->host_ns,
        .arrival_ns = scan->arrival_ns,
    };
    size_t n_angles =
        dev->angle->ops->samples(dev->angle, from_ns, until_ns, dev->samples, DX_SCIP_BLOCK_ANGLES);

    measure_stride(dev, &b, n_angles);
    snprintf(b.serial, sizeof(b.serial), "%.15s", s->identity.serial);
    *block = (struct dx_block){
        .stamp = {scan->arrival_ns, scan->device_ns, DX_CLOCK_DEVICE},
        .number = dev->n_blocks,
        .first = dev->n_blocks == 0,
        .source = dev->talk.link->place,
    };
    block->bytes =
        dx_scip_block_put(s->lines.reply, scan->len, &b, dev->samples, n_angles, &block->len);
    dev->n_blocks++;
}

/* Another scanner than the one that is meant is a fault: it is there, and it is not taken. */
static int check_serial(const struct dx_device *dev, struct dx_err *err)
{
    const struct dx_scip_session *s = &dev->talk.session;

    if (!s->is_known || !dev->serial[0] || !strcmp(s->identity.serial, dev->serial))
        return 0;
    return dx_hokuyo_seek_wrong(err, dev->talk.link->place, s->identity.serial, dev->serial);
}

/* One wait for bytes. 0: look again. */
static int step(struct dx_device *dev, uint64_t until_ns, struct dx_err *err)
{
    uint64_t pump_ns = dx_clock_ns() + (uint64_t)dev->angle->pump_ms * MS;
    int r = dev->angle->ops->pump(dev->angle, err);

    if (dev->angle->pump_ms && pump_ns < until_ns)
        until_ns = pump_ns;
    return r ? r : dx_scip_talk_step(&dev->talk, until_ns, err);
}

static void hokuyo_stop(struct dx_device *dev)
{
    struct dx_scip_session *s = &dev->talk.session;
    uint64_t due = dx_clock_ns() + STOP_NS;
    struct dx_err err;
    int r = 0;

    if (!dev->started)
        return;
    dev->started = false;
    dx_scip_session_stop(s, dx_clock_ns());
    while (r == 0 && s->state != DX_SCIP_STOPPED && dx_clock_ns() < due) {
        r = step(dev, s->deadline_ns, &err);
        r = r == DX_DRIVER_E_AGAIN ? 0 : r;
        while (dx_scip_talk_feed(&dev->talk) == 0)
            ; /* what still comes is not wanted */
    }
}

static void hokuyo_guard(struct dx_device *dev, const struct dx_interlock *interlock)
{
    dev->interlock = interlock;
}

/* The interlock is open: the scanner's laser off (QT), and not a word until it is closed. */
static int wait_dark(struct dx_device *dev, struct dx_err *err)
{
    struct dx_scip_talk *t = &dev->talk;
    int r;

    if (!dev->is_dark)
        hokuyo_stop(dev);
    dev->is_dark = true;
    r = t->link->ops->read(t->link, t->in, sizeof(t->in), &t->in_len, DX_SCIP_READ_MS, err);
    t->in_len = 0; /* what still comes is not wanted */
    return r ? r : DX_DRIVER_E_AGAIN;
}

static int hokuyo_read(struct dx_device *dev, struct dx_block *block, struct dx_err *err)
{
    uint64_t until = dx_clock_ns() + (uint64_t)DX_SCIP_READ_MS * MS;
    struct dx_interlock_state interlock;
    int r = 0;

    if (dx_interlock_is_open(dev->interlock, &interlock))
        return wait_dark(dev, err);
    if (dev->is_dark)
        r = begin(dev, err);
    dev->is_dark = false;
    if (r)
        return r;
    while ((r = dx_scip_talk_feed(&dev->talk)) == DX_DRIVER_E_AGAIN) {
        if (dx_clock_ns() >= until)
            return r;
        r = check_serial(dev, err);
        if (r == 0)
            r = step(dev, until, err);
        if (r)
            return r;
    }
    if (dev->n_blocks == 0)
        dx_hokuyo_seek_learn(dev->talk.link, dev->talk.session.identity.serial);
    make_block(dev, block);
    return 0;
}

/* ---- the rest ---------------------------------------------------------------------------------
 */

static int hokuyo_decode(struct dx_device *dev, const struct dx_block *block,
                         const struct dx_frame_sink *sink, struct dx_err *err)
{
    return dx_scip_decoder_decode(dev->decoder, block, sink, err);
}

static void hokuyo_wake(struct dx_device *dev)
{
    dx_scip_talk_wake(&dev->talk);
}

static uint64_t hokuyo_silence_ns(const struct dx_device *dev)
{
    const struct dx_scip_session *s = &dev->talk.session;

    if (s->suspended) /* it has said so, and the session waits that long before it begins anew */
        return DX_SCIP_MAX_SUSPENSION + SILENCE_NS;
    if (s->state != DX_SCIP_STREAM || s->n_since_start == 0)
        return SILENCE_NS;
    return (uint64_t)(16 * dx_scip_period_ns(&s->params) * (s->request.skip + 1));
}

static void hokuyo_health(const struct dx_device *dev, struct dx_device_health *out)
{
    const struct dx_scip_session *s = &dev->talk.session;

    *out = (struct dx_device_health){.n_lost = s->counts.n_lost, .n_damaged = s->counts.n_bad};
    snprintf(out->serial, sizeof(out->serial), "%s", s->identity.serial);
    if (dev->talk.link)
        snprintf(out->place, sizeof(out->place), "%s", dev->talk.link->place);
    if (s->trouble[0] || s->stat[0])
        snprintf(out->trouble, sizeof(out->trouble), "%s", s->trouble[0] ? s->trouble : s->stat);
    else if (dev->angle)
        dev->angle->ops->trouble(dev->angle, out->trouble, sizeof(out->trouble));
    if (!out->trouble[0] && dev->stride > MAX_STRIDE)
        snprintf(out->trouble, sizeof(out->trouble),
                 "too few scans a turn for %u columns, so no mesh: see stage.columns and stage.rpm",
                 dev->turn);
}

static void hokuyo_describe(struct dx_device *dev, char *text, size_t len)
{
    if (dev->decoder)
        dx_scip_decoder_describe(dev->decoder, text, len);
    else
        snprintf(text, len, "hokuyo: %s", dev->talk.session.identity.serial);
}

static bool is_remote(const void *config)
{
    const char *tcp = ((const struct dx_hokuyo_config *)config)->tcp;

    return tcp && *tcp;
}

static const char *const subsystems[] = {"usb", "tty", NULL};

const struct dx_driver dx_hokuyo_driver = {
    .name = "hokuyo",
    .subsystems = subsystems,
    .open = hokuyo_open,
    .open_decoder = open_decoder,
    .connect = hokuyo_connect,
    .start = hokuyo_start,
    .read = hokuyo_read,
    .decode = hokuyo_decode,
    .stop = hokuyo_stop,
    .close = hokuyo_close,
    .wake = hokuyo_wake,
    .is_remote = is_remote,
    .silence_ns = hokuyo_silence_ns,
    .health = hokuyo_health,
    .guard = hokuyo_guard,
    .probe = dx_hokuyo_probe,
    .describe = hokuyo_describe,
};
