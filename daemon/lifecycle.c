/* The life of a device. */
#include "daemon/lifecycle.h"

#define SECOND_NS 1000000000u

static uint64_t least(uint64_t a, uint64_t b)
{
    return a < b ? a : b;
}

static uint64_t most(uint64_t a, uint64_t b)
{
    return a > b ? a : b;
}

static void go(struct dx_life *l, enum dx_life_state state, uint64_t now_ns)
{
    if (l->state == state)
        return;
    l->state = state;
    l->since_ns = now_ns;
}

void dx_life_init(struct dx_life *l, uint64_t now_ns)
{
    *l = (struct dx_life){.state = DX_LIFE_OPENING, .since_ns = now_ns, .due_ns = now_ns};
}

enum dx_life_step dx_life_step(struct dx_life *l, uint64_t now_ns)
{
    if (l->is_open)
        return DX_LIFE_READ;
    if (now_ns < l->due_ns)
        return DX_LIFE_WAIT;
    l->tried_ns = now_ns; /* the state stays until it is open: a look shows nobody anything */
    return DX_LIFE_OPEN;
}

void dx_life_expect(struct dx_life *l, uint64_t silence_ns)
{
    l->silence_ns = silence_ns ? silence_ns : SECOND_NS;
}

void dx_life_opened(struct dx_life *l, uint64_t silence_ns, uint64_t now_ns)
{
    l->is_open = l->was_there = true;
    dx_life_expect(l, silence_ns);
    l->heard_ns = now_ns;
    go(l, DX_LIFE_OPENING, now_ns);
}

static void leave(struct dx_life *l, enum dx_life_state state, uint64_t now_ns)
{
    l->is_open = false;
    go(l, state, now_ns);
    if (state == DX_LIFE_ABSENT)
        l->due_ns = now_ns + DX_LIFE_LOOK_NS;
    else
        l->due_ns = now_ns + dx_backoff_next(&l->backoff);
}

static void hear(struct dx_life *l, uint64_t now_ns)
{
    if (!l->is_open)
        return;
    if (l->state != DX_LIFE_STREAMING)
        l->steady_ns = now_ns;
    go(l, DX_LIFE_STREAMING, now_ns);
    l->heard_ns = now_ns;
    if (now_ns - l->steady_ns >= DX_LIFE_HEALTHY_NS)
        dx_backoff_reset(&l->backoff);
}

static void miss(struct dx_life *l, uint64_t now_ns)
{
    uint64_t patience = l->silence_ns;

    if (!l->is_open)
        return;
    if (l->state == DX_LIFE_OPENING)
        patience = most(patience, DX_LIFE_FIRST_NS);
    if (l->state != DX_LIFE_STALLED && now_ns - l->heard_ns >= patience)
        go(l, DX_LIFE_STALLED, now_ns);
    else if (l->state == DX_LIFE_STALLED &&
             now_ns - l->since_ns >= most(DX_LIFE_REOPEN_NS, l->silence_ns))
        leave(l, DX_LIFE_FAULTED, now_ns);
}

/* A device that fails may make presence poke by itself, so pokes do not undo the waits after
 * faults; but who replugs it should not have to wait for long. */
static void look_sooner(struct dx_life *l, uint64_t now_ns)
{
    uint64_t pause = DX_LIFE_PAUSE_NS;

    if (l->is_open)
        return;
    if (l->state == DX_LIFE_FAULTED) {
        if (l->was_cut && now_ns - l->cut_ns < DX_LIFE_CUT_NS)
            return;
        l->was_cut = true;
        l->cut_ns = now_ns;
        pause = SECOND_NS;
    }
    l->due_ns = least(l->due_ns, most(now_ns, l->tried_ns + pause));
}

void dx_life_tell(struct dx_life *l, enum dx_life_event event, uint64_t now_ns)
{
    switch (event) {
    case DX_LIFE_NOT_THERE:
    case DX_LIFE_WENT:
        leave(l, l->was_there ? DX_LIFE_GONE : DX_LIFE_ABSENT, now_ns);
        break;
    case DX_LIFE_FAILED:
        leave(l, DX_LIFE_FAULTED, now_ns);
        break;
    case DX_LIFE_BLOCK:
        hear(l, now_ns);
        break;
    case DX_LIFE_QUIET:
        miss(l, now_ns);
        break;
    case DX_LIFE_POKE:
        look_sooner(l, now_ns);
        break;
    }
}

const char *dx_life_state_name(enum dx_life_state state)
{
    static const char *const names[] = {"absent",  "opening", "streaming",
                                        "stalled", "faulted", "gone"};

    return names[state];
}
