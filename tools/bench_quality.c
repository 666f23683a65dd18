/*
 * dexel bench quality: the quality figures of terrain mode on simulated scans, against the truth.
 * Everything follows from the seed: the same command prints the same numbers on every machine.
 */
#include "tools/args.h"
#include "tools/bench.h"
#include "tools/quality.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

static const char help[] =
    "usage: dexel bench quality [OPTIONS] [THEME...]\n"
    "Measures the meshes of simulated scans against what the beams really meet.\n\n"
    "  themes: coverage, veil, mixed, dropouts, diagonals, walls, noise, topology, bytes,\n"
    "          static, smooth, lod (all)\n"
    "  --seed N     of noise, drop-outs and mixed pixels (1)\n"
    "  --quick      grids of half the rows and columns, under the bars of whole ones\n"
    "  --check      exit status 1 when a bar is not met\n"
    "  --json       one JSON object on standard output\n"
    "  --markdown   the tables as Markdown\n";

enum { OPT_SEED = 256, OPT_QUICK, OPT_CHECK, OPT_JSON, OPT_MARKDOWN, OPT_HELP };

static const struct option options[] = {
    {"seed", required_argument, NULL, OPT_SEED},
    {"quick", no_argument, NULL, OPT_QUICK},
    {"check", no_argument, NULL, OPT_CHECK},
    {"json", no_argument, NULL, OPT_JSON},
    {"markdown", no_argument, NULL, OPT_MARKDOWN},
    {"help", no_argument, NULL, OPT_HELP},
    {0},
};

static const char *const theme_names[] = {"coverage", "veil",  "mixed",    "dropouts", "diagonals",
                                          "walls",    "noise", "topology", "bytes",    "static",
                                          "smooth",   "lod",   NULL};

static dx_quality_theme *const themes[] = {
    dx_quality_theme_coverage, dx_quality_theme_veil,      dx_quality_theme_mixed,
    dx_quality_theme_dropouts, dx_quality_theme_diagonals, dx_quality_theme_walls,
    dx_quality_theme_noise,    dx_quality_theme_topology,  dx_quality_theme_bytes,
    dx_quality_theme_static,   dx_quality_theme_smooth,    dx_quality_theme_lod,
};

#define N_THEMES (sizeof(themes) / sizeof(themes[0]))

struct args {
    uint64_t seed;
    bool quick, check;
    enum dx_quality_format format;
    bool wanted[N_THEMES];
};

int dx_quality_run_rig(struct dx_quality_rig **out, const struct dx_quality_run *run,
                       const struct dx_quality_scan *scan)
{
    struct dx_scene_config c;

    dx_scene_config_default(&c, scan->scene);
    c.width = run->quick ? scan->width / 2 : scan->width;
    c.height = run->quick ? scan->height / 2 : scan->height;
    c.flip_cols = scan->mirrored;
    return dx_quality_rig_new(out, &c);
}

static int set_option(struct args *a, int opt, const char *text)
{
    switch (opt) {
    case OPT_SEED:
        return dx_arg_u64(&a->seed, &(struct dx_arg){"dexel bench quality", "--seed", text}, 0,
                          INT64_MAX - 1, "a number");
    case OPT_QUICK:
        a->quick = true;
        return 0;
    case OPT_CHECK:
        a->check = true;
        return 0;
    case OPT_JSON:
        a->format = DX_QUALITY_JSON;
        return 0;
    case OPT_MARKDOWN:
        a->format = DX_QUALITY_MARKDOWN;
        return 0;
    default:
        return -EINVAL; /* getopt has said why */
    }
}

static int parse(struct args *a, int argc, char **argv)
{
    int opt;

    *a = (struct args){.seed = 1};
    while ((opt = getopt_long(argc, argv, "", options, NULL)) != -1) {
        if (opt == OPT_HELP)
            return dx_arg_help(help);
        if (set_option(a, opt, optarg) < 0)
            return -EINVAL;
    }
    for (size_t k = 0; k < N_THEMES; k++)
        a->wanted[k] = optind == argc;
    for (; optind < argc; optind++) {
        int k = dx_arg_choice(&(struct dx_arg){"dexel bench quality", "THEME", argv[optind]},
                              theme_names);

        if (k < 0)
            return -EINVAL;
        a->wanted[k] = true;
    }
    return 0;
}

int dx_bench_quality(int argc, char **argv)
{
    struct dx_quality_report report;
    struct dx_quality_run run = {.report = &report};
    struct args a;
    int rc = parse(&a, argc, argv);

    if (rc != 0)
        return rc == DX_ARG_E_HELP ? 0 : 2;
    run.seed = a.seed;
    run.quick = a.quick;
    dx_quality_report_init(&report, a.format, a.seed, a.quick);
    for (size_t k = 0; rc == 0 && k < N_THEMES; k++)
        if (a.wanted[k])
            rc = themes[k](&run);
    if (rc < 0)
        fprintf(stderr, "dexel bench quality: %s\n", strerror(-rc));
    if (dx_quality_report_close(&report) < 0)
        rc = -EIO;
    return rc < 0 || (a.check && report.n_short) ? 1 : 0;
}
