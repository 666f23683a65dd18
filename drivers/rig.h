/*
 * The GPIO lines of a stream besides its encoder: interlock and laser, trigger in and out, a pulse
 * a second, a status LED. A rig lives as long as its stream and has a thread of its own, so that
 * the laser goes off whatever the reader is at; lines that cannot be had, or are lost, are asked
 * for again every second, and until then the interlock counts as open. docs/drivers/gpio.md.
 */
#ifndef DX_RIG_H
#define DX_RIG_H

#include "core/base/err.h"
#include "drivers/gpio_line.h"
#include "drivers/interlock.h"

#include <stddef.h>

struct dx_gpio_bank;
struct dx_rig;

/* Lines are as in gpio_line.h; "" or NULL: there is none. */
struct dx_rig_config {
    struct {
        char *line;
        bool active_low; /* low means stop */
        enum dx_gpio_bias bias;
        uint32_t debounce_us; /* where the kernel can */
        uint32_t rearm_ms;    /* closed for so long before the laser may be on */
    } interlock;
    struct {
        char *line;
        bool active_low;
        double heartbeat_hz; /* 0: a level; else a square wave while it is on */
    } laser;
    struct {
        char *line;
        bool falling; /* the edge that counts; else the rising one */
        enum dx_gpio_bias bias;
        uint32_t max_delay_ms; /* from an edge to its frame */
        uint32_t min_gap_us;   /* edges closer than this are glitches */
    } trigger_in;
    struct {
        char *line;
        bool active_low;
        double hz; /* pulses a second while the source runs */
        uint32_t pulse_us;
    } trigger_out;
    struct {
        char *line; /* rising edge at the second */
    } pps;
    struct {
        char *line;
        bool active_low;
    } led;
};

/* Is there a line at all? */
bool dx_rig_is_wanted(const struct dx_rig_config *config);

#define DX_RIG_N_LINES 6
struct dx_rig_line {
    const char *key;   /* "interlock.line" */
    const char *where; /* gpio_line.h */
};
void dx_rig_list(const struct dx_rig_config *config, struct dx_rig_line lines[DX_RIG_N_LINES]);

/* NULL: it can be opened. Else what is wrong, and *key is the key at fault ("interlock.bias"). */
const char *dx_rig_check(const struct dx_rig_config *config, const char **key);

/* The configuration is borrowed. -EINVAL (the check), -ENOMEM, -EAGAIN (no thread): lines that are
 * not there are no error. */
int dx_rig_open(struct dx_rig **out, const struct dx_rig_config *config, struct dx_err *err);
/* The same on lines from elsewhere, for tests. */
int dx_rig_open_on(struct dx_rig **out, const struct dx_rig_config *config,
                   const struct dx_gpio_bank *bank, struct dx_err *err);

/* Laser, trigger and LED off, then the lines go. NULL is fine. */
void dx_rig_close(struct dx_rig *rig);

/* ---- any thread --------------------------------------------------------------------------------
 */

/* The source measures, or does not: the laser may be on while it does. Starts the pairing anew. */
void dx_rig_run(struct dx_rig *rig, bool runs);

/* The stream ends: as run(false), and for good. */
void dx_rig_end(struct dx_rig *rig);

enum dx_rig_show {
    DX_RIG_OFF = 0,
    DX_RIG_WAITING,  /* for the device */
    DX_RIG_LIVE,     /* frames come */
    DX_RIG_TROUBLE,  /* frames are doubtful, or do not come */
    DX_RIG_INTERLOCK /* shown by itself while it is open */
};
/* What the LED shows. */
void dx_rig_show(struct dx_rig *rig, enum dx_rig_show show);

/* NULL: the rig has none. As long as the rig. */
const struct dx_interlock *dx_rig_interlock(const struct dx_rig *rig);

/* Is there a trigger line for frames? */
bool dx_rig_pairs(const struct dx_rig *rig);

/* The time (CLOCK_MONOTONIC) of the trigger edge of a frame that came at `arrival_ns`, behind
 * `n_missed` frames that never came. False: there is no trigger line, or no edge for it. */
bool dx_rig_frame(struct dx_rig *rig, uint64_t arrival_ns, uint64_t n_missed, uint64_t *edge_ns);

/* Why what comes is doubtful, or does not come; "": it is not. */
void dx_rig_trouble(struct dx_rig *rig, char *text, size_t len);

struct dx_rig_status {
    bool has_lines;        /* they are ours now */
    bool is_laser_on;      /* is asked to be */
    uint64_t n_openings;   /* of the interlock */
    uint64_t n_edges;      /* of trigger in */
    uint64_t n_pairs;      /* frames with an edge */
    uint64_t n_unpaired;   /* frames without one */
    uint64_t n_resyncs;    /* times that the pairs were sought anew */
    uint64_t n_triggers;   /* pulses of trigger out */
    bool is_pps_locked;    /* what follows holds */
    int64_t pps_offset_ns; /* CLOCK_REALTIME minus true time */
    int64_t pps_jitter_ns; /* of that */
    int64_t pps_rate_ppb;  /* CLOCK_MONOTONIC is fast by so much */
};
void dx_rig_tell(struct dx_rig *rig, struct dx_rig_status *status);

#endif
