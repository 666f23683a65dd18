/*
 * The raw block of a scan: a header with all that decoding must know, the stage's angles, then the
 * scanner's own bytes. Little-endian. Pure functions; reading trusts nothing.
 */
#ifndef DX_SCIP_BLOCK_H
#define DX_SCIP_BLOCK_H

#include "drivers/angle.h"
#include "drivers/hokuyo/scip_scan.h"

#define DX_SCIP_BLOCK_HEADER 128
#define DX_SCIP_BLOCK_SAMPLE 24
#define DX_SCIP_BLOCK_ANGLES 1024 /* at most */
/* Free bytes that a block's head takes before the scan. */
#define DX_SCIP_BLOCK_HEADROOM                                                                     \
    (DX_SCIP_BLOCK_HEADER + (size_t)DX_SCIP_BLOCK_ANGLES * DX_SCIP_BLOCK_SAMPLE)

#define DX_SCIP_BLOCK_DEGRADED 1u /* while the scanner verified an abnormality */
#define DX_SCIP_BLOCK_UNSURE   2u /* host_ns: no time samples since the scanner's clock was reset */

struct dx_scip_block {
    uint32_t flags;
    uint16_t status; /* of the scan: "99" */
    struct dx_scip_params params;
    uint16_t first, last; /* steps */
    uint8_t cluster, skip;
    uint8_t command[2];  /* "MD" */
    uint64_t device_ns;  /* unwrapped: when step 0 was measured */
    uint64_t host_ns;    /* the same by the host's clock, as it was mapped then */
    uint64_t arrival_ns; /* host: the last byte */
    char serial[16];     /* cut */
    uint32_t n_angles;
    const uint8_t *angles; /* n_angles samples: dx_scip_block_angle() */
    const uint8_t *scan;
    size_t scan_len;
};

/* Writes header and angles right before `scan` (there must be room for them); returns where the
 * block begins. b->scan, scan_len and angles are not read. */
uint8_t *dx_scip_block_put(uint8_t *scan, size_t scan_len, const struct dx_scip_block *b,
                           const struct dx_angle_sample *angles, size_t n_angles, size_t *len);

/* -EBADMSG with a text (what, and at which byte): no such block. What it holds makes sense then. */
int dx_scip_block_get(struct dx_scip_block *b, const uint8_t *bytes, size_t len,
                      struct dx_err *err);

struct dx_angle_sample dx_scip_block_angle(const struct dx_scip_block *b, size_t k);

#endif
