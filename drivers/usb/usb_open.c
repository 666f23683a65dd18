/*
 * Which devices there are, and opening one. A context lives as long as its device is open. Called
 * by the device's thread; dx_usb_list() by any.
 */
#include "drivers/usb/usb_priv.h"

#include "drivers/driver.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

#define UDEV_RULE "60-dexeld.rules"

static bool is_of(const struct dx_usb_id *ids, struct dx_usb_id id)
{
    for (; ids->vid; ids++)
        if (ids->vid == id.vid && ids->pid == id.pid)
            return true;
    return false;
}

/* "1-2.3"; a root hub is "usb1". */
static void put_port(char *text, size_t len, libusb_device *device)
{
    uint8_t ports[8];
    int n = libusb_get_port_numbers(device, ports, (int)sizeof(ports));
    int at = snprintf(text, len, n > 0 ? "%u" : "usb%u", libusb_get_bus_number(device));

    for (int k = 0; k < n && at > 0 && (size_t)at < len; k++)
        at += snprintf(text + at, len - (size_t)at, k ? ".%u" : "-%u", ports[k]);
}

bool dx_usb_is_port(const char *text)
{
    for (unsigned n = 0; n < 8; n++) { /* the bus, and at most seven ports */
        size_t len = strspn(text, "0123456789");

        if (len < 1 || len > 3 || text[0] == '0')
            return false;
        text += len;
        if (n > 0 && !*text)
            return true;
        if (*text++ != (n ? '.' : '-'))
            return false;
    }
    return false;
}

static int look(struct dx_usb_about *about, libusb_device *device)
{
    struct libusb_device_descriptor d;
    int r = libusb_get_device_descriptor(device, &d);

    if (r)
        return dx_usb_code(r);
    memset(about, 0, sizeof(*about));
    about->id = (struct dx_usb_id){d.idVendor, d.idProduct};
    about->release = d.bcdDevice;
    put_port(about->port, sizeof(about->port), device);
    snprintf(about->node, sizeof(about->node), "/dev/bus/usb/%03u/%03u",
             libusb_get_bus_number(device), libusb_get_device_address(device));
    return 0;
}

static void get_text(char *text, size_t len, libusb_device_handle *handle, uint8_t index)
{
    int n = index ? libusb_get_string_descriptor_ascii(handle, index, (unsigned char *)text,
                                                       (int)len - 1)
                  : 0;

    text[n > 0 ? n : 0] = '\0';
    for (char *c = text; *c; c++)
        if (*c < 0x20 || *c > 0x7e)
            *c = '?';
}

/* Opens, and reads what can be read only then. */
static int open_one(libusb_device_handle **handle, struct dx_usb_about *about,
                    libusb_device *device)
{
    struct libusb_device_descriptor d;
    int r = libusb_open(device, handle);

    about->access = r ? dx_usb_code(r) : 0;
    if (r)
        return about->access;
    if (libusb_get_device_descriptor(device, &d) == 0) {
        get_text(about->serial, sizeof(about->serial), *handle, d.iSerialNumber);
        get_text(about->product, sizeof(about->product), *handle, d.iProduct);
    }
    return 0;
}

/* 1: a machine without USB, which has no devices. */
static int init_context(libusb_context **context, struct dx_err *err)
{
    int r = libusb_init(context);

    if (r == LIBUSB_ERROR_OTHER && access("/dev/bus/usb", F_OK) != 0)
        return 1;
    if (r)
        return dx_err_set(err, r == LIBUSB_ERROR_NO_MEM ? -ENOMEM : -EIO,
                          "usb: libusb cannot be set up: %s", libusb_strerror(r));
    return 0;
}

int dx_usb_list(const struct dx_usb_id *ids,
                void (*found)(void *ctx, const struct dx_usb_about *about), void *ctx,
                struct dx_err *err)
{
    libusb_context *context;
    libusb_device **devices;
    struct dx_usb_about about;
    libusb_device_handle *handle;
    ssize_t n;
    int r = init_context(&context, err);

    if (r)
        return r < 0 ? r : 0;
    n = libusb_get_device_list(context, &devices);
    if (n < 0) {
        libusb_exit(context);
        return dx_err_set(err, -EIO, "usb: cannot list devices: %s", libusb_strerror((int)n));
    }
    for (ssize_t k = 0; k < n; k++) {
        if (look(&about, devices[k]) || !is_of(ids, about.id))
            continue;
        r = open_one(&handle, &about, devices[k]);
        if (r == DX_DRIVER_E_GONE)
            continue;
        found(ctx, &about);
        if (r == 0)
            libusb_close(handle);
    }
    libusb_free_device_list(devices, 1);
    libusb_exit(context);
    return 0;
}

static int not_there(const struct dx_usb_want *want, struct dx_err *err)
{
    char ids[128] = "";
    size_t at = 0;

    for (const struct dx_usb_id *id = want->ids; id->vid && at + 12 < sizeof(ids); id++)
        at += (size_t)snprintf(ids + at, sizeof(ids) - at, "%s%04x:%04x", at ? ", " : "", id->vid,
                               id->pid);
    return dx_err_set(err, DX_DRIVER_E_GONE, "no USB device %s%s%s%s%s is there", ids,
                      want->serial && *want->serial ? ", serial " : "",
                      want->serial && *want->serial ? want->serial : "",
                      want->port && *want->port ? ", at port " : "",
                      want->port && *want->port ? want->port : "");
}

static int no_access(const struct dx_usb_about *about, struct dx_err *err)
{
    if (about->access != -EACCES)
        return dx_err_set(err, about->access, "USB device %04x:%04x at port %s: cannot open %s: %s",
                          about->id.vid, about->id.pid, about->port, about->node,
                          strerror(-about->access));
    return dx_err_set(
        err, -EACCES,
        "USB device %04x:%04x at port %s: no permission for %s; the udev rule " UDEV_RULE
        " grants it (then plug it in again)",
        about->id.vid, about->id.pid, about->port, about->node);
}

/* Fills handle and about of the first device that fits. A device that cannot be opened may be the
 * one of the serial number; it is named only when no other fits. */
static int choose(struct dx_usb *usb, const struct dx_usb_want *want, libusb_device **devices,
                  ssize_t n, struct dx_err *err)
{
    struct dx_usb_about denied = {.access = 0};

    for (ssize_t k = 0; k < n; k++) {
        struct dx_usb_about *about = &usb->about;

        if (look(about, devices[k]) || !is_of(want->ids, about->id))
            continue;
        if (want->port && *want->port && strcmp(want->port, about->port) != 0)
            continue;
        if (open_one(&usb->handle, about, devices[k])) {
            if (about->access < 0 && denied.access == 0)
                denied = *about;
            continue;
        }
        if (!want->serial || !*want->serial || strcmp(want->serial, about->serial) == 0)
            return 0;
        libusb_close(usb->handle);
        usb->handle = NULL;
    }
    usb->handle = NULL;
    return denied.access ? no_access(&denied, err) : not_there(want, err);
}

static int choose_of_list(struct dx_usb *usb, const struct dx_usb_want *want, struct dx_err *err)
{
    libusb_device **devices;
    ssize_t n = libusb_get_device_list(usb->context, &devices);
    int r;

    if (n < 0)
        return dx_err_set(err, -EIO, "usb: cannot list devices: %s", libusb_strerror((int)n));
    r = choose(usb, want, devices, n, err);
    libusb_free_device_list(devices, 1); /* the open one keeps its own reference */
    return r;
}

int dx_usb_open(struct dx_usb **out, const struct dx_usb_want *want, struct dx_err *err)
{
    struct dx_usb *usb = calloc(1, sizeof(*usb));
    int r;

    if (!usb)
        return dx_err_set(err, -ENOMEM, "usb: out of memory");
    usb->wake_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (usb->wake_fd < 0) {
        r = dx_err_set(err, -errno, "usb: eventfd: %s", strerror(errno));
        goto err_usb;
    }
    r = init_context(&usb->context, err);
    if (r) {
        usb->context = NULL;
        r = r > 0 ? not_there(want, err) : r;
        goto err_usb;
    }
    r = choose_of_list(usb, want, err);
    if (r)
        goto err_usb;
    libusb_set_auto_detach_kernel_driver(usb->handle, 1);
    r = dx_usb_watch(usb);
    if (r == 0)
        r = dx_usb_calls_init(usb);
    if (r) {
        dx_err_set(err, r, "USB device at port %s: %s", usb->about.port, strerror(-r));
        goto err_usb;
    }
    *out = usb;
    return 0;

err_usb:
    dx_usb_close(usb);
    return r;
}

void dx_usb_close(struct dx_usb *usb)
{
    if (!usb)
        return;
    for (unsigned k = 0; k < DX_USB_MAX_STREAMS; k++)
        dx_usb_stream_close(usb->streams[k]);
    dx_usb_calls_fini(usb);
    if (usb->handle) {
        /* The last one first: a kernel's driver of several interfaces (CDC-ACM) is bound by the
         * first, and takes it only when the others are free. */
        for (int k = 31; k >= 0; k--)
            if (usb->claimed >> k & 1)
                libusb_release_interface(usb->handle, k);
        libusb_close(usb->handle);
    }
    dx_usb_unwatch(usb);
    if (usb->context)
        libusb_exit(usb->context);
    if (usb->wake_fd >= 0)
        close(usb->wake_fd);
    free(usb);
}

const struct dx_usb_about *dx_usb_tell(const struct dx_usb *usb)
{
    return &usb->about;
}
