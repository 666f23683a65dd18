/*
 * The way to a scanner: bytes in, bytes out, behind one small table. Reader thread, save wake().
 */
#ifndef DX_SCIP_LINK_H
#define DX_SCIP_LINK_H

#include "drivers/hokuyo/hokuyo.h"

#define DX_HOKUYO_USB_VENDOR  0x15d1
#define DX_HOKUYO_USB_PRODUCT 0x0000 /* of all models */

struct dx_scip_link;

struct dx_scip_link_ops {
    /* Waits until the way is open, when opening has only begun it: 0. AGAIN: woken, or the time ran
     * out; else as for opening. NULL: it is. */
    int (*connect)(struct dx_scip_link *link, int timeout_ms, struct dx_err *err);
    /* Sends all; a scanner takes a command at once or is not there. 0, GONE, or negative. */
    int (*write)(struct dx_scip_link *link, const uint8_t *bytes, size_t len, struct dx_err *err);
    /* Waits for bytes and takes up to `cap` of them. 0: *len came. AGAIN: woken, or the time ran
     * out. GONE, or negative: open it anew. */
    int (*read)(struct dx_scip_link *link, uint8_t *bytes, size_t cap, size_t *len, int timeout_ms,
                struct dx_err *err);
    void (*wake)(struct dx_scip_link *link); /* any thread: ends a wait now, or the next */
    void (*close)(struct dx_scip_link *link);
};

struct dx_scip_link {
    const struct dx_scip_link_ops *ops;
    char place[128]; /* for people and for health: "/dev/ttyACM0", "192.168.0.10:10940" */
    char node[32];   /* of a USB device, "/dev/bus/usb/001/002"; "": none */
};

/* GONE: it is not there; negative: it is, but cannot be had. err says what was looked for. */
int dx_scip_link_open_tty(struct dx_scip_link **out, const char *path, uint32_t baud,
                          struct dx_err *err);
int dx_scip_link_open_tcp(struct dx_scip_link **out, const char *address, struct dx_err *err);
/* "host", "host:port", "[v6]:port" to its parts, within `text`. False: it is none of them. */
bool dx_scip_tcp_split(char *text, const char **host, const char **port);
int dx_scip_link_open_usb(struct dx_scip_link **out, const char *port, struct dx_err *err);

/* By what the configuration names. */
int dx_scip_link_open(struct dx_scip_link **out, const struct dx_hokuyo_config *config,
                      struct dx_err *err);
void dx_scip_link_close(struct dx_scip_link *link); /* NULL is fine */

#endif
