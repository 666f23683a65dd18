/*
 * A simulated SCIP 2 scanner (DEVICES.md 11.1): commands in, replies and scans out, faults on
 * demand. It knows no device and no clock of its own: times are given, so a test of hours takes
 * milliseconds. It stands in a box-shaped room, on a stage that turns evenly, so what it sees is
 * known. For scip_sim.c and unit tests; one thread.
 */
#ifndef SCIP_DEVICE_H
#define SCIP_DEVICE_H

#include "drivers/hokuyo/scip_code.h"
#include "tests/hil/scip_models.h"
#include "tests/hil/scip_room.h"
#include "tests/hil/scip_track.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SCIP_SIM_OUT (256u << 10)

enum scip_sim_state { SIM_BOOTING, SIM_IDLE, SIM_SINGLE, SIM_MULTI, SIM_TIME, SIM_ERROR };

struct scip_sim {
    struct scip_model model;
    struct scip_faults faults;
    struct scip_pose pose;
    const struct scip_track *track; /* where its stage is; NULL: by the pose's speed */
    double room[6];                 /* low x, y, z, high x, y, z; metres */
    double skew;                    /* device clock: host * (1 + skew) + offset */
    int64_t offset_ms;
    uint64_t boot_ns, transfer_ns;

    enum scip_sim_state state;
    bool is_11, laser;
    uint64_t epoch_ns; /* host time when the device's clock was 0 */
    uint64_t until_ns; /* BOOTING */
    uint64_t rb_ns;
    uint64_t n_commands, n_scans, n_bytes, n_blocks;
    char line[128];
    size_t line_len;

    /* MULTI */
    char command[16];
    uint32_t first, last, cluster, skip, left;
    bool endless;
    uint64_t next_ns; /* step 0 of the next scan */
    bool suspended;

    bool gone; /* the link has dropped */
    uint8_t out[SCIP_SIM_OUT];
    size_t out_len;
};

/* Metres along the beam at the scanner's angle, when the stage is at psi. */
static inline double scip_sim_range(const struct scip_sim *s, double angle, double psi)
{
    return scip_room_range(s->room, &s->pose, angle, psi);
}

/* ---- its clock --------------------------------------------------------------------------------
 */

static inline double scip_sim_period_ns(const struct scip_sim *s)
{
    return 60e9 / s->model.rpm;
}

static inline uint32_t scip_sim_stamp(const struct scip_sim *s, uint64_t host_ns)
{
    double ms = (double)(host_ns - s->epoch_ns) / 1e6 * (1 + s->skew);

    return (uint32_t)((int64_t)floor(ms) + s->offset_ms) & 0xFFFFFF;
}

/* ---- out --------------------------------------------------------------------------------------
 */

static inline void scip_sim_bytes(struct scip_sim *s, const void *bytes, size_t len)
{
    len = len < SCIP_SIM_OUT - s->out_len ? len : SCIP_SIM_OUT - s->out_len;
    memcpy(s->out + s->out_len, bytes, len);
    s->out_len += len;
}

/* A byte of a scan, which may be lost or doubled. */
static inline void scip_sim_byte(struct scip_sim *s, uint8_t c)
{
    s->n_bytes++;
    if (s->faults.drop_every && s->n_bytes % s->faults.drop_every == 0)
        return;
    scip_sim_bytes(s, &c, 1);
    if (s->faults.double_every && s->n_bytes % s->faults.double_every == 0)
        scip_sim_bytes(s, &c, 1);
}

static inline void scip_sim_text(struct scip_sim *s, const char *text)
{
    for (; *text; text++)
        scip_sim_byte(s, (uint8_t)*text);
}

/* A line with its check character. */
static inline void scip_sim_line(struct scip_sim *s, const uint8_t *line, size_t len, bool wrong)
{
    for (size_t k = 0; k < len; k++)
        scip_sim_byte(s, line[k]);
    scip_sim_byte(s, (uint8_t)(dx_scip_sum(line, len) ^ (wrong ? 1 : 0)));
    scip_sim_byte(s, '\n');
}

static inline void scip_sim_reply(struct scip_sim *s, const char *echo, const char *status)
{
    char text[160];
    int n = snprintf(text, sizeof(text), "%s\n%s%c\n", echo, status,
                     dx_scip_sum((const uint8_t *)status, strlen(status)));

    scip_sim_bytes(s, text, (size_t)n);
}

static inline void scip_sim_key(struct scip_sim *s, const char *text)
{
    char line[160];
    int n = snprintf(line, sizeof(line), "%s;%c\n", text,
                     dx_scip_sum((const uint8_t *)text, strlen(text)));

    scip_sim_bytes(s, line, (size_t)n);
}

/* ---- scans ------------------------------------------------------------------------------------
 */

static inline void scip_sim_value(const struct scip_sim *s, uint8_t *out, size_t *n, uint32_t step,
                                  uint64_t host_ns)
{
    double angle = ((double)step - s->model.afrt) * 2 * DX_PI / s->model.ares;
    uint64_t t = host_ns + (uint64_t)(step * scip_sim_period_ns(s) / s->model.ares);
    double psi = s->track ? scip_track_stage(s->track, t) : scip_sim_stage(&s->pose, t);
    uint32_t mm = (uint32_t)rint(scip_sim_range(s, angle, psi) * 1000);
    bool echoes = s->command[0] == 'N' || s->command[0] == 'H';
    bool strong = s->command[1] == 'E';
    size_t chars = s->command[1] == 'S' ? 2 : 3;

    if (mm > s->model.dmax)
        mm = 65533;
    if (chars == 2 && mm > 4095)
        mm = 4095;
    if (s->faults.code_every && step % s->faults.code_every == 0)
        mm = 3;
    dx_scip_put(out + *n, chars, mm);
    *n += chars;
    if (strong) {
        dx_scip_put(out + *n, 3, 1000 + step);
        *n += 3;
    }
    if (!echoes || step % 5)
        return;
    out[(*n)++] = '&'; /* every fifth beam goes through something to twice as far */
    dx_scip_put(out + *n, 3, 2 * mm);
    *n += 3;
    if (strong) {
        dx_scip_put(out + *n, 3, 2000 + step);
        *n += 3;
    }
}

/* The scan whose step 0 was at host_ns, with the echo and status of the request that it answers. */
static inline void scip_sim_scan(struct scip_sim *s, const char *status, uint64_t host_ns)
{
    static uint8_t data[64u << 10];
    uint8_t stamp[4];
    char echo[24];
    size_t n = 0, step = s->cluster ? s->cluster : 1;
    unsigned n_line = 0;
    bool wrong = s->faults.bad_sum_every && s->n_scans % s->faults.bad_sum_every == 0;

    snprintf(echo, sizeof(echo), "%.13s%02u\n", s->command, s->endless ? 0 : s->left);
    scip_sim_text(s, echo);
    scip_sim_line(s, (const uint8_t *)status, 2, false);
    dx_scip_put(stamp, 4, scip_sim_stamp(s, host_ns));
    scip_sim_line(s, stamp, 4, false);
    for (size_t k = s->first; k <= s->last; k += step)
        scip_sim_value(s, data, &n, (uint32_t)k, host_ns);
    for (size_t at = 0; at < n; at += 64)
        scip_sim_line(s, data + at, n - at < 64 ? n - at : 64,
                      wrong && ++n_line == (s->faults.bad_sum_line ? s->faults.bad_sum_line : 1));
    scip_sim_byte(s, '\n');
}

/* The stream ends, or pauses, with a status instead of a scan. */
static inline void scip_sim_event(struct scip_sim *s, const char *status)
{
    char echo[24];

    snprintf(echo, sizeof(echo), "%.13s00", s->command);
    scip_sim_reply(s, echo, status);
    scip_sim_bytes(s, "\n", 1);
}

/* When a scan that began at next_ns can be sent. */
static inline uint64_t scip_sim_due(const struct scip_sim *s)
{
    return s->next_ns + s->transfer_ns +
           (uint64_t)((s->last + 1) * scip_sim_period_ns(s) / s->model.ares);
}

static inline void scip_sim_next_scan(struct scip_sim *s)
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

static inline bool scip_sim_number(uint32_t *out, const char *p, int n)
{
    for (*out = 0; n > 0; n--, p++) {
        if (*p < '0' || *p > '9')
            return false;
        *out = 10 * *out + (uint32_t)(*p - '0');
    }
    return true;
}

/* Start, end and cluster of Gx and Mx; the status when they are wrong. */
static inline const char *scip_sim_range_of(struct scip_sim *s, const char *c)
{
    uint32_t first, last, cluster;

    if (!scip_sim_number(&first, c + 2, 4))
        return "01";
    if (!scip_sim_number(&last, c + 6, 4))
        return "02";
    if (!scip_sim_number(&cluster, c + 10, 2))
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

static inline void scip_sim_stream(struct scip_sim *s, const char *c, uint64_t now_ns)
{
    const char *wrong = strlen(c) < 15 ? "0C" : strlen(c) > 15 ? "0D" : scip_sim_range_of(s, c);
    uint32_t skip = 0, count = 0;

    if (!wrong && !scip_sim_number(&skip, c + 12, 1))
        wrong = "06";
    if (!wrong && !scip_sim_number(&count, c + 13, 2))
        wrong = "07";
    scip_sim_reply(s, c, wrong ? wrong : "00");
    scip_sim_bytes(s, "\n", 1);
    if (wrong)
        return;
    snprintf(s->command, sizeof(s->command), "%s", c);
    s->skip = skip;
    s->left = count;
    s->endless = count == 0;
    s->state = SIM_MULTI;
    s->next_ns = now_ns + (uint64_t)scip_sim_period_ns(s);
}

static inline void scip_sim_single(struct scip_sim *s, const char *c, uint64_t now_ns)
{
    const char *wrong = strlen(c) < 12 ? "0C" : strlen(c) > 12 ? "0D" : scip_sim_range_of(s, c);

    if (!wrong && !s->laser)
        wrong = "10";
    if (wrong) {
        scip_sim_reply(s, c, wrong);
        scip_sim_bytes(s, "\n", 1);
        return;
    }
    snprintf(s->command, sizeof(s->command), "%s0", c);
    s->endless = true;
    scip_sim_scan(s, "00", now_ns);
}

static inline void scip_sim_tell(struct scip_sim *s, const char *c)
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
        if (!s->faults.no_serial)
            scip_sim_key(s, "SERI:H0614967");
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

static inline void scip_sim_time(struct scip_sim *s, const char *c, uint64_t now_ns)
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
        dx_scip_put(stamp, 4, scip_sim_stamp(s, now_ns));
        stamp[4] = dx_scip_sum(stamp, 4);
        stamp[5] = '\n';
        scip_sim_bytes(s, stamp, 6);
    }
    scip_sim_bytes(s, "\n", 1);
    if (!strcmp(status, "00") && c[2] != '1')
        s->state = c[2] == '0' ? SIM_TIME : SIM_IDLE;
}

static inline void scip_sim_simple(struct scip_sim *s, const char *c, const char *status,
                                   enum scip_sim_state state, bool laser)
{
    scip_sim_reply(s, c, status);
    scip_sim_bytes(s, "\n", 1);
    s->state = state;
    s->laser = laser;
}

static inline void scip_sim_reboot(struct scip_sim *s, uint64_t now_ns)
{
    bool second = s->rb_ns && now_ns - s->rb_ns < 1000000000u;

    scip_sim_simple(s, "RB", second ? "00" : "01", s->state, s->laser);
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

static inline void scip_sim_command(struct scip_sim *s, const char *c, uint64_t now_ns)
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
        scip_sim_simple(s, c, "0B", s->state, s->laser);
    } else if (!strcmp(c, "RB")) {
        scip_sim_reboot(s, now_ns);
    } else if (!serves) {
        scip_sim_simple(s, c, "0L", s->state, s->laser);
    } else if (!strcmp(c, "QT")) {
        scip_sim_simple(s, c, "00", s->state == SIM_ERROR ? SIM_ERROR : SIM_IDLE, false);
    } else if (!strcmp(c, "RS") || !strcmp(c, "RT")) {
        scip_sim_simple(s, c, "00", SIM_IDLE, false);
        s->epoch_ns = now_ns;
        s->offset_ms = 0;
        s->faults.fault_at = 0;
    } else if (!strcmp(c, "VV") || !strcmp(c, "PP") || !strcmp(c, "II")) {
        scip_sim_tell(s, c);
    } else if (s->state == SIM_TIME && strncmp(c, "TM", 2)) {
        scip_sim_simple(s, c, "0E", s->state, s->laser);
    } else if (!strncmp(c, "TM", 2) && strlen(c) == 3) {
        scip_sim_time(s, c, now_ns);
    } else if (!strcmp(c, "BM")) {
        scip_sim_simple(s, c, s->laser ? "02" : "00", s->laser ? s->state : SIM_SINGLE, true);
    } else if ((c[0] == 'M' && strchr("DSE", c[1])) ||
               (s->model.echoes && c[0] == 'N' && strchr("DE", c[1]))) {
        scip_sim_stream(s, c, now_ns);
    } else if (c[0] == 'G' && c[1] && strchr("DSE", c[1])) {
        scip_sim_single(s, c, now_ns);
    } else {
        scip_sim_simple(s, c, "0E", s->state, s->laser);
    }
}

/* ---- in ---------------------------------------------------------------------------------------
 */

static inline void scip_sim_init(struct scip_sim *s, const struct scip_model *model,
                                 uint64_t now_ns)
{
    memset(s, 0, sizeof(*s));
    s->model = *model;
    s->is_11 = model->is_old;
    s->state = SIM_IDLE;
    s->epoch_ns = now_ns;
    s->offset_ms = 300000;
    s->boot_ns = 1000000000u;
    s->transfer_ns = 500000;
    memcpy(s->room, (const double[6]){-3, -2.5, -1.2, 4, 2, 1.6}, sizeof(s->room));
}

/* Someone opens the link. */
static inline void scip_sim_open(struct scip_sim *s, uint64_t now_ns)
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

static inline void scip_sim_feed(struct scip_sim *s, const uint8_t *bytes, size_t len,
                                 uint64_t now_ns)
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
            scip_sim_command(s, s->line, now_ns);
    }
}

/* When it does something by itself; UINT64_MAX: never. */
static inline uint64_t scip_sim_next_ns(const struct scip_sim *s)
{
    if (s->state == SIM_BOOTING)
        return s->until_ns;
    return s->state == SIM_MULTI && !s->faults.mute ? scip_sim_due(s) : UINT64_MAX;
}

static inline void scip_sim_tick(struct scip_sim *s, uint64_t now_ns)
{
    if (s->state == SIM_BOOTING && now_ns >= s->until_ns)
        s->state = SIM_IDLE;
    while (s->state == SIM_MULTI && !s->faults.mute && now_ns >= scip_sim_due(s))
        scip_sim_next_scan(s);
}

#endif
