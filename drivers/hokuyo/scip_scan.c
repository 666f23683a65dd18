/* Scans: checked, and to ranges. */
#include "drivers/hokuyo/scip_scan.h"

#include "drivers/hokuyo/scip_code.h"

#include <errno.h>
#include <string.h>

#define STAMP_CHARS     4
#define INTENSITY_CHARS 3
#define FAR_REASON      255 /* beyond DMAX; codes of scanners are below it */

bool dx_scip_format_of(struct dx_scip_format *f, const uint8_t command[2])
{
    static const struct {
        char name[3];
        struct dx_scip_format format;
    } known[] = {
        {"MD", {3, false, false}}, {"GD", {3, false, false}}, {"MS", {2, false, false}},
        {"GS", {2, false, false}}, {"ME", {3, true, false}},  {"GE", {3, true, false}},
        {"ND", {3, false, true}},  {"HD", {3, false, true}},  {"NE", {3, true, true}},
        {"HE", {3, true, true}},
    };

    for (size_t k = 0; k < sizeof(known) / sizeof(known[0]); k++)
        if (!memcmp(known[k].name, command, 2)) {
            *f = known[k].format;
            return true;
        }
    return false;
}

uint16_t dx_scip_status(const uint8_t *line, size_t len)
{
    if (len != 3 || !dx_scip_sum_holds(line, len))
        return 0;
    return (uint16_t)(line[0] << 8 | line[1]);
}

bool dx_scip_scan_check(struct dx_scip_head *head, const uint8_t *reply, size_t len)
{
    struct dx_scip_cursor c = {reply, reply + len};
    const uint8_t *line;
    size_t n;

    if (len < 2 || memcmp(reply + len - 2, "\n\n", 2) || !dx_scip_next_line(&c, &line, &n) ||
        !dx_scip_next_line(&c, &line, &n))
        return false;
    head->status = dx_scip_status(line, n);
    if (!head->status || !dx_scip_next_line(&c, &line, &n) || n != STAMP_CHARS + 1 ||
        !dx_scip_sum_holds(line, n))
        return false;
    head->stamp_ms = dx_scip_get(line, STAMP_CHARS);
    head->data = c;
    while (dx_scip_next_line(&c, &line, &n))
        if (!dx_scip_sum_holds(line, n))
            return false;
    return head->stamp_ms != DX_SCIP_INVALID && head->data.p < c.p;
}

/* The data characters of a scan as one stream, over the ends of lines. */
struct stream {
    struct dx_scip_cursor lines;
    const uint8_t *p, *end;
};

/* The next character without taking it, or -1. */
static int peek(struct stream *s)
{
    const uint8_t *line;
    size_t len;

    while (s->p == s->end) {
        if (!dx_scip_next_line(&s->lines, &line, &len))
            return -1;
        s->p = line;
        s->end = line + len - 1; /* without the check character */
    }
    return *s->p;
}

static uint32_t take_number(struct stream *s, size_t n)
{
    uint8_t chars[4];

    if ((size_t)(s->end - s->p) >= n) { /* most of them lie in one line */
        s->p += n;
        return dx_scip_get(s->p - n, n);
    }
    for (size_t k = 0; k < n; k++) {
        int c = peek(s);

        if (c < 0)
            return DX_SCIP_INVALID;
        chars[k] = (uint8_t)c;
        s->p++;
    }
    return dx_scip_get(chars, n);
}

struct echo {
    uint32_t mm, intensity;
};

static bool take_echo(struct stream *s, const struct dx_scip_format *f, struct echo *e)
{
    e->mm = take_number(s, f->chars);
    e->intensity = f->intensity ? take_number(s, INTENSITY_CHARS) : 0;
    return e->mm != DX_SCIP_INVALID && e->intensity != DX_SCIP_INVALID;
}

static bool is_return(const struct dx_scip_params *p, uint32_t mm)
{
    return mm >= p->dmin && mm <= p->dmax && mm > 0;
}

/* Of two echoes of a step, `b` the later one: which counts? One that is no return never does while
 * the other is. */
static bool is_better(const struct dx_scip_params *p, enum dx_scip_echo choice,
                      const struct echo *b, const struct echo *a)
{
    if (is_return(p, a->mm) != is_return(p, b->mm))
        return is_return(p, b->mm);
    return choice == DX_SCIP_LAST || (choice == DX_SCIP_STRONGEST && b->intensity > a->intensity);
}

static bool take_step(struct stream *s, const struct dx_scip_params *p,
                      const struct dx_scip_format *f, enum dx_scip_echo choice, struct echo *best)
{
    struct echo e;

    if (!take_echo(s, f, best))
        return false;
    for (int k = 1; f->echoes && peek(s) == '&'; k++) {
        s->p++;
        if (k == DX_SCIP_MAX_ECHOES || !take_echo(s, f, &e))
            return false;
        if (is_better(p, choice, &e, best))
            *best = e;
    }
    return true;
}

int dx_scip_scan_decode(uint32_t *range_mm, uint8_t *reason, uint16_t *intensity, uint32_t n,
                        struct dx_scip_tally *tally, const struct dx_scip_params *params,
                        const struct dx_scip_format *format, enum dx_scip_echo choice,
                        struct dx_scip_cursor data, struct dx_err *err)
{
    struct stream s = {.lines = data};
    struct dx_scip_tally t = {0};

    for (uint32_t k = 0; k < n; k++) {
        struct echo e;
        bool there, far;

        if (!take_step(&s, params, format, choice, &e))
            return dx_err_set(err, -EBADMSG, "value %u of %u is no number", k, n);
        there = is_return(params, e.mm);
        far = !there && e.mm > params->dmax;
        range_mm[k] = there ? e.mm : 0;
        if (reason)
            reason[k] = there ? 0 : far || e.mm >= FAR_REASON ? FAR_REASON : (uint8_t)e.mm;
        if (intensity)
            intensity[k] = e.intensity > 65535 ? 65535 : (uint16_t)e.intensity;
        t.n_returns += there;
        t.n_far += far;
        t.n_near += !there && !far;
    }
    if (peek(&s) >= 0)
        return dx_err_set(err, -EBADMSG, "more than the %u values that were asked for", n);
    if (tally)
        *tally = t;
    return 0;
}

static const char *urg_reason(uint8_t reason)
{
    switch (reason) {
    case 0:
        return "out of reach";
    case 1:
    case 2:
        return "low intensity";
    case 7:
        return "in disagreement with its neighbours";
    case 8:
        return "the two waves differ in intensity";
    case 9:
        return "failed in the last two scans";
    case 18:
        return "strong reflector";
    case 19:
        return "not measurable";
    default:
        return "other";
    }
}

static const char *utm_reason(uint8_t reason)
{
    switch (reason) {
    case 1:
        return "no object";
    case 2:
        return "too near, within the scanner";
    case 3:
        return "error or interference";
    case 4:
        return "too near";
    default:
        return "other";
    }
}

const char *dx_scip_reason_text(enum dx_scip_class class, uint8_t reason)
{
    if (reason == FAR_REASON)
        return "beyond the largest range";
    return class == DX_SCIP_CLASS_UTM ? utm_reason(reason) : urg_reason(reason);
}
