/*
 * What the benchmarks of a frame work on: two draws of the noise of one simulated scan, which taken
 * in turn change every tile; the encoding of tiles on a pool, each thread into memory that is used
 * again, as the service does; and the speed of copying memory, to compare with. One owner.
 */
#ifndef DX_BENCH_FRAME_H
#define DX_BENCH_FRAME_H

#include "core/grid/terrain.h"
#include "core/wire/chunk.h"
#include "drivers/synth/scene.h"
#include "tools/bench_args.h"

struct dx_bench_frames {
    struct dx_geometry *geometry;
    struct dx_plane plane[2];
};

/* The draws are made by all processors. Errors: -EINVAL (sizes), -ENOMEM; fini in any case. */
int dx_bench_frames_init(struct dx_bench_frames *f, const struct dx_bench_args *a,
                         struct dx_bench_size size);
void dx_bench_frames_fini(struct dx_bench_frames *f);

struct dx_bench_encoder;

/* For pools of up to `n_threads`, and arrays of such tiles. Errors: -ENOMEM. */
int dx_bench_encoder_new(struct dx_bench_encoder **out, const struct dx_tiling *tiling,
                         unsigned n_threads);
void dx_bench_encoder_free(struct dx_bench_encoder *e);

struct dx_bench_encoded {
    size_t n_bytes, n_triangles; /* triangles are counted with f32 alone */
};

/* The tiles that the last commit changed (`all` false), or all, as chunks. */
struct dx_bench_encoded dx_bench_encode(struct dx_bench_encoder *e, const struct dx_terrain *t,
                                        enum dx_encoding encoding, bool all, struct dx_pool *pool);

/* Two stretches of memory that no cache holds. */
struct dx_bench_memory {
    uint8_t *from, *to;
};

#define DX_BENCH_MEMORY_LEN ((size_t)128 << 20)

int dx_bench_memory_init(struct dx_bench_memory *m); /* -ENOMEM */
void dx_bench_memory_fini(struct dx_bench_memory *m);
/* Copies all of it: DX_BENCH_MEMORY_LEN read and as much written. */
void dx_bench_memory_copy(struct dx_bench_memory *m, struct dx_pool *pool);

#endif
