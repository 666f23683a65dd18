/* How far a command is, on one line of standard error that is written again and again. Switched
 * off, nothing is written. One thread. */
#ifndef DX_PROGRESS_H
#define DX_PROGRESS_H

#include <stdbool.h>
#include <stdint.h>

struct dx_progress {
    bool on, shown;
    const char *stage;
    uint64_t last_ns;
};

/* On where standard error is a terminal, or where it is asked for. */
void dx_progress_init(struct dx_progress *p, bool asked);

/* What is being done from now on: "reading". The text is the caller's and stays there. */
void dx_progress_stage(struct dx_progress *p, const char *stage);

/* How much of it is done, 0 to 1. Ten times a second at most something is written; to call it
 * for every thousandth step is often enough. */
void dx_progress_share(struct dx_progress *p, double share);

/* Takes the line away, before other text and in the end. */
void dx_progress_clear(struct dx_progress *p);

#endif
