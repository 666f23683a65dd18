/* Medians over a sample of a cloud's points, spread through it: what its measures are made of. */
#ifndef DX_SAMPLE_H
#define DX_SAMPLE_H

#include "core/cloud/cloud.h"

#define DX_SAMPLES 512

struct dx_sample_median {
    double value[DX_SAMPLES]; /* ascending */
    uint32_t n;
};

static inline void dx_sample_insert(struct dx_sample_median *m, double x)
{
    uint32_t k = m->n++;

    for (; k > 0 && m->value[k - 1] > x; k--)
        m->value[k] = m->value[k - 1];
    m->value[k] = x;
}

/* How many points are in the sample, and the rank of the k-th. */
static inline uint32_t dx_sample_n(const struct dx_cloud *c)
{
    return c->n < DX_SAMPLES ? c->n : DX_SAMPLES;
}

static inline uint32_t dx_sample_rank(const struct dx_cloud *c, uint32_t k)
{
    return (uint32_t)((uint64_t)k * c->n / dx_sample_n(c));
}

#endif
