/*
 * A histogram of latencies in logarithmic buckets, eight to an octave: quantiles to one part in
 * eight, in fixed room. It forgets: when full its counts are halved, so that it tells of the last
 * few thousand. One owner (the loop).
 */
#ifndef DX_LATENCY_H
#define DX_LATENCY_H

#include <stdint.h>

#define DX_LATENCY_BUCKETS 512
#define DX_LATENCY_FULL    4096u

struct dx_latency {
    uint32_t n;
    uint32_t bucket[DX_LATENCY_BUCKETS];
};

static inline uint32_t dx_latency_bucket(uint64_t ns)
{
    uint32_t octave = ns < 8 ? 0 : 60 - (uint32_t)__builtin_clzll(ns);

    return octave * 8 + (uint32_t)(ns >> octave & 7) + (ns < 8 ? 0 : 8);
}

static inline void dx_latency_add(struct dx_latency *h, uint64_t ns)
{
    if (h->n >= DX_LATENCY_FULL) {
        h->n = 0;
        for (int k = 0; k < DX_LATENCY_BUCKETS; k++)
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
