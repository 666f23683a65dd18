/*
 * The lower medians of many values that fall into many bins: the values are kept in one buffer,
 * made once for as many as may come, then brought into the order of their bins and searched there.
 * One owner.
 */
#ifndef DX_MEDIAN_H
#define DX_MEDIAN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct dx_median_value {
    uint64_t key; /* what is compared */
    uint32_t bin;
    uint16_t attr; /* goes with it */
};

struct dx_medians {
    uint32_t n, max_values, n_bins;
    struct dx_median_value *value; /* [max_values] */
    uint32_t *start; /* [n_bins + 1], of each bin, once sorted; counts, one bin further, before */
    uint32_t *next;  /* [n_bins]: scratch of the sort */
};

/* Errors: -ENOMEM. */
int dx_medians_init(struct dx_medians *m, uint32_t n_bins, uint32_t max_values);
void dx_medians_fini(struct dx_medians *m);

/* Forgets all values. */
void dx_medians_reset(struct dx_medians *m);

/* `bin` is one of the bins; false: the buffer is full. */
bool dx_medians_add(struct dx_medians *m, uint32_t bin, uint64_t key, uint16_t attr);

/* Once all values have come; after it only the medians and the reset. */
void dx_medians_sort(struct dx_medians *m);

/* Value (n - 1) / 2 of the n of a bin in the order of their keys; NULL: the bin is empty. Moves the
 * values of the bin. */
const struct dx_median_value *dx_medians_of(struct dx_medians *m, uint32_t bin);

#endif
