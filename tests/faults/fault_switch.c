/*
 * Faults for tests: $DEXELD_FAULT is "hang-loop", "hang-open", "hang-reader", "hang-mesher" or
 * "hang-recorder", with ":N" behind it to strike at the N-th time that the place is come by (1).
 * The thread then sleeps until the process is killed. Any thread.
 */
#include "daemon/fault.h"

#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char *const names[] = {
    [DX_FAULT_LOOP] = "hang-loop",         [DX_FAULT_OPEN] = "hang-open",
    [DX_FAULT_READER] = "hang-reader",     [DX_FAULT_MESHER] = "hang-mesher",
    [DX_FAULT_RECORDER] = "hang-recorder",
};

static _Atomic unsigned long n_passed[sizeof(names) / sizeof(*names)];

/* At which passing of the place the fault strikes; 0: never. */
static unsigned long strikes_at(enum dx_fault_place place)
{
    const char *wanted = getenv("DEXELD_FAULT");
    size_t len = strlen(names[place]);

    if (!wanted || strncmp(wanted, names[place], len) != 0)
        return 0;
    return wanted[len] == ':' ? strtoul(wanted + len + 1, NULL, 10) : 1;
}

void dx_fault_point(enum dx_fault_place place)
{
    unsigned long at = strikes_at(place);

    if (at == 0 || atomic_fetch_add(&n_passed[place], 1) + 1 != at)
        return;
    fprintf(stderr, "fault: %s\n", names[place]);
    for (;;)
        pause();
}
