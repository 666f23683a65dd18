/* Interpolation of an encoder's counts. */
#include "drivers/gpio/angle_track.h"

static struct dx_track_point *edge(struct dx_angle_track *t, uint64_t number)
{
    return &t->edge[number % DX_ANGLE_TRACK_LEN];
}

static const struct dx_track_point *edge_at(const struct dx_angle_track *t, uint64_t number)
{
    return &t->edge[number % DX_ANGLE_TRACK_LEN];
}

static uint64_t oldest(const struct dx_angle_track *t)
{
    return t->n > DX_ANGLE_TRACK_LEN ? t->n - DX_ANGLE_TRACK_LEN : 0;
}

void dx_angle_track_init(struct dx_angle_track *t, uint64_t host_ns, double counts,
                         bool is_uncertain)
{
    t->n = 1;
    t->known_ns = host_ns;
    t->certain_from = 0;
    t->edge[0] = (struct dx_track_point){host_ns, counts, is_uncertain};
}

void dx_angle_track_put(struct dx_angle_track *t, uint64_t host_ns, double counts,
                        bool is_uncertain)
{
    uint64_t last_ns = edge(t, t->n - 1)->host_ns;

    *edge(t, t->n) =
        (struct dx_track_point){host_ns > last_ns ? host_ns : last_ns, counts, is_uncertain};
    t->n++;
}

void dx_angle_track_index(struct dx_angle_track *t, bool was_wrong)
{
    uint64_t k = t->certain_from > oldest(t) ? t->certain_from : oldest(t);

    for (; k < t->n && was_wrong; k++)
        edge(t, k)->is_uncertain = true;
    t->certain_from = t->n;
}

void dx_angle_track_know(struct dx_angle_track *t, uint64_t host_ns)
{
    if (host_ns > t->known_ns)
        t->known_ns = host_ns;
}

/* The number of the first edge later than a time; t->n: there is none. */
static uint64_t first_after(const struct dx_angle_track *t, uint64_t host_ns)
{
    uint64_t lo = oldest(t), hi = t->n;

    while (lo < hi) {
        uint64_t mid = lo + (hi - lo) / 2;

        if (edge_at(t, mid)->host_ns <= host_ns)
            lo = mid + 1;
        else
            hi = mid;
    }
    return lo;
}

/* Behind the last edge. */
static struct dx_track_point ahead(const struct dx_angle_track *t, uint64_t host_ns)
{
    const struct dx_track_point *last = edge_at(t, t->n - 1);
    const struct dx_track_point *before = t->n > oldest(t) + 1 ? edge_at(t, t->n - 2) : last;
    uint64_t period_ns = last->host_ns - before->host_ns;
    struct dx_track_point p = {host_ns, last->counts, last->is_uncertain};
    double step = last->counts - before->counts, periods;

    if (period_ns == 0 || (step != 1 && step != -1)) /* it turned back, or it is not known */
        return p;
    periods = (double)(host_ns - last->host_ns) / (double)period_ns;
    if (host_ns <= t->known_ns) {
        periods = periods < 1 ? periods : 1;
    } else if (periods > DX_ANGLE_TRACK_AHEAD) {
        periods = DX_ANGLE_TRACK_AHEAD;
        p.is_uncertain = true;
    }
    p.counts += periods * step;
    return p;
}

struct dx_track_point dx_angle_track_at(const struct dx_angle_track *t, uint64_t host_ns)
{
    uint64_t k = first_after(t, host_ns);
    const struct dx_track_point *a, *b;
    double share;

    if (k == t->n)
        return ahead(t, host_ns);
    b = edge_at(t, k);
    if (k == oldest(t)) /* forgotten, or before the beginning */
        return (struct dx_track_point){host_ns, b->counts, true};
    a = edge_at(t, k - 1);
    share = (double)(host_ns - a->host_ns) / (double)(b->host_ns - a->host_ns);
    return (struct dx_track_point){host_ns, a->counts + share * (b->counts - a->counts),
                                   a->is_uncertain || b->is_uncertain};
}

size_t dx_angle_track_points(const struct dx_angle_track *t, uint64_t from_ns, uint64_t until_ns,
                             struct dx_track_point *out, size_t max)
{
    uint64_t first = first_after(t, from_ns), end = first_after(t, until_ns), n_edges;
    size_t room = max - 2, n = 0;

    out[n++] = dx_angle_track_at(t, from_ns);
    if (until_ns <= from_ns)
        return n;
    n_edges = end - first;
    if (n_edges < room)
        room = (size_t)n_edges;
    for (size_t k = 0; k < room; k++) {
        const struct dx_track_point *e = edge_at(t, first + n_edges * k / room);

        if (e->host_ns >= until_ns || e->host_ns <= from_ns)
            continue;
        if (n > 1 && out[n - 1].host_ns == e->host_ns)
            n--; /* of edges at one instant the last */
        out[n++] = *e;
    }
    out[n++] = dx_angle_track_at(t, until_ns);
    return n;
}
