/*
 * dexel bench paper: table 2 of Gopi and Krishnan (2002) again. Their 6,479,713 samples of a room
 * are not to be had; as many random samples of the simulated hall stand for them, with as large a
 * part of the array without a return. They are thinned to the paper's two arrays; each array is
 * meshed by all rules and by the paper's own. Rounds go over everything in turn, and a round makes
 * its samples anew, batch by batch.
 */
#include "tools/bench.h"

#include "core/grid/represent.h"
#include "core/grid/terrain.h"
#include "tools/args.h"
#include "tools/bench_room.h"
#include "tools/bench_table.h"
#include "tools/now.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define BATCH 65536
/* Longest edge of the paper's rule: 12 cm at 1500 columns, in proportion to the step. */
#define CAP_M(width) (0.12 * 1500 / (width))

static const char help[] =
    "usage: dexel bench paper [OPTIONS]\n"
    "Repeats table 2 of Gopi and Krishnan (2002) on a simulated room: samples thinned to\n"
    "dexel arrays of 600x400 and 1500x1000, then meshed with all checks and without.\n\n"
    "  --samples N   of the room (6479713)\n"
    "  --noise M     of their ranges, metres (0.002)\n"
    "  --silent P    share of the directions without a return (0.43)\n"
    "  --seed N      of directions and noise (1)\n"
    "  --keep KEEP   which sample a dexel keeps: centre|nearest|median|mean|first (centre)\n"
    "  --threads N   that compute tiles (1)\n"
    "  --rounds N    measured (5)\n"
    "  --json        one JSON object on standard output\n";

enum {
    OPT_SAMPLES = 256,
    OPT_NOISE,
    OPT_SILENT,
    OPT_SEED,
    OPT_KEEP,
    OPT_THREADS,
    OPT_ROUNDS,
    OPT_JSON,
    OPT_HELP
};

static const struct option options[] = {
    {"samples", required_argument, NULL, OPT_SAMPLES},
    {"noise", required_argument, NULL, OPT_NOISE},
    {"silent", required_argument, NULL, OPT_SILENT},
    {"seed", required_argument, NULL, OPT_SEED},
    {"keep", required_argument, NULL, OPT_KEEP},
    {"threads", required_argument, NULL, OPT_THREADS},
    {"rounds", required_argument, NULL, OPT_ROUNDS},
    {"json", no_argument, NULL, OPT_JSON},
    {"help", no_argument, NULL, OPT_HELP},
    {0},
};

struct args {
    struct dx_table_setup setup;
    bool json;
};

/* With the checks (all rules), and without (the paper's rule alone). */
enum rules { CHECKS, PLAIN, N_RULES };

/* One of the two dexel arrays, and its part of the table. */
struct array {
    uint32_t width, height;
    struct dx_geometry *geometry;
    struct dx_represent *represent;
    struct dx_plane plane, empty;
    struct dx_terrain *terrain[N_RULES];
    double init_s[DX_BENCH_MAX_ROUNDS], rules_s[N_RULES][DX_BENCH_MAX_ROUNDS];
    uint64_t n_triangles[N_RULES];
};

struct bench {
    struct dx_room room;
    struct array array[DX_TABLE_ARRAYS];
    struct dx_pool *pool;
    double *xyz; /* of a batch */
    struct dx_tile *tile;
    struct dx_tile_mesh *mesh;
};

/* ---- putting it together -------------------------------------------------------------------- */

static void array_fini(struct array *a)
{
    for (int k = 0; k < N_RULES; k++)
        dx_terrain_free(a->terrain[k]);
    dx_plane_fini(&a->plane);
    dx_plane_fini(&a->empty);
    dx_represent_free(a->represent);
    dx_geometry_unref(a->geometry);
}

static int array_init(struct array *a, const struct args *args, const struct dx_room *room)
{
    struct dx_scene_config scene = room->scene;
    struct dx_terrain_params params;
    int rc;

    scene.width = a->width;
    scene.height = a->height;
    rc = dx_scene_geometry(&a->geometry, &scene);
    if (rc == 0)
        rc = dx_represent_new(&a->represent, a->geometry, args->setup.keep, args->setup.n_samples);
    if (rc == 0)
        rc = dx_plane_init(&a->plane, a->height, a->width, a->geometry->range_bytes, 0);
    if (rc == 0)
        rc = dx_plane_init(&a->empty, a->height, a->width, a->geometry->range_bytes, 0);
    for (int k = 0; rc == 0 && k < N_RULES; k++) {
        dx_terrain_params_default(&params);
        params.paper = k == PLAIN;
        params.cap_m = k == PLAIN ? CAP_M(a->width) : 0;
        rc = dx_terrain_new(&a->terrain[k], a->geometry, &params, 0);
    }
    return rc;
}

static void bench_fini(struct bench *b)
{
    for (int k = 0; k < DX_TABLE_ARRAYS; k++)
        array_fini(&b->array[k]);
    dx_pool_free(b->pool);
    free(b->xyz);
    free(b->tile);
    free(b->mesh);
}

static int bench_init(struct bench *b, const struct args *a)
{
    int rc = dx_pool_new(&b->pool, a->setup.n_threads);

    dx_room_init(&b->room, a->setup.seed, a->setup.noise_m, a->setup.silent);
    for (int k = 0; rc == 0 && k < DX_TABLE_ARRAYS; k++) {
        b->array[k].width = dx_table_paper[k].width;
        b->array[k].height = dx_table_paper[k].height;
        rc = array_init(&b->array[k], a, &b->room);
    }
    b->xyz = malloc(3 * BATCH * sizeof(*b->xyz));
    b->tile = calloc(1, sizeof(*b->tile));
    b->mesh = calloc(1, sizeof(*b->mesh));
    return rc == 0 && (!b->xyz || !b->tile || !b->mesh) ? -ENOMEM : rc;
}

/* ---- one round ------------------------------------------------------------------------------ */

/* All samples into both arrays. The clock runs for the thinning, not for the simulation. */
static void thin(struct bench *b, const struct args *a, uint32_t round)
{
    double seconds[DX_TABLE_ARRAYS] = {0};

    for (int k = 0; k < DX_TABLE_ARRAYS; k++) {
        uint64_t start = dx_now_ns();

        dx_represent_reset(b->array[k].represent);
        seconds[k] += dx_seconds_since(start);
    }
    for (uint32_t done = 0; done < a->setup.n_samples; done += BATCH) {
        uint32_t left = a->setup.n_samples - done, n = left < BATCH ? left : BATCH;
        const struct dx_samples samples = {.n = n, .xyz = b->xyz, .number = done};

        dx_room_sample(b->xyz, &b->room, done, n, b->pool);
        for (int k = 0; k < DX_TABLE_ARRAYS; k++) {
            uint64_t start = dx_now_ns();

            dx_represent_add(b->array[k].represent, &samples);
            seconds[k] += dx_seconds_since(start);
        }
    }
    for (int k = 0; k < DX_TABLE_ARRAYS; k++) {
        uint64_t start = dx_now_ns();

        dx_represent_finish(b->array[k].represent, &b->array[k].plane, NULL);
        b->array[k].init_s[round] = seconds[k] + dx_seconds_since(start);
    }
}

/* From the array to the triangles of all tiles with their vertices. The array is emptied before, so
 * that every round finds all tiles changed. */
static void reconstruct(struct bench *b, struct array *a, enum rules rules, uint32_t round)
{
    struct dx_terrain *t = a->terrain[rules];
    uint64_t start, n = 0;

    dx_terrain_publish(t, &a->empty, 0, a->width, b->pool);
    dx_terrain_commit(t, b->pool);
    start = dx_now_ns();
    dx_terrain_publish(t, &a->plane, 0, a->width, b->pool);
    dx_terrain_commit(t, b->pool);
    for (uint32_t k = 0; k < dx_tiling_n_tiles(dx_terrain_tiling(t)); k++) {
        if (!dx_terrain_tile(t, k, b->tile))
            continue;
        dx_tile_mesh_build(b->mesh, b->tile, dx_terrain_tiling(t), a->geometry);
        n += b->mesh->n_triangles;
    }
    a->rules_s[rules][round] = dx_seconds_since(start);
    a->n_triangles[rules] = n;
}

static void run_round(struct bench *b, const struct args *a, uint32_t round)
{
    thin(b, a, round);
    for (int k = 0; k < DX_TABLE_ARRAYS; k++)
        for (enum rules rules = 0; rules < N_RULES; rules++)
            reconstruct(b, &b->array[k], rules, round);
}

static void tell(struct dx_table_row row[DX_TABLE_ARRAYS], const struct bench *b,
                 const struct args *args)
{
    uint32_t n_rounds = args->setup.n_rounds;

    for (int k = 0; k < DX_TABLE_ARRAYS; k++) {
        const struct array *a = &b->array[k];

        row[k] = (struct dx_table_row){
            .width = a->width,
            .height = a->height,
            .triangles = (double)a->n_triangles[CHECKS],
            .triangles_plain = (double)a->n_triangles[PLAIN],
            .init_s = dx_bench_median(a->init_s, n_rounds),
            .checks_s = dx_bench_median(a->rules_s[CHECKS], n_rounds),
            .plain_s = dx_bench_median(a->rules_s[PLAIN], n_rounds),
        };
        for (size_t i = 0; i < dx_plane_n_dexels(&a->plane); i++)
            row[k].points += dx_plane_range(&a->plane, i) != 0;
    }
}

/* ---- arguments ------------------------------------------------------------------------------ */

static int set_count(struct args *a, int opt, const char *text)
{
    const char *const command = "dexel bench paper";
    uint64_t n = 0;
    int rc;

    switch (opt) {
    case OPT_SAMPLES:
        rc = dx_arg_u64(&n, &(struct dx_arg){command, "--samples", text}, 1, 1000000000, "samples");
        a->setup.n_samples = (uint32_t)n;
        return rc;
    case OPT_THREADS:
        rc = dx_arg_u64(&n, &(struct dx_arg){command, "--threads", text}, 1, DX_POOL_MAX_THREADS,
                        "threads");
        a->setup.n_threads = (unsigned)n;
        return rc;
    case OPT_ROUNDS:
        rc = dx_arg_u64(&n, &(struct dx_arg){command, "--rounds", text}, 1, DX_BENCH_MAX_ROUNDS,
                        "rounds");
        a->setup.n_rounds = (uint32_t)n;
        return rc;
    case OPT_SEED:
        return dx_arg_u64(&a->setup.seed, &(struct dx_arg){command, "--seed", text}, 0, UINT64_MAX,
                          "a seed");
    default:
        return -EINVAL; /* getopt has said why */
    }
}

static int set_option(struct args *a, int opt, const char *text)
{
    struct dx_arg arg = {"dexel bench paper", "--noise", text};

    switch (opt) {
    case OPT_NOISE:
        return dx_arg_double(&a->setup.noise_m, &arg, 0, 1, "metres");
    case OPT_SILENT:
        arg.option = "--silent";
        return dx_arg_double(&a->setup.silent, &arg, 0, 0.99, "a share");
    case OPT_KEEP:
        arg.option = "--keep";
        return dx_arg_keep(&a->setup.keep, &arg);
    case OPT_JSON:
        a->json = true;
        return 0;
    default:
        return set_count(a, opt, text);
    }
}

static int parse(struct args *a, int argc, char **argv)
{
    int opt;

    *a = (struct args){.setup = {.n_samples = 6479713,
                                 .noise_m = 0.002,
                                 .silent = 0.43,
                                 .seed = 1,
                                 .keep = DX_KEEP_CENTRE,
                                 .n_threads = 1,
                                 .n_rounds = 5}};
    while ((opt = getopt_long(argc, argv, "", options, NULL)) != -1) {
        if (opt == OPT_HELP)
            return dx_arg_help(help);
        if (set_option(a, opt, optarg) < 0)
            return -EINVAL;
    }
    if (optind == argc)
        return 0;
    fprintf(stderr, "dexel bench paper: found '%s', expected options alone\n", argv[optind]);
    return -EINVAL;
}

int dx_bench_paper(int argc, char **argv)
{
    struct dx_table_row row[DX_TABLE_ARRAYS];
    struct bench *b;
    struct args a;
    int rc = parse(&a, argc, argv);

    if (rc != 0)
        return rc == DX_ARG_E_HELP ? 0 : 2;
    b = calloc(1, sizeof(*b));
    rc = b ? bench_init(b, &a) : -ENOMEM;
    if (rc < 0) {
        fprintf(stderr, "dexel bench paper: %s\n", strerror(-rc));
    } else {
        run_round(b, &a, 0); /* warm: the noise is settled, pages are there */
        for (uint32_t k = 0; k < a.setup.n_rounds; k++)
            run_round(b, &a, k);
        tell(row, b, &a);
        if (a.json)
            rc = dx_table_print_json(row, &a.setup);
        else
            dx_table_print_text(row, &a.setup);
    }
    if (b)
        bench_fini(b);
    free(b);
    return rc < 0 ? 1 : 0;
}
