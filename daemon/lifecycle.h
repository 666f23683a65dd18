/*
 * The life of a device under a stream: one state machine for all drivers, without a clock, a thread
 * or a device of its own. Its owner does what dx_life_step() says and tells what came of it; times
 * are the owner's, in nanoseconds, and never go back.
 */
#ifndef DX_LIFECYCLE_H
#define DX_LIFECYCLE_H

#include "drivers/backoff.h"

#include <stdbool.h>
#include <stdint.h>

#define DX_LIFE_LOOK_NS    30000000000u /* an absent device is looked for so often in any case */
#define DX_LIFE_PAUSE_NS   50000000u    /* between two looks, however often presence pokes */
#define DX_LIFE_HEALTHY_NS 10000000000u /* of streaming, and the series of waits begins anew */
#define DX_LIFE_FIRST_NS   5000000000u  /* for the first block after the opening, at least */
#define DX_LIFE_REOPEN_NS  5000000000u  /* of silence after a stall was told, at least */
#define DX_LIFE_CUT_NS     10000000000u /* a poke may cut the wait after a fault so often */

enum dx_life_state {
    DX_LIFE_ABSENT,    /* has not been there yet; looked for when presence pokes */
    DX_LIFE_OPENING,   /* first look, or opened and no block yet */
    DX_LIFE_STREAMING, /* blocks come */
    DX_LIFE_STALLED,   /* open and silent */
    DX_LIFE_FAULTED,   /* it is there, and failed; opened anew after a wait */
    DX_LIFE_GONE,      /* it was there; looked for after a wait, and when presence pokes */
};

enum dx_life_event {
    DX_LIFE_NOT_THERE, /* of opening: no such device */
    DX_LIFE_FAILED,    /* of opening or reading */
    DX_LIFE_WENT,      /* of reading: it was unplugged */
    DX_LIFE_BLOCK,     /* of reading */
    DX_LIFE_QUIET,     /* of reading: nothing yet */
    DX_LIFE_POKE,      /* presence saw something come, go or change; any number of them */
};

enum dx_life_step {
    DX_LIFE_OPEN, /* open it, and call dx_life_opened(), or say NOT_THERE or FAILED */
    DX_LIFE_READ, /* read, and say BLOCK, QUIET, WENT or FAILED */
    DX_LIFE_WAIT, /* it is closed; until due_ns, or a poke */
};

struct dx_life {
    enum dx_life_state state;
    uint64_t since_ns; /* in this state */
    uint64_t due_ns;   /* closed: when to open */
    bool is_open;      /* false: what was open is to be closed */

    uint64_t silence_ns; /* of this stay */
    uint64_t heard_ns;   /* the last block, or the opening */
    uint64_t steady_ns;  /* streaming without a break since */
    uint64_t tried_ns;   /* the last opening */
    uint64_t cut_ns;     /* the last wait that was cut */
    bool was_there, was_cut;
    struct dx_backoff backoff; /* of the waits after faults, and when it has gone */
};

void dx_life_init(struct dx_life *l, uint64_t now_ns);
enum dx_life_step dx_life_step(struct dx_life *l, uint64_t now_ns);
/* It is open; counts as stalled after `silence_ns` without a block (0: one second). */
void dx_life_opened(struct dx_life *l, uint64_t silence_ns, uint64_t now_ns);
/* Another silence from now on: the device has told its rate. */
void dx_life_expect(struct dx_life *l, uint64_t silence_ns);
void dx_life_tell(struct dx_life *l, enum dx_life_event event, uint64_t now_ns);

const char *dx_life_state_name(enum dx_life_state state);

#endif
