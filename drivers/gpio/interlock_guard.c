/* When the laser may be on. */
#include "drivers/gpio/interlock_guard.h"

void dx_interlock_guard_init(struct dx_interlock_guard *g, uint64_t rearm_ns, uint64_t now_ns)
{
    *g = (struct dx_interlock_guard){.rearm_ns = rearm_ns, .is_open = true, .since_ns = now_ns};
}

static bool open_it(struct dx_interlock_guard *g, enum dx_guard_cause cause, uint64_t t_ns)
{
    bool was_open = g->is_open;

    g->is_contact_closed = false;
    if (was_open) {
        /* never closed yet stays the reason until something is known */
        g->cause = g->cause == DX_GUARD_START && cause == DX_GUARD_CONTACT ? DX_GUARD_START : cause;
        return false;
    }
    g->is_open = true;
    g->cause = cause;
    g->since_ns = t_ns;
    g->n_openings++;
    return true;
}

bool dx_interlock_guard_contact(struct dx_interlock_guard *g, bool is_closed, uint64_t t_ns)
{
    if (!is_closed)
        return open_it(g, DX_GUARD_CONTACT, t_ns);
    if (!g->is_contact_closed) {
        g->is_contact_closed = true;
        g->closed_since_ns = t_ns;
    }
    if (!g->is_open || t_ns < g->closed_since_ns || t_ns - g->closed_since_ns < g->rearm_ns)
        return false;
    g->is_open = false;
    g->since_ns = t_ns;
    return true;
}

bool dx_interlock_guard_break(struct dx_interlock_guard *g, uint64_t t_ns)
{
    return open_it(g, DX_GUARD_CONTACT, t_ns);
}

bool dx_interlock_guard_fault(struct dx_interlock_guard *g, uint64_t now_ns)
{
    return open_it(g, DX_GUARD_FAULT, now_ns);
}

uint64_t dx_interlock_guard_due(const struct dx_interlock_guard *g)
{
    return g->is_open && g->is_contact_closed ? g->closed_since_ns + g->rearm_ns : UINT64_MAX;
}
