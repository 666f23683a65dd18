/* Runs of columns, and rows from them. */
#include "core/grid/runs.h"

#include <string.h>

void dx_runs_find(struct dx_runs *runs, int64_t col0, uint32_t n, bool wrap, uint32_t width)
{
    runs->n = runs->n_columns = 0;
    for (uint32_t at = 0; at < n;) {
        const int64_t col = wrap ? (col0 + at + width) % width : col0 + at;
        const int64_t follow = col < 0 ? -col : width - col;
        const uint32_t left = n - at, n_run = follow < left ? (uint32_t)follow : left;

        if (col >= width)
            break;
        if (col >= 0) {
            runs->run[runs->n++] = (struct dx_run){at, n_run, (uint32_t)col};
            runs->n_columns += n_run;
        }
        at += n_run;
    }
}

void dx_runs_gather(void *out, const void *row, size_t size, const struct dx_runs *runs, uint32_t n)
{
    if (runs->n_columns < n)
        memset(out, 0, n * size);
    for (const struct dx_run *r = runs->run; r < runs->run + runs->n; r++)
        memcpy((uint8_t *)out + r->at * size, (const uint8_t *)row + r->col * size, r->n * size);
}
