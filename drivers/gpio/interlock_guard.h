/*
 * The interlock's rule: it opens at once, by a level, an edge or a fault, and closes only when the
 * contact has been closed without a break for a while. Pure; owned by its rig.
 */
#ifndef DX_INTERLOCK_GUARD_H
#define DX_INTERLOCK_GUARD_H

#include <stdbool.h>
#include <stdint.h>

enum dx_guard_cause {
    DX_GUARD_START = 0, /* never closed yet */
    DX_GUARD_CONTACT,   /* the contact opened */
    DX_GUARD_FAULT,     /* the line cannot be read */
};

struct dx_interlock_guard {
    uint64_t rearm_ns;
    bool is_open, is_contact_closed;
    enum dx_guard_cause cause; /* why it is open */
    uint64_t closed_since_ns;  /* the contact */
    uint64_t since_ns;         /* is_open */
    uint64_t n_openings;
};

/* Open, for the time being. */
void dx_interlock_guard_init(struct dx_interlock_guard *g, uint64_t rearm_ns, uint64_t now_ns);

/* The contact is seen to be closed or open, at a time. True: the interlock has opened or closed. */
bool dx_interlock_guard_contact(struct dx_interlock_guard *g, bool is_closed, uint64_t t_ns);

/* The contact was open for a moment: an edge says so, though its level may be back. */
bool dx_interlock_guard_break(struct dx_interlock_guard *g, uint64_t t_ns);

/* Nobody knows. */
bool dx_interlock_guard_fault(struct dx_interlock_guard *g, uint64_t now_ns);

/* When a level is to be told at the latest so that it closes in time; UINT64_MAX: it need not. */
uint64_t dx_interlock_guard_due(const struct dx_interlock_guard *g);

#endif
