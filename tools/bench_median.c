/* The median of measured rounds: machines are shared, and a mean would tell of the others. */
#include "tools/bench.h"

#include <stdlib.h>
#include <string.h>

int dx_bench_by_value(const void *x, const void *y)
{
    const double *a = x, *b = y;

    return *a < *b ? -1 : *a > *b;
}

double dx_bench_median(const double *values, uint32_t n)
{
    double sorted[DX_BENCH_MAX_ROUNDS];

    memcpy(sorted, values, n * sizeof(*values));
    qsort(sorted, n, sizeof(*sorted), dx_bench_by_value);
    return sorted[n / 2];
}
