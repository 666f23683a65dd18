/* Attached devices, by sd-device. */
#include "drivers/udev.h"

#include "drivers/driver.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <systemd/sd-device.h>
#include <unistd.h>

/* ---- texts -----------------------------------------------------------------------------------
 */

/* Devices tell what they like. */
static void copy(char *to, size_t len, const char *from)
{
    size_t n = strnlen(from, len - 1);

    for (size_t k = 0; k < n; k++)
        to[k] = (char)(from[k] < 0x20 || from[k] > 0x7e ? '?' : from[k]);
    while (n > 0 && to[n - 1] == ' ')
        n--;
    to[n] = 0;
}

/* "" when the device has no such attribute, or is no longer there. */
static const char *attribute(sd_device *d, const char *name)
{
    const char *value;

    return d && sd_device_get_sysattr_value(d, name, &value) >= 0 ? value : "";
}

static unsigned number(sd_device *d, const char *name, int base, unsigned max)
{
    unsigned long n = strtoul(attribute(d, name), NULL, base);

    return n <= max ? (unsigned)n : 0;
}

static bool is_of(sd_device *d, const char *subsystem, const char *devtype)
{
    const char *s, *t;

    return sd_device_get_subsystem(d, &s) >= 0 && !strcmp(s, subsystem) &&
           (!devtype || (sd_device_get_devtype(d, &t) >= 0 && !strcmp(t, devtype)));
}

/* The device itself or a parent; borrowed. NULL: none. */
static sd_device *ancestor(sd_device *d, const char *subsystem, const char *devtype)
{
    sd_device *parent;

    if (is_of(d, subsystem, devtype))
        return d;
    return sd_device_get_parent_with_subsystem_devtype(d, subsystem, devtype, &parent) >= 0 ? parent
                                                                                            : NULL;
}

/* ---- places ----------------------------------------------------------------------------------
 */

/* "pci-0000:00:14.0": the nearest parent that stays where it is. False: none. */
static bool put_parent(sd_device *d, char *text, size_t len)
{
    static const char *const fixed[] = {"pci", "platform", "i2c", "spi", "acpi", "virtio"};
    const char *sysname;

    for (sd_device *p = d; sd_device_get_parent(p, &p) >= 0;)
        for (size_t k = 0; k < sizeof(fixed) / sizeof(fixed[0]); k++)
            if (is_of(p, fixed[k], NULL) && sd_device_get_sysname(p, &sysname) >= 0) {
                snprintf(text, len, "%s-%s", fixed[k], sysname);
                return true;
            }
    return false;
}

/* As udev's own path_id makes it, so that it is the same where no udevd runs. */
static void make_place(sd_device *d, sd_device *usb, sd_device *interface, char *text, size_t len)
{
    char controller[64], parts[64];
    const char *s;

    if (sd_device_get_property_value(d, "ID_PATH", &s) >= 0) {
        copy(text, len, s);
        return;
    }
    if (usb) {
        const char *suffix =
            interface && sd_device_get_sysname(interface, &s) >= 0 ? strchr(s, ':') : NULL;
        bool known = put_parent(usb, controller, sizeof(controller));

        copy(parts, sizeof(parts), attribute(usb, "devpath"));
        snprintf(text, len, "%.50s%susb-0:%.30s%.20s", known ? controller : "", known ? "-" : "",
                 parts, suffix ? suffix : "");
    } else if (!put_parent(d, text, len) && sd_device_get_sysname(d, &s) >= 0) {
        copy(text, len, s);
    }
}

/* ---- one device ------------------------------------------------------------------------------
 */

static void describe_usb(struct dx_udev_device *out, sd_device *usb, sd_device *interface)
{
    const char *s;

    copy(out->serial, sizeof(out->serial), attribute(usb, "serial"));
    if (sd_device_get_sysname(usb, &s) >= 0)
        copy(out->port, sizeof(out->port), s);
    out->vendor = (uint16_t)number(usb, "idVendor", 16, UINT16_MAX);
    out->product = (uint16_t)number(usb, "idProduct", 16, UINT16_MAX);
    out->bus = (uint8_t)number(usb, "busnum", 10, UINT8_MAX);
    out->address = (uint8_t)number(usb, "devnum", 10, UINT8_MAX);
    if (interface)
        out->interface = (int)number(interface, "bInterfaceNumber", 16, UINT8_MAX);
}

static void make_name(struct dx_udev_device *out, sd_device *d, sd_device *usb)
{
    char maker[64], product[64];

    copy(out->name, sizeof(out->name), attribute(d, "name")); /* video4linux */
    if (!*out->name)
        copy(out->name, sizeof(out->name), attribute(d, "label")); /* gpio */
    if (*out->name || !usb)
        return;
    copy(maker, sizeof(maker), attribute(usb, "manufacturer"));
    copy(product, sizeof(product), attribute(usb, "product"));
    snprintf(out->name, sizeof(out->name), "%s%s%s", maker, *maker && *product ? " " : "", product);
}

/* False: it has no node. */
static bool describe(struct dx_udev_device *out, sd_device *d)
{
    sd_device *usb = ancestor(d, "usb", "usb_device");
    sd_device *interface = usb ? ancestor(d, "usb", "usb_interface") : NULL;
    const char *s;

    *out = (struct dx_udev_device){.interface = -1};
    if (sd_device_get_devname(d, &s) < 0)
        return false;
    copy(out->node, sizeof(out->node), s);
    if (sd_device_get_subsystem(d, &s) >= 0)
        copy(out->subsystem, sizeof(out->subsystem), s);
    if (sd_device_get_sysname(d, &s) >= 0)
        copy(out->sysname, sizeof(out->sysname), s);
    if (sd_device_get_syspath(d, &s) >= 0)
        copy(out->syspath, sizeof(out->syspath), s);
    if (usb)
        describe_usb(out, usb, interface);
    make_name(out, d, usb);
    make_place(d, usb, interface, out->place, sizeof(out->place));
    return true;
}

/* ---- all of them -----------------------------------------------------------------------------
 */

static int enumerate(sd_device_enumerator **out, const char *subsystem)
{
    int r = sd_device_enumerator_new(out);

    if (r >= 0)
        r = sd_device_enumerator_add_match_subsystem(*out, subsystem, true);
    if (r >= 0) /* those that no udevd has seen: there may be none */
        r = sd_device_enumerator_allow_uninitialized(*out);
    return r < 0 ? r : 0;
}

int dx_udev_each(const char *subsystem, bool (*take)(void *ctx, const struct dx_udev_device *d),
                 void *ctx, struct dx_err *err)
{
    sd_device_enumerator *e = NULL;
    struct dx_udev_device one;
    int r = enumerate(&e, subsystem);

    if (r < 0)
        dx_err_set(err, r, "no list of devices (%s): %s", subsystem, strerror(-r));
    else
        for (sd_device *d = sd_device_enumerator_get_device_first(e); d;
             d = sd_device_enumerator_get_device_next(e))
            if (describe(&one, d) && !take(ctx, &one))
                break;
    sd_device_enumerator_unref(e);
    return r;
}

int dx_udev_by_node(struct dx_udev_device *out, const char *node, struct dx_err *err)
{
    sd_device *d = NULL;
    struct stat st;
    int r = stat(node, &st) < 0 ? -errno : 0;

    *out = (struct dx_udev_device){.interface = -1};
    if (r == 0 && !S_ISCHR(st.st_mode))
        return dx_err_set(err, -ENODEV, "%s: not a device, expected the node of one", node);
    if (r == 0)
        r = sd_device_new_from_devnum(&d, 'c', st.st_rdev);
    if (r >= 0 && !describe(out, d))
        r = -ENODEV;
    sd_device_unref(d);
    if (r >= 0)
        return 0;
    if (r == -ENOENT || r == -ENOTDIR || r == -ENXIO)
        r = -ENODEV;
    return dx_err_set(err, r, "%s: %s", node, r == -ENODEV ? "no such device" : strerror(-r));
}

/* ---- choosing --------------------------------------------------------------------------------
 */

static bool is_node(const char *path, const char *node)
{
    struct stat a, b;

    return *path == '/' && stat(path, &a) == 0 && stat(node, &b) == 0 && S_ISCHR(a.st_mode) &&
           S_ISCHR(b.st_mode) && a.st_rdev == b.st_rdev;
}

bool dx_udev_is(const struct dx_udev_device *d, const char *serial, const char *place)
{
    if (*serial && *d->serial)
        return !strcmp(d->serial, serial);
    if (!*place)
        return !*serial;
    return !strcmp(d->place, place) || (*d->port && !strcmp(d->port, place)) ||
           is_node(place, d->node);
}

void dx_udev_attribute(const struct dx_udev_device *d, const char *name, char *text, size_t len)
{
    sd_device *device = NULL;

    *text = 0;
    if (sd_device_new_from_syspath(&device, d->syspath) >= 0)
        copy(text, len, attribute(device, name));
    sd_device_unref(device);
}

/* ---- permissions -----------------------------------------------------------------------------
 */

int dx_udev_access(const char *node)
{
    return faccessat(AT_FDCWD, node, R_OK | W_OK, AT_EACCESS) < 0 ? -errno : 0;
}

void dx_device_rule(const char *node, char *text, size_t len)
{
    struct dx_udev_device d;
    struct dx_err err;
    char match[128] = "";

    if (dx_udev_by_node(&d, node, &err) < 0) {
        snprintf(text, len, "KERNEL==\"%.40s\"",
                 strrchr(node, '/') ? strrchr(node, '/') + 1 : node);
    } else {
        if (d.vendor)
            snprintf(match, sizeof(match),
                     ", ATTRS{idVendor}==\"%04x\", ATTRS{idProduct}==\"%04x\"", d.vendor,
                     d.product);
        else
            snprintf(match, sizeof(match), ", KERNEL==\"%s\"", d.sysname);
        snprintf(text, len, "SUBSYSTEM==\"%s\"%s", d.subsystem, match);
    }
    snprintf(text + strlen(text), len - strlen(text),
             ", MODE=\"0660\", GROUP=\"dexeld\", TAG+=\"uaccess\"");
}

int dx_udev_refused(struct dx_err *err, int code, const char *node)
{
    char rule[256];

    if (code != -EACCES && code != -EPERM)
        return dx_err_set(err, code, "%s: %s", node, strerror(-code));
    dx_device_rule(node, rule, sizeof(rule));
    return dx_err_set(err, code, "%s: %s; a udev rule grants it: %s", node, strerror(-code), rule);
}
