/* GPIO lines and the life of a device. */
#include "daemon/reader_rig.h"

#include <stdio.h>
#include <string.h>

#define RESUME_NS 5000000000u /* for a scanner to measure again when the interlock is closed */

void dx_reader_rig_open(struct dx_rig *rig, const struct dx_driver *driver,
                        struct dx_device *device)
{
    if (!rig)
        return;
    if (driver->guard)
        driver->guard(device, dx_rig_interlock(rig));
    dx_rig_run(rig, true);
}

void dx_reader_rig_close(struct dx_rig *rig)
{
    if (rig)
        dx_rig_run(rig, false);
}

void dx_reader_rig_stamp(struct dx_rig *rig, const struct dx_driver *driver,
                         struct dx_device *device, uint64_t *n_lost, struct dx_block *block)
{
    struct dx_device_health h = {0};
    uint64_t edge_ns, n_missed;

    if (!rig || !dx_rig_pairs(rig))
        return;
    driver->health(device, &h);
    n_missed = h.n_lost > *n_lost ? h.n_lost - *n_lost : 0; /* it may count anew */
    *n_lost = h.n_lost;
    if (dx_rig_frame(rig, block->stamp.host_ns, n_missed, &edge_ns)) {
        block->stamp.device_ns = edge_ns;
        block->stamp.clock_id = DX_CLOCK_MONOTONIC;
    }
}

void dx_reader_rig_trouble(struct dx_rig *rig, struct dx_device_health *health)
{
    char text[sizeof(health->trouble)];

    if (!rig)
        return;
    dx_rig_trouble(rig, text, sizeof(text));
    if (*text)
        memcpy(health->trouble, text, sizeof(text));
}

void dx_reader_rig_show(struct dx_rig *rig, enum dx_life_state state, bool has_trouble)
{
    if (!rig)
        return;
    switch (state) {
    case DX_LIFE_STREAMING:
        dx_rig_show(rig, has_trouble ? DX_RIG_TROUBLE : DX_RIG_LIVE);
        break;
    case DX_LIFE_STALLED:
    case DX_LIFE_FAULTED:
        dx_rig_show(rig, DX_RIG_TROUBLE);
        break;
    default:
        dx_rig_show(rig, DX_RIG_WAITING);
    }
}

bool dx_reader_rig_holds(struct dx_rig *rig, uint64_t now_ns, char text[96])
{
    struct dx_interlock_state s;
    const struct dx_interlock *interlock = rig ? dx_rig_interlock(rig) : NULL;
    bool is_open = dx_interlock_is_open(interlock, &s);

    snprintf(text, 96, "%s", s.text);
    return is_open || (interlock && s.n_openings > 0 && now_ns < s.since_ns + RESUME_NS);
}
