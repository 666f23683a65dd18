/*
 * What is attached, as sysfs and the udev database tell it: for the probe() and open() of drivers,
 * which choose a device by serial or place and never by the number in its node's name. Works where
 * no udevd runs: sysfs has all of it. Plain functions without state; any thread.
 */
#ifndef DX_UDEV_H
#define DX_UDEV_H

#include "core/base/err.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Texts hold printable characters only and are cut to fit. */
struct dx_udev_device {
    char subsystem[32]; /* "video4linux", "usb", "tty", "gpio" */
    char sysname[64];   /* "video0", "1-2.3" */
    char syspath[256];  /* "/sys/devices/..." */
    char node[64];      /* "/dev/video0" */
    char name[128];     /* of the device itself where it has one, else of the USB device */
    /* Where it is attached, stable over a restart. As in /dev/v4l/by-path and the like:
     * "pci-0000:00:14.0-usb-0:2.3:1.0"; where there is no such name, that of the nearest parent
     * ("platform-gpio-sim.0"). */
    char place[128];

    /* Of the USB device that it belongs to; else empty, 0, -1. */
    char serial[64];
    char port[32]; /* "1-2.3": the bus and the ports on the way, as in `lsusb -t` */
    uint16_t vendor, product;
    uint8_t bus, address;
    int interface; /* -1 also of the USB device itself */
};

/*
 * Tells each device of `subsystem` that has a node (of "usb": devices, not interfaces), in the
 * order of their paths in sysfs; false from `take` ends it. A device that goes meanwhile is left
 * out or told half: whoever opens it finds out. 0, or negative with err.
 */
int dx_udev_each(const char *subsystem, bool (*take)(void *ctx, const struct dx_udev_device *d),
                 void *ctx, struct dx_err *err);

/* The device behind a node; links as in /dev/v4l/by-id are followed. -ENODEV: there is none. */
int dx_udev_by_node(struct dx_udev_device *out, const char *node, struct dx_err *err);

/*
 * Whether this is the device that a configuration asks for; "" asks for nothing. A device with a
 * serial is known by `serial`, wherever it is attached; without one, by `place`: its place, port,
 * node, or a link to the node.
 */
bool dx_udev_is(const struct dx_udev_device *d, const char *serial, const char *place);

/* An attribute of the device in sysfs ("index", "product"); "" when it has none. */
void dx_udev_attribute(const struct dx_udev_device *d, const char *name, char *text, size_t len);

/* 0, or why this process cannot open the node for reading and writing: -EACCES ... */
int dx_udev_access(const char *node);

/* err: why opening `node` failed, with `code`; of a missing permission also the udev rule that
 * grants it. Returns code. */
int dx_udev_refused(struct dx_err *err, int code, const char *node);

#endif
