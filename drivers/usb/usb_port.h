/*
 * The drivers' common way to libusb: choose a device, open it, claim, control transfers, bulk and
 * isochronous streams. The only room that includes libusb. Each open device has a libusb context of
 * its own, and one thread: who opened it makes all calls (dx_usb_wake() is for any thread), and
 * callbacks run inside those calls. Presence comes from sd-device, not from here.
 *
 * Returns are those of drivers/driver.h: 0, DX_DRIVER_E_AGAIN, DX_DRIVER_E_GONE (the device is not
 * there, or not any more), or negative errno with text.
 */
#ifndef DX_USB_PORT_H
#define DX_USB_PORT_H

#include "core/base/err.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define DX_USB_CONTROL_MAX 1024 /* bytes of one control transfer */
#define DX_USB_OUT_MAX     4096 /* bytes of one bulk OUT transfer; dx_usb_write() takes more */

struct dx_usb;
struct dx_usb_stream;

struct dx_usb_id {
    uint16_t vid, pid;
};

/* Is it the name of a port, "1-2.3": the bus, then the ports on the way? */
bool dx_usb_is_port(const char *text);

struct dx_usb_want {
    const struct dx_usb_id *ids; /* ends with vid 0 */
    const char *serial;          /* NULL or "": any */
    const char *port;            /* "1-2.3", as the kernel names it; NULL or "": any */
};

/* What is known of an attached device. Texts are "" where it has none. */
struct dx_usb_about {
    struct dx_usb_id id;
    uint16_t release; /* bcdDevice */
    char port[32];    /* "1-2.3": bus, then the ports; the same as long as the plug stays */
    char node[32];    /* "/dev/bus/usb/001/002" */
    char serial[64];  /* printable ASCII; needs access, as `product` */
    char product[64];
    int access; /* 0, or why it cannot be opened: -EACCES, ... */
};

/* Calls `found` for each attached device of `ids`. Any thread. A machine without USB has none. */
int dx_usb_list(const struct dx_usb_id *ids,
                void (*found)(void *ctx, const struct dx_usb_about *about), void *ctx,
                struct dx_err *err);

/* Opens the first device that is wanted. GONE: none is there (the text
 * says what was looked for); -EACCES: there, but not for us (the text names node and rule). */
int dx_usb_open(struct dx_usb **out, const struct dx_usb_want *want, struct dx_err *err);
/* Cancels what flies, waits for it (bounded), releases all. NULL is fine. */
void dx_usb_close(struct dx_usb *usb);
const struct dx_usb_about *dx_usb_tell(const struct dx_usb *usb);

/* Takes an interface from the kernel's driver (which gets it back at close) and sets its alternate
 * setting when that is not 0. -EBUSY: another program has it. */
int dx_usb_claim(struct dx_usb *usb, uint8_t interface, uint8_t alt, struct dx_err *err);

/* Where bulk bytes go: the first interface of a class that has a bulk IN and a bulk OUT endpoint
 * in its alternate setting 0. */
struct dx_usb_pair {
    uint8_t interface;
    uint8_t in, out; /* endpoint addresses */
    uint16_t in_packet_len;
};
/* -ENOENT: the device has none. */
int dx_usb_find_pair(const struct dx_usb *usb, uint8_t interface_class, struct dx_usb_pair *out,
                     struct dx_err *err);
/* The first interface of a class; -ENOENT without text: none. */
int dx_usb_find_interface(const struct dx_usb *usb, uint8_t interface_class, uint8_t *out);

/* Bytes of an isochronous endpoint's packet for the claimed setting, or `otherwise`. */
size_t dx_usb_iso_packet_len(const struct dx_usb *usb, uint8_t endpoint, size_t otherwise);

struct dx_usb_setup {
    uint8_t request_type, request; /* bmRequestType (0x80: IN), bRequest */
    uint16_t value, index;
};
/* `got` may be NULL. -EPIPE: refused (stall); -ETIMEDOUT. */
int dx_usb_control(struct dx_usb *usb, const struct dx_usb_setup *setup, void *bytes, size_t len,
                   size_t *got, int timeout_ms, struct dx_err *err);
/* Sends all bytes to a bulk OUT endpoint. */
int dx_usb_write(struct dx_usb *usb, uint8_t endpoint, const void *bytes, size_t len,
                 int timeout_ms, struct dx_err *err);

/* Whether control requests and writes end with AGAIN when dx_usb_wake() comes, as waits do. At
 * first they do not: a stop must get through. */
void dx_usb_heed_wake(struct dx_usb *usb, bool on);

/* What an IN stream calls for each piece that came: a bulk transfer's bytes, or one isochronous
 * packet (status 0, else it is damaged: -EIO, -EOVERFLOW ...; empty ones are left out). May not
 * call anything of this room. */
typedef void dx_usb_came_fn(void *ctx, const uint8_t *bytes, size_t len, int status);

struct dx_usb_stream_config {
    uint8_t endpoint;
    bool isochronous;
    unsigned n_transfers;
    unsigned n_packets; /* of an isochronous transfer; bulk: 1 */
    size_t packet_len;  /* bulk: bytes of a transfer, a multiple of the endpoint's packets */
    dx_usb_came_fn *came;
    void *ctx;
};
/* Allocates all, and queues the transfers; after this nothing is allocated. */
int dx_usb_stream_open(struct dx_usb_stream **out, struct dx_usb *usb,
                       const struct dx_usb_stream_config *config, struct dx_err *err);
/* Cancels the transfers and waits for them; at most 0.3 s. NULL is fine. */
void dx_usb_stream_close(struct dx_usb_stream *stream);

/* Waits until something new came of any stream and has been given to its callback: 0. (What came
 * during another call was given then; look at what the callback has kept before waiting.) AGAIN:
 * the time ran out, or dx_usb_wake(). Negative: a stream has failed for good; open the device anew.
 */
int dx_usb_wait(struct dx_usb *usb, int timeout_ms, struct dx_err *err);
/* Ends a dx_usb_wait(), now or the next one. Any thread. */
void dx_usb_wake(struct dx_usb *usb);

#endif
