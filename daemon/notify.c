/* What the service manager is told. Loop thread. */
#include "daemon/notify.h"

#include <stdio.h>
#include <string.h>
#include <systemd/sd-daemon.h>

#include "daemon/clock.h"
#include "daemon/server_priv.h"

#define MAX_NAMED 3  /* streams that are not live */
#define REST_LEN  32 /* ", N more; N clients" */

static const char *plural(uint32_t n)
{
    return n == 1 ? "" : "s";
}

/* Adds ", NAME: STATE", where that leaves room for the rest of the line. */
static bool put_stream(char line[DX_NOTIFY_LINE], size_t *len, const struct dx_server_stream *st)
{
    const char *name = st->options.name, *state = dx_stream_state_name(st->loop->state);

    if (*len + strlen(name) + strlen(state) + 4 + REST_LEN > DX_NOTIFY_LINE)
        return false;
    *len += (size_t)snprintf(line + *len, DX_NOTIFY_LINE - *len, ", %s: %s", name, state);
    return true;
}

static void put_line(const struct dx_server *s, char line[DX_NOTIFY_LINE])
{
    uint32_t n_live = 0, n_named = 0, n_more;
    size_t len;

    for (const struct dx_server_stream *st = s->streams; st; st = st->next)
        n_live += st->loop->state == DX_STREAM_LIVE;
    len = (size_t)snprintf(line, DX_NOTIFY_LINE, "%u stream%s, %u live", s->n_streams,
                           plural(s->n_streams), n_live);
    for (const struct dx_server_stream *st = s->streams; st && n_named < MAX_NAMED; st = st->next)
        if (st->loop->state != DX_STREAM_LIVE)
            n_named += put_stream(line, &len, st);
    n_more = s->n_streams - n_live - n_named;
    if (n_more)
        len += (size_t)snprintf(line + len, DX_NOTIFY_LINE - len, ", %u more", n_more);
    snprintf(line + len, DX_NOTIFY_LINE - len, "; %u client%s", s->n_clients, plural(s->n_clients));
}

/* A text may be that of a file: an assignment stays one line. */
static void tell(const struct dx_server *s, const char *before)
{
    const char *refusal = s->notify.refusal.text;
    char status[DX_NOTIFY_LINE + sizeof(s->notify.refusal.text) + 32];

    snprintf(status, sizeof(status), "%s%s%s", s->notify.told, *refusal ? "; reload refused: " : "",
             refusal);
    for (char *p = status; *p; p++)
        if ((unsigned char)*p < 0x20)
            *p = ' ';
    sd_notifyf(0, "%sSTATUS=%s", before, status);
}

void dx_notify_ready(struct dx_server *s)
{
    put_line(s, s->notify.told);
    tell(s, "READY=1\n");
}

void dx_notify_tick(struct dx_server *s)
{
    char line[DX_NOTIFY_LINE];

    put_line(s, line);
    if (!strcmp(line, s->notify.told))
        return;
    memcpy(s->notify.told, line, sizeof(line));
    tell(s, "");
}

void dx_notify_reloading(void)
{
    sd_notifyf(0, "RELOADING=1\nMONOTONIC_USEC=%llu", (unsigned long long)dx_clock_ns() / 1000);
}

void dx_notify_reloaded(struct dx_server *s, const struct dx_err *refusal)
{
    s->notify.refusal.text[0] = '\0';
    if (refusal)
        s->notify.refusal = *refusal;
    dx_notify_ready(s);
}

/* A service that has ended has no streams. */
void dx_notify_stopping(void)
{
    sd_notify(0, "STOPPING=1\nSTATUS=");
}
