/*
 * dexel bench lod: what levels of detail cost. The errors of a frame of which every tile has
 * changed, and the f32 chunks of one level, in turn with the codes and the whole f32 chunks.
 */
#include "tools/bench.h"

#include "core/grid/lod.h"
#include "tools/bench_frame.h"
#include "tools/bench_sizes.h"
#include "tools/now.h"

#include <errno.h>
#include <stdlib.h>

static const char help[] =
    "usage: dexel bench lod [OPTIONS]\n"
    "Measures the errors of levels of detail and the f32 chunks of one at 4 sigma, beside the\n"
    "codes of the frame and its whole f32 chunks.\n\n" DX_BENCH_ARGS_HELP;

static const struct dx_bench_command command = {"dexel bench lod", help, NULL, false};

enum step { CODES, WHOLE, ERRORS, LEVEL, N_STEPS };

static const struct dx_report_column columns[] = {
    {"size", "size", 0},
    {"threads", "threads", 0},
    {"codes", "codes_ns", 2},
    {"f32", "whole_ns", 2},
    {"errors", "errors_ns", 2},
    {"level", "level_ns", 2},
    {"level, B", "level_bytes", 2},
    {NULL, NULL, 0},
};

#define FIRST_COLUMN 2 /* of the steps */

static const struct dx_lod_level levels[DX_LOD_SLOTS] = {{.bound = 4 * DX_LOD_PER_SIGMA}};

struct bench {
    const struct dx_bench_args *args;
    uint32_t n_rounds, n_frames;
    struct dx_bench_frames frames;
    struct dx_terrain *terrain;
    struct dx_lod *lod;
    struct dx_bench_encoder *encoder;
    struct dx_pool *pool[DX_BENCH_THREADS];
    /* of the one thread that cuts */
    struct dx_lod_scratch *scratch;
    struct dx_tile tile;
    struct dx_tile_mesh whole, cut;
    uint8_t *body;
    size_t n_bytes;
    double seconds[DX_BENCH_THREADS][N_STEPS][DX_BENCH_MAX_ROUNDS];
};

static void bench_fini(void *bench)
{
    struct bench *b = bench;

    free(b->body);
    dx_lod_scratch_free(b->scratch);
    for (int k = 0; k < DX_BENCH_THREADS; k++)
        dx_pool_free(b->pool[k]);
    dx_bench_encoder_free(b->encoder);
    dx_lod_free(b->lod);
    dx_terrain_free(b->terrain);
    dx_bench_frames_fini(&b->frames);
}

static int bench_init(void *bench, const struct dx_bench_args *a, struct dx_bench_size size)
{
    struct bench *b = bench;
    struct dx_terrain_params params;
    unsigned most = 1;
    int r = dx_bench_frames_init(&b->frames, a, size);

    b->args = a;
    b->n_rounds = dx_bench_rounds(a, size);
    dx_terrain_params_default(&params);
    if (r == 0)
        r = dx_terrain_new(&b->terrain, b->frames.geometry, &params, 0);
    for (uint32_t k = 0; r == 0 && k < a->n_threads; k++) {
        r = dx_pool_new(&b->pool[k], a->threads[k]);
        most = a->threads[k] > most ? a->threads[k] : most;
    }
    if (r == 0)
        r = dx_bench_encoder_new(&b->encoder, dx_terrain_tiling(b->terrain), most);
    if (r < 0)
        return r;
    dx_terrain_publish(b->terrain, &b->frames.plane[1], 0, b->frames.plane[1].width, NULL);
    dx_terrain_commit(b->terrain, b->pool[0]);
    b->scratch = dx_lod_scratch_new();
    b->body = malloc(dx_chunk_max_len(DX_ENCODING_F32));
    if (!b->scratch || !b->body)
        return -ENOMEM;
    return dx_lod_new(&b->lod, b->terrain, b->pool[0]);
}

static void cut_all(struct bench *b)
{
    const struct dx_tiling *tiling = dx_terrain_tiling(b->terrain);

    b->n_bytes = 0;
    for (uint32_t k = 0; k < dx_tiling_n_tiles(tiling); k++) {
        if (!dx_terrain_tile(b->terrain, k, &b->tile))
            continue;
        dx_tile_mesh_build(&b->whole, &b->tile, tiling, b->frames.geometry);
        dx_lod_mesh(&b->cut, b->lod, levels[0], &b->tile, &b->whole, b->scratch);
        b->n_bytes += dx_chunk_put_mesh(b->body, &b->cut);
    }
}

static void run_step(struct bench *b, enum step step, struct dx_pool *pool)
{
    switch (step) {
    case CODES:
        dx_terrain_commit(b->terrain, pool);
        break;
    case WHOLE:
        dx_bench_encode(b->encoder, b->terrain, DX_ENCODING_F32, true, pool);
        break;
    case ERRORS:
        dx_lod_note(b->lod, dx_terrain_changed(b->terrain));
        dx_lod_update(b->lod, levels, pool);
        break;
    default:
        cut_all(b);
    }
}

static void run_round(void *bench, uint32_t round)
{
    struct bench *b = bench;

    for (uint32_t k = 0; k < b->args->n_threads; k++) {
        const struct dx_plane *frame = &b->frames.plane[b->n_frames++ & 1];

        dx_terrain_publish(b->terrain, frame, 0, frame->width, NULL);
        for (enum step s = 0; s < N_STEPS; s++) {
            uint64_t start = dx_now_ns();

            run_step(b, s, b->pool[k]);
            b->seconds[k][s][round] = dx_seconds_since(start);
        }
    }
}

static void tell(const void *bench, struct dx_report_table *t, struct dx_bench_size size)
{
    const struct bench *b = bench;
    double n = (double)size.width * size.height;

    for (uint32_t k = 0; k < b->args->n_threads; k++) {
        json_t *row = dx_report_row(t);

        dx_bench_args_label(row, size, b->args->threads[k], b->n_rounds);
        for (enum step s = 0; s < N_STEPS; s++)
            json_object_set_new(
                row, columns[FIRST_COLUMN + s].key,
                json_real(dx_bench_median(b->seconds[k][s], b->n_rounds) * 1e9 / n));
        json_object_set_new(row, "level_bytes", json_real((double)b->n_bytes / n));
    }
}

static const struct dx_bench_kind bench_kind = {
    .command = &command,
    .len = sizeof(struct bench),
    .fini = bench_fini,
    .init = bench_init,
    .round = run_round,
    .tell = tell,
};

int dx_bench_lod(int argc, char **argv)
{
    struct dx_report_table table = {
        .name = "lod",
        .title = "Levels of detail, ns a dexel",
        .text = "*errors* brings those of all dexels up to date (threads as told), *level* cuts "
                "the tiles at\n4 sigma and makes their f32 chunks from the whole ones (one "
                "thread). Every tile changes\nin every frame. Medians.",
        .columns = columns};

    return dx_bench_sizes(&bench_kind, &table, 1, argc, argv);
}
