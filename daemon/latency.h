/*
 * A histogram of latencies in logarithmic buckets, eight to an octave: quantiles to one part in
 * eight, in fixed room. It forgets: when full its counts are halved, so that it tells of the last
 * few thousand. Beside it a coarse one that forgets nothing, for metrics. One owner (the loop).
 */
#ifndef DX_LATENCY_H
#define DX_LATENCY_H

#include <stdint.h>

#define DX_LATENCY_BUCKETS 512
#define DX_LATENCY_FULL    4096u
#define DX_LATENCY_BOUNDS  16

struct dx_latency {
    uint32_t n;
    uint32_t bucket[DX_LATENCY_BUCKETS];
    uint64_t n_within[DX_LATENCY_BOUNDS + 1]; /* up to each bound and above the one before it; the
                                                 last: above all */
    uint64_t sum_ns;
};

/* Of the coarse one, ascending, and as metrics write it in seconds. */
static const struct dx_latency_bound {
    uint64_t ns;
    const char *seconds;
} dx_latency_bounds[DX_LATENCY_BOUNDS] = {
    {50000, "0.00005"}, {100000, "0.0001"},  {200000, "0.0002"},  {500000, "0.0005"},
    {1000000, "0.001"}, {2000000, "0.002"},  {5000000, "0.005"},  {10000000, "0.01"},
    {20000000, "0.02"}, {50000000, "0.05"},  {100000000, "0.1"},  {200000000, "0.2"},
    {500000000, "0.5"}, {1000000000, "1.0"}, {2000000000, "2.0"}, {5000000000, "5.0"},
};

static inline uint32_t dx_latency_bucket(uint64_t ns)
{
    uint32_t octave = ns < 8 ? 0 : 60 - (uint32_t)__builtin_clzll(ns);

    return octave * 8 + (uint32_t)(ns >> octave & 7) + (ns < 8 ? 0 : 8);
}

static inline void dx_latency_add(struct dx_latency *h, uint64_t ns)
{
    int k = 0;

    while (k < DX_LATENCY_BOUNDS && ns > dx_latency_bounds[k].ns)
        k++;
    h->n_within[k]++;
    h->sum_ns += ns;
    if (h->n >= DX_LATENCY_FULL) {
        h->n = 0;
        for (k = 0; k < DX_LATENCY_BUCKETS; k++)
            h->n += h->bucket[k] /= 2;
    }
    h->bucket[dx_latency_bucket(ns)]++;
    h->n++;
}

/* The lower edge of the bucket where the quantile (0..1) lies; 0 when nothing was added. */
static inline uint64_t dx_latency_quantile(const struct dx_latency *h, double q)
{
    uint32_t rank = (uint32_t)(q * h->n), k = 0;

    if (h->n == 0)
        return 0;
    while (k < DX_LATENCY_BUCKETS - 1 && rank >= h->bucket[k])
        rank -= h->bucket[k++];
    return k < 8 ? k : (uint64_t)(8 + k % 8) << (k / 8 - 1);
}

#endif
