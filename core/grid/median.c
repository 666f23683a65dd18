/* Bins by permutation in place, medians by partition at the highest bit in which keys differ: the
 * work is bounded whatever the values are. */
#include "core/grid/median.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

int dx_medians_init(struct dx_medians *m, uint32_t n_bins, uint32_t max_values)
{
    *m = (struct dx_medians){.max_values = max_values, .n_bins = n_bins};
    m->value = calloc((size_t)max_values + 1, sizeof(*m->value));
    m->start = calloc((size_t)n_bins + 1, sizeof(*m->start));
    m->next = calloc((size_t)n_bins + 1, sizeof(*m->next));
    if (m->value && m->start && m->next)
        return 0;
    dx_medians_fini(m);
    return -ENOMEM;
}

void dx_medians_fini(struct dx_medians *m)
{
    free(m->value);
    free(m->start);
    free(m->next);
    *m = (struct dx_medians){0};
}

void dx_medians_reset(struct dx_medians *m)
{
    m->n = 0;
    memset(m->start, 0, ((size_t)m->n_bins + 1) * sizeof(*m->start));
}

bool dx_medians_add(struct dx_medians *m, uint32_t bin, uint64_t key, uint16_t attr)
{
    if (m->n == m->max_values)
        return false;
    m->value[m->n++] = (struct dx_median_value){key, bin, attr};
    m->start[bin + 1]++;
    return true;
}

static void swap(struct dx_median_value *a, struct dx_median_value *b)
{
    struct dx_median_value t = *a;

    *a = *b;
    *b = t;
}

void dx_medians_sort(struct dx_medians *m)
{
    for (uint32_t k = 0; k < m->n_bins; k++)
        m->start[k + 1] += m->start[k];
    memcpy(m->next, m->start, (size_t)m->n_bins * sizeof(*m->next));
    for (uint32_t bin = 0; bin < m->n_bins; bin++)
        for (; m->next[bin] < m->start[bin + 1]; m->next[bin]++) {
            struct dx_median_value *v = &m->value[m->next[bin]];

            while (v->bin != bin) /* each step puts one value where it belongs */
                swap(v, &m->value[m->next[v->bin]++]);
        }
}

/* The bits in which n keys differ. */
static uint64_t differing(const struct dx_median_value *v, uint32_t n)
{
    uint64_t bits = 0;

    for (uint32_t k = 1; k < n; k++)
        bits |= v[k].key ^ v[0].key;
    return bits;
}

/* Moves the values without the bit before those with it; how many they are. */
static uint32_t partition(struct dx_median_value *v, uint32_t n, uint64_t bit)
{
    uint32_t n_clear = 0;

    for (uint32_t k = 0; k < n; k++)
        if (!(v[k].key & bit))
            swap(&v[k], &v[n_clear++]);
    return n_clear;
}

const struct dx_median_value *dx_medians_of(struct dx_medians *m, uint32_t bin)
{
    struct dx_median_value *v = m->value + m->start[bin];
    uint32_t n = m->start[bin + 1] - m->start[bin], rank = (n - 1) / 2;
    uint64_t bits;

    if (n == 0)
        return NULL;
    while ((bits = differing(v, n)) != 0) {
        uint32_t n_clear = partition(v, n, 1ull << (63 - __builtin_clzll(bits)));

        if (rank < n_clear) {
            n = n_clear;
        } else {
            v += n_clear;
            n -= n_clear;
            rank -= n_clear;
        }
    }
    return v;
}
