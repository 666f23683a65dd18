/*
 * dexel bench update: what a frame costs of which little has changed, beside one of which all has:
 * publish, commit, and the chunks of the tiles that changed. Full frames and updates take turns.
 */
#include "tools/bench.h"

#include "tools/bench_frame.h"
#include "tools/bench_sizes.h"
#include "tools/now.h"

#include <stdio.h>
#include <string.h>

static const char help[] =
    "usage: dexel bench update [OPTIONS]\n"
    "Measures a frame of which a share of the tiles has changed, from ranges to the chunks of\n"
    "the tiles that changed, beside a frame of which all has.\n\n"
    "  --dirty P        share of the tiles, at least one (0.01)\n" DX_BENCH_ARGS_HELP;

static const struct dx_bench_command command = {"dexel bench update", help, NULL, true};

/* Nothing closer to its edge than this changes in a dirty tile: more than any rule looks. */
#define INSET 12

static const struct dx_report_column columns[] = {
    {"size", "size", 0},
    {"threads", "threads", 0},
    {"tiles", "tiles", 0},
    {"changed", "changed", 0},
    {"changed, %", "changed_percent", 2},
    {"f32, ms", "f32_ms", 3},
    {"of a full frame, %", "f32_percent", 2},
    {"q16, ms", "q16_ms", 3},
    {"of a full frame, %", "q16_percent", 2},
    {"delta, ms", "delta_ms", 3},
    {"of a full frame, %", "delta_percent", 2},
    {NULL, NULL, 0},
};

static const char *const encoding_names[DX_N_ENCODINGS] = {"f32", "q16", "delta"};

/* Publish and commit, then each encoding: of a full frame, and of an update. */
enum kind { FULL, UPDATE, N_KINDS };

struct seconds {
    double mesh[N_KINDS][DX_BENCH_MAX_ROUNDS];
    double encode[N_KINDS][DX_N_ENCODINGS][DX_BENCH_MAX_ROUNDS];
};

struct bench {
    const struct dx_bench_args *args;
    uint32_t n_rounds;
    struct dx_bench_frames frames;
    struct dx_plane patched; /* the second frame, with dirty tiles of the first */
    struct dx_terrain *terrain;
    struct dx_bench_encoder *encoder;
    struct dx_pool *pool[DX_BENCH_THREADS];
    struct seconds seconds[DX_BENCH_THREADS];
    uint32_t n_changed; /* by the last update */
};

/* ---- frames -----------------------------------------------------------------------------------
 */

static void patch_tile(struct bench *b, uint32_t tile)
{
    const struct dx_tiling *t = dx_terrain_tiling(b->terrain);
    uint32_t row0 = tile / t->cols * DX_TILE_CELLS, col0 = tile % t->cols * DX_TILE_CELLS;
    uint32_t row1 = row0 + DX_TILE_CELLS, col1 = col0 + DX_TILE_CELLS;

    row1 = row1 < t->cell_rows ? row1 : t->cell_rows;
    col1 = col1 < t->cell_cols ? col1 : t->cell_cols;
    for (uint32_t i = row0 + INSET; i + INSET < row1; i++)
        for (uint32_t j = col0 + INSET; j + INSET < col1; j++) {
            size_t k = (size_t)i * t->width + j;

            dx_plane_set_range(&b->patched, k, dx_plane_range(&b->frames.plane[0], k));
        }
}

static uint32_t common_divisor(uint32_t x, uint32_t y)
{
    return y ? common_divisor(y, x % y) : x;
}

/* Spread over the whole grid, by steps of about the golden section of it. */
static void patch(struct bench *b)
{
    uint32_t n_tiles = dx_tiling_n_tiles(dx_terrain_tiling(b->terrain));
    uint32_t n = (uint32_t)(b->args->dirty * n_tiles + 0.5);
    uint32_t step = (uint32_t)(0.618 * n_tiles) + 1;
    size_t bytes = dx_plane_n_dexels(&b->patched) * b->patched.range_bytes;

    memcpy(b->patched.range, b->frames.plane[1].range, bytes);
    n = n < 1 ? 1 : n;
    while (common_divisor(step, n_tiles) != 1)
        step++;
    for (uint32_t k = 0; k < n; k++)
        patch_tile(b, (uint32_t)(((uint64_t)k * step + n_tiles / 2) % n_tiles));
}

/* ---- putting it together ----------------------------------------------------------------------
 */

static void bench_fini(void *bench)
{
    struct bench *b = bench;

    for (int k = 0; k < DX_BENCH_THREADS; k++)
        dx_pool_free(b->pool[k]);
    dx_bench_encoder_free(b->encoder);
    dx_terrain_free(b->terrain);
    dx_plane_fini(&b->patched);
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
    if (r == 0)
        r = dx_plane_init_for(&b->patched, b->frames.geometry, 0);
    for (uint32_t k = 0; r == 0 && k < a->n_threads; k++) {
        r = dx_pool_new(&b->pool[k], a->threads[k]);
        most = a->threads[k] > most ? a->threads[k] : most;
    }
    if (r == 0)
        r = dx_bench_encoder_new(&b->encoder, dx_terrain_tiling(b->terrain), most);
    if (r == 0)
        patch(b);
    return r;
}

/* ---- one round --------------------------------------------------------------------------------
 */

static bool can_encode(const struct bench *b, enum dx_encoding e)
{
    return e != DX_ENCODING_Q16 || b->frames.geometry->range_bytes == 2;
}

static void take(struct bench *b, const struct dx_plane *frame, enum kind kind, uint32_t lane,
                 uint32_t round)
{
    struct seconds *s = &b->seconds[lane];
    uint64_t start = dx_now_ns();
    uint32_t n_changed;

    dx_terrain_publish(b->terrain, frame, 0, frame->width, b->pool[lane]);
    n_changed = dx_terrain_commit(b->terrain, b->pool[lane]);
    s->mesh[kind][round] = dx_seconds_since(start);
    for (unsigned e = 0; e < DX_N_ENCODINGS; e++) {
        if (!can_encode(b, (enum dx_encoding)e))
            continue;
        start = dx_now_ns();
        dx_bench_encode(b->encoder, b->terrain, (enum dx_encoding)e, false, b->pool[lane]);
        s->encode[kind][e][round] = dx_seconds_since(start);
    }
    if (kind == UPDATE)
        b->n_changed = n_changed;
}

static void run_round(void *bench, uint32_t round)
{
    struct bench *b = bench;

    for (uint32_t k = 0; k < b->args->n_threads; k++) {
        dx_terrain_publish(b->terrain, &b->frames.plane[0], 0, b->patched.width, b->pool[k]);
        dx_terrain_commit(b->terrain, b->pool[k]);
        take(b, &b->frames.plane[1], FULL, k, round);
        take(b, &b->patched, UPDATE, k, round);
    }
}

/* ---- telling ----------------------------------------------------------------------------------
 */

static double median(const struct bench *b, uint32_t lane, enum kind kind, unsigned e)
{
    const struct seconds *s = &b->seconds[lane];
    double sum[DX_BENCH_MAX_ROUNDS];

    for (uint32_t k = 0; k < b->n_rounds; k++)
        sum[k] = s->mesh[kind][k] + s->encode[kind][e][k];
    return dx_bench_median(sum, b->n_rounds);
}

static void set_real(json_t *row, const char *encoding, const char *what, double value)
{
    char key[48];

    snprintf(key, sizeof(key), "%s_%s", encoding, what);
    json_object_set_new(row, key, json_real(value));
}

static void tell(const void *bench, struct dx_report_table *t, struct dx_bench_size size)
{
    const struct bench *b = bench;
    uint32_t n_tiles = dx_tiling_n_tiles(dx_terrain_tiling(b->terrain));

    for (uint32_t k = 0; k < b->args->n_threads; k++) {
        json_t *row = dx_report_row(t);

        dx_bench_args_label(row, size, b->args->threads[k], b->n_rounds);
        json_object_set_new(row, "tiles", json_integer(n_tiles));
        json_object_set_new(row, "changed", json_integer(b->n_changed));
        json_object_set_new(row, "changed_percent", json_real(100.0 * b->n_changed / n_tiles));
        for (unsigned e = 0; e < DX_N_ENCODINGS; e++) {
            double full = median(b, k, FULL, e), update = median(b, k, UPDATE, e);

            if (!can_encode(b, (enum dx_encoding)e))
                continue;
            set_real(row, encoding_names[e], "full_ms", full * 1e3);
            set_real(row, encoding_names[e], "ms", update * 1e3);
            set_real(row, encoding_names[e], "percent", 100 * update / full);
        }
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

int dx_bench_update(int argc, char **argv)
{
    struct dx_report_table table = {
        .name = "updates",
        .title = "Frames of which little has changed",
        .text =
            "From ranges to the chunks of the tiles that changed, and that time as a share of a "
            "full\nframe's, of which every tile changes. Medians; both in turn. All ranges of a "
            "frame are looked at\neither way.",
        .columns = columns};

    return dx_bench_sizes(&bench_kind, &table, 1, argc, argv);
}
