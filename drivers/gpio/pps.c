/* Medians over the last pulses. */
#include "drivers/gpio/pps.h"

#include <stdlib.h>

#define NS         1000000000
#define MAX_OFF    500000 /* of a second between pulses: clocks are better, noise is not */
#define MAX_GAP_S  10
#define MIN_PULSES 3

void dx_pps_init(struct dx_pps *p)
{
    *p = (struct dx_pps){.n = 0};
}

/* The nearest second to a time, and how far the time is behind it. */
static int64_t behind_second(uint64_t ns)
{
    int64_t rest = (int64_t)(ns % NS);

    return rest > NS / 2 ? rest - NS : rest;
}

static bool is_regular(const struct dx_pps *p, uint64_t mono_ns)
{
    uint64_t last = p->mono_ns[(p->n - 1) % DX_PPS_WINDOW], gap;
    int64_t off;

    if (mono_ns <= last)
        return false;
    gap = mono_ns - last;
    off = behind_second(gap);
    return gap > NS / 2 && gap < (uint64_t)MAX_GAP_S * NS && off > -MAX_OFF && off < MAX_OFF;
}

void dx_pps_pulse(struct dx_pps *p, uint64_t mono_ns, uint64_t real_ns)
{
    p->n_pulses++;
    if (p->n > 0 && !is_regular(p, mono_ns)) {
        p->n_bad++;
        if (p->n >= MIN_PULSES &&
            mono_ns < p->mono_ns[(p->n - 1) % DX_PPS_WINDOW] + MAX_GAP_S * (uint64_t)NS)
            return; /* the ones before agree: this one is the false one */
        p->n = 0;
    }
    p->mono_ns[p->n % DX_PPS_WINDOW] = mono_ns;
    p->offset_ns[p->n % DX_PPS_WINDOW] = behind_second(real_ns);
    p->n++;
}

static int compare(const void *a, const void *b)
{
    const int64_t *x = a, *y = b;

    return *x < *y ? -1 : *x > *y;
}

static int64_t median(int64_t *values, uint32_t n)
{
    qsort(values, n, sizeof(*values), compare);
    return values[n / 2];
}

static int64_t rate_ppb(const struct dx_pps *p, uint32_t n)
{
    uint64_t first = p->mono_ns[(p->n - n) % DX_PPS_WINDOW];
    uint64_t took = p->mono_ns[(p->n - 1) % DX_PPS_WINDOW] - first;
    int64_t seconds = (int64_t)((took + NS / 2) / NS);

    return ((int64_t)took - seconds * NS) / seconds;
}

void dx_pps_state(const struct dx_pps *p, uint64_t now_ns, struct dx_pps_state *out)
{
    uint32_t n = p->n < DX_PPS_WINDOW ? (uint32_t)p->n : DX_PPS_WINDOW;
    int64_t values[DX_PPS_WINDOW];

    *out = (struct dx_pps_state){.is_locked = false};
    if (n < MIN_PULSES)
        return;
    for (uint32_t k = 0; k < n; k++)
        values[k] = p->offset_ns[k];
    out->offset_ns = median(values, n);
    for (uint32_t k = 0; k < n; k++)
        values[k] = llabs(p->offset_ns[k] - out->offset_ns);
    out->jitter_ns = median(values, n);
    out->rate_ppb = rate_ppb(p, n);
    out->is_locked = now_ns < p->mono_ns[(p->n - 1) % DX_PPS_WINDOW] + MAX_GAP_S * (uint64_t)NS;
}
