/* dexel bench: the benchmarks by name; without one, the stages of a frame. */
#include "tools/bench.h"
#include "tools/cmd.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

static const struct {
    const char *name;
    char *full_name; /* the benchmark's argv[0], as in main.c */
    int (*run)(int argc, char **argv);
} benches[] = {
    {"rules", "dexel bench rules", dx_bench_rules},
    {"update", "dexel bench update", dx_bench_update},
    {"lod", "dexel bench lod", dx_bench_lod},
    {"live", "dexel bench live", dx_bench_live},
    {"record", "dexel bench record", dx_bench_record},
    {"paper", "dexel bench paper", dx_bench_paper},
    {"quality", "dexel bench quality", dx_bench_quality},
    {NULL, NULL, NULL},
};

static bool is_stage(const char *name)
{
    for (size_t k = 0; dx_bench_stage_names[k]; k++)
        if (strcmp(dx_bench_stage_names[k], name) == 0)
            return true;
    return false;
}

static int say_unknown(const char *name)
{
    fprintf(stderr, "dexel bench: found '%s', expected a benchmark (", name);
    for (size_t k = 0; benches[k].name; k++)
        fprintf(stderr, "%s%s", k ? "|" : "", benches[k].name);
    fputs(") or stages of a frame (", stderr);
    for (size_t k = 0; dx_bench_stage_names[k]; k++)
        fprintf(stderr, "%s%s", k ? "|" : "", dx_bench_stage_names[k]);
    fputs(")\n", stderr);
    return 2;
}

int cmd_bench(int argc, char **argv)
{
    for (size_t k = 0; argc > 1 && benches[k].name; k++)
        if (strcmp(argv[1], benches[k].name) == 0) {
            argv[1] = benches[k].full_name;
            return benches[k].run(argc - 1, argv + 1);
        }
    if (argc > 1 && argv[1][0] != '-' && !is_stage(argv[1]))
        return say_unknown(argv[1]);
    return dx_bench_stages(argc, argv);
}
