/*
 * What a driver is: a table of functions. Every driver is split in two so that a recording can be
 * taken and replayed: read() hands over a raw block (the device's own bytes with stamps), decode()
 * turns a block into frame parts. decode() depends on nothing but the driver's configuration and
 * the blocks before it. All functions of one open driver are called by its reader thread alone,
 * save wake().
 *
 * Sources that end (recordings, scenes) are opened once and decode what they read themselves.
 * Drivers of devices, which have `subsystems`, come and go: for each stay of the device there is an
 * open(), connect(), start(), read()..., stop(), close(); all blocks are decoded by one decoder of
 * open_decoder(), which lives as long as the stream, as in a replay. So whatever decode() must know
 * of the device (its constants, its format) is in the blocks, in each of them, and a decoder can
 * begin with any.
 */
#ifndef DX_DRIVER_H
#define DX_DRIVER_H

#include "core/base/err.h"
#include "core/grid/geometry.h"
#include "core/grid/plane.h"
#include "drivers/interlock.h"

/* Positive results: conditions that the reader must handle. */
enum dx_driver_condition {
    DX_DRIVER_E_AGAIN = 1, /* nothing yet (woken, or the wait ran out): call again */
    DX_DRIVER_E_EOF = 2,   /* a replay has ended; the reason is not an error */
    DX_DRIVER_E_GONE = 3,  /* the device went away */
    DX_DRIVER_E_CORRUPT =
        4, /* this block cannot be decoded (err says where); the next may be fine */
};

enum dx_clock {
    DX_CLOCK_NONE = 0,
    DX_CLOCK_REALTIME = 1,
    DX_CLOCK_MONOTONIC = 2,
    DX_CLOCK_DEVICE = 3
};

struct dx_stamp {
    uint64_t host_ns;   /* CLOCK_MONOTONIC when the last byte came */
    uint64_t device_ns; /* of the device's clock, or of the recording */
    uint32_t clock_id;  /* enum dx_clock, of device_ns */
};

/* Raw device bytes. The memory is the driver's and holds until the next read(). */
struct dx_block {
    const uint8_t *bytes;
    size_t len;
    struct dx_stamp stamp;
    uint64_t number;    /* 0, 1, ... */
    bool first;         /* of a stay of the device: what a decoder has half of is void */
    const char *source; /* for messages: file name or device path */
};

/*
 * Some columns of one frame. decode() asks the sink for the frame's plane, fills columns of it, and
 * delivers them; whole frames are one part.
 */
struct dx_frame_part {
    uint64_t frame; /* number; parts of one frame share it */
    uint32_t col0, n_cols;
    bool last; /* ends the frame */
    struct dx_stamp stamp;
};

/* Where decode() puts frames: the mailbox, or an offline tool. */
struct dx_frame_sink {
    void *ctx;
    /* Tells the geometry; before the first frame, and again when it changes (RESET). The sink takes
     * its own reference. Non-zero stops the decode and is passed up. */
    int (*geometry)(void *ctx, struct dx_geometry *g, uint8_t attr_bytes);
    /* The plane of frame `number`, of the told geometry's size, to write columns into; all zero
     * when the number is new. May wait (lossless replay). NULL: shutting down, return
     * DX_DRIVER_E_AGAIN. */
    struct dx_plane *(*plane)(void *ctx, uint64_t number);
    void (*deliver)(void *ctx, const struct dx_frame_part *part);
};

/* A sensor, opened. Drivers put their own state behind it. */
struct dx_device;

/* What an open device says of itself; the counts are of this stay. */
struct dx_device_health {
    char serial[64];    /* "": it has none */
    char place[128];    /* where it is attached, stable over a restart: a USB port, a path */
    uint64_t n_lost;    /* frames that it made and that never came */
    uint64_t n_damaged; /* frames that came damaged, and were left out */
    char trouble[96];   /* "": none; else why what comes is doubtful, though it comes */
};

/* A device that is attached, for people: `dexel devices`. */
struct dx_device_found {
    const char *name;   /* "Intel RealSense D435, depth" */
    const char *node;   /* "/dev/video2" */
    const char *serial; /* "": none */
    const char *place;
    const char *yaml; /* the driver's keys that choose it, a line each, without indentation */
    int access;       /* 0; else why it cannot be opened: -EACCES, -EBUSY ... */
};

struct dx_driver {
    const char *name; /* the key in the configuration: "file", "synthetic" */

    /* Of drivers of devices: where sd-device tells that one has come or gone ("video4linux",
     * "usb"), ends with NULL; empty for those on the network. NULL: no device. */
    const char *const *subsystems;

    /* Opens what `config` (the driver's own struct) names; reads no frame yet. Of devices: GONE
     * when it is not there (err says what was looked for); what is negative is tried again, later.
     */
    int (*open)(struct dx_device **out, const void *config, struct dx_err *err);
    /* The same for blocks of a recording: touches nothing that `config` names. Of what it opens
     * only decode, adopt, describe and close are called. */
    int (*open_decoder)(struct dx_device **out, const void *config, struct dx_err *err);
    /* Before start(), of devices that must be waited for, or asked who they are: 0: it is reached.
     * AGAIN: call again; within a second or so, and at once after wake(). Else as open(), and it is
     * closed. NULL: open() has done it all. */
    int (*connect)(struct dx_device *dev, struct dx_err *err);
    int (*start)(struct dx_device *dev, struct dx_err *err);

    /* Waits for the next block. 0, or AGAIN, EOF, GONE, or negative: it is to be opened anew. A
     * device that is silent: AGAIN every 100 ms at the latest; a source whose time has not come:
     * every second. */
    int (*read)(struct dx_device *dev, struct dx_block *block, struct dx_err *err);
    /* Seconds that one read() may take though all is well: a large file on a slow disk. 0: it only
     * waits, as above. */
    uint32_t read_s;

    /* One block to parts. 0, CORRUPT, AGAIN (the sink is closing), or negative. */
    int (*decode)(struct dx_device *dev, const struct dx_block *block,
                  const struct dx_frame_sink *sink, struct dx_err *err);

    /* Before the first block of a recording that is decoded from its middle on: the geometry that
     * was in force there, told to the sink as decode() does. NULL: the driver makes it from its
     * configuration alone. Returns as decode(). */
    int (*adopt)(struct dx_device *dev, struct dx_geometry *g, uint8_t attr_bytes,
                 const struct dx_frame_sink *sink, struct dx_err *err);

    void (*stop)(struct dx_device *dev);
    void (*close)(struct dx_device *dev); /* NULL is fine */

    /* Makes a read() or connect() that waits return AGAIN at once. Any thread; async-signal-unsafe.
     */
    void (*wake)(struct dx_device *dev);

    /* ---- of drivers of devices; else NULL ---------------------------------------------------- */

    /* Is what `config` names on the network, where udev tells nothing? NULL: never. */
    bool (*is_remote)(const void *config);
    /* Nanoseconds without a block after which an open device counts as stalled: a few frames. */
    uint64_t (*silence_ns)(const struct dx_device *dev);
    void (*health)(const struct dx_device *dev, struct dx_device_health *out);
    /* Before start(): the stream's interlock, for the driver to poll (interlock.h); it
     * outlives the device. NULL: the driver has no laser that it can switch. */
    void (*guard)(struct dx_device *dev, const struct dx_interlock *interlock);
    /* Calls `found` for each device attached that the driver would take. Any thread; opens nothing
     * for longer than the call. 0, or negative with err. */
    int (*probe)(void (*found)(void *ctx, const struct dx_device_found *device), void *ctx,
                 struct dx_err *err);

    /* One line for people ("pump.ptx.gz: 1 frame, spinning 345x1074, rms 0.02 dexel"). */
    void (*describe)(struct dx_device *dev, char *text, size_t len);
};

/* The udev rule that grants the opening of a device's node, for people. */
void dx_device_rule(const char *node, char *text, size_t len);

/* Drivers of this build: NULL-terminated. */
extern const struct dx_driver *const dx_drivers[];
const struct dx_driver *dx_driver_find(const char *name);

#endif
