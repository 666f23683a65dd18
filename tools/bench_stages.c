/*
 * dexel bench: what a frame costs on this machine, stage by stage and as a whole, beside the speed
 * of copying memory in the same rounds. All threads' counts take turns within a round, because
 * machines are shared.
 */
#include "tools/bench.h"

#include "tools/alloc_count.h"
#include "tools/bench_apart.h"
#include "tools/bench_frame.h"
#include "tools/bench_ingest.h"
#include "tools/bench_sizes.h"
#include "tools/bench_smooth.h"
#include "tools/now.h"

#include <errno.h>
#include <stdio.h>
#include <sys/resource.h>

static const char help[] =
    "usage: dexel bench [OPTIONS] [STAGE...]\n"
    "       dexel bench rules|update|lod|live|record|paper|quality ...   (each has its --help)\n"
    "Measures terrain mode on a simulated scan: publish, codes, f32, q16, delta. Instead of\n"
    "publish: mean, median3 (through a filter); beside: smooth (what it would add), copy,\n"
    "apart (frames by threads that share nothing).\n"
    "rules: the codes with each rule; update: a frame where little has changed; lod: levels\n"
    "of detail; live: a running service at its subscribers; paper: the table of Gopi and\n"
    "Krishnan (2002); quality: meshes against the truth.\n\n" DX_BENCH_ARGS_HELP;

enum stage { PUBLISH, MEAN, MEDIAN3, SMOOTH, CODES, F32, Q16, DELTA, COPY, APART, N_STAGES };

const char *const dx_bench_stage_names[] = {"publish", "mean",  "median3", "smooth", "codes", "f32",
                                            "q16",     "delta", "copy",    "apart",  NULL};

static const struct dx_bench_command command = {"dexel bench", help, dx_bench_stage_names, false};

/* Of one count of threads. */
struct lane {
    struct dx_pool *pool;
    double seconds[N_STAGES][DX_BENCH_MAX_ROUNDS];
    uint64_t n_allocations;
};

struct bench {
    const struct dx_bench_args *args;
    uint32_t wanted; /* stages that can be had of those asked for */
    uint32_t n_rounds, n_frames;
    struct dx_bench_frames frames;
    struct dx_terrain *terrain;
    struct dx_bench_encoder *encoder;
    struct dx_bench_ingest ingest; /* where those stages are wanted */
    struct dx_bench_smooth smooth;
    /* taken only where wanted, and the second after the first round: they would be counted */
    struct dx_bench_memory memory;
    struct dx_bench_apart apart;
    double resident_bytes;
    unsigned most; /* threads of a lane */
    struct dx_bench_encoded encoded[N_STAGES];
    struct lane lane[DX_BENCH_THREADS];
};

static bool wants(const struct bench *b, enum stage s)
{
    return b->wanted >> s & 1;
}

/* ---- one round --------------------------------------------------------------------------------
 */

/* Seconds that it took. */
static double run_stage(struct bench *b, enum stage stage, struct dx_pool *pool)
{
    static const enum dx_encoding encoding[N_STAGES] = {
        [F32] = DX_ENCODING_F32, [Q16] = DX_ENCODING_Q16, [DELTA] = DX_ENCODING_DELTA};
    const struct dx_plane *frame = &b->frames.plane[b->n_frames & 1];
    const uint64_t start = dx_now_ns();

    switch (stage) {
    case PUBLISH:
        dx_terrain_publish(b->terrain, frame, 0, frame->width, pool);
        break;
    case MEAN:
        dx_bench_ingest_run(&b->ingest, DX_FILTER_MEAN, frame, pool);
        break;
    case MEDIAN3:
        dx_bench_ingest_run(&b->ingest, DX_FILTER_MEDIAN3, frame, pool);
        break;
    case SMOOTH:
        dx_bench_smooth_run(&b->smooth, frame, pool);
        break;
    case CODES:
        dx_terrain_commit(b->terrain, pool);
        break;
    case COPY:
        dx_bench_memory_copy(&b->memory, pool);
        break;
    case APART:
        return dx_bench_apart_run(&b->apart, pool);
    default:
        b->encoded[stage] = dx_bench_encode(b->encoder, b->terrain, encoding[stage], true, pool);
    }
    return dx_seconds_since(start);
}

static void run_round(void *bench, uint32_t round)
{
    struct bench *b = bench;

    for (uint32_t k = 0; k < b->args->n_threads; k++) {
        struct lane *lane = &b->lane[k];
        uint64_t before = dx_alloc_count();

        for (enum stage s = 0; s < N_STAGES; s++) {
            if (s != PUBLISH && s != CODES && !wants(b, s))
                continue; /* those two are what the others work on */
            lane->seconds[s][round] = run_stage(b, s, lane->pool);
        }
        b->n_frames++;
        lane->n_allocations += dx_alloc_count() - before;
    }
}

static double peak_resident_bytes(void)
{
    struct rusage u;

    getrusage(RUSAGE_SELF, &u);
    return 1024.0 * (double)u.ru_maxrss;
}

/* Gates, pages, caches. Errors: -ENOMEM. */
static int warm(void *bench)
{
    struct bench *b = bench;
    const bool apart = wants(b, APART);
    int r = 0;

    b->wanted &= ~(1u << APART);
    run_round(b, 0);
    b->resident_bytes = peak_resident_bytes();
    if (apart) {
        b->wanted |= 1u << APART;
        r = dx_bench_apart_init(&b->apart, &b->frames, dx_terrain_params(b->terrain), b->most);
        if (r == 0)
            run_round(b, 0);
    }
    for (uint32_t k = 0; k < b->args->n_threads; k++)
        b->lane[k].n_allocations = 0;
    return r;
}

/* ---- putting it together ----------------------------------------------------------------------
 */

static void bench_fini(void *bench)
{
    struct bench *b = bench;

    for (int k = 0; k < DX_BENCH_THREADS; k++)
        dx_pool_free(b->lane[k].pool);
    dx_bench_apart_fini(&b->apart);
    dx_bench_memory_fini(&b->memory);
    dx_bench_smooth_fini(&b->smooth);
    dx_bench_ingest_fini(&b->ingest);
    dx_bench_encoder_free(b->encoder);
    dx_terrain_free(b->terrain);
    dx_bench_frames_fini(&b->frames);
}

static int bench_init(void *bench, const struct dx_bench_args *a, struct dx_bench_size size)
{
    struct bench *b = bench;
    struct dx_terrain_params params;
    int r = dx_bench_frames_init(&b->frames, a, size);

    b->args = a;
    b->n_rounds = dx_bench_rounds(a, size);
    b->wanted = a->wanted;
    dx_terrain_params_default(&params);
    if (r == 0)
        r = dx_terrain_new(&b->terrain, b->frames.geometry, &params, 0);
    for (uint32_t k = 0; r == 0 && k < a->n_threads; k++) {
        r = dx_pool_new(&b->lane[k].pool, a->threads[k]);
        b->most = a->threads[k] > b->most ? a->threads[k] : b->most;
    }
    if (r == 0)
        r = dx_bench_encoder_new(&b->encoder, dx_terrain_tiling(b->terrain), b->most);
    params.sigma[0] = a->scene.sigma[0];
    if (r == 0 && wants(b, MEAN))
        r = dx_bench_ingest_init(&b->ingest, DX_FILTER_MEAN, b->frames.geometry, &params);
    if (r == 0 && wants(b, MEDIAN3))
        r = dx_bench_ingest_init(&b->ingest, DX_FILTER_MEDIAN3, b->frames.geometry, &params);
    if (r == 0 && wants(b, SMOOTH))
        r = dx_bench_smooth_init(&b->smooth, b->frames.geometry, &params);
    if (r == 0 && wants(b, COPY))
        r = dx_bench_memory_init(&b->memory);
    if (r == 0 && b->frames.geometry->range_bytes != 2)
        b->wanted &= ~(1u << Q16);
    return r;
}

/* ---- telling ----------------------------------------------------------------------------------
 */

static const struct dx_report_column stage_columns[] = {
    {"size", "size", 0},
    {"threads", "threads", 0},
    {"publish", "publish_ns", 2},
    {"mean", "mean_ns", 2},
    {"median3", "median3_ns", 2},
    {"smooth", "smooth_ns", 2},
    {"codes", "codes_ns", 2},
    {"f32", "f32_ns", 2},
    {"q16", "q16_ns", 2},
    {"delta", "delta_ns", 2},
    {"f32, B", "f32_bytes", 2},
    {"q16, B", "q16_bytes", 2},
    {"delta, B", "delta_bytes", 2},
    {"allocations", "allocations", 2},
    {NULL, NULL, 0},
};

static const struct dx_report_column frame_columns[] = {
    {"size", "size", 0},
    {"threads", "threads", 0},
    {"to f32, ms", "f32_ms", 3},
    {"to q16, ms", "q16_ms", 3},
    {"to delta, ms", "delta_ms", 3},
    {"copy, GB/s", "copy_gb_per_s", 2},
    {"f32 of copy, %", "f32_copy_percent", 1},
    {"q16 of copy, %", "q16_copy_percent", 1},
    {"delta of copy, %", "delta_copy_percent", 1},
    {"f32, times", "f32_times", 2},
    {"apart, times", "apart_times", 2},
    {NULL, NULL, 0},
};

static void set_real(json_t *row, const char *stage, const char *what, double value)
{
    char key[48];

    snprintf(key, sizeof(key), "%s_%s", stage, what);
    json_object_set_new(row, key, json_real(value));
}

static void tell_stages(struct dx_report_table *t, const struct bench *b, struct dx_bench_size size)
{
    double n = (double)size.width * size.height;

    for (uint32_t k = 0; k < b->args->n_threads; k++) {
        const struct lane *lane = &b->lane[k];
        json_t *row = dx_report_row(t);

        dx_bench_args_label(row, size, b->args->threads[k], b->n_rounds);
        for (enum stage s = PUBLISH; s < COPY; s++) {
            if (!wants(b, s))
                continue;
            set_real(row, dx_bench_stage_names[s], "ns",
                     dx_bench_median(lane->seconds[s], b->n_rounds) * 1e9 / n);
            if (s > CODES)
                set_real(row, dx_bench_stage_names[s], "bytes", (double)b->encoded[s].n_bytes / n);
        }
        if (wants(b, F32))
            set_real(row, "f32", "triangles", (double)b->encoded[F32].n_triangles);
        json_object_set_new(row, "allocations",
                            json_real((double)lane->n_allocations / b->n_rounds));
    }
}

/* The median of whole frames, from ranges to chunks of one encoding. */
static double frame_seconds(const struct lane *lane, enum stage encoding, uint32_t n_rounds)
{
    double sum[DX_BENCH_MAX_ROUNDS];

    for (uint32_t k = 0; k < n_rounds; k++)
        sum[k] = lane->seconds[PUBLISH][k] + lane->seconds[CODES][k] + lane->seconds[encoding][k];
    return dx_bench_median(sum, n_rounds);
}

/* Bytes that a frame moves at the least: a range is published (read, written), looked at for its
 * cell's code (read, a byte written), and encoded with it (both read); and what comes out. */
static double frame_bytes(const struct bench *b, enum stage encoding)
{
    double n = (double)dx_plane_n_dexels(&b->frames.plane[0]);

    return n * (4 * b->frames.geometry->range_bytes + 2) + (double)b->encoded[encoding].n_bytes;
}

/* By how much a lane's threads are faster than one, where that was measured too. */
static void tell_times(json_t *row, const struct bench *b, const struct lane *lane)
{
    const struct lane *one = NULL;

    for (uint32_t k = 0; k < b->args->n_threads; k++)
        if (b->args->threads[k] == 1)
            one = &b->lane[k];
    if (!one)
        return;
    if (wants(b, F32))
        set_real(row, "f32", "times",
                 frame_seconds(one, F32, b->n_rounds) / frame_seconds(lane, F32, b->n_rounds));
    if (wants(b, F32) && wants(b, APART))
        set_real(row, "apart", "times",
                 frame_seconds(one, F32, b->n_rounds) /
                     dx_bench_median(lane->seconds[APART], b->n_rounds));
}

static void tell_frames(struct dx_report_table *t, const struct bench *b, struct dx_bench_size size)
{
    for (uint32_t k = 0; k < b->args->n_threads; k++) {
        const struct lane *lane = &b->lane[k];
        json_t *row = dx_report_row(t);
        double copy = 2.0 * DX_BENCH_MEMORY_LEN / dx_bench_median(lane->seconds[COPY], b->n_rounds);

        dx_bench_args_label(row, size, b->args->threads[k], b->n_rounds);
        if (wants(b, COPY))
            json_object_set_new(row, "copy_gb_per_s", json_real(copy * 1e-9));
        for (enum stage s = F32; s < COPY; s++) {
            double seconds = frame_seconds(lane, s, b->n_rounds);

            if (!wants(b, s))
                continue;
            set_real(row, dx_bench_stage_names[s], "ms", seconds * 1e3);
            if (wants(b, COPY))
                set_real(row, dx_bench_stage_names[s], "copy_percent",
                         100 * frame_bytes(b, s) / seconds / copy);
        }
        tell_times(row, b, lane);
    }
}

static void tell(const void *bench, struct dx_report_table *tables, struct dx_bench_size size)
{
    const struct bench *b = bench;
    struct dx_report_table *frames = &tables[1];

    tell_stages(&tables[0], b, size);
    tell_frames(frames, b, size);
    json_object_set_new(json_array_get(frames->rows, json_array_size(frames->rows) - 1),
                        "resident_bytes", json_real(b->resident_bytes));
}

static const struct dx_bench_kind bench_kind = {
    .command = &command,
    .len = sizeof(struct bench),
    .fini = bench_fini,
    .init = bench_init,
    .warm = warm,
    .round = run_round,
    .tell = tell,
};

int dx_bench_stages(int argc, char **argv)
{
    struct dx_report_table tables[] = {
        {.name = "stages",
         .title = "The stages of a frame, ns a dexel",
         .text =
             "Medians. *publish* takes a frame over where it differs; *mean* and *median3* publish "
             "through a\nfilter over frames instead, *smooth* is what smoothing would add; *codes* "
             "decides the mesh by\nall rules, *f32*, *q16* and *delta* make the chunks of all "
             "tiles; "
             "beside them the bytes a\ndexel of those, and allocations in a round. Every tile "
             "changes "
             "in every frame.",
         .columns = stage_columns},
        {.name = "frames",
         .title = "Whole frames",
         .text =
             "From ranges in memory to the chunks of all tiles: the stages together. *copy* is "
             "what\n`memcpy` reads and writes in the same rounds, by as many threads; *of copy* "
             "is the time that\nthe bytes of the frame would take at that speed (its ranges and "
             "codes through the three\nstages, and the chunks), as a share of the time it took. "
             "*times*: by how much it is faster than\nwith one thread; *apart*: the same of "
             "as many threads that share nothing, each with a frame of\nits own, which is "
             "the most that these processors could give in the same rounds.",
         .columns = frame_columns}};

    return dx_bench_sizes(&bench_kind, tables, 2, argc, argv);
}
