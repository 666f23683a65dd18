/*
 * dexel bench: what a frame costs on this machine, stage by stage, beside the memory bandwidth
 * measured in the same run. One thread unless asked; medians of interleaved rounds, because
 * machines are shared.
 */
#include "tools/bench.h"

#include "core/grid/lod.h"
#include "core/wire/chunk.h"
#include "drivers/synth/scene.h"
#include "tools/alloc_count.h"
#include "tools/args.h"
#include "tools/now.h"
#include "tools/stats_json.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

static const char help[] =
    "usage: dexel bench [OPTIONS] [STAGE...]\n"
    "       dexel bench paper [OPTIONS]\n"
    "       dexel bench quality [OPTIONS] [THEME...]\n"
    "Measures terrain mode on a simulated scan: publish, codes, f32, q16, delta,\n"
    "errors and lod (a level of 4 sigma, as f32), copy.\n"
    "`dexel bench paper` repeats the table of Gopi and Krishnan (2002), `dexel bench quality`\n"
    "measures meshes against the truth.\n\n"
    "  --scene NAME    which scene (hall)\n"
    "  --size WxH      columns x rows (1500x1000)\n"
    "  --noise M       noise of the scan, metres (0.002)\n"
    "  --dropouts P    share of dexels without a return (0)\n"
    "  --threads N     of the pool (1)\n"
    "  --rounds N      measured frames, odd (15)\n"
    "  --json          one JSON object on standard output\n";

enum {
    OPT_SCENE = 256,
    OPT_SIZE,
    OPT_NOISE,
    OPT_DROPOUTS,
    OPT_THREADS,
    OPT_ROUNDS,
    OPT_JSON,
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
    {"help", no_argument, NULL, OPT_HELP},
    {0},
};

enum stage { PUBLISH, CODES, F32, Q16, DELTA, ERRORS, LOD, COPY, N_STAGES };

static const char *const stage_names[] = {"publish", "codes", "f32",  "q16", "delta",
                                          "errors",  "lod",   "copy", NULL};

struct args {
    struct dx_scene_config scene;
    unsigned n_threads;
    uint32_t n_rounds;
    bool json;
    bool wanted[N_STAGES];
};

struct bench {
    struct dx_geometry *geometry;
    struct dx_plane frame[2]; /* two noise draws in turn: every tile changes each time */
    struct dx_terrain *terrain;
    struct dx_pool *pool;
    struct dx_tile *tile;
    struct dx_tile_mesh *mesh, *cut;
    struct dx_lod *lod; /* as copy */
    struct dx_lod_scratch *scratch;
    uint8_t *body, *copy; /* no copy: that stage is not wanted, and its memory would be counted */
    size_t n_bytes[N_STAGES];
    size_t n_triangles;
    double seconds[N_STAGES][DX_BENCH_MAX_ROUNDS];
    uint64_t n_allocations;
};

static const struct dx_lod_level levels[DX_LOD_SLOTS] = {{.bound = 4 * DX_LOD_PER_SIGMA}};

/* ---- one round ------------------------------------------------------------------------------ */

/* Every tile through an encoder, into a buffer that is used again: the mesher's own way. */
static void encode(struct bench *b, enum stage stage)
{
    const struct dx_tiling *tiling = dx_terrain_tiling(b->terrain);
    size_t n = 0, n_triangles = 0;

    for (uint32_t k = 0; k < dx_tiling_n_tiles(tiling); k++) {
        if (!dx_terrain_tile(b->terrain, k, b->tile))
            continue;
        if (stage == Q16) {
            n += dx_chunk_put_q16(b->body, b->tile);
            continue;
        }
        if (stage == DELTA) {
            n += dx_chunk_put_delta(b->body, b->tile);
            continue;
        }
        dx_tile_mesh_build(b->mesh, b->tile, tiling, b->geometry);
        if (stage == LOD) {
            dx_lod_mesh(b->cut, b->lod, levels[0], b->tile, b->mesh, b->scratch);
            n += dx_chunk_put_f32(b->body, b->cut);
            continue;
        }
        n += dx_chunk_put_f32(b->body, b->mesh);
        n_triangles += b->mesh->n_triangles;
    }
    b->n_bytes[stage] = n;
    if (stage == F32)
        b->n_triangles = n_triangles;
}

static void run_stage(struct bench *b, enum stage stage, const struct dx_plane *frame)
{
    switch (stage) {
    case PUBLISH:
        dx_terrain_publish(b->terrain, frame, 0, frame->width);
        b->n_bytes[stage] = dx_plane_n_dexels(frame) * frame->range_bytes;
        break;
    case CODES:
        dx_terrain_commit(b->terrain, b->pool);
        break;
    case ERRORS:
        if (b->lod) {
            dx_lod_note(b->lod, dx_terrain_changed(b->terrain));
            dx_lod_update(b->lod, levels, b->pool);
        }
        break;
    case LOD:
        if (b->lod)
            encode(b, stage);
        break;
    case COPY: /* the size of the f32 output, read and written once */
        memcpy(b->copy, b->copy + b->n_bytes[F32], b->n_bytes[F32]);
        b->n_bytes[stage] = 2 * b->n_bytes[F32];
        break;
    default:
        encode(b, stage);
    }
}

static void run_round(struct bench *b, uint32_t round)
{
    for (enum stage s = 0; s < (b->copy ? N_STAGES : COPY); s++) {
        uint64_t start = dx_now_ns();

        run_stage(b, s, &b->frame[round & 1]);
        b->seconds[s][round] = dx_seconds_since(start);
    }
}

/* ---- putting it together -------------------------------------------------------------------- */

static void bench_fini(struct bench *b)
{
    free(b->copy);
    free(b->body);
    free(b->mesh);
    free(b->tile);
    free(b->cut);
    dx_lod_scratch_free(b->scratch);
    dx_lod_free(b->lod);
    dx_pool_free(b->pool);
    dx_terrain_free(b->terrain);
    dx_plane_fini(&b->frame[0]);
    dx_plane_fini(&b->frame[1]);
    dx_geometry_unref(b->geometry);
}

static int bench_init(struct bench *b, const struct args *a)
{
    struct dx_scene_config scene = a->scene;
    struct dx_terrain_params params;
    int r = dx_scene_geometry(&b->geometry, &scene);

    for (int k = 0; r == 0 && k < 2; k++, scene.seed++) {
        r = dx_plane_init(&b->frame[k], scene.height, scene.width, b->geometry->range_bytes, 0);
        if (r == 0)
            dx_scene_cast(&b->frame[k], b->geometry, &scene, 0, 0, scene.width);
    }
    dx_terrain_params_default(&params);
    if (r == 0)
        r = dx_terrain_new(&b->terrain, b->geometry, &params, 0);
    if (r == 0)
        r = dx_pool_new(&b->pool, a->n_threads);
    if (r < 0)
        return r;
    b->tile = calloc(1, sizeof(*b->tile));
    b->mesh = calloc(1, sizeof(*b->mesh));
    b->body = malloc(dx_chunk_max_len(DX_ENCODING_F32));
    if (a->wanted[ERRORS] || a->wanted[LOD]) {
        b->cut = calloc(1, sizeof(*b->cut));
        b->scratch = dx_lod_scratch_new();
        if (!b->cut || !b->scratch || dx_lod_new(&b->lod, b->terrain, b->pool) < 0)
            return -ENOMEM;
    }
    if (a->wanted[COPY])
        b->copy = calloc(dx_plane_n_dexels(&b->frame[0]), 64);
    return b->tile && b->mesh && b->body && (b->copy || !a->wanted[COPY]) ? 0 : -ENOMEM;
}

static void measure(struct bench *b, const struct args *a)
{
    uint64_t before;

    for (uint32_t k = 0; k < 2; k++) /* warm: gates, pages, caches */
        run_round(b, k);
    before = dx_alloc_count();
    for (uint32_t k = 0; k < a->n_rounds; k++)
        run_round(b, k);
    b->n_allocations = dx_alloc_count() - before;
}

/* ---- telling -------------------------------------------------------------------------------- */

static double resident_bytes(void)
{
    struct rusage u;

    getrusage(RUSAGE_SELF, &u);
    return 1024.0 * (double)u.ru_maxrss;
}

static void print_text(const struct bench *b, const struct args *a)
{
    double n = (double)dx_plane_n_dexels(&b->frame[0]);
    double copy =
        b->copy ? dx_bench_median(b->seconds[COPY], a->n_rounds) / (double)b->n_bytes[COPY] : 0;

    printf("%s %ux%u, %u thread%s, medians of %u frames\n", dx_scene_name(a->scene.scene),
           a->scene.width, a->scene.height, dx_pool_threads(b->pool),
           dx_pool_threads(b->pool) > 1 ? "s" : "", a->n_rounds);
    printf("%-8s %9s %10s %10s %14s\n", "stage", "ms", "ns/dexel", "B/dexel", "of copy speed");
    for (enum stage s = 0; s < N_STAGES; s++) {
        double seconds = dx_bench_median(b->seconds[s], a->n_rounds), bytes = (double)b->n_bytes[s];

        char share[16] = "-";

        if (b->copy && bytes > 0)
            snprintf(share, sizeof(share), "%.0f%%", 100 * copy * bytes / seconds);
        if (a->wanted[s])
            printf("%-8s %9.3f %10.2f %10.2f %14s\n", stage_names[s], seconds * 1e3,
                   seconds * 1e9 / n, bytes / n, share);
    }
    printf("triangles %zu, allocations a frame %.2f\n", b->n_triangles,
           (double)b->n_allocations / a->n_rounds);
}

static int print_json(const struct bench *b, const struct args *a)
{
    double n = (double)dx_plane_n_dexels(&b->frame[0]);
    json_t *j = json_object(), *stages = json_object();

    for (enum stage s = 0; s < N_STAGES; s++)
        if (a->wanted[s])
            json_object_set_new(stages, stage_names[s],
                                json_pack("{s:f, s:f, s:f}", "ms",
                                          dx_bench_median(b->seconds[s], a->n_rounds) * 1e3,
                                          "ns_per_dexel",
                                          dx_bench_median(b->seconds[s], a->n_rounds) * 1e9 / n,
                                          "bytes_per_dexel", (double)b->n_bytes[s] / n));
    json_object_set_new(j, "scene", json_string(dx_scene_name(a->scene.scene)));
    json_object_set_new(j, "width", json_integer(a->scene.width));
    json_object_set_new(j, "height", json_integer(a->scene.height));
    json_object_set_new(j, "threads", json_integer(dx_pool_threads(b->pool)));
    json_object_set_new(j, "triangles", json_integer((json_int_t)b->n_triangles));
    json_object_set_new(j, "allocations_per_frame",
                        json_real((double)b->n_allocations / a->n_rounds));
    json_object_set_new(j, "resident_bytes", json_real(resident_bytes()));
    json_object_set_new(j, "stages", stages);
    return dx_json_print(j, "dexel bench");
}

static int set_option(struct args *a, int opt, const char *text)
{
    struct dx_arg arg = {"dexel bench", "--size", text};
    uint64_t n = 0;
    int r = 0;

    switch (opt) {
    case OPT_SCENE:
        r = dx_scene_from_name(text);
        if (r < 0)
            return dx_arg_bad(&(struct dx_arg){"dexel bench", "--scene", text},
                              "one of those of `dexel sim --list`");
        a->scene.scene = (enum dx_scene)r;
        return 0;
    case OPT_SIZE:
        return dx_arg_size(&a->scene.width, &a->scene.height, &arg);
    case OPT_NOISE:
        arg.option = "--noise";
        return dx_arg_double(&a->scene.sigma[0], &arg, 0, 100, "metres");
    case OPT_DROPOUTS:
        arg.option = "--dropouts";
        return dx_arg_double(&a->scene.dropout, &arg, 0, 1, "a share");
    case OPT_THREADS:
        arg.option = "--threads";
        r = dx_arg_u64(&n, &arg, 1, DX_POOL_MAX_THREADS, "threads");
        a->n_threads = (unsigned)n;
        return r;
    case OPT_ROUNDS:
        arg.option = "--rounds";
        r = dx_arg_u64(&n, &arg, 1, DX_BENCH_MAX_ROUNDS, "rounds");
        a->n_rounds = (uint32_t)n;
        return r;
    case OPT_JSON:
        a->json = true;
        return 0;
    default:
        return -EINVAL; /* getopt has said why */
    }
}

static int parse(struct args *a, int argc, char **argv)
{
    int opt;

    *a = (struct args){.n_threads = 1, .n_rounds = 15};
    dx_scene_config_default(&a->scene, DX_SCENE_HALL);
    a->scene.width = 1500;
    a->scene.height = 1000;
    a->scene.sigma[0] = 0.002;
    while ((opt = getopt_long(argc, argv, "", options, NULL)) != -1) {
        if (opt == OPT_HELP)
            return dx_arg_help(help);
        if (set_option(a, opt, optarg) < 0)
            return -EINVAL;
    }
    for (int s = 0; s < N_STAGES; s++)
        a->wanted[s] = optind == argc;
    for (; optind < argc; optind++) {
        int s = dx_arg_choice(&(struct dx_arg){"dexel bench", "STAGE", argv[optind]}, stage_names);

        if (s < 0)
            return -EINVAL;
        a->wanted[s] = true;
    }
    return 0;
}

int dx_bench_stages(int argc, char **argv)
{
    struct bench b = {0};
    struct args a;
    int r = parse(&a, argc, argv);

    if (r != 0)
        return r == DX_ARG_E_HELP ? 0 : 2;
    r = bench_init(&b, &a);
    if (r < 0) {
        fprintf(stderr, "dexel bench: %s\n", strerror(-r));
    } else {
        measure(&b, &a);
        if (a.json)
            r = print_json(&b, &a);
        else
            print_text(&b, &a);
    }
    bench_fini(&b);
    return r < 0 ? 1 : 0;
}
