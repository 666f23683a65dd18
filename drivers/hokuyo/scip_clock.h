/*
 * The scanner's clock (24 bits of milliseconds, DEVICES 1.7) and the host's: which host time is a
 * device's stamp? Stamps are unwrapped by the host's time that has passed; one that does not fit
 * means that the scanner has been reset. The offset comes from time samples taken before streaming,
 * and follows the crystals' drift by the lower envelope of the scans' arrivals. All times are
 * given, none is asked for. Reader thread.
 */
#ifndef DX_SCIP_CLOCK_H
#define DX_SCIP_CLOCK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define DX_SCIP_WRAP_MS     (1u << 24)
#define DX_SCIP_MAX_SAMPLES 32
#define DX_SCIP_N_BUCKETS   10 /* of one second each: the window of the envelope */

/* An exchange of TM1. */
struct dx_scip_time_sample {
    uint64_t sent_ns, got_ns; /* host */
    uint64_t device_ns;
};

struct dx_scip_clock {
    /* unwrapping */
    bool running;
    uint32_t last_ms;
    uint64_t last_host_ns, device_ms; /* of the last stamp; device_ms counts on over wraps */
    /* offset: host = device + offset */
    bool have_offset, is_sampled; /* is_sampled: from samples, not from arrivals alone */
    int64_t offset_ns;
    struct dx_scip_time_sample sample[DX_SCIP_MAX_SAMPLES];
    unsigned n_samples;
    /* lower envelope of arrival - device: a minimum for each second */
    bool have_reference;
    int64_t reference_ns; /* the envelope when the offset was true */
    uint64_t bucket_s;    /* the second that is being filled */
    int64_t bucket[DX_SCIP_N_BUCKETS];
    unsigned n_buckets, at; /* `at`: the one that is being filled */
};

void dx_scip_clock_init(struct dx_scip_clock *c);

/* A stamp that came at host_ns, counted on over wraps, in nanoseconds. *reset: the scanner's clock
 * began anew (a restart): what was known of the offset is void. */
uint64_t dx_scip_clock_unwrap(struct dx_scip_clock *c, uint32_t stamp_ms, uint64_t host_ns,
                              bool *reset);

void dx_scip_clock_sample(struct dx_scip_clock *c, uint64_t sent_ns, uint64_t got_ns,
                          uint64_t device_ns);
/* The offset from the samples: the median of the quarter with the shortest exchanges. False: there
 * are none. */
bool dx_scip_clock_settle(struct dx_scip_clock *c);

/* A scan whose last byte came at arrival_ns; `due_ns` is the device's time when it could come at
 * the earliest (stamp, sweep, transfer). */
void dx_scip_clock_arrival(struct dx_scip_clock *c, uint64_t due_ns, uint64_t arrival_ns);

/* Host time of a device's. Before any sample or arrival: the device's own. */
uint64_t dx_scip_clock_host(const struct dx_scip_clock *c, uint64_t device_ns);

#endif
