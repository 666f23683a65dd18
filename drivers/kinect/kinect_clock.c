/* The camera's clock. */
#include "drivers/kinect/kinect_clock.h"

#include <math.h>

/* Before that much time the frames' way here, some milliseconds more or less, is seen in the rate.
 */
#define FIT_AFTER_NS UINT64_C(5000000000)
#define WRAP         4294967296.0

void dx_kinect_clock_init(struct dx_kinect_clock *c, double tick_hz)
{
    *c = (struct dx_kinect_clock){
        .tick_hz = tick_hz > 0 ? tick_hz : DX_KINECT_TICK_HZ,
        .fit = !(tick_hz > 0),
    };
}

uint64_t dx_kinect_clock_ns(struct dx_kinect_clock *c, uint32_t ticks, uint64_t host_ns)
{
    uint64_t passed_ns = host_ns > c->host_ns ? host_ns - c->host_ns : 0;
    double step = (uint32_t)(ticks - c->ticks), wraps;

    if (c->any) {
        /* A camera that was silent for longer than a wrap: the host knows how often. */
        wraps = rint(((double)passed_ns / 1e9 * c->tick_hz - step) / WRAP);
        step += wraps > 0 ? wraps * WRAP : 0;
        c->n_ticks += (uint64_t)step;
        c->span_ns += passed_ns;
        if (c->fit && c->span_ns >= FIT_AFTER_NS && c->n_ticks > 0)
            c->tick_hz = (double)c->n_ticks / ((double)c->span_ns / 1e9);
        c->now_ns += step / c->tick_hz * 1e9;
    }
    c->any = true;
    c->ticks = ticks;
    c->host_ns = host_ns;
    return (uint64_t)rint(c->now_ns);
}
