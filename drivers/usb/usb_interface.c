/* Interfaces and endpoints of an open device: claiming, and finding them by the descriptors. */
#include "drivers/usb/usb_priv.h"

#include "drivers/driver.h"

#include <errno.h>

int dx_usb_claim(struct dx_usb *usb, uint8_t interface, uint8_t alt, struct dx_err *err)
{
    int r =
        interface < 32 ? libusb_claim_interface(usb->handle, interface) : LIBUSB_ERROR_NOT_FOUND;

    if (r == LIBUSB_ERROR_BUSY)
        return dx_err_set(err, -EBUSY,
                          "USB device at port %s: another program has interface %u (%s)",
                          usb->about.port, interface, usb->about.node);
    if (r)
        return dx_err_set(err, dx_usb_code(r), "USB device at port %s: interface %u: %s",
                          usb->about.port, interface, libusb_strerror(r));
    usb->claimed |= 1u << interface;
    r = alt ? libusb_set_interface_alt_setting(usb->handle, interface, alt) : 0;
    if (r)
        return dx_err_set(err, dx_usb_code(r),
                          "USB device at port %s: interface %u, alternate setting %u: %s",
                          usb->about.port, interface, alt, libusb_strerror(r));
    return 0;
}

static bool pair_of(const struct libusb_interface_descriptor *d, struct dx_usb_pair *pair)
{
    bool in = false, out = false;

    pair->interface = d->bInterfaceNumber;
    for (unsigned k = 0; k < d->bNumEndpoints; k++) {
        const struct libusb_endpoint_descriptor *e = &d->endpoint[k];

        if ((e->bmAttributes & 3) != LIBUSB_TRANSFER_TYPE_BULK)
            continue;
        if (e->bEndpointAddress & LIBUSB_ENDPOINT_IN && !in) {
            in = true;
            pair->in = e->bEndpointAddress;
            pair->in_packet_len = e->wMaxPacketSize & 0x7ff;
        } else if (!(e->bEndpointAddress & LIBUSB_ENDPOINT_IN) && !out) {
            out = true;
            pair->out = e->bEndpointAddress;
        }
    }
    return in && out && pair->in_packet_len > 0;
}

/* Alternate setting 0 of each interface of the class, until one `fits`. */
static int find(const struct dx_usb *usb, uint8_t interface_class,
                bool (*fits)(const struct libusb_interface_descriptor *d, struct dx_usb_pair *pair),
                struct dx_usb_pair *pair)
{
    struct libusb_config_descriptor *config;
    int r = libusb_get_active_config_descriptor(libusb_get_device(usb->handle), &config);
    bool found = false;

    if (r)
        return r == LIBUSB_ERROR_NOT_FOUND ? -ENOENT : dx_usb_code(r);
    for (unsigned k = 0; k < config->bNumInterfaces && !found; k++) {
        const struct libusb_interface *i = &config->interface[k];

        found = i->num_altsetting > 0 && i->altsetting[0].bInterfaceClass == interface_class &&
                fits(&i->altsetting[0], pair);
    }
    libusb_free_config_descriptor(config);
    return found ? 0 : -ENOENT;
}

int dx_usb_find_pair(const struct dx_usb *usb, uint8_t interface_class, struct dx_usb_pair *out,
                     struct dx_err *err)
{
    int r = find(usb, interface_class, pair_of, out);

    if (r)
        dx_err_set(err, r,
                   "USB device %04x:%04x at port %s: no interface of class %02x with bulk IN and "
                   "bulk OUT",
                   usb->about.id.vid, usb->about.id.pid, usb->about.port, interface_class);
    return r;
}

static bool any_of(const struct libusb_interface_descriptor *d, struct dx_usb_pair *pair)
{
    pair->interface = d->bInterfaceNumber;
    return true;
}

int dx_usb_find_interface(const struct dx_usb *usb, uint8_t interface_class, uint8_t *out)
{
    struct dx_usb_pair pair = {0};
    int r = find(usb, interface_class, any_of, &pair);

    if (r == 0)
        *out = pair.interface;
    return r;
}

size_t dx_usb_iso_packet_len(const struct dx_usb *usb, uint8_t endpoint, size_t otherwise)
{
    int len = libusb_get_max_iso_packet_size(libusb_get_device(usb->handle), endpoint);

    return len > 0 ? (size_t)len : otherwise;
}
