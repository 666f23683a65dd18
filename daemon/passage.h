/*
 * When the newest data of an epoch passed the stations on its way from the device to the feed, on
 * the daemon's clock. The mesher fills it in and hands it over with the epoch; the loop makes
 * latencies of it.
 */
#ifndef DX_PASSAGE_H
#define DX_PASSAGE_H

#include <stdint.h>

struct dx_passage {
    uint64_t read_ns;      /* its bytes came; 0: not known, and nothing of this is */
    uint64_t delivered_ns; /* decoded, in the mailbox */
    uint64_t taken_ns;     /* by the mesher */
    uint64_t meshed_ns;
    uint64_t published_ns; /* its chunks are made, and the loop is told */
};

/* The stages between the stations, and the last one, from there until the kernel has the COMMIT. */
enum dx_stage {
    DX_STAGE_DECODE,
    DX_STAGE_WAIT,
    DX_STAGE_MESH,
    DX_STAGE_ENCODE,
    DX_STAGE_SEND,
    DX_N_STAGES,
};

#endif
