/*
 * A scanner on USB, past the kernel's tty: the bulk endpoints of its CDC-ACM data interface
 * (DEVICES 1.1). All models have the same numbers, and none has a serial number of USB.
 */
#include "drivers/hokuyo/scip_link.h"

#include "drivers/usb/usb_port.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CLASS_COMM  0x02
#define CLASS_DATA  0x0A
#define N_TRANSFERS 4
#define TRANSFER    2048 /* bytes: a multiple of a bulk packet's */
#define KEPT        ((size_t)64 << 10)
#define COMMAND_MS  200

static const struct dx_usb_id ids[] = {{DX_HOKUYO_USB_VENDOR, DX_HOKUYO_USB_PRODUCT}, {0, 0}};

struct usb_link {
    struct dx_scip_link link;
    struct dx_usb *usb;
    struct dx_usb_stream *stream;
    uint8_t out; /* endpoint */
    /* what the stream's callback has kept: [at, len) */
    uint8_t kept[KEPT];
    size_t at, len;
    int damage; /* -errno of a transfer that failed */
};

static struct usb_link *of(struct dx_scip_link *link)
{
    return (struct usb_link *)link;
}

/* A reader that is far behind loses what is newest: the session finds the next whole scan. */
static void came(void *ctx, const uint8_t *bytes, size_t len, int status)
{
    struct usb_link *l = ctx;

    if (status)
        l->damage = status;
    if (l->at > 0) {
        memmove(l->kept, l->kept + l->at, l->len - l->at);
        l->len -= l->at;
        l->at = 0;
    }
    len = len < KEPT - l->len ? len : KEPT - l->len;
    memcpy(l->kept + l->len, bytes, len);
    l->len += len;
}

static int usb_write(struct dx_scip_link *link, const uint8_t *bytes, size_t len,
                     struct dx_err *err)
{
    return dx_usb_write(of(link)->usb, of(link)->out, bytes, len, COMMAND_MS, err);
}

static int usb_read(struct dx_scip_link *link, uint8_t *bytes, size_t cap, size_t *len,
                    int timeout_ms, struct dx_err *err)
{
    struct usb_link *l = of(link);
    int r = l->at < l->len ? 0 : dx_usb_wait(l->usb, timeout_ms, err);

    if (r)
        return r;
    if (l->at == l->len)
        return DX_DRIVER_E_AGAIN;
    *len = l->len - l->at < cap ? l->len - l->at : cap;
    memcpy(bytes, l->kept + l->at, *len);
    l->at += *len;
    return 0;
}

static void usb_wake(struct dx_scip_link *link)
{
    dx_usb_wake(of(link)->usb);
}

static void usb_close(struct dx_scip_link *link)
{
    struct usb_link *l = of(link);

    dx_usb_stream_close(l->stream);
    dx_usb_close(l->usb);
    free(l);
}

static const struct dx_scip_link_ops usb_ops = {
    .write = usb_write, .read = usb_read, .wake = usb_wake, .close = usb_close};

/* 115200 8N1, DTR and RTS, as a terminal would ask. Scanners do not need them, and may refuse. */
static void set_line(struct usb_link *l, uint8_t interface)
{
    const struct dx_usb_setup coding = {0x21, 0x20, 0, interface};
    const struct dx_usb_setup lines = {0x21, 0x22, 0x0003, interface};
    uint8_t rate[7] = {0x00, 0xc2, 0x01, 0x00, 0, 0, 8};
    struct dx_err err;

    dx_usb_control(l->usb, &coding, rate, sizeof(rate), NULL, COMMAND_MS, &err);
    dx_usb_control(l->usb, &lines, NULL, 0, NULL, COMMAND_MS, &err);
}

static int set_up(struct usb_link *l, struct dx_err *err)
{
    struct dx_usb_stream_config stream = {
        .n_transfers = N_TRANSFERS, .n_packets = 1, .packet_len = TRANSFER, .came = came, .ctx = l};
    struct dx_usb_pair pair;
    uint8_t comm;
    int r = dx_usb_find_pair(l->usb, CLASS_DATA, &pair, err);

    if (r)
        return r;
    if (dx_usb_find_interface(l->usb, CLASS_COMM, &comm) == 0) {
        r = dx_usb_claim(l->usb, comm, 0, err);
        if (r)
            return r;
    } else {
        comm = pair.interface;
    }
    r = dx_usb_claim(l->usb, pair.interface, 0, err);
    if (r)
        return r;
    set_line(l, comm);
    l->out = pair.out;
    stream.endpoint = pair.in;
    return dx_usb_stream_open(&l->stream, l->usb, &stream, err);
}

int dx_scip_link_open_usb(struct dx_scip_link **out, const char *port, struct dx_err *err)
{
    const struct dx_usb_want want = {ids, NULL, port};
    struct usb_link *l = calloc(1, sizeof(*l));
    int r;

    if (!l)
        return dx_err_set(err, -ENOMEM, "hokuyo: no memory");
    l->link.ops = &usb_ops;
    r = dx_usb_open(&l->usb, &want, err);
    if (r == 0) {
        snprintf(l->link.place, sizeof(l->link.place), "usb %s", dx_usb_tell(l->usb)->port);
        snprintf(l->link.node, sizeof(l->link.node), "%s", dx_usb_tell(l->usb)->node);
        r = set_up(l, err);
    }
    if (r) {
        usb_close(&l->link);
        return r;
    }
    *out = &l->link;
    return 0;
}
