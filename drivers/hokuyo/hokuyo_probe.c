/* Scanners that are attached by USB. All models have the same numbers, and which one it is only VV
 * tells, which would disturb who uses it. */
#include "drivers/hokuyo/hokuyo_probe.h"

#include "drivers/hokuyo/scip_link.h"
#include "drivers/udev.h"

#include <stdio.h>

struct probe {
    void (*found)(void *ctx, const struct dx_device_found *device);
    void *ctx;
};

static bool take(void *ctx, const struct dx_udev_device *d)
{
    const struct probe *p = ctx;
    struct dx_device_found found = {
        .name = "Hokuyo line scanner", .node = d->node, .serial = "", .place = d->place};
    char yaml[128];

    if (d->vendor != DX_HOKUYO_USB_VENDOR || d->product != DX_HOKUYO_USB_PRODUCT)
        return true;
    snprintf(yaml, sizeof(yaml),
             "port: \"%s\"\n#stage: {rpm: 30} # or its encoder: see dexeld.yaml(5)\n", d->port);
    found.yaml = yaml;
    found.access = dx_udev_access(d->node);
    p->found(p->ctx, &found);
    return true;
}

int dx_hokuyo_probe(void (*found)(void *ctx, const struct dx_device_found *device), void *ctx,
                    struct dx_err *err)
{
    struct probe p = {found, ctx};

    return dx_udev_each("usb", take, &p, err);
}
