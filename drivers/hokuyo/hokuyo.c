/*
 * The driver: a link, a session on it, and an angle source; or a decoder. read() drives the session
 * until a scan is whole; the block is made around the scan's bytes where they lie. Owned by the
 * reader thread; wake() from any.
 */
#include "drivers/hokuyo/hokuyo.h"

#include "drivers/hokuyo/hokuyo_probe.h"
#include "drivers/hokuyo/scip_decoder.h"
#include "drivers/hokuyo/scip_link.h"
#include "drivers/hokuyo/scip_session.h"

#include "drivers/replay.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define IN_LEN       4096
#define READ_MS      100           /* most that read() waits */
#define SILENCE_NS   2000000000ull /* of a scanner whose speed is not known yet */
#define STOP_NS      (600 * MS)    /* whatever a scanner answers to QT, or not */
#define MS           1000000u
#define MAX_STRIDE   2.0 /* beyond it too few neighbours have values */
#define STRIDE_SHARE 0.1 /* of each new scan */

struct dx_device {
    struct dx_hokuyo_config config; /* without its texts */
    struct dx_scip_link *link;
    struct dx_scip_session session;
    struct dx_angle_source *angle;
    const struct dx_interlock *interlock; /* NULL: none */
    bool started, is_dark;                /* by the interlock */
    char serial[64];                      /* that is wanted; "": any */
    uint8_t in[IN_LEN];                   /* bytes [in_at, in_len) wait for the session */
    size_t in_at, in_len;
    uint64_t in_ns; /* when they came */
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
    dx_scip_link_close(dev->link);
    dx_scip_session_fini(&dev->session);
    dx_angle_close(dev->angle);
    dx_scip_decoder_free(dev->decoder);
    free(dev);
}

static int new_device(struct dx_device **out, const struct dx_hokuyo_config *c, struct dx_err *err)
{
    const char *why = dx_hokuyo_check(c);
    struct dx_device *dev;

    if (why)
        return dx_err_set(err, -EINVAL, "hokuyo: %s", why);
    dev = calloc(1, sizeof(*dev));
    if (!dev)
        return dx_err_set(err, -ENOMEM, "hokuyo: no memory");
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

static int hokuyo_open(struct dx_device **out, const void *config, struct dx_err *err)
{
    const struct dx_hokuyo_config *c = config;
    struct dx_device *dev = NULL;
    int r = new_device(&dev, c, err);

    if (r)
        return r;
    if (c->serial)
        snprintf(dev->serial, sizeof(dev->serial), "%s", c->serial);
    r = dx_scip_link_open(&dev->link, c, err);
    if (r == 0)
        r = dx_angle_open(&dev->angle, &dev->config.stage.angle, err);
    if (r) {
        hokuyo_close(dev);
        return r;
    }
    *out = dev;
    return 0;
}

/* A talk from its beginning. The counts are those of the stay. */
static int begin(struct dx_device *dev, struct dx_err *err)
{
    struct dx_scip_want want = wanted(&dev->config);
    struct dx_scip_counts counts = dev->session.counts;
    int r;

    dx_scip_session_fini(&dev->session);
    r = dx_scip_session_init(&dev->session, &want, DX_SCIP_BLOCK_HEADROOM, dx_pace_now());
    if (r)
        return dx_err_set(err, r, "%s: no memory", dev->link->place);
    dev->session.counts = counts;
    dev->in_at = dev->in_len = 0;
    dev->started = true;
    return 0;
}

static int hokuyo_start(struct dx_device *dev, struct dx_err *err)
{
    int r;

    dev->session.counts = (struct dx_scip_counts){0};
    r = begin(dev, err);
    if (r)
        return r;
    dev->n_blocks = 0;
    return 0;
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
    const struct dx_scip_session *s = &dev->session;
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
        .source = dev->link->place,
    };
    block->bytes =
        dx_scip_block_put(s->lines.reply, scan->len, &b, dev->samples, n_angles, &block->len);
    dev->n_blocks++;
}

/* Feeds what waits; 0 when a scan has become whole. */
static int feed(struct dx_device *dev)
{
    struct dx_scip_session *s = &dev->session;

    while (dev->in_at < dev->in_len) {
        dev->in_at +=
            dx_scip_session_feed(s, dev->in + dev->in_at, dev->in_len - dev->in_at, dev->in_ns);
        if (s->scan_ready)
            return 0;
    }
    return DX_DRIVER_E_AGAIN;
}

static int send_waiting(struct dx_device *dev, struct dx_err *err)
{
    struct dx_scip_session *s = &dev->session;
    size_t len = s->out_len;
    int r;

    if (len == 0)
        return 0;
    r = dev->link->ops->write(dev->link, s->out, len, err);
    if (r == 0)
        dx_scip_session_sent(s, len, dx_pace_now());
    return r;
}

/* Milliseconds until the session, the angle source or the caller wants to be heard. */
static int wait_ms(const struct dx_device *dev, uint64_t until_ns, uint64_t now_ns)
{
    uint64_t next = dev->session.deadline_ns < until_ns ? dev->session.deadline_ns : until_ns;
    uint64_t ms = next > now_ns ? (next - now_ns + MS - 1) / MS : 0;

    if (dev->angle->pump_ms && ms > dev->angle->pump_ms)
        ms = dev->angle->pump_ms;
    return (int)ms;
}

/* Another scanner than the one that is meant is a fault: it is there, and it is not taken. */
static int check_serial(const struct dx_device *dev, struct dx_err *err)
{
    const char *found = dev->session.identity.serial, *want = dev->serial;

    if (!want[0] || !dev->session.is_known || !strcmp(found, want))
        return 0;
    if (!found[0])
        return dx_err_set(err, -ENXIO, "%s: the scanner tells no serial number, expected '%s'",
                          dev->link->place, want);
    return dx_err_set(err, -ENXIO, "%s: serial number is '%s', expected '%s'", dev->link->place,
                      found, want);
}

/* One wait for bytes. 0: look again. */
static int step(struct dx_device *dev, uint64_t until_ns, struct dx_err *err)
{
    uint64_t now = dx_pace_now();
    int r;

    dx_scip_session_tick(&dev->session, now);
    if (dev->session.dead)
        return dx_err_set(err, -ETIMEDOUT, "%s: %s", dev->link->place, dev->session.trouble);
    r = send_waiting(dev, err);
    if (r == 0)
        r = dev->angle->ops->pump(dev->angle, err);
    if (r == 0)
        r = dev->link->ops->read(dev->link, dev->in, sizeof(dev->in), &dev->in_len,
                                 wait_ms(dev, until_ns, now), err);
    dev->in_at = 0;
    if (r) {
        dev->in_len = 0;
        return r;
    }
    dev->in_ns = dx_pace_now();
    return 0;
}

static void hokuyo_stop(struct dx_device *dev)
{
    struct dx_scip_session *s = &dev->session;
    uint64_t due = dx_pace_now() + STOP_NS;
    struct dx_err err;
    int r = 0;

    if (!dev->started)
        return;
    dev->started = false;
    dx_scip_session_stop(s, dx_pace_now());
    while (r == 0 && s->state != DX_SCIP_STOPPED && dx_pace_now() < due) {
        r = step(dev, s->deadline_ns, &err);
        r = r == DX_DRIVER_E_AGAIN ? 0 : r;
        while (feed(dev) == 0)
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
    int r;

    if (!dev->is_dark)
        hokuyo_stop(dev);
    dev->is_dark = true;
    r = dev->link->ops->read(dev->link, dev->in, sizeof(dev->in), &dev->in_len, READ_MS, err);
    dev->in_len = 0; /* what still comes is not wanted */
    return r ? r : DX_DRIVER_E_AGAIN;
}

static int hokuyo_read(struct dx_device *dev, struct dx_block *block, struct dx_err *err)
{
    uint64_t until = dx_pace_now() + (uint64_t)READ_MS * MS;
    struct dx_interlock_state interlock;
    int r = 0;

    if (dx_interlock_is_open(dev->interlock, &interlock))
        return wait_dark(dev, err);
    if (dev->is_dark)
        r = begin(dev, err);
    dev->is_dark = false;
    if (r)
        return r;
    while ((r = feed(dev)) == DX_DRIVER_E_AGAIN) {
        if (dx_pace_now() >= until)
            return r;
        r = check_serial(dev, err);
        if (r == 0)
            r = step(dev, until, err);
        if (r)
            return r;
    }
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
    dev->link->ops->wake(dev->link);
}

static uint64_t hokuyo_silence_ns(const struct dx_device *dev)
{
    const struct dx_scip_session *s = &dev->session;

    if (s->suspended) /* it has said so, and the session waits that long before it begins anew */
        return DX_SCIP_MAX_SUSPENSION + SILENCE_NS;
    if (s->state != DX_SCIP_STREAM || s->n_since_start == 0)
        return SILENCE_NS;
    return (uint64_t)(16 * dx_scip_period_ns(&s->params) * (s->request.skip + 1));
}

static void hokuyo_health(const struct dx_device *dev, struct dx_device_health *out)
{
    const struct dx_scip_session *s = &dev->session;

    *out = (struct dx_device_health){.n_lost = s->counts.n_lost, .n_damaged = s->counts.n_bad};
    snprintf(out->serial, sizeof(out->serial), "%s", s->identity.serial);
    snprintf(out->place, sizeof(out->place), "%s", dev->link->place);
    if (s->trouble[0] || s->stat[0])
        snprintf(out->trouble, sizeof(out->trouble), "%s", s->trouble[0] ? s->trouble : s->stat);
    else
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
        snprintf(text, len, "hokuyo: %s", dev->session.identity.serial);
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
