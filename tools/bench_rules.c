/*
 * dexel bench rules: what each rule of terrain mode costs. The codes of one frame by the
 * first-order rule alone, then with one rule more at a time; all in turn within a round, each on an
 * array of its own.
 */
#include "tools/bench.h"

#include "tools/bench_frame.h"
#include "tools/bench_sizes.h"
#include "tools/now.h"

static const char help[] =
    "usage: dexel bench rules [OPTIONS]\n"
    "Measures the codes of a frame by the first-order rule alone, then with each further\n"
    "rule: rescue, mixed, bend, bridge, normals, caps.\n\n" DX_BENCH_ARGS_HELP;

static const struct dx_bench_command command = {"dexel bench rules", help, NULL, false};

enum step { FIRST, RESCUE, MIXED, BEND, BRIDGE, NORMALS, CAPS, N_STEPS };

static const struct dx_report_column columns[] = {
    {"size", "size", 0},
    {"threads", "threads", 0},
    {"first order", "first_ns", 2},
    {"+ rescue", "rescue_ns", 2},
    {"+ mixed", "mixed_ns", 2},
    {"+ bend", "bend_ns", 2},
    {"+ bridge", "bridge_ns", 2},
    {"+ normals", "normals_ns", 2},
    {"+ caps", "caps_ns", 2},
    {NULL, NULL, 0},
};

#define FIRST_COLUMN 2 /* of the steps */

struct bench {
    const struct dx_bench_args *args;
    uint32_t n_rounds, n_frames;
    struct dx_bench_frames frames;
    struct dx_terrain *terrain[N_STEPS];
    struct dx_pool *pool[DX_BENCH_THREADS];
    double seconds[DX_BENCH_THREADS][N_STEPS][DX_BENCH_MAX_ROUNDS];
    uint32_t caps; /* keeps the call */
};

static struct dx_terrain_params params_of(enum step step)
{
    struct dx_terrain_params p;

    dx_terrain_params_default(&p);
    p.rescue = step >= RESCUE;
    p.mixed = step >= MIXED ? DX_MIXED_AXIS : DX_MIXED_OFF;
    p.diag = step >= BEND ? DX_DIAG_BEND : DX_DIAG_FIXED;
    p.bridge = step >= BRIDGE ? 1 : 0;
    p.normals = step >= NORMALS;
    p.caps = step >= CAPS;
    return p;
}

static void bench_fini(void *bench)
{
    struct bench *b = bench;

    for (int k = 0; k < DX_BENCH_THREADS; k++)
        dx_pool_free(b->pool[k]);
    for (enum step s = 0; s < N_STEPS; s++)
        dx_terrain_free(b->terrain[s]);
    dx_bench_frames_fini(&b->frames);
}

static int bench_init(void *bench, const struct dx_bench_args *a, struct dx_bench_size size)
{
    struct bench *b = bench;
    int r = dx_bench_frames_init(&b->frames, a, size);

    b->args = a;
    b->n_rounds = dx_bench_rounds(a, size);
    for (enum step s = 0; r == 0 && s < N_STEPS; s++) {
        struct dx_terrain_params params = params_of(s);

        r = dx_terrain_new(&b->terrain[s], b->frames.geometry, &params, 0);
    }
    for (uint32_t k = 0; r == 0 && k < a->n_threads; k++)
        r = dx_pool_new(&b->pool[k], a->threads[k]);
    return r;
}

static void run_round(void *bench, uint32_t round)
{
    struct bench *b = bench;

    for (uint32_t k = 0; k < b->args->n_threads; k++) {
        const struct dx_plane *frame = &b->frames.plane[b->n_frames++ & 1];

        for (enum step s = 0; s < N_STEPS; s++) {
            uint64_t start;

            dx_terrain_publish(b->terrain[s], frame, 0, frame->width, b->pool[k]);
            start = dx_now_ns();
            dx_terrain_commit(b->terrain[s], b->pool[k]);
            b->caps += dx_terrain_caps(b->terrain[s]);
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

int dx_bench_rules(int argc, char **argv)
{
    struct dx_report_table table = {
        .name = "rules",
        .title = "Codes, by rule, ns a dexel",
        .text =
            "The commit of a frame of which every tile has changed: cells, struts and what tells "
            "that a\ntile has changed. The first-order rule alone (no second chance, no filter, "
            "fixed diagonals),\nthen with one rule more in each column; the default rules end "
            "with *bridge*. Medians.",
        .columns = columns};

    return dx_bench_sizes(&bench_kind, &table, 1, argc, argv);
}
