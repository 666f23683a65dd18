/* What the simulated scanner says: replies with their check characters, and scans of its room. */
#include "tests/hil/scip_replies.h"

#include "drivers/hokuyo/scip_code.h"

#include <stdio.h>
#include <string.h>

/* ---- its clock --------------------------------------------------------------------------------
 */

double scip_sim_period_ns(const struct scip_sim *s)
{
    return 60e9 / s->model.rpm;
}

static uint32_t stamp_of(const struct scip_sim *s, uint64_t host_ns)
{
    double ms = (double)(host_ns - s->epoch_ns) / 1e6 * (1 + s->skew);

    return (uint32_t)((int64_t)floor(ms) + s->offset_ms) & 0xFFFFFF;
}

void scip_sim_put_stamp(const struct scip_sim *s, uint8_t out[4], uint64_t host_ns)
{
    dx_scip_put(out, 4, stamp_of(s, host_ns));
}

/* ---- out --------------------------------------------------------------------------------------
 */

void scip_sim_bytes(struct scip_sim *s, const void *bytes, size_t len)
{
    len = len < SCIP_SIM_OUT - s->out_len ? len : SCIP_SIM_OUT - s->out_len;
    memcpy(s->out + s->out_len, bytes, len);
    s->out_len += len;
}

/* A byte of a scan, which may be lost or doubled. */
static void put_byte(struct scip_sim *s, uint8_t c)
{
    s->n_bytes++;
    if (s->faults.drop_every && s->n_bytes % s->faults.drop_every == 0)
        return;
    scip_sim_bytes(s, &c, 1);
    if (s->faults.double_every && s->n_bytes % s->faults.double_every == 0)
        scip_sim_bytes(s, &c, 1);
}

static void put_text(struct scip_sim *s, const char *text)
{
    for (; *text; text++)
        put_byte(s, (uint8_t)*text);
}

/* A line with its check character. */
static void put_line(struct scip_sim *s, const uint8_t *line, size_t len, bool wrong)
{
    for (size_t k = 0; k < len; k++)
        put_byte(s, line[k]);
    put_byte(s, (uint8_t)(dx_scip_sum(line, len) ^ (wrong ? 1 : 0)));
    put_byte(s, '\n');
}

void scip_sim_reply(struct scip_sim *s, const char *echo, const char *status)
{
    char text[160];
    int n = snprintf(text, sizeof(text), "%s\n%s%c\n", echo, status,
                     dx_scip_sum((const uint8_t *)status, strlen(status)));

    scip_sim_bytes(s, text, (size_t)n);
}

void scip_sim_key(struct scip_sim *s, const char *text)
{
    char line[160];
    int n = snprintf(line, sizeof(line), "%s;%c\n", text,
                     dx_scip_sum((const uint8_t *)text, strlen(text)));

    scip_sim_bytes(s, line, (size_t)n);
}

/* ---- scans ------------------------------------------------------------------------------------
 */

double scip_sim_range(const struct scip_sim *s, double angle, double psi)
{
    return scip_room_range(s->room, &s->pose, angle, psi);
}

static void put_value(const struct scip_sim *s, uint8_t *out, size_t *n, uint32_t step,
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

void scip_sim_scan(struct scip_sim *s, const char *status, uint64_t host_ns)
{
    static uint8_t data[64u << 10];
    uint8_t stamp[4];
    char echo[24];
    size_t n = 0, step = s->cluster ? s->cluster : 1;
    unsigned n_line = 0;
    bool wrong = s->faults.bad_sum_every && s->n_scans % s->faults.bad_sum_every == 0;

    snprintf(echo, sizeof(echo), "%.13s%02u\n", s->command, s->endless ? 0 : s->left);
    put_text(s, echo);
    put_line(s, (const uint8_t *)status, 2, false);
    scip_sim_put_stamp(s, stamp, host_ns);
    put_line(s, stamp, 4, false);
    for (size_t k = s->first; k <= s->last; k += step)
        put_value(s, data, &n, (uint32_t)k, host_ns);
    for (size_t at = 0; at < n; at += 64)
        put_line(s, data + at, n - at < 64 ? n - at : 64,
                 wrong && ++n_line == (s->faults.bad_sum_line ? s->faults.bad_sum_line : 1));
    put_byte(s, '\n');
}

void scip_sim_event(struct scip_sim *s, const char *status)
{
    char echo[24];

    snprintf(echo, sizeof(echo), "%.13s00", s->command);
    scip_sim_reply(s, echo, status);
    scip_sim_bytes(s, "\n", 1);
}
