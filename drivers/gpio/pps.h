/*
 * A pulse a second (of a GPS receiver) against the host's clocks: how far the host's second is from
 * the true one, and how fast CLOCK_MONOTONIC runs. Pure; owned by its rig.
 */
#ifndef DX_PPS_H
#define DX_PPS_H

#include <stdbool.h>
#include <stdint.h>

#define DX_PPS_WINDOW 16u

struct dx_pps {
    int64_t offset_ns[DX_PPS_WINDOW]; /* of each pulse: host's second minus the true one */
    uint64_t mono_ns[DX_PPS_WINDOW];
    uint64_t n; /* good pulses, since the last gap */
    uint64_t n_pulses, n_bad;
};

struct dx_pps_state {
    bool is_locked;    /* three good pulses at least, and the last one not long ago */
    int64_t offset_ns; /* CLOCK_REALTIME minus true time, -500 to 500 ms: median of the window */
    int64_t jitter_ns; /* the median distance from it */
    int64_t rate_ppb;  /* CLOCK_MONOTONIC is fast by so much */
};

void dx_pps_init(struct dx_pps *p);

/* A pulse at a time by both clocks. One that is not a whole number of seconds (within 0.05 %) after
 * the one before is a false one or follows one: left out, and the window begins anew after three.
 */
void dx_pps_pulse(struct dx_pps *p, uint64_t mono_ns, uint64_t real_ns);

void dx_pps_state(const struct dx_pps *p, uint64_t now_ns, struct dx_pps_state *out);

#endif
