/*
 * Going over the sizes that a benchmark of a frame is asked for: at each it is made anew, warmed,
 * measured in rounds, and told in the rows of its tables. One thread.
 */
#ifndef DX_BENCH_SIZES_H
#define DX_BENCH_SIZES_H

#include "tools/bench_args.h"

#include <stddef.h>

/* `bench` is the benchmark's own, `len` bytes, zero before init. */
struct dx_bench_kind {
    const struct dx_bench_command *command;
    size_t len;
    /* Also after an init that failed. */
    void (*fini)(void *bench);
    /* 0, or -errno. */
    int (*init)(void *bench, const struct dx_bench_args *a, struct dx_bench_size size);
    /* Gates, pages, caches; 0, or -errno. NULL: a round. */
    int (*warm)(void *bench);
    void (*round)(void *bench, uint32_t k);
    /* Rows for each of the tables. */
    void (*tell)(const void *bench, struct dx_report_table *tables, struct dx_bench_size size);
};

/* The whole command. Returns the exit status. */
int dx_bench_sizes(const struct dx_bench_kind *kind, struct dx_report_table *tables,
                   unsigned n_tables, int argc, char **argv);

#endif
