/*
 * Edges of an encoder in any order, with any stamps: lost, bounced, reordered, of lines that are
 * none; through the order of several queues, the count and the track, as stage_encoder.c puts them
 * together. What must hold whatever comes: no event is lost or made up, a count moves by what an
 * edge can mean and is doubted when it may be wrong, and the track tells places between its edges.
 *
 * Input: 1 byte of flags (1: an index line, 2: a queue a line), 1 of counts a turn, then pairs of
 * bytes: what, and a number (see step()).
 */
#include "drivers/gpio/angle_track.h"
#include "drivers/gpio/edge_merge.h"
#include "drivers/gpio/quadrature.h"

#include <math.h>
#include <stdlib.h>

#define MAX_POINTS 8

#define MUST(condition)                                                                            \
    do {                                                                                           \
        if (!(condition))                                                                          \
            abort();                                                                               \
    } while (0)

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len);

static struct dx_quadrature quadrature;
static struct dx_edge_merge merge;
static struct dx_angle_track track;
static bool per_line;
static uint64_t now_ns;
static uint32_t n_pushed[DX_EDGE_MERGE_LINES], n_popped[DX_EDGE_MERGE_LINES];
static uint64_t newest_ns; /* given out by the merge */

/* ---- the count ----------------------------------------------------------------------------------
 */

/* 00 10 11 01: its place in a cycle. */
static int64_t place_of(uint8_t state)
{
    static const int64_t places[4] = {0, 3, 1, 2};

    MUST(state < 4);
    return places[state];
}

static void check_count(const struct dx_quadrature *before, unsigned result)
{
    const struct dx_quadrature *q = &quadrature;
    int64_t moved = q->count - before->count, turn = q->counts_per_turn;

    MUST(q->dir >= -1 && q->dir <= 1 && q->z_dir >= -1 && q->z_dir <= 1);
    MUST(q->n_doubts - before->n_doubts <= 2);
    MUST(!(result & DX_QUADRATURE_DOUBT) == (q->n_doubts == before->n_doubts));
    MUST(!(result & DX_QUADRATURE_DOUBT) || q->is_uncertain);
    MUST(!(result & DX_QUADRATURE_REZEROED) || result & DX_QUADRATURE_INDEX);
    if (result & DX_QUADRATURE_INDEX) { /* it is right from here on: a count beside a turn */
        int64_t rest = (q->count % turn + turn) % turn;

        MUST(!q->is_uncertain && q->is_indexed);
        MUST(rest <= 2 || rest >= turn - 2);
        MUST(llabs(moved) <= turn / 2 + 1);
    } else {
        MUST(q->is_uncertain || !before->is_uncertain);
        MUST(llabs(moved) <= 2);
        MUST(result & DX_QUADRATURE_MOVED || moved == 0);
    }
    if (!q->has_index && q->n_doubts == 0) /* nothing was missed: the lines agree with the count */
        MUST((q->count - place_of(q->state)) % 4 == 0);
}

static void follow(uint64_t t_ns, unsigned result)
{
    const struct dx_quadrature *q = &quadrature;
    double at = (double)(q->dir > 0 ? q->count : q->count + 1);

    if (result & DX_QUADRATURE_INDEX)
        dx_angle_track_index(&track, (result & DX_QUADRATURE_REZEROED) != 0);
    if (!(result & DX_QUADRATURE_MOVED))
        at = dx_angle_track_at(&track, t_ns).counts;
    if (result & (DX_QUADRATURE_MOVED | DX_QUADRATURE_DOUBT))
        dx_angle_track_put(&track, t_ns, at, q->is_uncertain);
}

static void one_edge(const struct dx_gpio_event *e, bool doubt)
{
    struct dx_quadrature before = quadrature;
    unsigned result = dx_quadrature_edge(&quadrature, (enum dx_quadrature_line)e->line, e->rising,
                                         doubt || e->overflow);

    if (e->line != DX_QUADRATURE_Z) /* whatever came before, the line stands so now */
        MUST((quadrature.state >> (e->line == DX_QUADRATURE_A ? 1 : 0) & 1) == e->rising);
    check_count(&before, result);
    follow(e->timestamp_ns, result);
}

static void levels(uint64_t t_ns, bool a, bool b, bool at_once)
{
    struct dx_quadrature before = quadrature;
    unsigned result =
        at_once ? dx_quadrature_both(&quadrature, a, b) : dx_quadrature_levels(&quadrature, a, b);

    MUST(quadrature.state == (a << 1 | b));
    check_count(&before, result);
    follow(t_ns, result);
}

/* ---- the order ----------------------------------------------------------------------------------
 */

/* Its number on its line was put where nothing else looks. */
static void check_event(const struct dx_gpio_event *e)
{
    MUST(e->line < DX_EDGE_MERGE_LINES);
    MUST(e->seqno == ++n_popped[e->line]);
}

static void pop_all(uint64_t horizon_ns)
{
    struct dx_edge_merged m;

    while (dx_edge_merge_pop(&merge, horizon_ns, &m)) {
        MUST(m.n == 1 || m.n == 2);
        for (uint32_t k = 0; k < m.n; k++)
            check_event(&m.event[k]);
        MUST(m.is_late || m.event[0].timestamp_ns >= newest_ns);
        if (m.event[0].timestamp_ns > newest_ns)
            newest_ns = m.event[0].timestamp_ns;
        if (m.n == 1) {
            one_edge(&m.event[0], m.is_late);
            continue;
        }
        MUST(m.event[0].line == 0 && m.event[1].line == 1);
        MUST(m.event[0].timestamp_ns == m.event[1].timestamp_ns);
        levels(m.event[0].timestamp_ns, m.event[0].rising, m.event[1].rising, true);
    }
    for (uint32_t k = 0; k < DX_EDGE_MERGE_LINES; k++)
        MUST(n_pushed[k] - n_popped[k] == merge.line[k].n);
}

static void take_event(struct dx_gpio_event e)
{
    if (!per_line) {
        if (e.line < merge.n_lines) /* others were not asked for */
            one_edge(&e, false);
        return;
    }
    e.seqno = e.line < DX_EDGE_MERGE_LINES ? n_pushed[e.line] + 1 : 0;
    if (!dx_edge_merge_push(&merge, &e)) {
        MUST(merge.line[e.line].n == DX_EDGE_MERGE_DEPTH);
        pop_all(UINT64_MAX);
        if (!dx_edge_merge_push(&merge, &e))
            return;
    }
    if (e.line < merge.n_lines)
        n_pushed[e.line]++;
}

/* ---- the track ----------------------------------------------------------------------------------
 */

static void ask(uint64_t from_ns, uint64_t until_ns, size_t max)
{
    struct dx_track_point points[MAX_POINTS];
    size_t n = dx_angle_track_points(&track, from_ns, until_ns, points, max);

    MUST(n >= 1 && n <= max);
    MUST(points[0].host_ns == from_ns);
    MUST(until_ns <= from_ns ? n == 1 : points[n - 1].host_ns == until_ns);
    for (size_t k = 0; k < n; k++) {
        MUST(isfinite(points[k].counts));
        MUST(k == 0 || points[k].host_ns > points[k - 1].host_ns);
    }
}

/* Between two edges there is nothing else than what lies between them. */
static void check_between(void)
{
    const struct dx_track_point *a, *b;
    struct dx_track_point p;
    double low, high;

    if (track.n < 2)
        return;
    a = &track.edge[(track.n - 2) % DX_ANGLE_TRACK_LEN];
    b = &track.edge[(track.n - 1) % DX_ANGLE_TRACK_LEN];
    MUST(a->host_ns <= b->host_ns);
    if (b->host_ns - a->host_ns < 2)
        return;
    p = dx_angle_track_at(&track, a->host_ns + (b->host_ns - a->host_ns) / 2);
    low = fmin(a->counts, b->counts);
    high = fmax(a->counts, b->counts);
    MUST(p.counts >= low && p.counts <= high);
    MUST(p.is_uncertain == (a->is_uncertain || b->is_uncertain));
}

/* ---- the input ----------------------------------------------------------------------------------
 */

static void other_step(uint8_t what, uint8_t number)
{
    switch (what >> 2 & 7) {
    case 0:
        levels(now_ns, number & 1, number & 2, false);
        break;
    case 1:
        levels(now_ns, number & 1, number & 2, true);
        break;
    case 2:
        ask(now_ns - ((uint64_t)number << 12), now_ns + ((uint64_t)(number & 7) << 16),
            2 + number % (MAX_POINTS - 1));
        break;
    case 3:
        dx_angle_track_know(&track, now_ns);
        break;
    case 4:
        pop_all(number & 1 ? UINT64_MAX : now_ns);
        break;
    case 5: /* of a line that is none; the decoder of one queue is never asked for such */
        if (per_line)
            take_event((struct dx_gpio_event){.timestamp_ns = now_ns, .line = 3u + number});
        break;
    case 6:
        now_ns = number & 1 ? UINT64_MAX - number : number; /* a stamp that is nonsense */
        break;
    default:
        ask(now_ns, number, 2);
    }
}

/* `what`: bits 0-1 the line (3: something else), 2 it rises, 3 an overflow, 4 its stamp lies
 * before the last one, 5-7 how large the number's unit is. */
static void step(uint8_t what, uint8_t number)
{
    uint64_t by = (uint64_t)number << (4 * (what >> 5));

    if ((what & 3) == 3) {
        other_step(what, number);
        return;
    }
    now_ns = what & 16 ? now_ns - by : now_ns + by;
    take_event((struct dx_gpio_event){
        .timestamp_ns = now_ns, .line = what & 3, .rising = what & 4, .overflow = what & 8});
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len)
{
    bool has_index;

    if (len < 2)
        return 0;
    has_index = bytes[0] & 1;
    per_line = bytes[0] & 2;
    now_ns = 1000000000u;
    newest_ns = 0;
    for (uint32_t k = 0; k < DX_EDGE_MERGE_LINES; k++)
        n_pushed[k] = n_popped[k] = 0;
    dx_quadrature_init(&quadrature, 8 + 4u * bytes[1], has_index, false, false);
    dx_edge_merge_init(&merge, has_index ? 3 : 2);
    dx_angle_track_init(&track, now_ns, 0, has_index);
    for (size_t at = 2; at + 2 <= len; at += 2) {
        step(bytes[at], bytes[at + 1]);
        check_between();
    }
    pop_all(UINT64_MAX);
    check_between();
    ask(0, UINT64_MAX, MAX_POINTS);
    return 0;
}
