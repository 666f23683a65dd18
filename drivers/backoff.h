/*
 * Waits between attempts that fail: 1, 2, 4, 8, 16, 30, 30 ... seconds, and from the beginning when
 * all has been well for a while, which its owner judges. Zeroed, the series begins.
 */
#ifndef DX_BACKOFF_H
#define DX_BACKOFF_H

#include <stdint.h>

#define DX_BACKOFF_MAX_S 30

struct dx_backoff {
    uint32_t wait_s; /* the last one; 0: the series begins */
};

/* The next wait, in nanoseconds. */
static inline uint64_t dx_backoff_next(struct dx_backoff *b)
{
    uint32_t twice_s = 2 * b->wait_s;

    b->wait_s = b->wait_s == 0 ? 1 : twice_s < DX_BACKOFF_MAX_S ? twice_s : DX_BACKOFF_MAX_S;
    return b->wait_s * UINT64_C(1000000000);
}

static inline void dx_backoff_reset(struct dx_backoff *b)
{
    b->wait_s = 0;
}

#endif
