/*
 * One scan: the reply of MD, MS, ME, ND or NE with status 99 (of GD and the like: 00), to ranges.
 * What a scanner sent is not trusted. Pure functions.
 */
#ifndef DX_SCIP_SCAN_H
#define DX_SCIP_SCAN_H

#include "drivers/hokuyo/scip_params.h"

#include "core/base/err.h"

#define DX_SCIP_MAX_ECHOES 3

/* Which of several echoes of one step counts. */
enum dx_scip_echo { DX_SCIP_FIRST = 0, DX_SCIP_LAST = 1, DX_SCIP_STRONGEST = 2 };

/* How values are written. */
struct dx_scip_format {
    uint8_t chars;  /* 2 or 3 of a distance */
    bool intensity; /* three more behind each */
    bool echoes;    /* several to a step, joined by '&' */
};

/* What a scan is, from its first three lines. */
struct dx_scip_head {
    uint16_t status; /* its two characters: "99" is 0x3939 */
    uint32_t stamp_ms;
    struct dx_scip_cursor data; /* the lines behind it */
};

/* Counts of what a scan held. */
struct dx_scip_tally {
    uint32_t n_returns;
    uint32_t n_near; /* below DMIN: the code of a reason */
    uint32_t n_far;  /* beyond DMAX */
};

/* The format that a request's first two characters ask for. False: unknown. */
bool dx_scip_format_of(struct dx_scip_format *f, const uint8_t command[2]);

/* Status of a reply; 0 when its line is damaged. */
uint16_t dx_scip_status(const uint8_t *line, size_t len);

/* Whether echo, status, stamp and every data line are whole. */
bool dx_scip_scan_check(struct dx_scip_head *head, const uint8_t *reply, size_t len);

/*
 * The values of a checked scan: `n` millimetres (0: no return), `reason` (the code; 0 where there
 * is a return) and, when the format has it, intensities up to 65535. Any output but range_mm may be
 * NULL. -EBADMSG with a text: not `n` values, or no numbers.
 */
int dx_scip_scan_decode(uint32_t *range_mm, uint8_t *reason, uint16_t *intensity, uint32_t n,
                        struct dx_scip_tally *tally, const struct dx_scip_params *params,
                        const struct dx_scip_format *format, enum dx_scip_echo choice,
                        struct dx_scip_cursor data, struct dx_err *err);

/* Why a step has no return, for people. */
const char *dx_scip_reason_text(enum dx_scip_class class, uint8_t reason);

#endif
