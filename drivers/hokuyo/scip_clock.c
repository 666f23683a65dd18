/* Unwrapping, and the offset. */
#include "drivers/hokuyo/scip_clock.h"

#include <string.h>

#define NS_PER_MS 1000000u
#define NS_PER_S  1000000000u

/* A stamp may be so far from what the host's clock says before it counts as a reset: a scan that
 * was held up, and 1000 ppm of drift. */
#define SLACK_MS    2000.0
#define SLACK_DRIFT 1e-3

void dx_scip_clock_init(struct dx_scip_clock *c)
{
    *c = (struct dx_scip_clock){0};
}

/* The scanner's clock begins anew: device time goes on, so that it never runs backwards. */
static void begin_anew(struct dx_scip_clock *c)
{
    c->have_offset = c->is_sampled = c->have_reference = false;
    c->n_buckets = c->n_samples = 0;
}

uint64_t dx_scip_clock_unwrap(struct dx_scip_clock *c, uint32_t stamp_ms, uint64_t host_ns,
                              bool *reset)
{
    double passed_ms = host_ns > c->last_host_ns ? (double)(host_ns - c->last_host_ns) / 1e6 : 0;
    double off, wraps = 0;
    uint32_t step = (stamp_ms - c->last_ms) & (DX_SCIP_WRAP_MS - 1);

    *reset = false;
    if (!c->running) {
        c->device_ms = stamp_ms;
    } else {
        /* as many whole wraps as the host's time says; the nearest */
        off = passed_ms - step;
        if (off > 0)
            wraps = (double)(uint64_t)(off / DX_SCIP_WRAP_MS + 0.5);
        off -= wraps * DX_SCIP_WRAP_MS;
        if (off < 0)
            off = -off;
        /* a little back: two stamps out of order, or of the same instant */
        if (step > DX_SCIP_WRAP_MS - 1000 && passed_ms < SLACK_MS)
            return (c->device_ms - (DX_SCIP_WRAP_MS - step)) * NS_PER_MS;
        if (off > SLACK_MS + SLACK_DRIFT * passed_ms) {
            *reset = true;
            begin_anew(c);
            c->device_ms += (uint64_t)passed_ms;
        } else {
            c->device_ms += step + (uint64_t)wraps * DX_SCIP_WRAP_MS;
        }
    }
    c->running = true;
    c->last_ms = stamp_ms;
    c->last_host_ns = host_ns;
    return c->device_ms * NS_PER_MS;
}

void dx_scip_clock_sample(struct dx_scip_clock *c, uint64_t sent_ns, uint64_t got_ns,
                          uint64_t device_ns)
{
    if (c->n_samples < DX_SCIP_MAX_SAMPLES)
        c->sample[c->n_samples++] = (struct dx_scip_time_sample){sent_ns, got_ns, device_ns};
}

static uint64_t exchange(const struct dx_scip_time_sample *s)
{
    return s->got_ns - s->sent_ns;
}

static int64_t offset_of(const struct dx_scip_time_sample *s)
{
    return (int64_t)(s->sent_ns + exchange(s) / 2 - s->device_ns);
}

bool dx_scip_clock_settle(struct dx_scip_clock *c)
{
    struct dx_scip_time_sample s;
    unsigned quarter = (c->n_samples + 3) / 4;

    if (c->n_samples == 0)
        return false;
    for (unsigned i = 1; i < c->n_samples; i++) { /* the shortest exchanges first */
        unsigned k = i;

        for (s = c->sample[i]; k > 0 && exchange(&s) < exchange(&c->sample[k - 1]); k--)
            c->sample[k] = c->sample[k - 1];
        c->sample[k] = s;
    }
    for (unsigned i = 1; i < quarter; i++) { /* of these, by offset */
        unsigned k = i;

        for (s = c->sample[i]; k > 0 && offset_of(&s) < offset_of(&c->sample[k - 1]); k--)
            c->sample[k] = c->sample[k - 1];
        c->sample[k] = s;
    }
    c->offset_ns =
        (offset_of(&c->sample[(quarter - 1) / 2]) + offset_of(&c->sample[quarter / 2])) / 2;
    c->have_offset = c->is_sampled = true;
    c->have_reference = false;
    c->n_buckets = c->n_samples = 0;
    return true;
}

static int64_t envelope(const struct dx_scip_clock *c)
{
    int64_t least = c->bucket[0];

    for (unsigned k = 1; k < DX_SCIP_N_BUCKETS; k++)
        least = c->bucket[k] < least ? c->bucket[k] : least;
    return least;
}

/* A second is over. With a full window the envelope is known: the first one is what the offset
 * found at the start stands for, and the offset follows how it moves. */
static void next_bucket(struct dx_scip_clock *c)
{
    int64_t now;

    if (c->n_buckets < DX_SCIP_N_BUCKETS)
        return;
    now = envelope(c);
    if (!c->have_reference)
        c->reference_ns = now;
    c->have_reference = true;
    c->offset_ns += now - c->reference_ns;
    c->reference_ns = now;
}

void dx_scip_clock_arrival(struct dx_scip_clock *c, uint64_t due_ns, uint64_t arrival_ns)
{
    int64_t late = (int64_t)(arrival_ns - due_ns);
    uint64_t second = arrival_ns / NS_PER_S;

    if (c->n_buckets == 0 || second != c->bucket_s) {
        next_bucket(c);
        c->at = (c->at + 1) % DX_SCIP_N_BUCKETS;
        c->n_buckets = c->n_buckets < DX_SCIP_N_BUCKETS ? c->n_buckets + 1 : c->n_buckets;
        c->bucket[c->at] = late;
        c->bucket_s = second;
    } else if (late < c->bucket[c->at]) {
        c->bucket[c->at] = late;
    }
    /* without time samples the least delay so far is all that is known */
    if (!c->have_offset || (!c->is_sampled && !c->have_reference && late < c->offset_ns)) {
        c->offset_ns = late;
        c->have_offset = true;
    }
}

uint64_t dx_scip_clock_host(const struct dx_scip_clock *c, uint64_t device_ns)
{
    return device_ns + (uint64_t)c->offset_ns;
}
