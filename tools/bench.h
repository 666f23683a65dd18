/*
 * The benchmarks of `dexel bench`, and what they share. Each takes its own arguments as a
 * subcommand does and returns the exit status (tools/cmd.h). One thread calls them.
 */
#ifndef DX_BENCH_H
#define DX_BENCH_H

#include <stdint.h>

#define DX_BENCH_MAX_ROUNDS 101

int dx_bench_stages(int argc, char **argv);

/* Of n (1 to DX_BENCH_MAX_ROUNDS) measured values; the upper one of two. */
double dx_bench_median(const double *values, uint32_t n);

#endif
