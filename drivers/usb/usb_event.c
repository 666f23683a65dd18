/*
 * Events of an open device: waiting in one poll() for libusb's descriptors and the wake eventfd,
 * then callbacks; and transfers that are waited for. Transfers carry no timeouts of libusb: the
 * deadlines are ours, so that poll() knows them all. The device's thread, save dx_usb_wake().
 */
#include "drivers/usb/usb_priv.h"

#include "drivers/driver.h"
#include "drivers/monotonic.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

int dx_usb_code(int libusb_error)
{
    switch (libusb_error) {
    case LIBUSB_SUCCESS:
        return 0;
    case LIBUSB_ERROR_NO_DEVICE:
        return DX_DRIVER_E_GONE;
    case LIBUSB_ERROR_ACCESS:
        return -EACCES;
    case LIBUSB_ERROR_NOT_FOUND:
        return -ENOENT;
    case LIBUSB_ERROR_BUSY:
        return -EBUSY;
    case LIBUSB_ERROR_TIMEOUT:
        return -ETIMEDOUT;
    case LIBUSB_ERROR_PIPE:
        return -EPIPE;
    case LIBUSB_ERROR_NO_MEM:
        return -ENOMEM;
    default:
        return -EIO;
    }
}

int dx_usb_status_code(enum libusb_transfer_status status)
{
    switch (status) {
    case LIBUSB_TRANSFER_COMPLETED:
        return 0;
    case LIBUSB_TRANSFER_NO_DEVICE:
        return DX_DRIVER_E_GONE;
    case LIBUSB_TRANSFER_STALL:
        return -EPIPE;
    case LIBUSB_TRANSFER_OVERFLOW:
        return -EOVERFLOW;
    case LIBUSB_TRANSFER_TIMED_OUT:
        return -ETIMEDOUT;
    case LIBUSB_TRANSFER_CANCELLED:
        return -ECANCELED;
    default:
        return -EIO;
    }
}

const char *dx_usb_text(int code)
{
    if (code == DX_DRIVER_E_GONE)
        return "it was removed";
    if (code == DX_DRIVER_E_AGAIN)
        return "woken";
    return code == -EPIPE ? "refused (stall)" : strerror(-code);
}

static void fd_added(int fd, short events, void *ctx)
{
    struct dx_usb *usb = ctx;

    if (usb->n_fds == DX_USB_MAX_FDS) {
        usb->too_many_fds = true;
        return;
    }
    usb->fds[usb->n_fds++] = (struct pollfd){.fd = fd, .events = events};
}

static void fd_removed(int fd, void *ctx)
{
    struct dx_usb *usb = ctx;

    for (unsigned k = 1; k < usb->n_fds; k++)
        if (usb->fds[k].fd == fd)
            usb->fds[k--] = usb->fds[--usb->n_fds];
}

int dx_usb_watch(struct dx_usb *usb)
{
    const struct libusb_pollfd **fds = libusb_get_pollfds(usb->context);

    if (!fds)
        return -ENOMEM;
    usb->n_fds = 0;
    fd_added(usb->wake_fd, POLLIN, usb);
    for (const struct libusb_pollfd **f = fds; *f; f++)
        fd_added((*f)->fd, (*f)->events, usb);
    libusb_free_pollfds(fds);
    libusb_set_pollfd_notifiers(usb->context, fd_added, fd_removed, usb);
    return usb->too_many_fds ? -EMFILE : 0;
}

void dx_usb_unwatch(struct dx_usb *usb)
{
    if (usb->context)
        libusb_set_pollfd_notifiers(usb->context, NULL, NULL, NULL);
}

/* 0 after callbacks may have run, AGAIN when the time is over or (heed_wake) somebody woke us. */
int dx_usb_pump(struct dx_usb *usb, int64_t until_ms, bool heed_wake)
{
    unsigned first = heed_wake ? 0 : 1;
    int64_t left = until_ms - dx_clock_ms();
    struct timeval at_once = {0, 0};
    uint64_t count;
    int r = poll(usb->fds + first, usb->n_fds - first,
                 left < 0       ? 0
                 : left > 60000 ? 60000
                                : (int)left);

    if (r < 0)
        return errno == EINTR ? DX_DRIVER_E_AGAIN : -errno;
    if (r == 0)
        return DX_DRIVER_E_AGAIN;
    if (heed_wake && usb->fds[0].revents) {
        /* Callbacks first another time: who wakes us wants the thread back. */
        if (read(usb->wake_fd, &count, sizeof(count)) > 0)
            return DX_DRIVER_E_AGAIN;
    }
    r = libusb_handle_events_timeout_completed(usb->context, &at_once, NULL);
    usb->gone |= r == LIBUSB_ERROR_NO_DEVICE;
    if (r && r != LIBUSB_ERROR_INTERRUPTED && r != LIBUSB_ERROR_NO_DEVICE)
        return dx_usb_code(r);
    return usb->too_many_fds ? -EMFILE : 0;
}

int dx_usb_wait(struct dx_usb *usb, int timeout_ms, struct dx_err *err)
{
    int64_t until_ms = dx_clock_ms() + timeout_ms;
    uint64_t before = usb->n_came;
    int r = 0;

    while (r == 0 && usb->n_came == before) {
        for (unsigned k = 0; k < DX_USB_MAX_STREAMS; k++) {
            const struct dx_usb_stream *s = usb->streams[k];

            if (!usb->gone && s && dx_usb_stream_error(s))
                return dx_err_set(err, dx_usb_stream_error(s),
                                  "USB device at port %s: endpoint 0x%02x: %s", usb->about.port,
                                  dx_usb_stream_endpoint(s), dx_usb_text(dx_usb_stream_error(s)));
        }
        if (usb->gone)
            return dx_err_set(err, DX_DRIVER_E_GONE, "USB device at port %s: %s", usb->about.port,
                              dx_usb_text(DX_DRIVER_E_GONE));
        if (dx_clock_ms() > until_ms)
            return DX_DRIVER_E_AGAIN;
        r = dx_usb_pump(usb, until_ms, true);
    }
    if (r < 0)
        dx_err_set(err, r, "USB device at port %s: %s", usb->about.port, strerror(-r));
    return r;
}

void dx_usb_wake(struct dx_usb *usb)
{
    uint64_t one = 1;
    ssize_t n = write(usb->wake_fd, &one, sizeof(one));

    (void)n; /* a full counter wakes as well */
}

/* ---- transfers that are waited for ----------------------------------------------------------- */

static void call_done(struct libusb_transfer *transfer)
{
    struct dx_usb_call *call = transfer->user_data;

    call->flying = false;
}

static int call_init(struct dx_usb_call *call, size_t len)
{
    call->transfer = libusb_alloc_transfer(0);
    call->bytes = malloc(len);
    return call->transfer && call->bytes ? 0 : -ENOMEM;
}

/* Waits for a cancelled transfer. */
static void call_cancel(struct dx_usb *usb, struct dx_usb_call *call)
{
    int64_t until_ms = dx_clock_ms() + DX_USB_DRAIN_MS;

    if (call->flying)
        libusb_cancel_transfer(call->transfer);
    while (call->flying && dx_clock_ms() <= until_ms)
        if (dx_usb_pump(usb, until_ms, false) < 0)
            break;
}

static bool call_fini(struct dx_usb *usb, struct dx_usb_call *call)
{
    call_cancel(usb, call);
    if (call->flying) /* the kernel may still write to it */
        return false;
    libusb_free_transfer(call->transfer);
    free(call->bytes);
    return true;
}

int dx_usb_calls_init(struct dx_usb *usb)
{
    int r = call_init(&usb->control, LIBUSB_CONTROL_SETUP_SIZE + DX_USB_CONTROL_MAX);

    return r ? r : call_init(&usb->out, DX_USB_OUT_MAX);
}

bool dx_usb_calls_fini(struct dx_usb *usb)
{
    bool control = call_fini(usb, &usb->control), out = call_fini(usb, &usb->out);

    return control && out;
}

void dx_usb_heed_wake(struct dx_usb *usb, bool on)
{
    usb->heeds_wake = on;
}

/* Submits a filled transfer, and waits for it. */
static int call(struct dx_usb *usb, struct dx_usb_call *call, int timeout_ms)
{
    int64_t until_ms = dx_clock_ms() + timeout_ms;
    bool woken = false;
    int r = 0;

    if (usb->gone)
        return DX_DRIVER_E_GONE;
    r = libusb_submit_transfer(call->transfer);
    if (r) {
        usb->gone |= r == LIBUSB_ERROR_NO_DEVICE;
        return dx_usb_code(r);
    }
    call->flying = true;
    while (call->flying && !woken && r >= 0 && dx_clock_ms() <= until_ms) {
        r = dx_usb_pump(usb, until_ms, usb->heeds_wake);
        woken = usb->heeds_wake && r == DX_DRIVER_E_AGAIN && dx_clock_ms() < until_ms;
    }
    call_cancel(usb, call);
    if (call->flying)
        return -EIO;
    if (woken)
        return DX_DRIVER_E_AGAIN;
    r = dx_usb_status_code(call->transfer->status);
    usb->gone |= r == DX_DRIVER_E_GONE;
    return r == -ECANCELED ? -ETIMEDOUT : r;
}

static int tell(struct dx_usb *usb, int r, const char *what, unsigned which, struct dx_err *err)
{
    return dx_err_set(err, r, "USB device at port %s: %s 0x%02x: %s", usb->about.port, what, which,
                      dx_usb_text(r));
}

int dx_usb_control(struct dx_usb *usb, const struct dx_usb_setup *setup, void *bytes, size_t len,
                   size_t *got, int timeout_ms, struct dx_err *err)
{
    struct dx_usb_call *c = &usb->control;
    bool in = setup->request_type & LIBUSB_ENDPOINT_IN;
    size_t n;
    int r;

    if (len > DX_USB_CONTROL_MAX || c->flying)
        return tell(usb, c->flying ? -EIO : -EINVAL, "control request", setup->request, err);
    libusb_fill_control_setup(c->bytes, setup->request_type, setup->request, setup->value,
                              setup->index, (uint16_t)len);
    if (!in && len)
        memcpy(c->bytes + LIBUSB_CONTROL_SETUP_SIZE, bytes, len);
    libusb_fill_control_transfer(c->transfer, usb->handle, c->bytes, call_done, c, 0);
    r = call(usb, c, timeout_ms);
    if (r)
        return tell(usb, r, "control request", setup->request, err);
    n = c->transfer->actual_length > 0 ? (size_t)c->transfer->actual_length : 0;
    n = n < len ? n : len;
    if (in && n)
        memcpy(bytes, c->bytes + LIBUSB_CONTROL_SETUP_SIZE, n);
    if (got)
        *got = n;
    return 0;
}

int dx_usb_write(struct dx_usb *usb, uint8_t endpoint, const void *bytes, size_t len,
                 int timeout_ms, struct dx_err *err)
{
    int64_t until_ms = dx_clock_ms() + timeout_ms;
    struct dx_usb_call *c = &usb->out;
    const uint8_t *at = bytes;

    while (len > 0) {
        size_t n = len < DX_USB_OUT_MAX ? len : DX_USB_OUT_MAX;
        int64_t left = until_ms - dx_clock_ms();
        int r = -EIO;

        if (!c->flying) {
            memcpy(c->bytes, at, n);
            libusb_fill_bulk_transfer(c->transfer, usb->handle, endpoint, c->bytes, (int)n,
                                      call_done, c, 0);
            r = call(usb, c, left > 0 ? (int)left : 0);
        }
        if (r == 0 && c->transfer->actual_length <= 0)
            r = -EIO;
        if (r)
            return tell(usb, r, "endpoint", endpoint, err);
        at += c->transfer->actual_length;
        len -= (size_t)c->transfer->actual_length;
    }
    return 0;
}
