/* Frames by threads that share nothing. */
#include "tools/bench_apart.h"

#include "tools/now.h"

#include <errno.h>
#include <stdlib.h>

int dx_bench_apart_init(struct dx_bench_apart *b, const struct dx_bench_frames *frames,
                        const struct dx_terrain_params *params, unsigned n_threads)
{
    int r = 0;

    b->desk = calloc(n_threads, sizeof(*b->desk));
    if (!b->desk)
        return -ENOMEM;
    b->n_desks = n_threads;
    for (unsigned k = 0; r == 0 && k < n_threads; k++) {
        struct dx_bench_desk *d = &b->desk[k];

        d->frames = frames;
        r = dx_terrain_new(&d->terrain, frames->geometry, params, 0);
        if (r == 0)
            r = dx_bench_encoder_new(&d->encoder, dx_terrain_tiling(d->terrain), 1);
    }
    return r;
}

void dx_bench_apart_fini(struct dx_bench_apart *b)
{
    for (unsigned k = 0; k < b->n_desks; k++) {
        dx_bench_encoder_free(b->desk[k].encoder);
        dx_terrain_free(b->desk[k].terrain);
    }
    free(b->desk);
}

/* A task waits for the others, so that each is on a thread of its own. */
static void mesh_frame(void *ctx, uint32_t task, unsigned thread)
{
    struct dx_bench_apart *b = ctx;
    struct dx_bench_desk *d = &b->desk[task];
    const struct dx_plane *frame = &d->frames->plane[d->n_frames++ & 1];
    uint64_t start;

    (void)thread;
    pthread_barrier_wait(&b->start);
    start = dx_now_ns();
    dx_terrain_publish(d->terrain, frame, 0, frame->width, NULL);
    dx_terrain_commit(d->terrain, NULL);
    dx_bench_encode(d->encoder, d->terrain, DX_ENCODING_F32, true, NULL);
    d->seconds = dx_seconds_since(start);
}

double dx_bench_apart_run(struct dx_bench_apart *b, struct dx_pool *pool)
{
    const unsigned n = dx_pool_threads(pool);
    double frames_per_second = 0;

    pthread_barrier_init(&b->start, NULL, n);
    dx_pool_run(pool, n, mesh_frame, b);
    pthread_barrier_destroy(&b->start);
    for (unsigned k = 0; k < n; k++)
        frames_per_second += 1 / b->desk[k].seconds;
    return 1 / frames_per_second;
}
