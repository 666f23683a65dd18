/* A line that begins with a carriage return, and blanks over what it was. */
#include "tools/progress.h"

#include "tools/now.h"

#include <stdio.h>
#include <unistd.h>

#define PERIOD_NS UINT64_C(100000000)
#define WIDTH     32

void dx_progress_init(struct dx_progress *p, bool asked)
{
    *p = (struct dx_progress){.on = asked || isatty(STDERR_FILENO), .stage = ""};
}

void dx_progress_stage(struct dx_progress *p, const char *stage)
{
    p->stage = stage;
    if (!p->on)
        return;
    fprintf(stderr, "\r%-*s", WIDTH, stage);
    p->shown = true;
    p->last_ns = dx_now_ns();
}

void dx_progress_share(struct dx_progress *p, double share)
{
    char text[WIDTH + 1];
    uint64_t now;

    if (!p->on || (now = dx_now_ns()) - p->last_ns < PERIOD_NS)
        return;
    snprintf(text, sizeof(text), "%s %3.0f %%", p->stage, share < 1 ? 100 * share : 100);
    fprintf(stderr, "\r%-*s", WIDTH, text);
    p->shown = true;
    p->last_ns = now;
}

void dx_progress_clear(struct dx_progress *p)
{
    if (p->shown)
        fprintf(stderr, "\r%*s\r", WIDTH, "");
    p->shown = false;
}
