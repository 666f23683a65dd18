/*
 * The arguments that the benchmarks of a frame share: what is scanned, at which sizes, by how many
 * threads, how often. What is wrong goes to standard error as in args.h.
 */
#ifndef DX_BENCH_ARGS_H
#define DX_BENCH_ARGS_H

#include "drivers/synth/scene.h"
#include "tools/bench.h"
#include "tools/bench_report.h"

#define DX_BENCH_SIZES      8
#define DX_BENCH_THREADS    4
#define DX_BENCH_MAX_DEXELS (1u << 26) /* some 1.5 GB of frames, arrays and chunks */

struct dx_bench_size {
    uint32_t width, height;
};

struct dx_bench_command {
    const char *name; /* "dexel bench rules" */
    const char *help;
    const char *const *operands; /* that may be given, NULL-terminated; NULL: none */
    bool takes_dirty;
};

struct dx_bench_args {
    const struct dx_bench_command *command;
    struct dx_scene_config scene;
    struct dx_bench_size size[DX_BENCH_SIZES];
    uint32_t n_sizes;
    unsigned threads[DX_BENCH_THREADS];
    uint32_t n_threads;
    uint32_t n_rounds; /* 0: dx_bench_rounds decides */
    double dirty;      /* share of the tiles that an update changes */
    enum dx_report_format format;
    uint32_t wanted; /* bit for each of the operands' names; all when none is given */
};

#define DX_BENCH_ARGS_HELP                                                                         \
    "  --scene NAME     which scene (hall)\n"                                                      \
    "  --size WxH[,..]  columns x rows, up to eight; or all: 600x400, 640x480, 2048x128,\n"        \
    "                   1280x720, 1500x1000, 10000x4000 (1500x1000)\n"                             \
    "  --noise M        noise of the scan, metres (0.002)\n"                                       \
    "  --dropouts P     share of dexels without a return (0)\n"                                    \
    "  --threads N[,..] that work, up to four counts, measured in turn (1)\n"                      \
    "  --rounds N       measured frames (15; fewer of large sizes)\n"                              \
    "  --json           one JSON object on standard output\n"                                      \
    "  --markdown       the tables as Markdown\n"

/* 0; DX_ARG_E_HELP having printed the help; -EINVAL having said why. */
int dx_bench_args_parse(struct dx_bench_args *a, const struct dx_bench_command *command, int argc,
                        char **argv);

/* Rounds at a size: as asked for, else so many that it takes seconds. */
uint32_t dx_bench_rounds(const struct dx_bench_args *a, struct dx_bench_size size);

/* Sets "size" (columns x rows), "threads" and "rounds". */
void dx_bench_args_label(json_t *row, struct dx_bench_size size, unsigned n_threads,
                         uint32_t n_rounds);

#endif
