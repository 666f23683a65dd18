/* Which scanners are simulated, and what may be wrong with them. */
#ifndef SCIP_MODELS_H
#define SCIP_MODELS_H

#include <stdbool.h>
#include <stdint.h>

struct scip_model {
    const char *name;
    uint32_t ares, amin, amax, afrt, dmin, dmax, rpm;
    bool is_old; /* starts in SCIP 1.1 */
    bool echoes;
};

static const struct scip_model scip_models[] = {
    {"urg-04lx", 1024, 44, 725, 384, 20, 5600, 600, true, false},
    {"ubg-05lx", 1024, 44, 725, 384, 20, 5600, 2142, false, false},
    {"utm-30lx", 1440, 0, 1080, 540, 23, 60000, 2400, false, false},
    {"utm-30lx-ew", 1440, 0, 1080, 540, 23, 60000, 2400, false, true},
    {"ust-20lx", 1440, 0, 1080, 540, 20, 60000, 2400, false, false},
};

/* Faults; each scan, byte and command is counted from 1, 0: never. */
struct scip_faults {
    uint64_t bad_sum_every; /* every so many scans, a wrong check character ... */
    unsigned bad_sum_line;  /* ... in this data line */
    uint64_t drop_every,
        double_every;                 /* every so many bytes of scans one is lost, or comes twice */
    unsigned code_every;              /* every so many steps hold the code of an error */
    bool stale;                       /* it streams when it is opened */
    bool mute;                        /* answers nothing */
    uint64_t suspend_at, suspend_for; /* scan: status 21, then 98 after so many scans */
    uint64_t fault_at;                /* scan: status 51, and the stream ends */
    uint64_t abnormal_at;             /* scan: 0L to everything until it is rebooted */
    uint64_t busy_at;                 /* command: answered 0B */
    bool no_time;                     /* TM is refused */
    bool no_serial;                   /* VV tells no SERI */
};

#endif
