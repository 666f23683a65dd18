/* The order of events of several queues. */
#include "drivers/gpio/edge_merge.h"

void dx_edge_merge_init(struct dx_edge_merge *m, uint32_t n_lines)
{
    *m = (struct dx_edge_merge){.n_lines = n_lines, .last_line = n_lines};
}

bool dx_edge_merge_push(struct dx_edge_merge *m, const struct dx_gpio_event *event)
{
    uint32_t k = event->line, at;

    if (k >= m->n_lines)
        return true; /* of no interest */
    if (m->line[k].n == DX_EDGE_MERGE_DEPTH)
        return false;
    at = (m->line[k].head + m->line[k].n++) % DX_EDGE_MERGE_DEPTH;
    m->line[k].event[at] = *event;
    return true;
}

/* NULL: the line has told nothing. */
static const struct dx_gpio_event *head_of(const struct dx_edge_merge *m, uint32_t k)
{
    return m->line[k].n ? &m->line[k].event[m->line[k].head] : NULL;
}

static struct dx_gpio_event take(struct dx_edge_merge *m, uint32_t k)
{
    struct dx_gpio_event e = m->line[k].event[m->line[k].head];

    m->line[k].head = (m->line[k].head + 1) % DX_EDGE_MERGE_DEPTH;
    m->line[k].n--;
    return e;
}

bool dx_edge_merge_pop(struct dx_edge_merge *m, uint64_t horizon_ns, struct dx_edge_merged *out)
{
    const struct dx_gpio_event *first = NULL, *other;
    bool all_told = true, follows_a_tie;

    for (uint32_t k = 0; k < m->n_lines; k++) {
        const struct dx_gpio_event *e = head_of(m, k);

        all_told &= e != NULL;
        if (e && (!first || e->timestamp_ns < first->timestamp_ns))
            first = e;
    }
    if (!first || (!all_told && first->timestamp_ns >= horizon_ns))
        return false;
    follows_a_tie = first->timestamp_ns == m->last_ns && m->last_line == (first->line ^ 1u);
    *out = (struct dx_edge_merged){.n = 1,
                                   .is_late = first->timestamp_ns < m->last_ns || follows_a_tie};
    out->event[0] = take(m, first->line);
    other = out->event[0].line == 0 ? head_of(m, 1) : NULL;
    if (other && other->timestamp_ns == out->event[0].timestamp_ns)
        out->event[out->n++] = take(m, 1);
    if (out->event[0].timestamp_ns >= m->last_ns) {
        m->last_ns = out->event[0].timestamp_ns;
        m->last_line = out->event[out->n - 1].line;
    }
    return true;
}

bool dx_edge_merge_waits(const struct dx_edge_merge *m)
{
    for (uint32_t k = 0; k < m->n_lines; k++)
        if (m->line[k].n)
            return true;
    return false;
}
