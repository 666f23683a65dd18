/*
 * Pacing of sources that have no device to wait for (recordings, simulated scenes): when is the
 * next frame due? Drift-free from the first frame's time; wakeable. Used by the reader thread; wake
 * from any.
 */
#ifndef DX_REPLAY_H
#define DX_REPLAY_H

#include <stdint.h>

struct dx_pace {
    double rate;       /* 1 real time, N times; 0 = as fast as possible */
    uint64_t start_ns; /* host time of stamp0_ns; 0 until the first wait */
    uint64_t stamp0_ns;
    int wake_fd; /* eventfd, -1 when not open */
};

/* Errors: -EINVAL (rate), from eventfd. */
int dx_pace_init(struct dx_pace *p, double rate);
void dx_pace_fini(struct dx_pace *p);
/* Waits until the frame stamped `stamp_ns` is due. 0 due; DX_DRIVER_E_AGAIN: woken, or not yet, and
 * half a second is over; negative errno. */
int dx_pace_wait(struct dx_pace *p, uint64_t stamp_ns);
/* Waits for a wake, or half a second: paused. DX_DRIVER_E_AGAIN; negative errno. */
int dx_pace_idle(struct dx_pace *p);
void dx_pace_wake(struct dx_pace *p);
/* Forget the start (loop, seek): the next wait is due at once. */
void dx_pace_restart(struct dx_pace *p);

#endif
