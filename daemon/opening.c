/* Texts under a lock: what they are made of may be freed at any time. */
#include "daemon/opening.h"

#include <stdio.h>
#include <string.h>

void dx_opening_init(struct dx_opening *p)
{
    pthread_mutex_init(&p->lock, NULL);
    p->now = (struct dx_opening_now){0};
}

void dx_opening_fini(struct dx_opening *p)
{
    pthread_mutex_destroy(&p->lock);
}

void dx_opening_set(struct dx_opening *p, const struct dx_stream_config *c)
{
    struct dx_opening_now now = {0};

    if (c) {
        bool has_files = !strcmp(c->driver, "file");

        snprintf(now.stream, sizeof(now.stream), "%s", c->name);
        snprintf(now.text, sizeof(now.text), "%.63s%s%.180s", c->name, has_files ? ": " : "",
                 has_files ? c->source.file.path : "");
    }
    pthread_mutex_lock(&p->lock);
    p->now = now;
    pthread_mutex_unlock(&p->lock);
}

struct dx_opening_now dx_opening_get(struct dx_opening *p)
{
    struct dx_opening_now now;

    pthread_mutex_lock(&p->lock);
    now = p->now;
    pthread_mutex_unlock(&p->lock);
    return now;
}
