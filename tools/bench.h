/*
 * The benchmarks of `dexel bench`, and what they share. Each takes its own arguments as a
 * subcommand does and returns the exit status (tools/cmd.h). One thread calls them.
 */
#ifndef DX_BENCH_H
#define DX_BENCH_H

#include <stdint.h>

#define DX_BENCH_MAX_ROUNDS 101

/* Of a frame: what dx_bench_stages may be told to measure alone. NULL-terminated. */
extern const char *const dx_bench_stage_names[];
int dx_bench_stages(int argc, char **argv);
int dx_bench_rules(int argc, char **argv);
int dx_bench_update(int argc, char **argv);
int dx_bench_lod(int argc, char **argv);
int dx_bench_live(int argc, char **argv);
int dx_bench_record(int argc, char **argv);
int dx_bench_paper(int argc, char **argv);
int dx_bench_quality(int argc, char **argv);

/* Of n (1 to DX_BENCH_MAX_ROUNDS) measured values; the upper one of two. */
double dx_bench_median(const double *values, uint32_t n);

/* Of doubles, for qsort. */
int dx_bench_by_value(const void *x, const void *y);

#endif
