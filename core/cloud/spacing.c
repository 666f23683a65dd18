/* Spacing by medians over a sample of the points. */
#include "core/cloud/spacing.h"

#include <math.h>

#define N_SAMPLES 512

double dx_cloud_spacing(const struct dx_cloud *c)
{
    const uint32_t n = c->n < N_SAMPLES ? c->n : N_SAMPLES;
    int64_t d2[N_SAMPLES];
    uint32_t n_found = 0;

    for (uint32_t k = 0; k < n; k++) {
        struct dx_near near;
        uint32_t j;

        if (!dx_cloud_nearest(c, (uint32_t)((uint64_t)k * c->n / n), 1, &near))
            continue;
        for (j = n_found++; j > 0 && d2[j - 1] > near.d2; j--)
            d2[j] = d2[j - 1];
        d2[j] = near.d2;
    }
    return n_found ? sqrt((double)d2[n_found / 2]) : 1;
}
