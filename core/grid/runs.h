/*
 * Columns beside a tile as they lie in the grid: beyond its seam they go around, beyond its borders
 * there are none. Found once for a tile, for all of its rows. Pure functions.
 */
#ifndef DX_RUNS_H
#define DX_RUNS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define DX_RUNS_MAX 80

/* Columns that follow each other in the grid: `n` of them from column `col` on; `at` is the first
 * one's place among those that were asked for. */
struct dx_run {
    uint32_t at, n, col;
};

struct dx_runs {
    struct dx_run run[DX_RUNS_MAX]; /* one where neither seam nor border is near */
    uint32_t n, n_columns;          /* runs; columns of all of them */
};

/* Columns [col0, col0 + n), n <= DX_RUNS_MAX, of a grid of `width`; col0 >= -width. */
void dx_runs_find(struct dx_runs *runs, int64_t col0, uint32_t n, bool wrap, uint32_t width);

/* A row of elements of `size` bytes; columns outside the grid become 0. */
void dx_runs_gather(void *out, const void *row, size_t size, const struct dx_runs *runs,
                    uint32_t n);

#endif
