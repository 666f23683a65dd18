/*
 * A USB device of our own on umockdev: it answers the kernel's usbfs ioctls, under the real libusb.
 * Its functions run in the testbed's thread. What it cannot do: hold poll() back (its node is
 * always ready), and isochronous transfers.
 */
#ifndef DX_MOCK_USB_H
#define DX_MOCK_USB_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define MOCK_USB_STALL (-32)
#define MOCK_USB_HOLD  (-11) /* nothing yet: the transfer stays queued */

struct mock_usb_device {
    const uint8_t *descriptors; /* device, then configuration */
    size_t descriptors_len;
    void *ctx;
    /* Each returns bytes, or one of the above. Strings are asked by control() too. */
    int (*control)(void *ctx, const uint8_t setup[8], uint8_t *bytes, int len);
    int (*in)(void *ctx, uint8_t endpoint, uint8_t *bytes, int len);
    int (*out)(void *ctx, uint8_t endpoint, const uint8_t *bytes, int len);
    bool forbidden;     /* the node lets nobody in but root; nothing of it works then */
    const char *serial; /* in sysfs; NULL: none */
};

struct mock_usb;

/* Starts the program anew under umockdev's wrapper when it does not run there; ends it with 77 when
 * there is none. First in main(). */
void mock_usb_wrap(char **argv);

/* At bus 1, address 2, port "1-1". */
struct mock_usb *mock_usb_new(const struct mock_usb_device *device);
/* A second one, at port "1-2", address 3; to be freed first. */
struct mock_usb *mock_usb_new_beside(struct mock_usb *first, const struct mock_usb_device *device);
void mock_usb_free(struct mock_usb *mock);
/* Queued transfers come back as the kernel shuts them down; all else says ENODEV. */
void mock_usb_unplug(struct mock_usb *mock);
/* Around what a test does to what those functions use. */
void mock_usb_lock(struct mock_usb *mock);
void mock_usb_unlock(struct mock_usb *mock);
/* Interfaces claimed and transfers queued at this moment. */
int mock_usb_n_claimed(struct mock_usb *mock);
int mock_usb_n_queued(struct mock_usb *mock);

/* Answers GET_DESCRIPTOR of strings: 1, 2, ... are `texts`. For control(). */
int mock_usb_string(const uint8_t setup[8], uint8_t *bytes, int len, const char *const *texts,
                    int n_texts);

#endif
