/* Which frame belongs to which edge. */
#include "drivers/gpio/trigger_queue.h"

#define SMOOTHING 8 /* the delay follows by an eighth */
#define N_LONG    8 /* long gaps in a row that are a new period, and not edges that were lost */

void dx_trigger_queue_init(struct dx_trigger_queue *q, uint64_t max_delay_ns)
{
    *q = (struct dx_trigger_queue){.max_delay_ns = max_delay_ns};
}

void dx_trigger_queue_restart(struct dx_trigger_queue *q)
{
    q->next = q->n_edges;
    q->is_paired = false;
    q->last_edge_ns = q->period_ns = 0;
    q->n_long = 0;
}

/* From edge to edge. A gap that is longer than before is mostly an edge that was lost. */
static void learn_period(struct dx_trigger_queue *q, uint64_t gap_ns)
{
    bool is_long = q->period_ns && gap_ns > q->period_ns + q->period_ns / 2;

    q->n_long = is_long ? q->n_long + 1 : 0;
    if (!is_long || q->n_long >= N_LONG)
        q->period_ns = gap_ns;
}

void dx_trigger_queue_edge(struct dx_trigger_queue *q, uint64_t t_ns, uint64_t min_gap_ns,
                           bool doubt)
{
    if (q->last_edge_ns && t_ns - q->last_edge_ns < min_gap_ns) {
        q->n_glitches++;
        return;
    }
    if (doubt)
        q->is_paired = false;
    else if (q->last_edge_ns && t_ns > q->last_edge_ns)
        learn_period(q, t_ns - q->last_edge_ns);
    q->last_edge_ns = t_ns;
    q->edge_ns[q->n_edges++ % DX_TRIGGER_QUEUE_LEN] = t_ns;
    if (q->n_edges - q->next > DX_TRIGGER_QUEUE_LEN) /* no frames come: the oldest is gone */
        q->next = q->n_edges - DX_TRIGGER_QUEUE_LEN;
}

static uint64_t edge(const struct dx_trigger_queue *q, uint64_t number)
{
    return q->edge_ns[number % DX_TRIGGER_QUEUE_LEN];
}

/* Could it be this edge's frame? */
static bool is_possible(const struct dx_trigger_queue *q, uint64_t number, uint64_t arrival_ns)
{
    uint64_t e = edge(q, number);

    return e <= arrival_ns && arrival_ns - e <= q->max_delay_ns;
}

static uint64_t distance(uint64_t a, uint64_t b)
{
    return a > b ? a - b : b - a;
}

/* Does its delay say that it is this edge's, and not that of one beside it? */
static bool fits(const struct dx_trigger_queue *q, uint64_t number, uint64_t arrival_ns)
{
    uint64_t delay = arrival_ns - edge(q, number);

    return !q->is_paired || q->period_ns == 0 || distance(delay, q->delay_ns) <= q->period_ns / 2;
}

/* The possible edge whose delay is nearest to what was usual, or the newest. n_edges: none. */
static uint64_t seek(const struct dx_trigger_queue *q, uint64_t arrival_ns)
{
    uint64_t best = q->n_edges, best_off = 0;

    for (uint64_t k = q->next; k < q->n_edges; k++) {
        uint64_t off = distance(arrival_ns - edge(q, k), q->delay_ns);

        if (!is_possible(q, k, arrival_ns))
            continue;
        if (best == q->n_edges || q->delay_ns == 0 || off < best_off) {
            best = k;
            best_off = off;
        }
    }
    return best;
}

static void pair(struct dx_trigger_queue *q, uint64_t number, uint64_t arrival_ns)
{
    uint64_t delay = arrival_ns - edge(q, number);

    if (!q->is_paired && (q->delay_ns == 0 || distance(delay, q->delay_ns) > q->period_ns / 2))
        q->delay_ns = delay;
    else
        q->delay_ns = q->delay_ns - q->delay_ns / SMOOTHING + delay / SMOOTHING;
    q->is_paired = true;
    q->next = number + 1;
    q->n_pairs++;
}

bool dx_trigger_queue_frame(struct dx_trigger_queue *q, uint64_t arrival_ns, uint64_t n_missed,
                            uint64_t *edge_ns)
{
    uint64_t left = q->n_edges - q->next, number;

    q->n_frames++;
    q->next += n_missed < left ? n_missed : left;
    number = q->next;
    if (number == q->n_edges || !q->is_paired || !is_possible(q, number, arrival_ns) ||
        !fits(q, number, arrival_ns)) {
        q->n_resyncs += q->is_paired && number < q->n_edges;
        number = seek(q, arrival_ns);
        if (number == q->n_edges) /* none: it keeps its own stamp, and the delay stays */
            return false;
        if (q->is_paired && !fits(q, number, arrival_ns))
            return false; /* its edge was lost; the next frames have theirs */
    }
    *edge_ns = edge(q, number);
    pair(q, number, arrival_ns);
    return true;
}
