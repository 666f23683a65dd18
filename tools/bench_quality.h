/* dexel bench quality: takes its own arguments as a subcommand does (tools/cmd.h). */
#ifndef DX_BENCH_QUALITY_H
#define DX_BENCH_QUALITY_H

int dx_bench_quality(int argc, char **argv);

#endif
