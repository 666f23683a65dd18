/* The table of `dexel bench paper`: what was measured beside what the paper printed. */
#ifndef DX_BENCH_TABLE_H
#define DX_BENCH_TABLE_H

#include "core/grid/represent.h"

#include <stdint.h>

#define DX_TABLE_ARRAYS 2

struct dx_table_setup {
    uint32_t n_samples;
    double noise_m, silent;
    uint64_t seed;
    enum dx_keep keep;
    unsigned n_threads;
    uint32_t n_rounds;
};

/* Of one dexel array. Seconds are medians. */
struct dx_table_row {
    uint32_t width, height;
    double points; /* dexels with a sample */
    double triangles, triangles_plain;
    double init_s;            /* samples to the array; the paper's includes reading them */
    double checks_s, plain_s; /* the array to its triangles, with the checks and without */
};

/* Table 2 of the paper: 250 MHz R10000, 6,479,713 samples. It counts triangles once. */
extern const struct dx_table_row dx_table_paper[DX_TABLE_ARRAYS];

void dx_table_print_text(const struct dx_table_row row[DX_TABLE_ARRAYS],
                         const struct dx_table_setup *setup);
/* 0; -EIO, -ENOMEM having said so. */
int dx_table_print_json(const struct dx_table_row row[DX_TABLE_ARRAYS],
                        const struct dx_table_setup *setup);

#endif
