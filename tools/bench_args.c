/* Arguments of the benchmarks of a frame: see bench_args.h. */
#include "tools/bench_args.h"

#include "core/base/pool.h"
#include "tools/args.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#define ROUNDS        15
#define FEWEST_ROUNDS 3
#define ROUND_DEXELS  30000000u /* in all rounds of a size */

enum {
    OPT_SCENE = 256,
    OPT_SIZE,
    OPT_NOISE,
    OPT_DROPOUTS,
    OPT_THREADS,
    OPT_ROUNDS,
    OPT_DIRTY,
    OPT_JSON,
    OPT_MARKDOWN,
    OPT_HELP
};

static const struct option options[] = {
    {"scene", required_argument, NULL, OPT_SCENE},
    {"size", required_argument, NULL, OPT_SIZE},
    {"noise", required_argument, NULL, OPT_NOISE},
    {"dropouts", required_argument, NULL, OPT_DROPOUTS},
    {"threads", required_argument, NULL, OPT_THREADS},
    {"rounds", required_argument, NULL, OPT_ROUNDS},
    {"json", no_argument, NULL, OPT_JSON},
    {"markdown", no_argument, NULL, OPT_MARKDOWN},
    {"help", no_argument, NULL, OPT_HELP},
    {"dirty", required_argument, NULL, OPT_DIRTY},
    {0},
};

/* A camera, a small and a large room, a lidar, a depth sensor of today, a scan of hours. */
static const struct dx_bench_size all_sizes[] = {
    {600, 400}, {640, 480}, {2048, 128}, {1280, 720}, {1500, 1000}, {10000, 4000},
};

#define N_ALL_SIZES (sizeof(all_sizes) / sizeof(all_sizes[0]))

/* ---- lists ------------------------------------------------------------------------------------
 */

/* Calls `set` for each text between commas; they must be `max` at most. */
static int each_of(struct dx_bench_args *a, const struct dx_arg *arg, unsigned max,
                   int (*set)(struct dx_bench_args *a, const struct dx_arg *one))
{
    char copy[256], *rest = copy, *one;
    unsigned n = 0;

    if (strlen(arg->text) >= sizeof(copy))
        return dx_arg_bad(arg, "a list of at most %u", max);
    strcpy(copy, arg->text);
    while ((one = strsep(&rest, ","))) {
        int r;

        if (++n > max)
            return dx_arg_bad(arg, "a list of at most %u", max);
        r = set(a, &(struct dx_arg){arg->command, arg->option, one});
        if (r < 0)
            return r;
    }
    return 0;
}

static int add_size(struct dx_bench_args *a, const struct dx_arg *one)
{
    struct dx_bench_size *s = &a->size[a->n_sizes];
    int r = dx_arg_size(&s->width, &s->height, one);

    if (r < 0)
        return r;
    if ((uint64_t)s->width * s->height > DX_BENCH_MAX_DEXELS)
        return dx_arg_bad(one, "at most %u dexels", DX_BENCH_MAX_DEXELS);
    if (s->width < 8 || s->height < 2)
        return dx_arg_bad(one, "at least 8x2");
    a->n_sizes++;
    return 0;
}

static int add_threads(struct dx_bench_args *a, const struct dx_arg *one)
{
    uint64_t n = 0;
    int r = dx_arg_u64(&n, one, 1, DX_POOL_MAX_THREADS, "threads");

    if (r == 0)
        a->threads[a->n_threads++] = (unsigned)n;
    return r;
}

static int set_sizes(struct dx_bench_args *a, const struct dx_arg *arg)
{
    a->n_sizes = 0;
    if (strcmp(arg->text, "all") != 0)
        return each_of(a, arg, DX_BENCH_SIZES, add_size);
    for (; a->n_sizes < N_ALL_SIZES; a->n_sizes++)
        a->size[a->n_sizes] = all_sizes[a->n_sizes];
    return 0;
}

/* ---- options ----------------------------------------------------------------------------------
 */

static int set_scene(struct dx_bench_args *a, const struct dx_arg *arg)
{
    int scene = dx_scene_from_name(arg->text);

    if (scene < 0)
        return dx_arg_bad(arg, "one of those of `dexel sim --list`");
    a->scene.scene = (enum dx_scene)scene;
    return 0;
}

static int set_rounds(struct dx_bench_args *a, const struct dx_arg *arg)
{
    uint64_t n = 0;
    int r = dx_arg_u64(&n, arg, 1, DX_BENCH_MAX_ROUNDS, "rounds");

    a->n_rounds = (uint32_t)n;
    return r;
}

static int set_option(struct dx_bench_args *a, int opt, const char *text)
{
    switch (opt) {
    case OPT_SCENE:
        return set_scene(a, &(struct dx_arg){a->command->name, "--scene", text});
    case OPT_SIZE:
        return set_sizes(a, &(struct dx_arg){a->command->name, "--size", text});
    case OPT_NOISE:
        return dx_arg_double(&a->scene.sigma[0],
                             &(struct dx_arg){a->command->name, "--noise", text}, 0, 100, "metres");
    case OPT_DROPOUTS:
        return dx_arg_double(&a->scene.dropout,
                             &(struct dx_arg){a->command->name, "--dropouts", text}, 0, 1,
                             "a share");
    case OPT_THREADS:
        a->n_threads = 0;
        return each_of(a, &(struct dx_arg){a->command->name, "--threads", text}, DX_BENCH_THREADS,
                       add_threads);
    case OPT_ROUNDS:
        return set_rounds(a, &(struct dx_arg){a->command->name, "--rounds", text});
    case OPT_DIRTY:
        if (!a->command->takes_dirty) {
            fprintf(stderr, "%s: found --dirty, expected it with `dexel bench update`\n",
                    a->command->name);
            return -EINVAL;
        }
        return dx_arg_double(&a->dirty, &(struct dx_arg){a->command->name, "--dirty", text}, 0, 1,
                             "a share");
    case OPT_JSON:
        a->format = DX_REPORT_JSON;
        return 0;
    case OPT_MARKDOWN:
        a->format = DX_REPORT_MARKDOWN;
        return 0;
    default:
        return -EINVAL; /* getopt has said why */
    }
}

static void set_defaults(struct dx_bench_args *a, const struct dx_bench_command *command)
{
    *a = (struct dx_bench_args){.command = command,
                                .size = {{1500, 1000}},
                                .n_sizes = 1,
                                .threads = {1},
                                .n_threads = 1,
                                .dirty = 0.01};
    dx_scene_config_default(&a->scene, DX_SCENE_HALL);
    a->scene.sigma[0] = 0.002;
}

static int set_wanted(struct dx_bench_args *a, const char *text)
{
    int k;

    if (!a->command->operands) {
        fprintf(stderr, "%s: found '%s', expected options alone\n", a->command->name, text);
        return -EINVAL;
    }
    k = dx_arg_choice(&(struct dx_arg){a->command->name, "STAGE", text}, a->command->operands);
    if (k < 0)
        return -EINVAL;
    a->wanted |= 1u << k;
    return 0;
}

int dx_bench_args_parse(struct dx_bench_args *a, const struct dx_bench_command *command, int argc,
                        char **argv)
{
    int opt;

    set_defaults(a, command);
    while ((opt = getopt_long(argc, argv, "", options, NULL)) != -1) {
        if (opt == OPT_HELP)
            return dx_arg_help(command->help);
        if (set_option(a, opt, optarg) < 0)
            return -EINVAL;
    }
    a->wanted = optind == argc ? UINT32_MAX : 0;
    for (; optind < argc; optind++)
        if (set_wanted(a, argv[optind]) < 0)
            return -EINVAL;
    return 0;
}

/* ---- what follows from them -------------------------------------------------------------------
 */

uint32_t dx_bench_rounds(const struct dx_bench_args *a, struct dx_bench_size size)
{
    uint32_t n = ROUND_DEXELS / (size.width * size.height);

    if (a->n_rounds)
        return a->n_rounds;
    return n < FEWEST_ROUNDS ? FEWEST_ROUNDS : n < ROUNDS ? n | 1 : ROUNDS;
}

void dx_bench_args_label(json_t *row, struct dx_bench_size size, unsigned n_threads,
                         uint32_t n_rounds)
{
    char text[32];

    snprintf(text, sizeof(text), "%ux%u", size.width, size.height);
    json_object_set_new(row, "size", json_string(text));
    json_object_set_new(row, "threads", json_integer(n_threads));
    json_object_set_new(row, "rounds", json_integer(n_rounds));
}
