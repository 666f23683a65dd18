/* The camera's clock. */
#include "drivers/kinect/kinect_clock.h"

#include <math.h>

/* Before that much time the frames' way here, some milliseconds more or less, is seen in the rate.
 */
#define FIT_AFTER_NS UINT64_C(5000000000)
#define WRAP         4294967296.0
#define DOUBT_S      0.5

void dx_kinect_clock_init(struct dx_kinect_clock *c, double tick_hz)
{
    *c = (struct dx_kinect_clock){
        .tick_hz = tick_hz > 0 ? tick_hz : DX_KINECT_TICK_HZ,
        .fit = !(tick_hz > 0),
    };
}

/* Ticks since the newest frame: what the counter says, where it can be true. */
static double step_of(const struct dx_kinect_clock *c, uint32_t ticks, uint64_t passed_ns)
{
    double step = (uint32_t)(ticks - c->ticks);
    double expected = (double)passed_ns / 1e9 * c->tick_hz;
    /* A camera that was silent for longer than a wrap: the host knows how often. */
    double wraps = rint((expected - step) / WRAP);

    step += wraps > 0 ? wraps * WRAP : 0;
    if (fabs(step - expected) > DOUBT_S * c->tick_hz + expected / 4)
        return rint(expected); /* it began anew, or came damaged */
    return step;
}

uint64_t dx_kinect_clock_ns(struct dx_kinect_clock *c, uint32_t ticks, uint64_t host_ns)
{
    uint64_t passed_ns = host_ns > c->host_ns ? host_ns - c->host_ns : 0;

    if (c->any) {
        double step = step_of(c, ticks, passed_ns);

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
