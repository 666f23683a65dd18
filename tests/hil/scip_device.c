/* The simulated scanner: what it does with commands, and by itself. */
#include "tests/hil/scip_device.h"

#include "drivers/hokuyo/scip_code.h"
#include "tests/hil/scip_replies.h"

#include <stdio.h>
#include <string.h>

/* ---- the stream -------------------------------------------------------------------------------
 */

/* When a scan that began at next_ns can be sent. */
static uint64_t due(const struct scip_sim *s)
{
    return s->next_ns + s->transfer_ns +
           (uint64_t)((s->last + 1) * scip_sim_period_ns(s) / s->model.ares);
}

static void next_scan(struct scip_sim *s)
{
    const struct scip_faults *f = &s->faults;
    uint64_t n = ++s->n_scans;

    if (f->fault_at == n) {
        scip_sim_event(s, "51");
        s->state = SIM_ERROR;
    } else if (f->abnormal_at == n) {
        scip_sim_event(s, "0L");
        s->state = SIM_ERROR;
    } else if (f->suspend_at == n) {
        scip_sim_event(s, "21");
        s->suspended = true;
    } else if (s->suspended && n >= f->suspend_at + f->suspend_for) {
        scip_sim_event(s, "98");
        s->suspended = false;
    } else if (!s->suspended) {
        scip_sim_scan(s, "99", s->next_ns);
    }
    s->next_ns += (uint64_t)(scip_sim_period_ns(s) * (s->skip + 1));
    if (!s->endless && --s->left == 0)
        s->state = SIM_SINGLE;
}

/* ---- commands ---------------------------------------------------------------------------------
 */

static bool read_number(uint32_t *out, const char *p, int n)
{
    for (*out = 0; n > 0; n--, p++) {
        if (*p < '0' || *p > '9')
            return false;
        *out = 10 * *out + (uint32_t)(*p - '0');
    }
    return true;
}

/* Start, end and cluster of Gx and Mx; the status when they are wrong. */
static const char *read_steps(struct scip_sim *s, const char *c)
{
    uint32_t first, last, cluster;

    if (!read_number(&first, c + 2, 4))
        return "01";
    if (!read_number(&last, c + 6, 4))
        return "02";
    if (!read_number(&cluster, c + 10, 2))
        return "03";
    if (first < s->model.amin || last > s->model.amax)
        return "04";
    if (last < first)
        return "05";
    s->first = first;
    s->last = last;
    s->cluster = cluster;
    return NULL;
}

static void stream(struct scip_sim *s, const char *c, uint64_t now_ns)
{
    const char *wrong = strlen(c) < 15 ? "0C" : strlen(c) > 15 ? "0D" : read_steps(s, c);
    uint32_t skip = 0, count = 0;

    if (!wrong && !read_number(&skip, c + 12, 1))
        wrong = "06";
    if (!wrong && !read_number(&count, c + 13, 2))
        wrong = "07";
    scip_sim_reply(s, c, wrong ? wrong : "00");
    scip_sim_bytes(s, "\n", 1);
    if (wrong)
        return;
    snprintf(s->command, sizeof(s->command), "%.15s", c);
    s->skip = skip;
    s->left = count;
    s->endless = count == 0;
    s->state = SIM_MULTI;
    s->next_ns = now_ns + (uint64_t)scip_sim_period_ns(s);
}

static void single(struct scip_sim *s, const char *c, uint64_t now_ns)
{
    const char *wrong = strlen(c) < 12 ? "0C" : strlen(c) > 12 ? "0D" : read_steps(s, c);

    if (!wrong && !s->laser)
        wrong = "10";
    if (wrong) {
        scip_sim_reply(s, c, wrong);
        scip_sim_bytes(s, "\n", 1);
        return;
    }
    snprintf(s->command, sizeof(s->command), "%.14s0", c);
    s->endless = true;
    scip_sim_scan(s, "00", now_ns);
}

static void tell(struct scip_sim *s, const char *c)
{
    char text[64];
    const struct scip_model *m = &s->model;
    const struct {
        const char *key;
        uint32_t value;
    } numbers[] = {{"DMIN", m->dmin}, {"DMAX", m->dmax}, {"ARES", m->ares}, {"AMIN", m->amin},
                   {"AMAX", m->amax}, {"AFRT", m->afrt}, {"SCAN", m->rpm}};

    scip_sim_reply(s, c, "00");
    if (!strcmp(c, "VV")) {
        scip_sim_key(s, "VEND:Hokuyo Automatic Co.,Ltd.");
        scip_sim_key(s, "PROD:simulated scanner");
        scip_sim_key(s, "FIRM:1.0.00");
        scip_sim_key(s, "PROT:SCIP 2.0");
        snprintf(text, sizeof(text), "SERI:%s", s->serial ? s->serial : "");
        if (s->serial && !s->faults.no_serial)
            scip_sim_key(s, text);
    } else if (!strcmp(c, "PP")) {
        snprintf(text, sizeof(text), "MODL:%s(simulated)", m->name);
        for (char *p = text + 5; *p && *p != '('; p++)
            *p = (char)(*p >= 'a' && *p <= 'z' ? *p - 32 : *p);
        scip_sim_key(s, text);
        for (size_t k = 0; k < sizeof(numbers) / sizeof(numbers[0]); k++) {
            snprintf(text, sizeof(text), "%s:%u", numbers[k].key, numbers[k].value);
            scip_sim_key(s, text);
        }
    } else {
        scip_sim_key(s, s->laser ? "LASR:ON" : "LASR:OFF");
        scip_sim_key(s, s->state == SIM_MULTI ? "MESM:004 Multi_scan" : "MESM:000 Idle");
        scip_sim_key(s, s->state == SIM_ERROR ? "STAT:laser fault" : "STAT:Stable 000 no error.");
    }
    scip_sim_bytes(s, "\n", 1);
}

static void answer_time(struct scip_sim *s, const char *c, uint64_t now_ns)
{
    uint8_t stamp[6];
    const char *status = "00";

    if (s->faults.no_time)
        status = "0E";
    else if (c[2] == '0')
        status = s->state == SIM_MULTI ? "10" : s->state == SIM_TIME ? "02" : "00";
    else if (c[2] == '2')
        status = s->state == SIM_TIME ? "00" : "03";
    else if (c[2] != '1' || s->state != SIM_TIME)
        status = c[2] == '1' ? "04" : "01";
    scip_sim_reply(s, c, status);
    if (c[2] == '1' && !strcmp(status, "00")) {
        scip_sim_put_stamp(s, stamp, now_ns);
        stamp[4] = dx_scip_sum(stamp, 4);
        stamp[5] = '\n';
        scip_sim_bytes(s, stamp, 6);
    }
    scip_sim_bytes(s, "\n", 1);
    if (!strcmp(status, "00") && c[2] != '1')
        s->state = c[2] == '0' ? SIM_TIME : SIM_IDLE;
}

static void answer(struct scip_sim *s, const char *c, const char *status, enum scip_sim_state state,
                   bool laser)
{
    scip_sim_reply(s, c, status);
    scip_sim_bytes(s, "\n", 1);
    s->state = state;
    s->laser = laser;
}

static void reboot(struct scip_sim *s, uint64_t now_ns)
{
    bool second = s->rb_ns && now_ns - s->rb_ns < 1000000000u;

    answer(s, "RB", second ? "00" : "01", s->state, s->laser);
    s->rb_ns = now_ns ? now_ns : 1;
    if (!second)
        return;
    s->state = SIM_BOOTING;
    s->laser = s->suspended = false;
    s->until_ns = now_ns + s->boot_ns;
    s->epoch_ns = s->until_ns;
    s->offset_ms = 0;
    s->gone = true;
    s->faults.abnormal_at = s->faults.fault_at = 0;
}

static void obey(struct scip_sim *s, const char *c, uint64_t now_ns)
{
    bool serves = s->state != SIM_ERROR || (s->faults.fault_at && s->faults.fault_at <= s->n_scans);

    s->n_commands++;
    if (s->is_11 && strcmp(c, "SCIP2.0")) {
        scip_sim_bytes(s, c, strlen(c));
        scip_sim_bytes(s, "\nE\n\n", 4);
    } else if (!strcmp(c, "SCIP2.0")) {
        s->is_11 = false;
        scip_sim_bytes(s, "SCIP2.0\n0\n\n", 11);
    } else if (s->faults.busy_at == s->n_commands) {
        answer(s, c, "0B", s->state, s->laser);
    } else if (!strcmp(c, "RB")) {
        reboot(s, now_ns);
    } else if (!serves) {
        answer(s, c, "0L", s->state, s->laser);
    } else if (!strcmp(c, "QT")) {
        answer(s, c, "00", s->state == SIM_ERROR ? SIM_ERROR : SIM_IDLE, false);
    } else if (!strcmp(c, "RS") || !strcmp(c, "RT")) {
        answer(s, c, "00", SIM_IDLE, false);
        s->epoch_ns = now_ns;
        s->offset_ms = 0;
        s->faults.fault_at = 0;
    } else if (!strcmp(c, "VV") || !strcmp(c, "PP") || !strcmp(c, "II")) {
        tell(s, c);
        /* NOLINTNEXTLINE(bugprone-branch-clone): refused for another reason than what is unknown */
    } else if (s->state == SIM_TIME && strncmp(c, "TM", 2)) {
        answer(s, c, "0E", s->state, s->laser);
    } else if (!strncmp(c, "TM", 2) && strlen(c) == 3) {
        answer_time(s, c, now_ns);
    } else if (!strcmp(c, "BM")) {
        answer(s, c, s->laser ? "02" : "00", s->laser ? s->state : SIM_SINGLE, true);
    } else if ((c[0] == 'M' && strchr("DSE", c[1])) ||
               (s->model.echoes && c[0] == 'N' && strchr("DE", c[1]))) {
        stream(s, c, now_ns);
    } else if (c[0] == 'G' && c[1] && strchr("DSE", c[1])) {
        single(s, c, now_ns);
    } else {
        answer(s, c, "0E", s->state, s->laser);
    }
}

/* ---- in ---------------------------------------------------------------------------------------
 */

void scip_sim_init(struct scip_sim *s, const struct scip_model *model, uint64_t now_ns)
{
    memset(s, 0, sizeof(*s));
    s->model = *model;
    s->is_11 = model->is_old;
    s->serial = SCIP_SIM_SERIAL;
    s->state = SIM_IDLE;
    s->epoch_ns = now_ns;
    s->offset_ms = 300000;
    s->boot_ns = 1000000000u;
    s->transfer_ns = 500000;
    memcpy(s->room, (const double[6]){-3, -2.5, -1.2, 4, 2, 1.6}, sizeof(s->room));
}

void scip_sim_open(struct scip_sim *s, uint64_t now_ns)
{
    s->gone = false;
    s->out_len = s->line_len = 0;
    s->is_11 = s->model.is_old;
    if (s->faults.stale) {
        s->is_11 = false;
        s->first = s->model.amin;
        s->last = s->model.amax;
        snprintf(s->command, sizeof(s->command), "MD%04u%04u00000", s->first, s->last);
        s->endless = true;
        s->cluster = s->skip = 0;
        s->state = SIM_MULTI;
        s->next_ns = now_ns;
    }
}

void scip_sim_feed(struct scip_sim *s, const uint8_t *bytes, size_t len, uint64_t now_ns)
{
    for (; len > 0; bytes++, len--) {
        if (*bytes != '\n' && *bytes != '\r') {
            if (s->line_len < sizeof(s->line) - 1)
                s->line[s->line_len++] = (char)*bytes;
            continue;
        }
        s->line[s->line_len] = 0;
        s->line_len = 0;
        if (s->line[0] && !s->faults.mute && s->state != SIM_BOOTING)
            obey(s, s->line, now_ns);
    }
}

uint64_t scip_sim_next_ns(const struct scip_sim *s)
{
    if (s->state == SIM_BOOTING)
        return s->until_ns;
    return s->state == SIM_MULTI && !s->faults.mute ? due(s) : UINT64_MAX;
}

void scip_sim_tick(struct scip_sim *s, uint64_t now_ns)
{
    if (s->state == SIM_BOOTING && now_ns >= s->until_ns)
        s->state = SIM_IDLE;
    while (s->state == SIM_MULTI && !s->faults.mute && now_ns >= due(s))
        next_scan(s);
}

void scip_sim_sent(struct scip_sim *s, size_t n)
{
    s->out_len -= n;
    memmove(s->out, s->out + n, s->out_len);
}
