/* The splitter. */
#include "drivers/hokuyo/scip_lines.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

int dx_scip_lines_init(struct dx_scip_lines *l, size_t headroom)
{
    *l = (struct dx_scip_lines){.room = malloc(headroom + DX_SCIP_MAX_REPLY)};
    if (!l->room)
        return -ENOMEM;
    l->reply = l->room + headroom;
    return 0;
}

void dx_scip_lines_fini(struct dx_scip_lines *l)
{
    free(l->room);
    *l = (struct dx_scip_lines){0};
}

void dx_scip_lines_clear(struct dx_scip_lines *l)
{
    l->len = l->line = 0;
    l->done = false;
}

void dx_scip_lines_resync(struct dx_scip_lines *l, const char *echo, size_t len)
{
    l->skipping = true;
    l->echo_len = len < sizeof(l->echo) ? len : sizeof(l->echo);
    memcpy(l->echo, echo, l->echo_len);
}

static bool begins_with_echo(const struct dx_scip_lines *l)
{
    return l->len >= l->echo_len && l->reply[0] && !memcmp(l->reply, l->echo, l->echo_len);
}

/* A line has ended, its LF included. */
static void end_line(struct dx_scip_lines *l)
{
    size_t line_len = l->len - l->line - 1;

    if (line_len > 0) {
        l->line = l->len;
        return;
    }
    if (l->len == 1) { /* an empty line before a reply: of one that was lost, or of the flush */
        dx_scip_lines_clear(l);
        return;
    }
    if (l->skipping && !begins_with_echo(l)) {
        l->n_skipped += l->len;
        dx_scip_lines_clear(l);
        return;
    }
    l->skipping = false;
    l->done = true;
}

size_t dx_scip_lines_feed(struct dx_scip_lines *l, const uint8_t *bytes, size_t len)
{
    size_t used = 0;

    if (l->done)
        dx_scip_lines_clear(l);
    while (used < len && !l->done) {
        const uint8_t *lf = memchr(bytes + used, '\n', len - used);
        size_t n = lf ? (size_t)(lf - (bytes + used)) + 1 : len - used;

        if (n > DX_SCIP_MAX_REPLY - l->len) {
            /* too long for a reply, so none; what follows the next empty line may be one */
            l->n_skipped += l->len + n;
            l->reply[0] = 0; /* stands for what was dropped */
            l->reply[1] = '\n';
            l->len = lf ? 2 : 1;
            l->line = 0;
            l->skipping = true;
        } else {
            memcpy(l->reply + l->len, bytes + used, n);
            l->len += n;
        }
        used += n;
        if (lf)
            end_line(l);
    }
    return used;
}

bool dx_scip_next_line(struct dx_scip_cursor *c, const uint8_t **line, size_t *len)
{
    const uint8_t *lf = c->p < c->end ? memchr(c->p, '\n', (size_t)(c->end - c->p)) : NULL;

    if (!lf || lf == c->p)
        return false;
    *line = c->p;
    *len = (size_t)(lf - c->p);
    c->p = lf + 1;
    return true;
}
