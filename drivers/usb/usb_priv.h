/* Inside drivers/usb: the open device, its transfers and their events. Owned by one thread. */
#ifndef DX_USB_PRIV_H
#define DX_USB_PRIV_H

#include "drivers/usb/usb_port.h"

#include <libusb-1.0/libusb.h>
#include <poll.h>

#define DX_USB_MAX_FDS     8
#define DX_USB_MAX_STREAMS 4
#define DX_USB_DRAIN_MS    300 /* for cancelled transfers to come back */

/* One transfer that is waited for: control, bulk OUT. */
struct dx_usb_call {
    struct libusb_transfer *transfer;
    uint8_t *bytes;
    bool flying;
};

struct dx_usb {
    libusb_context *context;
    libusb_device_handle *handle;
    struct dx_usb_about about;
    uint32_t claimed; /* bit n: interface n */
    int wake_fd;
    /* fds[0] is wake_fd; the others are libusb's, kept by its notifiers so that waiting need not
     * ask, which allocates. */
    struct pollfd fds[DX_USB_MAX_FDS];
    unsigned n_fds;
    bool too_many_fds;
    bool gone;
    bool heeds_wake; /* calls do, not waits alone */
    uint64_t n_came; /* pieces given to callbacks */
    struct dx_usb_call control, out;
    struct dx_usb_stream *streams[DX_USB_MAX_STREAMS];
};

/* Return value for a libusb error; for a transfer's status. */
int dx_usb_code(int libusb_error);
int dx_usb_status_code(enum libusb_transfer_status status);
const char *dx_usb_text(int code); /* "No such file or directory" */

/* Events of libusb: fds of the context into `usb`, and one round of waiting and callbacks: 0, AGAIN
 * when the time is over or (with `heed_wake`) somebody woke us, or negative. */
int dx_usb_watch(struct dx_usb *usb);
void dx_usb_unwatch(struct dx_usb *usb);
int dx_usb_pump(struct dx_usb *usb, int64_t until_ms, bool heed_wake);

/* Calls: memory once at open; false when a transfer did not come back and must be left to leak. */
int dx_usb_calls_init(struct dx_usb *usb);
bool dx_usb_calls_fini(struct dx_usb *usb);

/* 0, or why the first failed stream has failed. */
int dx_usb_stream_error(const struct dx_usb_stream *stream);
uint8_t dx_usb_stream_endpoint(const struct dx_usb_stream *stream);

#endif
