/* What is sent in which state. */
#include "drivers/hokuyo/scip_steps.h"

#include "drivers/hokuyo/scip_code.h"

#include <stdio.h>
#include <string.h>

#define MS (DX_SCIP_S / 1000)

static const struct step {
    const char *name;
    const char *command; /* NULL: none, or the request for the stream */
    uint64_t wait_ns;    /* for its answer */
} steps[DX_SCIP_N_STATES] = {
    [DX_SCIP_FLUSH] = {"flush", "\nQT", DX_SCIP_SILENCE},
    [DX_SCIP_SCIP2] = {"SCIP2.0", "SCIP2.0", 500 * MS},
    [DX_SCIP_VV] = {"VV", "VV", 1000 * MS},
    [DX_SCIP_PP] = {"PP", "PP", 1000 * MS},
    [DX_SCIP_II] = {"II", "II", 1000 * MS},
    [DX_SCIP_TM0] = {"TM0", "TM0", 500 * MS},
    [DX_SCIP_TM1] = {"TM1", "TM1", 500 * MS},
    [DX_SCIP_TM2] = {"TM2", "TM2", 500 * MS},
    [DX_SCIP_START] = {"start", NULL, 1000 * MS},
    [DX_SCIP_STREAM] = {"stream", NULL, 0},
    [DX_SCIP_FAULT_QT] = {"QT after a fault", "QT", 500 * MS},
    [DX_SCIP_FAULT_RS] = {"RS after a fault", "RS", 1000 * MS},
    [DX_SCIP_REBOOT_1] = {"RB", "RB", 500 * MS},
    [DX_SCIP_REBOOT_2] = {"second RB", "RB", 500 * MS},
    [DX_SCIP_PAUSE] = {"pause", NULL, 0},
    [DX_SCIP_STOPPING] = {"stopping", "QT", 0},
    [DX_SCIP_STOPPED] = {"stopped", NULL, 0},
};

const char *dx_scip_state_name(enum dx_scip_state state)
{
    return steps[state].name;
}

void dx_scip_queue(struct dx_scip_session *s, const char *command)
{
    size_t len = strlen(command);

    if (len + 1 > sizeof(s->out) - s->out_len)
        return; /* nothing goes out: the answer will be missed */
    memcpy(s->out + s->out_len, command, len);
    s->out[s->out_len + len] = '\n';
    s->out_len += len + 1;
}

uint64_t dx_scip_quiet_ns(const struct dx_scip_session *s)
{
    return (uint64_t)(4 * dx_scip_period_ns(&s->params) * (s->request.skip + 1));
}

/* Three periods, within reason. */
static uint64_t stop_ns(const struct dx_scip_session *s)
{
    double ns = s->params.scan_rpm ? 3 * dx_scip_period_ns(&s->params) : 0;

    return ns > 0 && ns < 500 * 1e6 ? (uint64_t)ns : 500 * MS;
}

void dx_scip_send(struct dx_scip_session *s, uint64_t now_ns)
{
    const struct step *step = &steps[s->state];

    s->sent_ns = now_ns;
    s->deadline_ns = now_ns + step->wait_ns;
    if (s->state == DX_SCIP_FLUSH)
        s->quiet_ns = s->deadline_ns;
    if (s->state == DX_SCIP_STOPPING)
        s->deadline_ns = now_ns + stop_ns(s);
    if (s->state == DX_SCIP_START)
        dx_scip_queue(s, s->request.command);
    else if (step->command)
        dx_scip_queue(s, step->command);
}

void dx_scip_enter(struct dx_scip_session *s, enum dx_scip_state state, uint64_t now_ns)
{
    if (state == DX_SCIP_TM0) {
        s->n_times = 0;
        s->clock.n_samples = 0;
    }
    if (state != DX_SCIP_STREAM)
        s->lines.skipping = false; /* answers have other echoes */
    if (state == DX_SCIP_FLUSH)
        s->saw_qt = s->is_old = s->suspended = s->asked = false;
    if (state == DX_SCIP_STREAM) {
        s->life_ns = s->run_from_ns = now_ns;
        s->n_since_start = s->n_bad_now = 0;
    }
    s->state = state;
    s->tries = 0;
    dx_scip_send(s, now_ns);
    if (state == DX_SCIP_STREAM)
        s->deadline_ns = now_ns + dx_scip_quiet_ns(s);
}

bool dx_scip_is_echo(const struct dx_scip_session *s, const uint8_t *line, size_t len)
{
    const char *command = s->state == DX_SCIP_START ? s->request.command : steps[s->state].command;

    return command && len == strlen(command) && !memcmp(line, command, len);
}

uint32_t dx_scip_n_values(uint32_t first, uint32_t last, uint32_t cluster)
{
    return (last - first) / cluster + 1;
}

bool dx_scip_make_request(struct dx_scip_session *s)
{
    static const char *const commands[2][2] = {{"MD", "ME"}, {"ND", "NE"}};
    const struct dx_scip_want *w = &s->want;
    struct dx_scip_request *r = &s->request;
    uint32_t first = w->first_step < 0 ? s->params.amin : (uint32_t)w->first_step;
    uint32_t last = w->last_step < 0 ? s->params.amax : (uint32_t)w->last_step;

    if (first < s->params.amin || last > s->params.amax || first >= last || last > 9999) {
        snprintf(s->trouble, sizeof(s->trouble), "steps %u to %u asked for, it has %u to %u", first,
                 last, s->params.amin, s->params.amax);
        return false;
    }
    r->first = (uint16_t)first;
    r->last = (uint16_t)last;
    r->cluster = (uint8_t)(w->cluster < 1 ? 1 : w->cluster > 99 ? 99 : w->cluster);
    r->skip = (uint8_t)(w->skip > 9 ? 9 : w->skip);
    snprintf(r->command, sizeof(r->command), "%s%04u%04u%02u%01u00",
             commands[w->echoes][w->intensity], first, last, r->cluster == 1u ? 0u : r->cluster,
             r->skip);
    return true;
}

uint32_t dx_scip_stamp(const uint8_t *line, size_t len)
{
    uint32_t v = len == 5 && dx_scip_sum_holds(line, len) ? dx_scip_get(line, 4) : DX_SCIP_INVALID;

    return v == DX_SCIP_INVALID ? DX_SCIP_NO_STAMP : v;
}
