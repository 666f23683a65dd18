/*
 * The talk with a scanner, from the first byte to the stream of scans and through every trouble, as
 * a state machine: bytes and times go in, bytes to send and scans come out. It knows no device, no
 * clock and no thread, so tests drive it. Reader thread.
 *
 *   FLUSH (QT, silence) - [SCIP2] - VV - PP - II - TM0 TM1... TM2 - START (MD) - STREAM
 *   status 50-97: QT RS, a pause, FLUSH     0L: RB RB, a pause, FLUSH     no scan for 16 periods:
 * FLUSH
 */
#ifndef DX_SCIP_SESSION_H
#define DX_SCIP_SESSION_H

#include "drivers/backoff.h"
#include "drivers/hokuyo/scip_clock.h"
#include "drivers/hokuyo/scip_scan.h"

enum dx_scip_state {
    DX_SCIP_FLUSH,
    DX_SCIP_SCIP2,
    DX_SCIP_VV,
    DX_SCIP_PP,
    DX_SCIP_II,
    DX_SCIP_TM0,
    DX_SCIP_TM1,
    DX_SCIP_TM2,
    DX_SCIP_START,
    DX_SCIP_STREAM,
    DX_SCIP_FAULT_QT,
    DX_SCIP_FAULT_RS,
    DX_SCIP_REBOOT_1,
    DX_SCIP_REBOOT_2,
    DX_SCIP_PAUSE, /* before a new FLUSH */
    DX_SCIP_STOPPING,
    DX_SCIP_STOPPED,
    DX_SCIP_N_STATES,
};

/* What is asked of the scanner. */
struct dx_scip_want {
    bool intensity, echoes;
    int32_t first_step, last_step; /* -1: all that can be measured */
    uint32_t cluster;              /* steps to a value, from 1 */
    uint32_t skip;                 /* scans left out after each */
};

/* What is asked in fact, once PP is known. */
struct dx_scip_request {
    uint16_t first, last;
    uint8_t cluster, skip;
    char command[24]; /* "MD0000108001000" */
};

struct dx_scip_counts {
    uint64_t n_scans, n_bad;
    uint64_t n_lost; /* scans that were due and did not come */
    uint64_t n_restarts, n_resets;
};

/* A scan that has come whole. The bytes are the splitter's, until the next feed. */
struct dx_scip_scan {
    const uint8_t *bytes;
    size_t len;
    struct dx_scip_head head;
    uint64_t device_ns;  /* unwrapped: when step 0 was measured */
    uint64_t host_ns;    /* the same by the host's clock */
    uint64_t arrival_ns; /* its last byte */
    bool degraded;       /* while the scanner verifies an abnormality */
    bool unsure;         /* host_ns is: the clock was reset, and no time samples since */
};

/* The longest that a scanner may verify an abnormality, without a scan (statuses 21 to 49). */
#define DX_SCIP_MAX_SUSPENSION 30000000000ull

struct dx_scip_session {
    struct dx_scip_want want;
    enum dx_scip_state state;
    struct dx_scip_lines lines;
    uint8_t out[64];
    size_t out_len;
    uint64_t deadline_ns;      /* when tick() has something to do */
    unsigned tries;            /* of the command that is out */
    uint64_t sent_ns;          /* when it went out */
    unsigned n_times;          /* TM1 so far */
    uint64_t quiet_ns;         /* FLUSH: silence until then */
    bool saw_qt, is_old;       /* FLUSH: QT was answered; by SCIP 1.1 */
    unsigned n_silent;         /* restarts in a row without any answer */
    struct dx_backoff backoff; /* of faults */

    struct dx_scip_params params;
    struct dx_scip_identity identity;
    bool is_known; /* VV was answered */
    struct dx_scip_request request;
    struct dx_scip_clock clock;
    bool was_bad;       /* the reply before */
    unsigned n_bad_now; /* within the second that began at bad_ns */
    uint64_t bad_ns;
    uint64_t life_ns; /* STREAM: the last scan, or status */
    bool asked;       /* STREAM: II is out, for want of scans */
    bool suspended;   /* 21-49 until 98 */
    uint64_t run_from_ns;
    uint64_t last_device_ns;
    uint64_t n_bad_before;  /* counts.n_bad at that scan */
    uint32_t n_since_start; /* scans */

    bool scan_ready;
    struct dx_scip_scan scan;
    bool dead;        /* nothing answers: the link should be opened anew */
    char trouble[96]; /* of the talk; "": none */
    char stat[64];    /* the scanner's own, from II; "": it is well */
    struct dx_scip_counts counts;
};

/* `headroom`: bytes left free before a scan's. -ENOMEM. */
int dx_scip_session_init(struct dx_scip_session *s, const struct dx_scip_want *want,
                         size_t headroom, uint64_t now_ns);
void dx_scip_session_fini(struct dx_scip_session *s);

/* Takes bytes up to the end of a scan at most; returns how many. `scan_ready`: `scan` is one. */
size_t dx_scip_session_feed(struct dx_scip_session *s, const uint8_t *bytes, size_t len,
                            uint64_t now_ns);
/* To be called at deadline_ns or later. */
void dx_scip_session_tick(struct dx_scip_session *s, uint64_t now_ns);

/* What waits to be sent is out[0, out_len); `n` bytes of it went out. */
void dx_scip_session_sent(struct dx_scip_session *s, size_t n, uint64_t now_ns);

/* Ends the stream: QT; STOPPED when it was answered, or after three periods. */
void dx_scip_session_stop(struct dx_scip_session *s, uint64_t now_ns);

/* Values of a scan, and where they lie: value k is of step first + k cluster + (cluster - 1) / 2.
 */
uint32_t dx_scip_n_values(uint32_t first, uint32_t last, uint32_t cluster);

const char *dx_scip_state_name(enum dx_scip_state state);

#endif
