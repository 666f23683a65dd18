/* Patterns of a status LED: eighths of their period, lit or not. */
#include "drivers/gpio/led.h"

#define MS 1000000u

struct pattern {
    uint32_t period_ms; /* 0: always as the first */
    uint8_t lit;        /* a bit for each eighth, the lowest first */
};

static const struct pattern patterns[] = {
    [DX_RIG_OFF] = {0, 0x00},
    [DX_RIG_WAITING] = {2000, 0x01}, /* a blink every two seconds */
    [DX_RIG_LIVE] = {0, 0xff},
    [DX_RIG_TROUBLE] = {500, 0x0f},    /* fast */
    [DX_RIG_INTERLOCK] = {1600, 0x05}, /* twice, then a pause */
};

bool dx_led_is_lit(enum dx_rig_show show, uint64_t now_ns, uint64_t *until_ns)
{
    const struct pattern *p = &patterns[show];
    uint64_t eighth_ns = (uint64_t)p->period_ms * MS / 8, k;

    *until_ns = UINT64_MAX;
    if (!eighth_ns)
        return p->lit & 1;
    k = now_ns / eighth_ns;
    *until_ns = (k + 1) * eighth_ns;
    return p->lit >> (k % 8) & 1;
}
