/* A benchmark at each size. */
#include "tools/bench_sizes.h"

#include "tools/args.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int warm(const struct dx_bench_kind *kind, void *bench)
{
    if (kind->warm)
        return kind->warm(bench);
    kind->round(bench, 0);
    return 0;
}

static int run_size(const struct dx_bench_kind *kind, const struct dx_bench_args *a,
                    struct dx_bench_size size, struct dx_report_table *tables)
{
    void *bench = calloc(1, kind->len);
    int r = bench ? kind->init(bench, a, size) : -ENOMEM;

    if (r == 0)
        r = warm(kind, bench);
    if (r < 0) {
        fprintf(stderr, "%s: %ux%u: %s\n", kind->command->name, size.width, size.height,
                strerror(-r));
    } else {
        for (uint32_t k = 0; k < dx_bench_rounds(a, size); k++)
            kind->round(bench, k);
        kind->tell(bench, tables, size);
    }
    if (bench)
        kind->fini(bench);
    free(bench);
    return r;
}

int dx_bench_sizes(const struct dx_bench_kind *kind, struct dx_report_table *tables,
                   unsigned n_tables, int argc, char **argv)
{
    struct dx_bench_args a;
    struct dx_report report;
    int r = dx_bench_args_parse(&a, kind->command, argc, argv);

    if (r != 0)
        return r == DX_ARG_E_HELP ? 0 : 2;
    dx_report_init(&report, a.format, kind->command->name, argc, argv);
    for (uint32_t k = 0; r == 0 && k < a.n_sizes; k++)
        r = run_size(kind, &a, a.size[k], tables);
    for (unsigned k = 0; k < n_tables; k++)
        dx_report_table(&report, &tables[k]);
    return dx_report_close(&report) < 0 || r < 0 ? 1 : 0;
}
