/*
 * Whether a scanner's laser may be on, as the contacts of its rig say. Polled by the driver of a
 * line scanner (reader thread), between blocks and at the latest every 100 ms; who keeps it up to
 * date is behind the table. Does not replace contacts in the laser's own supply:
 * docs/drivers/gpio.md.
 *
 * While it is open the driver has the scanner switch its laser off, read() gives AGAIN, and
 * health() has the text as its trouble.
 */
#ifndef DX_INTERLOCK_H
#define DX_INTERLOCK_H

#include <stdbool.h>
#include <stdint.h>

struct dx_interlock_state {
    bool is_open;        /* laser off: a contact is open, or it cannot be known */
    uint64_t since_ns;   /* CLOCK_MONOTONIC, of the last change */
    uint64_t n_openings; /* since the start of the stream */
    char text[96];       /* why it is open; "" */
};

struct dx_interlock {
    void (*state)(const struct dx_interlock *interlock, struct dx_interlock_state *out);
};

/* Without an interlock (NULL) nothing is open. */
static inline bool dx_interlock_is_open(const struct dx_interlock *interlock,
                                        struct dx_interlock_state *out)
{
    *out = (struct dx_interlock_state){0};
    if (interlock)
        interlock->state(interlock, out);
    return out->is_open;
}

#endif
