/*
 * Frames by threads that share nothing, for `dexel bench`: each meshes its own array on its own,
 * all at the same time. What they do in that time is the most that as many threads could do for one
 * frame: processors are not equally fast where others' work runs beside it on their cores.
 */
#ifndef DX_BENCH_APART_H
#define DX_BENCH_APART_H

#include "tools/bench_frame.h"

#include <pthread.h>

/* Of one thread. */
struct dx_bench_desk {
    const struct dx_bench_frames *frames; /* borrowed */
    struct dx_terrain *terrain;
    struct dx_bench_encoder *encoder;
    uint32_t n_frames;
    double seconds; /* of its last frame */
};

struct dx_bench_apart {
    struct dx_bench_desk *desk;
    unsigned n_desks;
    pthread_barrier_t start; /* of the run under way */
};

/* For runs of up to `n_threads`. Errors: -ENOMEM; fini in any case. */
int dx_bench_apart_init(struct dx_bench_apart *b, const struct dx_bench_frames *frames,
                        const struct dx_terrain_params *params, unsigned n_threads);
void dx_bench_apart_fini(struct dx_bench_apart *b);

/* A frame from ranges to f32 chunks by each thread of the pool. Returns seconds a frame, at the sum
 * of what they did in a second. */
double dx_bench_apart_run(struct dx_bench_apart *b, struct dx_pool *pool);

#endif
