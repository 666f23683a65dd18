/*
 * Places of a few keys in their order, without branches: where the next goes cannot be foretold.
 * Each key is counted against all others, several at a time. Pure, any thread.
 */
#ifndef DX_FEW_SORT_H
#define DX_FEW_SORT_H

#include <stdint.h>

#define DX_FEW_LANES 8 /* room for keys and places is a multiple of it */

/* place[i]: how many of key[n] are less than key[i]. No two keys are equal. */
static inline void dx_few_places(int32_t *place, const int32_t *key, uint32_t n)
{
    for (uint32_t i = 0; i < n; i += DX_FEW_LANES) {
        int32_t less[DX_FEW_LANES] = {0};

        for (uint32_t j = 0; j < n; j++)
            for (int m = 0; m < DX_FEW_LANES; m++)
                less[m] += key[j] < key[i + (uint32_t)m];
        for (int m = 0; m < DX_FEW_LANES; m++)
            place[i + (uint32_t)m] = less[m];
    }
}

#endif
