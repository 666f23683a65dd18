/*
 * A USB device that is a program: what QEMU's usb-redir plugs into the guest. The guest's real
 * host controller driver, usbfs or class drivers talk to it. A device gives its descriptors and
 * answers what is its own; everything else of USB is done here. One device a program, one thread.
 */
#ifndef HIL_REDIR_H
#define HIL_REDIR_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct redir_setup {
    uint8_t type, request; /* bmRequestType, bRequest */
    uint16_t value, index, length;
};

struct redir_device {
    const uint8_t *device; /* descriptors as on the wire; this one is of 18 bytes */
    const uint8_t *config;
    size_t config_len;
    const char *const *strings; /* number 1 and up of the descriptors; ends with NULL */
    bool full_speed;            /* 12 Mbit/s; else 480 */
    uint8_t endpoint;           /* the one that data come from, bulk or isochronous: 0x81 */
    uint8_t out;                /* the bulk one that they go to; 0: none */

    /* A control request that is none of GET_DESCRIPTOR, SET_CONFIGURATION, SET_INTERFACE. IN:
     * points *bytes at the answer and returns its length; OUT: *bytes are `length` bytes that came,
     * returns 0. Negative: stall. */
    int (*control)(const struct redir_setup *setup, const uint8_t **bytes);
    /* Called whenever something has happened, and after what the last call returned: sends what is
     * due by redir_bulk_in(); returns milliseconds until the next is due. */
    int (*pump)(void);
    /* Bytes that came to the bulk OUT endpoint; may be NULL where there is none. */
    void (*came)(const uint8_t *bytes, size_t len);
    /* The device has come, or has gone and holds no request any more. */
    void (*plugged)(bool in);
    /* An order by the other socket that is none of orders.c; the answer into text, no newline. */
    void (*order)(const char *line, char *text, size_t text_len);
};

/*
 * Listens at both paths, says so by a line on file descriptor 3 when that is open, serves one QEMU
 * until it goes away: it connects twice to `path`, for two ports of its controller. The device is
 * in none until it is ordered to be plugged. Orders and their answers are lines. Returns the
 * program's exit status.
 */
int redir_serve(const struct redir_device *device, const char *path, const char *orders_path);

/* Requests for data of the bulk IN endpoint that wait. */
unsigned redir_n_waiting(void);
/* Bytes that the oldest of them asks for. */
size_t redir_bulk_room(void);
/* Answers the oldest of them; len at most what it asks for. */
void redir_bulk_in(const uint8_t *bytes, size_t len);
/* Whether the guest fetches isochronous packets; gives it the next one. They are kept by QEMU, some
 * 900 at most: more are lost. */
bool redir_iso_runs(void);
void redir_iso_in(const uint8_t *bytes, size_t len);
/* Orders of the device itself; elsewhere: in the other port than before. */
void redir_plug(bool elsewhere);
void redir_unplug(void);
/* Unplugs when so many bytes of its answers and data have gone out, from now or from the next plug
 * on; the transfer that is cut has failed, with what came of it. */
void redir_unplug_after(uint64_t n_bytes);

#endif
