/*
 * The Kinect driver: the camera over USB, frames put together as their packets come, in blocks that
 * read() hands over where they lie. Owned by the reader's thread; wake() from any.
 */
#include "drivers/kinect/kinect.h"

#include "drivers/kinect/kinect_clock.h"
#include "drivers/kinect/kinect_decode.h"
#include "drivers/kinect/kinect_link.h"
#include "drivers/monotonic.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* One is being filled, one is with the reader, the others wait: more frames than can come at once
 * from what is queued with the kernel (256 packets). */
#define N_BLOCKS      4
#define N_TRANSFERS   16
#define N_PACKETS     16
#define PACKET_LEN    1920 /* where the descriptors do not tell */
#define SILENCE_NS    UINT64_C(200000000)
#define STOP_NS       UINT64_C(300000000) /* whatever the camera answers, or not */
#define ROUND_MS      100
#define LOSS_PACKETS  2420 /* over which their loss is measured: ten frames */
#define DOUBTFUL_LOSS 0.02

struct dx_device {
    struct dx_kinect_config config;
    struct dx_kinect_decoder decoder;

    /* The device half; none in a decoder. */
    struct dx_kinect_link link; /* its usb NULL: not open */
    struct dx_usb_stream *stream;
    struct dx_kinect_header header; /* what is the same in all blocks, and the newest counts */
    struct dx_kinect_assembler assembler;
    struct dx_kinect_clock clock;
    uint64_t n_blocks;       /* handed over in this stay */
    uint64_t n_missed;       /* frames that nobody read in time */
    double loss;             /* share of the packets that was lost of late */
    uint64_t n_came, n_lost; /* packets, when it was measured */
    char source[64];
    /* A ring: [tail, head) wait, head is being filled, tail - 1 may be with the reader. */
    unsigned head, tail;
    struct dx_stamp stamps[N_BLOCKS];
    uint8_t *blocks[N_BLOCKS];
};

static const struct dx_usb_id ids[] = {
    {DX_KINECT_VID, DX_KINECT_PID_XBOX}, {DX_KINECT_VID, DX_KINECT_PID_WINDOWS}, {0, 0}};

/* ---- frames to blocks ------------------------------------------------------------------------ */

static uint8_t *frame_of(const struct dx_device *dev, unsigned n)
{
    return dev->blocks[n % N_BLOCKS] + DX_KINECT_HEADER_LEN;
}

/* Inside read(), from the stream's callback. */
static uint8_t *take_frame(void *ctx, const struct dx_kinect_frame *frame)
{
    struct dx_device *dev = ctx;
    struct dx_kinect_header *h = &dev->header;
    uint64_t now = dx_clock_ns();

    h->ticks = frame->ticks;
    h->n_lost = frame->n_lost;
    h->n_frames_lost = (uint32_t)(dev->assembler.counts.n_frames_lost + dev->n_missed);
    h->n_frames_damaged = (uint32_t)dev->assembler.counts.n_frames_damaged;
    memcpy(h->lost, frame->lost, sizeof(h->lost));
    dx_kinect_header_put(dev->blocks[dev->head % N_BLOCKS], h);
    dev->stamps[dev->head % N_BLOCKS] =
        (struct dx_stamp){now, dx_kinect_clock_ns(&dev->clock, frame->ticks, now), DX_CLOCK_DEVICE};
    /* The reader's block is not touched: with no other free, the newest frame makes way. */
    if (dev->head - dev->tail == N_BLOCKS - 2)
        dev->n_missed++;
    else
        dev->head++;
    return frame_of(dev, dev->head);
}

/* Also of packets whose frames were given up. */
static void measure_loss(struct dx_device *dev)
{
    const struct dx_kinect_counts *n = &dev->assembler.counts;
    double came = (double)(n->n_packets - dev->n_came), lost = (double)(n->n_lost - dev->n_lost);

    if (came + lost < LOSS_PACKETS)
        return;
    dev->loss = lost / (came + lost);
    dev->n_came = n->n_packets;
    dev->n_lost = n->n_lost;
}

static void take_packet(void *ctx, const uint8_t *bytes, size_t len, int status)
{
    struct dx_device *dev = ctx;

    if (status == 0) /* a damaged one is as good as lost */
        dx_kinect_assembler_feed(&dev->assembler, bytes, len);
    measure_loss(dev);
}

/* ---- the device half ------------------------------------------------------------------------- */

static void kinect_close(struct dx_device *dev)
{
    if (!dev)
        return;
    dx_usb_close(dev->link.usb);
    dx_kinect_decoder_fini(&dev->decoder);
    for (unsigned k = 0; k < N_BLOCKS; k++)
        free(dev->blocks[k]);
    free(dev);
}

static int kinect_open_decoder(struct dx_device **out, const void *config, struct dx_err *err)
{
    const struct dx_kinect_config *c = config;
    struct dx_device *dev = calloc(1, sizeof(*dev));

    if (!dev)
        return dx_err_set(err, -ENOMEM, "kinect: out of memory");
    dev->config = *c;
    dx_kinect_decoder_init(&dev->decoder, c);
    *out = dev;
    return 0;
}

static int alloc_blocks(struct dx_device *dev, struct dx_err *err)
{
    for (unsigned k = 0; k < N_BLOCKS; k++) {
        dev->blocks[k] = calloc(1, DX_KINECT_HEADER_LEN + dx_kinect_frame_len(dev->config.bits));
        if (!dev->blocks[k])
            return dx_err_set(err, -ENOMEM, "kinect: out of memory");
    }
    return 0;
}

/* All that is known before it is asked. */
static int get_ready(struct dx_device *dev, struct dx_err *err)
{
    const struct dx_kinect_config *c = &dev->config;
    const struct dx_usb_about *about = dx_usb_tell(dev->link.usb);
    bool windows = about->id.pid == DX_KINECT_PID_WINDOWS;
    int r;

    snprintf(dev->source, sizeof(dev->source), "usb:%s", about->port);
    if (c->near && !windows)
        return dx_err_set(err, -ENOTSUP,
                          "Kinect at port %s: near mode is there on Kinect for Windows alone",
                          about->port);
    /* The second model streams in its other alternate setting. */
    r = dx_usb_claim(dev->link.usb, 0, windows, err);
    if (r)
        return r;
    dev->header.bits = c->bits;
    dev->header.windows = windows;
    dev->header.near = c->near;
    return 0;
}

static int kinect_open(struct dx_device **out, const void *config, struct dx_err *err)
{
    const struct dx_kinect_config *c = config;
    struct dx_device *dev = NULL;
    int r = kinect_open_decoder(&dev, config, err);

    if (r)
        return r;
    r = dx_usb_open(&dev->link.usb, &(struct dx_usb_want){ids, c->serial, c->port}, err);
    if (r == DX_DRIVER_E_GONE)
        dx_err_prefix(err, "Kinect (without its 12 V supply only its hub shows)");
    r = r ? r : get_ready(dev, err);
    r = r ? r : alloc_blocks(dev, err);
    if (r) {
        kinect_close(dev);
        return r;
    }
    *out = dev;
    return 0;
}

/* A camera that does not answer is asked for a second, unless somebody wants the thread back: then
 * it is asked anew. */
static int kinect_connect(struct dx_device *dev, struct dx_err *err)
{
    int r;

    dx_usb_heed_wake(dev->link.usb, true);
    r = dx_kinect_link_constants(&dev->link, &dev->header.constants, err);
    dx_usb_heed_wake(dev->link.usb, false);
    return r;
}

static void kinect_stop(struct dx_device *dev)
{
    if (!dev->stream)
        return;
    dev->link.due_ns = dx_clock_ns() + STOP_NS;
    if (dev->config.near) /* it would stay so for the next program */
        dx_kinect_link_near(&dev->link, false, NULL);
    dx_kinect_link_stop(&dev->link, NULL); /* while packets still have somewhere to go */
    dev->link.due_ns = 0;
    dx_usb_stream_close(dev->stream);
    dev->stream = NULL;
}

static int kinect_start(struct dx_device *dev, struct dx_err *err)
{
    struct dx_usb_stream_config s = {
        .endpoint = DX_KINECT_ENDPOINT,
        .isochronous = true,
        .n_transfers = N_TRANSFERS,
        .n_packets = N_PACKETS,
        .packet_len = dx_usb_iso_packet_len(dev->link.usb, DX_KINECT_ENDPOINT, PACKET_LEN),
        .came = take_packet,
        .ctx = dev,
    };
    int r;

    dev->head = dev->tail = 0;
    dev->n_blocks = dev->n_missed = 0;
    dev->n_came = dev->n_lost = 0;
    dev->loss = 0;
    dx_kinect_assembler_init(&dev->assembler, dev->config.bits, frame_of(dev, 0), take_frame, dev);
    dx_kinect_clock_init(&dev->clock, dev->config.tick_hz);
    r = dx_usb_stream_open(&dev->stream, dev->link.usb, &s, err);
    r = r ? r : dx_kinect_link_start(&dev->link, dev->config.bits, err);
    r = r || !dev->config.near ? r : dx_kinect_link_near(&dev->link, true, err);
    if (r)
        kinect_stop(dev);
    return r;
}

static int kinect_read(struct dx_device *dev, struct dx_block *block, struct dx_err *err)
{
    uint64_t until_ns = dx_clock_ns() + UINT64_C(1000000) * ROUND_MS;

    while (dev->head == dev->tail) {
        uint64_t now = dx_clock_ns();
        int r = now < until_ns ? dx_usb_wait(dev->link.usb, (int)((until_ns - now) / 1000000), err)
                               : DX_DRIVER_E_AGAIN;

        if (r)
            return r;
    }
    *block = (struct dx_block){
        .bytes = dev->blocks[dev->tail % N_BLOCKS],
        .len = DX_KINECT_HEADER_LEN + dx_kinect_frame_len(dev->config.bits),
        .stamp = dev->stamps[dev->tail % N_BLOCKS],
        .number = dev->n_blocks,
        .first = dev->n_blocks == 0,
        .source = dev->source,
    };
    dev->n_blocks++;
    dev->tail++;
    return 0;
}

static void kinect_wake(struct dx_device *dev)
{
    dx_usb_wake(dev->link.usb);
}

/* ---- what it says of itself ------------------------------------------------------------------ */

static int kinect_decode(struct dx_device *dev, const struct dx_block *block,
                         const struct dx_frame_sink *sink, struct dx_err *err)
{
    return dx_kinect_decode(&dev->decoder, block, sink, err);
}

static uint64_t kinect_silence_ns(const struct dx_device *dev)
{
    (void)dev;
    return SILENCE_NS;
}

static void kinect_health(const struct dx_device *dev, struct dx_device_health *out)
{
    const struct dx_usb_about *about = dx_usb_tell(dev->link.usb);
    const struct dx_kinect_counts *n = &dev->assembler.counts;

    *out = (struct dx_device_health){
        .n_lost = n->n_frames_lost + dev->n_missed,
        .n_damaged = n->n_frames_damaged,
    };
    snprintf(out->serial, sizeof(out->serial), "%s", about->serial);
    snprintf(out->place, sizeof(out->place), "%s", about->port);
    if (dev->loss > DOUBTFUL_LOSS)
        snprintf(out->trouble, sizeof(out->trouble), "%.1f %% of the USB packets are lost",
                 dev->loss * 100);
}

static void kinect_describe(struct dx_device *dev, char *text, size_t len)
{
    const struct dx_kinect_constants *c = &dev->decoder.constants;

    if (!dev->decoder.geometry)
        snprintf(text, len, "Kinect, 640x480 depths of %d bits", dev->config.bits);
    else
        snprintf(text, len,
                 "Kinect, pinhole 480x640 of %d bits, shift %u, projector at %.3f cm, reference "
                 "%.2f mm of %.4f mm a pixel",
                 dev->decoder.bits, c->shift, (double)c->emitter_cm, (double)c->reference_mm,
                 (double)c->pixel_mm);
}

struct found_at {
    void (*found)(void *ctx, const struct dx_device_found *device);
    void *ctx;
};

/* Printable characters as they stand in YAML between double quotes; room for twice as many. */
static const char *escaped(char *out, const char *text)
{
    char *at = out;

    for (; *text; *at++ = *text++)
        if (*text == '"' || *text == '\\')
            *at++ = '\\';
    *at = '\0';
    return out;
}

static void tell_found(void *ctx, const struct dx_usb_about *about)
{
    const struct found_at *f = ctx;
    char yaml[160], serial[2 * sizeof(about->serial)];

    if (about->serial[0])
        snprintf(yaml, sizeof(yaml), "serial: \"%s\"\n", escaped(serial, about->serial));
    else
        snprintf(yaml, sizeof(yaml), "port: \"%s\"\n", about->port);
    f->found(f->ctx,
             &(struct dx_device_found){
                 .name = about->id.pid == DX_KINECT_PID_WINDOWS ? "Kinect for Windows v1, depth"
                                                                : "Kinect for Xbox 360, depth",
                 .node = about->node,
                 .serial = about->serial,
                 .place = about->port,
                 .yaml = yaml,
                 .access = about->access,
             });
}

static int kinect_probe(void (*found)(void *ctx, const struct dx_device_found *device), void *ctx,
                        struct dx_err *err)
{
    return dx_usb_list(ids, tell_found, &(struct found_at){found, ctx}, err);
}

static const char *const subsystems[] = {"usb", NULL};

const struct dx_driver dx_kinect_driver = {
    .name = "kinect",
    .subsystems = subsystems,
    .open = kinect_open,
    .open_decoder = kinect_open_decoder,
    .connect = kinect_connect,
    .start = kinect_start,
    .read = kinect_read,
    .decode = kinect_decode,
    .stop = kinect_stop,
    .close = kinect_close,
    .wake = kinect_wake,
    .silence_ns = kinect_silence_ns,
    .health = kinect_health,
    .probe = kinect_probe,
    .describe = kinect_describe,
};
