/*
 * Which source a thread is opening, for another one that is asked meanwhile: a disk that does not
 * answer holds the first, and somebody must be told. A lock, held to copy a text.
 */
#ifndef DX_OPENING_H
#define DX_OPENING_H

#include "daemon/config.h"

#include <pthread.h>

#define DX_OPENING_LATE_NS 2000000000u /* an opening that takes longer is told of */

/* A stream and, if it reads files, their name. */
struct dx_opening_now {
    char stream[64]; /* "": none is being opened */
    char text[256];  /* "NAME: PATH" or "NAME" */
};

struct dx_opening {
    pthread_mutex_t lock;
    struct dx_opening_now now;
};

void dx_opening_init(struct dx_opening *p);
void dx_opening_fini(struct dx_opening *p);

/* This one is being opened from here on; NULL: none. */
void dx_opening_set(struct dx_opening *p, const struct dx_stream_config *c);

struct dx_opening_now dx_opening_get(struct dx_opening *p);

#endif
