/* The kernel: modules that drivers need, and memory for USB transfers. */
#include "tools/doctor.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_USB 32
#define USBFS   "/sys/module/usbcore/parameters/usbfs_memory_mb"

static bool is_loaded(const struct dx_doctor *d, const char *module)
{
    char path[64];
    struct stat st;

    snprintf(path, sizeof(path), "/sys/module/%s", module);
    return dx_doctor_stat(d, path, &st);
}

/* How many interfaces of this class (two hexadecimal digits) are attached by USB. */
static unsigned n_interfaces(const struct dx_doctor *d, const char *class)
{
    unsigned n = 0;
    glob_t g;

    dx_doctor_glob(d, "/sys/bus/usb/devices/*/bInterfaceClass", &g);
    for (size_t k = 0; k < g.gl_pathc; k++) {
        char text[8];

        n += dx_doctor_read(d, dx_doctor_match(d, &g, k), text, sizeof(text)) &&
             !strcmp(text, class);
    }
    globfree(&g);
    return n;
}

static void look_at_module(struct dx_doctor *d, const char *module, unsigned n, const char *what,
                           bool is_needed)
{
    if (is_loaded(d, module)) {
        dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "%s is loaded", module);
        return;
    }
    if (n == 0 && !is_needed) {
        dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "%s is not needed: no %s are attached", module, what);
        return;
    }
    dx_doctor_tell(d, is_needed ? DX_DOCTOR_PROBLEM : DX_DOCTOR_WARNING,
                   dx_doctor_command(d, "sudo modprobe @", module),
                   "the kernel's %s is not loaded, which makes nodes of %s (attached: %u)", module,
                   what, n);
}

static bool has_gpio_chip(const struct dx_doctor *d)
{
    glob_t g;
    size_t n = dx_doctor_glob(d, "/sys/bus/gpio/devices/gpiochip*", &g);

    globfree(&g);
    return n > 0;
}

/* Adapters on USB that have lines: how their aliases in sysfs begin, and their modules. */
static const struct {
    const char *alias, *module, *name;
} adapters[] = {
    {"usb:v04D8p00DD", "hid_mcp2221", "MCP2221"},
    {"usb:v10C4pEA90", "hid_cp2112", "CP2112"},
};

#define N_ADAPTERS (sizeof(adapters) / sizeof(adapters[0]))

/* One that is attached and whose module is not loaded: its number, else N_ADAPTERS. */
static size_t find_adapter(const struct dx_doctor *d)
{
    size_t found = N_ADAPTERS;
    glob_t g;

    dx_doctor_glob(d, "/sys/bus/usb/devices/*/modalias", &g);
    for (size_t k = 0; k < g.gl_pathc && found == N_ADAPTERS; k++) {
        char alias[64];

        if (!dx_doctor_read(d, dx_doctor_match(d, &g, k), alias, sizeof(alias)))
            continue;
        for (found = 0; found < N_ADAPTERS; found++)
            if (!strncmp(alias, adapters[found].alias, strlen(adapters[found].alias)) &&
                !is_loaded(d, adapters[found].module))
                break;
    }
    globfree(&g);
    return found;
}

static void look_at_gpio(struct dx_doctor *d)
{
    const size_t k = find_adapter(d);

    if (!dx_doctor_wants_gpio(d))
        dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "GPIO is not needed: no stream uses lines");
    else if (has_gpio_chip(d))
        dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "there are GPIO chips");
    else if (k < N_ADAPTERS)
        dx_doctor_tell(
            d, DX_DOCTOR_PROBLEM, dx_doctor_command(d, "sudo modprobe @", adapters[k].module),
            "streams want GPIO lines, and the kernel has no GPIO chip: the module of the "
            "%s that is attached is not loaded",
            adapters[k].name);
    else
        dx_doctor_tell(d, DX_DOCTOR_PROBLEM, NULL,
                       "streams want GPIO lines, and the kernel has no GPIO chip: plug in an "
                       "adapter that has lines (on USB: MCP2221, CP2112), or load the module of "
                       "the board's chip");
}

void dx_doctor_modules(struct dx_doctor *d)
{
    look_at_module(d, "uvcvideo", n_interfaces(d, "0e"), "cameras on USB",
                   n_interfaces(d, "0e") > 0 && dx_doctor_n_streams(d, "v4l2") > 0);
    look_at_module(d, "cdc_acm", n_interfaces(d, "02"), "scanners on USB as serial ports", false);
    if (d->has_config)
        look_at_gpio(d);
}

/*
 * What libusb's transfers take of the kernel's memory for all programs: of a Kinect 16 of 16
 * packets of 1920 bytes, of a scanner a few kilobytes. The kernel gives 16 MB where nobody has set
 * it.
 */
void dx_doctor_usb(struct dx_doctor *d)
{
    struct dx_doctor_usb usb[MAX_USB];
    const unsigned n_kinect = dx_doctor_usb_devices(d, "kinect", usb, MAX_USB);
    const unsigned n_hokuyo = dx_doctor_usb_devices(d, "hokuyo", usb, MAX_USB);
    const unsigned need_kib = 480 * n_kinect + 64 * n_hokuyo;
    const char *mend = "echo 64 | sudo tee " USBFS;
    char text[32];
    unsigned long mib;

    if (!dx_doctor_read(d, USBFS, text, sizeof(text))) {
        if (n_kinect + n_hokuyo)
            dx_doctor_tell(d, DX_DOCTOR_WARNING, NULL, USBFS " cannot be read");
        else
            dx_doctor_tell(d, DX_DOCTOR_OK, NULL,
                           "memory of usbfs is not needed: no scanner and no Kinect is attached");
        return;
    }
    mib = strtoul(text, NULL, 10);
    if (mib && mib * 1024 < need_kib)
        dx_doctor_tell(d, DX_DOCTOR_PROBLEM, mend,
                       "usbfs has %lu MB for transfers, the devices attached take %u kB", mib,
                       need_kib);
    else if (mib && mib < 16)
        dx_doctor_tell(d, DX_DOCTOR_WARNING, mend,
                       "usbfs has %lu MB for transfers of all programs, less than the usual 16",
                       mib);
    else if (mib)
        dx_doctor_tell(d, DX_DOCTOR_OK, NULL,
                       "usbfs has %lu MB for transfers, the devices attached take %u kB", mib,
                       need_kib);
    else
        dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "usbfs has no bound of memory for transfers");
}
