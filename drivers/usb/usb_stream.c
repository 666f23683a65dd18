/*
 * Streams from an IN endpoint: a number of transfers is always queued, each is given to the
 * callback and queued again. The device's thread.
 */
#include "drivers/usb/usb_priv.h"

#include "drivers/driver.h"
#include "drivers/monotonic.h"

#include <errno.h>
#include <stdlib.h>

/* Transfers in a row that may fail before the stream counts as dead, for each one queued: an unplug
 * shows as errors before the kernel tells it, and noise on the cable goes by. */
#define ROUNDS_OF_ERRORS 3

struct dx_usb_stream {
    struct dx_usb *usb;
    struct dx_usb_stream_config config;
    struct libusb_transfer **transfers;
    uint8_t *bytes; /* of all transfers */
    unsigned n_flying;
    unsigned n_errors; /* in a row */
    bool closing;
    int error; /* it has failed for good */
};

/* Each packet of an isochronous transfer has a status of its own. */
static void give_packets(struct dx_usb_stream *s, const struct libusb_transfer *transfer)
{
    const uint8_t *at = transfer->buffer;

    for (int k = 0; k < transfer->num_iso_packets; k++) {
        const struct libusb_iso_packet_descriptor *p = &transfer->iso_packet_desc[k];
        int status = dx_usb_status_code(p->status);

        if (status == DX_DRIVER_E_GONE)
            s->usb->gone = true;
        else if (p->actual_length > 0 || status)
            s->config.came(s->config.ctx, at, p->actual_length, status);
        at += p->length;
    }
}

static void give(struct dx_usb_stream *s, const struct libusb_transfer *transfer)
{
    s->n_errors = 0;
    s->usb->n_came++;
    if (s->config.isochronous)
        give_packets(s, transfer);
    else if (transfer->actual_length > 0)
        s->config.came(s->config.ctx, transfer->buffer, (size_t)transfer->actual_length, 0);
}

static void fail(struct dx_usb_stream *s, int code)
{
    if (code == DX_DRIVER_E_GONE)
        s->usb->gone = true;
    else if (s->error == 0)
        s->error = code;
}

static void came_back(struct libusb_transfer *transfer)
{
    struct dx_usb_stream *s = transfer->user_data;
    int status = dx_usb_status_code(transfer->status);

    s->n_flying--;
    if (s->closing)
        return;
    if (status == 0)
        give(s, transfer);
    else if (status == DX_DRIVER_E_GONE || status == -EPIPE ||
             ++s->n_errors >= ROUNDS_OF_ERRORS * s->config.n_transfers)
        fail(s, status);
    if (s->usb->gone || s->error)
        return;
    status = libusb_submit_transfer(transfer);
    if (status)
        fail(s, dx_usb_code(status));
    else
        s->n_flying++;
}

static int alloc(struct dx_usb_stream *s)
{
    const struct dx_usb_stream_config *c = &s->config;
    size_t transfer_len = c->n_packets * c->packet_len;
    int n_packets = c->isochronous ? (int)c->n_packets : 0;

    s->transfers = calloc(c->n_transfers, sizeof(struct libusb_transfer *));
    s->bytes = calloc(c->n_transfers, transfer_len);
    if (!s->transfers || !s->bytes)
        return -ENOMEM;
    for (unsigned k = 0; k < c->n_transfers; k++) {
        uint8_t *at = s->bytes + k * transfer_len;
        struct libusb_transfer *t = libusb_alloc_transfer(n_packets);

        s->transfers[k] = t;
        if (!t)
            return -ENOMEM;
        if (c->isochronous) {
            libusb_fill_iso_transfer(t, s->usb->handle, c->endpoint, at, (int)transfer_len,
                                     n_packets, came_back, s, 0);
            libusb_set_iso_packet_lengths(t, (unsigned)c->packet_len);
        } else
            libusb_fill_bulk_transfer(t, s->usb->handle, c->endpoint, at, (int)transfer_len,
                                      came_back, s, 0);
    }
    return 0;
}

/* False: some did not come back. */
static bool drain(struct dx_usb_stream *s)
{
    int64_t until_ms = dx_clock_ms() + DX_USB_DRAIN_MS;

    s->closing = true;
    /* Those that have come back answer NOT_FOUND. */
    for (unsigned k = 0; s->n_flying && k < s->config.n_transfers; k++)
        if (s->transfers[k])
            libusb_cancel_transfer(s->transfers[k]);
    while (s->n_flying && dx_clock_ms() <= until_ms)
        if (dx_usb_pump(s->usb, until_ms, false) < 0)
            break;
    return s->n_flying == 0;
}

void dx_usb_stream_close(struct dx_usb_stream *s)
{
    if (!s)
        return;
    for (unsigned k = 0; k < DX_USB_MAX_STREAMS; k++)
        if (s->usb->streams[k] == s)
            s->usb->streams[k] = NULL;
    if (!drain(s))
        return; /* lost to the kernel: a leak is better than memory that it still writes to */
    for (unsigned k = 0; s->transfers && k < s->config.n_transfers; k++)
        libusb_free_transfer(s->transfers[k]);
    free(s->transfers);
    free(s->bytes);
    free(s);
}

static int submit_all(struct dx_usb_stream *s)
{
    for (unsigned k = 0; k < s->config.n_transfers; k++) {
        int r = libusb_submit_transfer(s->transfers[k]);

        if (r)
            return dx_usb_code(r);
        s->n_flying++;
    }
    return 0;
}

int dx_usb_stream_open(struct dx_usb_stream **out, struct dx_usb *usb,
                       const struct dx_usb_stream_config *config, struct dx_err *err)
{
    struct dx_usb_stream *s = calloc(1, sizeof(*s));
    unsigned slot = 0;
    int r = s ? 0 : -ENOMEM;

    while (slot < DX_USB_MAX_STREAMS && usb->streams[slot])
        slot++;
    if (r == 0 && (slot == DX_USB_MAX_STREAMS || config->n_transfers - 1 > 63 ||
                   config->n_packets - 1 > 127 || config->packet_len - 1 > 65535))
        r = -EINVAL;
    if (r == 0) {
        s->usb = usb;
        s->config = *config;
        r = alloc(s);
        r = r ? r : submit_all(s);
        if (r == 0) {
            usb->streams[slot] = s;
            *out = s;
            return 0;
        }
        dx_usb_stream_close(s);
    } else
        free(s);
    return dx_err_set(err, r,
                      "USB device at port %s: cannot queue transfers of endpoint 0x%02x: %s",
                      usb->about.port, config->endpoint, dx_usb_text(r));
}

int dx_usb_stream_error(const struct dx_usb_stream *stream)
{
    return stream->error;
}

uint8_t dx_usb_stream_endpoint(const struct dx_usb_stream *stream)
{
    return stream->config.endpoint;
}
