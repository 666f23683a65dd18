/* The session: what comes, and what is done about it. scip_steps.c says what is sent in which
 * state.
 */
#include "drivers/hokuyo/scip_session.h"

#include "drivers/hokuyo/scip_steps.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#define ECHO_LEN     13 /* of a stream's command: without the count */
#define BAD_A_SECOND 8
#define CALM_NS      (60 * DX_SCIP_S) /* of streaming: a fault after that is a first one again */
#define SILENT_LIMIT 2

int dx_scip_session_init(struct dx_scip_session *s, const struct dx_scip_want *want,
                         size_t headroom, uint64_t now_ns)
{
    int r;

    *s = (struct dx_scip_session){.want = *want};
    r = dx_scip_lines_init(&s->lines, headroom);
    if (r)
        return r;
    dx_scip_clock_init(&s->clock);
    dx_scip_enter(s, DX_SCIP_FLUSH, now_ns);
    return 0;
}

void dx_scip_session_fini(struct dx_scip_session *s)
{
    dx_scip_lines_fini(&s->lines);
}

static void set_trouble(struct dx_scip_session *s, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
static void set_trouble(struct dx_scip_session *s, const char *format, ...)
{
    va_list ap;

    va_start(ap, format);
    vsnprintf(s->trouble, sizeof(s->trouble), format, ap);
    va_end(ap);
}

/* ---- ways out of a state ----------------------------------------------------------------------
 */

static void pause_for(struct dx_scip_session *s, uint64_t ns, uint64_t now_ns)
{
    dx_scip_enter(s, DX_SCIP_PAUSE, now_ns);
    s->deadline_ns = now_ns + ns;
}

static void restart(struct dx_scip_session *s, uint64_t now_ns)
{
    s->counts.n_restarts++;
    dx_scip_enter(s, DX_SCIP_FLUSH, now_ns);
}

static void back_off(struct dx_scip_session *s, uint64_t now_ns)
{
    s->counts.n_restarts++;
    pause_for(s, dx_backoff_next(&s->backoff), now_ns);
}

static void give_up(struct dx_scip_session *s, uint64_t now_ns)
{
    set_trouble(s, "no answer (%s)", dx_scip_state_name(s->state));
    s->dead = ++s->n_silent >= SILENT_LIMIT;
    s->counts.n_restarts++;
    pause_for(s, DX_SCIP_S / 2, now_ns);
}

static void try_again(struct dx_scip_session *s, uint64_t now_ns)
{
    if (++s->tries < DX_SCIP_TRIES && s->state != DX_SCIP_SCIP2) {
        dx_scip_send(s, now_ns);
        return;
    }
    switch (s->state) {
    case DX_SCIP_TM0: /* a scanner that will not: its clock is taken from the scans' arrivals */
    case DX_SCIP_TM1:
    case DX_SCIP_TM2:
        dx_scip_clock_settle(&s->clock);
        dx_scip_enter(s, DX_SCIP_START, now_ns);
        return;
    case DX_SCIP_SCIP2: /* others need not know it */
        dx_scip_enter(s, DX_SCIP_VV, now_ns);
        return;
    case DX_SCIP_FAULT_QT:
        dx_scip_enter(s, DX_SCIP_FAULT_RS, now_ns);
        return;
    case DX_SCIP_FAULT_RS:
        back_off(s, now_ns);
        return;
    default:
        give_up(s, now_ns);
    }
}

/* ---- replies to commands ----------------------------------------------------------------------
 */

static bool is_digits(uint16_t status)
{
    return status >> 8 >= '0' && status >> 8 <= '9' && (status & 0xFF) >= '0' &&
           (status & 0xFF) <= '9';
}

static unsigned status_number(uint16_t status)
{
    return 10u * (unsigned)((status >> 8) - '0') + (unsigned)((status & 0xFF) - '0');
}

/* A status that means the same in every state. True: it has been dealt with. */
static bool handle_fault(struct dx_scip_session *s, uint16_t status, uint64_t now_ns)
{
    if (s->state == DX_SCIP_STOPPING) /* whatever it says: nothing is begun anew */
        return false;
    if (status == DX_SCIP_STATUS('0', 'L')) {
        if (s->state != DX_SCIP_REBOOT_1 && s->state != DX_SCIP_REBOOT_2) {
            set_trouble(s, "abnormal state (0L): rebooting");
            dx_scip_enter(s, DX_SCIP_REBOOT_1, now_ns);
        }
        return true;
    }
    if (!is_digits(status) || status_number(status) < 50 || status_number(status) > 97 ||
        s->state == DX_SCIP_FAULT_QT || s->state == DX_SCIP_FAULT_RS)
        return false;
    set_trouble(s, "hardware fault: status %02u", status_number(status));
    dx_scip_enter(s, DX_SCIP_FAULT_QT, now_ns);
    return true;
}

static void handle_flush(struct dx_scip_session *s, const uint8_t *echo, size_t len,
                         uint16_t status)
{
    if (len != 2 || memcmp(echo, "QT", 2))
        return;
    s->saw_qt = true;
    s->is_old = status != DX_SCIP_STATUS('0', '0');
}

static void handle_time(struct dx_scip_session *s, struct dx_scip_cursor lines, uint64_t now_ns)
{
    const uint8_t *line;
    size_t len;
    bool reset = false;

    if (dx_scip_next_line(&lines, &line, &len)) {
        uint32_t stamp_ms = dx_scip_stamp(line, len);

        if (stamp_ms != DX_SCIP_NO_STAMP)
            dx_scip_clock_sample(&s->clock, s->sent_ns, now_ns,
                                 dx_scip_clock_unwrap(&s->clock, stamp_ms, now_ns, &reset));
        s->counts.n_resets += reset;
    }
    dx_scip_enter(s, ++s->n_times < DX_SCIP_N_TIMES ? DX_SCIP_TM1 : DX_SCIP_TM2, now_ns);
}

/* The scanner will not stream what is asked for. */
static void handle_refusal(struct dx_scip_session *s, uint16_t status, uint64_t now_ns)
{
    set_trouble(s, "%s refused: status %c%c", s->request.command, status >> 8, status & 0xFF);
    back_off(s, now_ns);
}

/* What it says of itself. A damaged answer is asked for once more, when the time is over. */
static void handle_introduction(struct dx_scip_session *s, bool ok, struct dx_scip_cursor lines,
                                uint64_t now_ns)
{
    struct dx_scip_params params;

    if (s->state == DX_SCIP_SCIP2) {
        dx_scip_enter(s, DX_SCIP_VV, now_ns);
    } else if (s->state == DX_SCIP_VV) {
        if (ok && dx_scip_read_identity(&s->identity, lines)) {
            s->is_known = true;
            dx_scip_enter(s, DX_SCIP_PP, now_ns);
        }
    } else if (s->state == DX_SCIP_II) {
        if (ok && dx_scip_read_trouble(s->stat, sizeof(s->stat), lines))
            dx_scip_enter(s, DX_SCIP_TM0, now_ns);
    } else if (ok && dx_scip_read_params(&params, lines)) {
        s->params = params;
        if (dx_scip_make_request(s))
            dx_scip_enter(s, DX_SCIP_II, now_ns);
        else
            back_off(s, now_ns);
    }
}

static void handle_answer(struct dx_scip_session *s, uint16_t status, struct dx_scip_cursor lines,
                          uint64_t now_ns)
{
    bool ok = status == DX_SCIP_STATUS('0', '0');

    s->n_silent = 0;
    if (status == DX_SCIP_STATUS('0', 'B') &&
        s->state != DX_SCIP_STOPPING) { /* the same command is at work: wait for it */
        s->deadline_ns = now_ns + DX_SCIP_S / 10;
        return;
    }
    switch (s->state) {
    case DX_SCIP_SCIP2:
    case DX_SCIP_VV:
    case DX_SCIP_PP:
    case DX_SCIP_II:
        handle_introduction(s, ok, lines, now_ns);
        return;
    case DX_SCIP_TM0:
        dx_scip_enter(s, ok || status == DX_SCIP_STATUS('0', '2') ? DX_SCIP_TM1 : DX_SCIP_START,
                      now_ns);
        return;
    case DX_SCIP_TM1:
        handle_time(s, lines, now_ns);
        return;
    case DX_SCIP_TM2:
        dx_scip_clock_settle(&s->clock);
        dx_scip_enter(s, DX_SCIP_START, now_ns);
        return;
    case DX_SCIP_START:
        if (ok || status == DX_SCIP_STATUS('9', '9')) /* 99: the acceptance was damaged */
            dx_scip_enter(s, DX_SCIP_STREAM, now_ns);
        else
            handle_refusal(s, status, now_ns);
        return;
    case DX_SCIP_FAULT_QT:
        dx_scip_enter(s, DX_SCIP_FAULT_RS, now_ns);
        return;
    case DX_SCIP_FAULT_RS:
        back_off(s, now_ns);
        return;
    case DX_SCIP_REBOOT_1:
        dx_scip_enter(s, DX_SCIP_REBOOT_2, now_ns);
        return;
    case DX_SCIP_REBOOT_2:
        s->counts.n_restarts++;
        pause_for(s, 2 * DX_SCIP_S, now_ns);
        return;
    case DX_SCIP_STOPPING:
        dx_scip_enter(s, DX_SCIP_STOPPED, now_ns);
        return;
    default:
        return;
    }
}

/* ---- the stream -------------------------------------------------------------------------------
 */

static void handle_damage(struct dx_scip_session *s, uint64_t now_ns)
{
    dx_scip_lines_resync(&s->lines, s->request.command, ECHO_LEN);
    s->counts.n_bad++;
    if (now_ns - s->bad_ns >= DX_SCIP_S) {
        s->bad_ns = now_ns;
        s->n_bad_now = 0;
    }
    if (++s->n_bad_now < BAD_A_SECOND)
        return;
    set_trouble(s, "%u damaged scans in a second: stream restarted", s->n_bad_now);
    restart(s, now_ns);
}

static void count_lost(struct dx_scip_session *s, uint64_t device_ns)
{
    double between = (double)(device_ns - s->last_device_ns) /
                     (dx_scip_period_ns(&s->params) * (s->request.skip + 1));

    uint64_t n_bad = s->counts.n_bad - s->n_bad_before, n_between;

    if (s->n_since_start++ > 0 && device_ns > s->last_device_ns && between > 1.5) {
        n_between = (uint64_t)(between - 0.5);
        s->counts.n_lost += n_between > n_bad ? n_between - n_bad : 0;
    }
    s->last_device_ns = device_ns;
    s->n_bad_before = s->counts.n_bad;
}

static void handle_scan(struct dx_scip_session *s, struct dx_scip_scan *scan, uint64_t now_ns)
{
    double step_ns = dx_scip_period_ns(&s->params) / s->params.ares;
    bool reset;

    scan->bytes = s->lines.reply;
    scan->len = s->lines.len;
    scan->arrival_ns = now_ns;
    scan->degraded = s->suspended;
    scan->device_ns = dx_scip_clock_unwrap(&s->clock, scan->head.stamp_ms, now_ns, &reset);
    s->counts.n_resets += reset;
    dx_scip_clock_arrival(&s->clock, scan->device_ns + (uint64_t)(step_ns * (s->request.last + 1)),
                          now_ns);
    scan->host_ns = dx_scip_clock_host(&s->clock, scan->device_ns);
    scan->unsure = !s->clock.is_sampled;
    count_lost(s, scan->device_ns);
    s->counts.n_scans++;
    s->life_ns = now_ns;
    s->asked = false;
    s->scan = *scan;
    s->scan_ready = true;
    if (now_ns - s->run_from_ns > CALM_NS)
        dx_backoff_reset(&s->backoff);
    if (!s->suspended && s->n_since_start == 2) /* it runs: what was before is over */
        s->trouble[0] = 0;
    s->deadline_ns = now_ns + dx_scip_quiet_ns(s);
}

/* 21-49: no scans while the scanner verifies an abnormality; 98: it goes on. */
static bool handle_suspension(struct dx_scip_session *s, uint16_t status, uint64_t now_ns)
{
    unsigned n = is_digits(status) ? status_number(status) : 0;

    if (n >= 21 && n <= 49) {
        set_trouble(s, "measurement suspended by the scanner: status %02u", n);
        s->suspended = true;
    } else if (n == 98) {
        s->suspended = false;
        s->trouble[0] = 0;
    } else {
        return false;
    }
    s->life_ns = now_ns;
    s->deadline_ns = now_ns + dx_scip_quiet_ns(s);
    return true;
}

static void handle_stream(struct dx_scip_session *s, uint16_t status, uint64_t now_ns)
{
    struct dx_scip_scan scan = {0};

    if (status == DX_SCIP_STATUS('9', '9')) {
        if (dx_scip_scan_check(&scan.head, s->lines.reply, s->lines.len))
            handle_scan(s, &scan, now_ns);
        else
            handle_damage(s, now_ns);
    } else if (status == 0) {
        handle_damage(s, now_ns);
    } else if (!handle_suspension(s, status, now_ns) && !handle_fault(s, status, now_ns) &&
               status != DX_SCIP_STATUS('0', '0')) {
        set_trouble(s, "stream ended: status %c%c", status >> 8, status & 0xFF);
        restart(s, now_ns);
    }
}

/* ---- in and out -------------------------------------------------------------------------------
 */

static bool is_stream_echo(const struct dx_scip_session *s, const uint8_t *echo, size_t len)
{
    return len >= ECHO_LEN && !memcmp(echo, s->request.command, ECHO_LEN);
}

static void handle_reply(struct dx_scip_session *s, uint64_t now_ns)
{
    struct dx_scip_cursor c = {s->lines.reply, s->lines.reply + s->lines.len};
    const uint8_t *echo, *line;
    size_t echo_len, len;
    uint16_t status = 0;

    if (!dx_scip_next_line(&c, &echo, &echo_len))
        return;
    if (dx_scip_next_line(&c, &line, &len))
        status = dx_scip_status(line, len);
    if (s->state == DX_SCIP_FLUSH) {
        handle_flush(s, echo, echo_len, status);
    } else if (s->state == DX_SCIP_STREAM) {
        if (is_stream_echo(s, echo, echo_len))
            handle_stream(s, status, now_ns);
        else if (echo_len == 2 && !memcmp(echo, "II", 2)) {
            if (!handle_fault(s, status, now_ns))
                dx_scip_read_trouble(s->stat, sizeof(s->stat), c);
        } else {
            handle_damage(s, now_ns);
        }
    } else if (dx_scip_is_echo(s, echo, echo_len) && (status || s->state == DX_SCIP_SCIP2)) {
        if (!handle_fault(s, status, now_ns))
            handle_answer(s, status, c, now_ns);
    }
}

static uint64_t flush_deadline(const struct dx_scip_session *s)
{
    uint64_t noise = s->sent_ns + DX_SCIP_NOISE;

    return s->quiet_ns < noise ? s->quiet_ns : noise;
}

size_t dx_scip_session_feed(struct dx_scip_session *s, const uint8_t *bytes, size_t len,
                            uint64_t now_ns)
{
    size_t used = 0;

    s->scan_ready = false;
    if (s->state == DX_SCIP_FLUSH && len) {
        s->quiet_ns = now_ns + DX_SCIP_SILENCE;
        s->deadline_ns = flush_deadline(s);
    }
    while (used < len && !s->scan_ready) {
        used += dx_scip_lines_feed(&s->lines, bytes + used, len - used);
        if (s->lines.done)
            handle_reply(s, now_ns);
    }
    return used;
}

/* FLUSH: it is silent, or it still talks: then it has not heard QT. */
static void end_flush(struct dx_scip_session *s, uint64_t now_ns)
{
    bool silent = now_ns >= s->quiet_ns;

    if (!silent && now_ns - s->sent_ns < DX_SCIP_NOISE)
        s->deadline_ns = flush_deadline(s);
    else if (!silent || (!s->saw_qt && s->tries + 1 < DX_SCIP_TRIES))
        try_again(s, now_ns);
    else
        dx_scip_enter(s, !s->saw_qt || s->is_old ? DX_SCIP_SCIP2 : DX_SCIP_VV, now_ns);
}

/* STREAM: no scan for four periods: is it well? For sixteen: anew. */
static void watch(struct dx_scip_session *s, uint64_t now_ns)
{
    uint64_t quiet = now_ns - s->life_ns, limit = 4 * dx_scip_quiet_ns(s);

    if (s->suspended && limit < DX_SCIP_MAX_SUSPENSION)
        limit = DX_SCIP_MAX_SUSPENSION;
    if (quiet >= limit) {
        set_trouble(s, "no scan for %.3g s: stream restarted", (double)quiet / 1e9);
        restart(s, now_ns);
        return;
    }
    if (!s->asked && quiet >= dx_scip_quiet_ns(s)) {
        s->asked = true;
        dx_scip_queue(s, "II");
    }
    s->deadline_ns = s->life_ns + (s->asked ? limit : dx_scip_quiet_ns(s));
}

void dx_scip_session_tick(struct dx_scip_session *s, uint64_t now_ns)
{
    if (now_ns < s->deadline_ns)
        return;
    switch (s->state) {
    case DX_SCIP_FLUSH:
        end_flush(s, now_ns);
        return;
    case DX_SCIP_STREAM:
        watch(s, now_ns);
        return;
    case DX_SCIP_PAUSE:
        dx_scip_enter(s, DX_SCIP_FLUSH, now_ns);
        return;
    case DX_SCIP_STOPPING:
        dx_scip_enter(s, DX_SCIP_STOPPED, now_ns);
        return;
    case DX_SCIP_STOPPED:
        s->deadline_ns = UINT64_MAX;
        return;
    default:
        try_again(s, now_ns);
    }
}

void dx_scip_session_sent(struct dx_scip_session *s, size_t n, uint64_t now_ns)
{
    s->out_len -= n;
    memmove(s->out, s->out + n, s->out_len);
    s->sent_ns = now_ns;
}

void dx_scip_session_stop(struct dx_scip_session *s, uint64_t now_ns)
{
    dx_scip_enter(s, s->state == DX_SCIP_STOPPED ? DX_SCIP_STOPPED : DX_SCIP_STOPPING, now_ns);
}
