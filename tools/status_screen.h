/*
 * The screen of `dexel status --watch`: one status of a service, and what has changed since the one
 * before it, as lines for a terminal of a given size. Writes no byte that is not meant for it,
 * whatever is in the status.
 */
#ifndef DX_STATUS_SCREEN_H
#define DX_STATUS_SCREEN_H

#include <jansson.h>
#include <stdbool.h>
#include <stdio.h>

struct dx_status_screen {
    unsigned columns, rows;
    bool colours;
    const char *trouble; /* why there is no newer status; NULL: there is */
};

/* From the top left corner to the end of the screen. `before` may be NULL: no rates then. */
void dx_status_screen_put(FILE *out, const struct dx_status_screen *s, const json_t *now,
                          const json_t *before);

#endif
