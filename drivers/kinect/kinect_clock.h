/*
 * The camera's clock: 32 bits of ticks that wrap about every 71 s, at a rate that nobody has
 * published, unwrapped into nanoseconds since the first frame. Owned by one thread.
 */
#ifndef DX_KINECT_CLOCK_H
#define DX_KINECT_CLOCK_H

#include <stdbool.h>
#include <stdint.h>

#define DX_KINECT_TICK_HZ 60e6 /* about; measured by others */

struct dx_kinect_clock {
    double tick_hz;
    bool fit; /* measure the rate against the host's clock */
    bool any;
    uint32_t ticks; /* of the newest frame */
    uint64_t host_ns;
    uint64_t n_ticks, span_ns; /* since the first frame, of both clocks */
    double now_ns;
};

/* tick_hz 0: measured. */
void dx_kinect_clock_init(struct dx_kinect_clock *c, double tick_hz);
/* Of a frame that came at host_ns: nanoseconds of the device; never backwards. */
uint64_t dx_kinect_clock_ns(struct dx_kinect_clock *c, uint32_t ticks, uint64_t host_ns);

#endif
