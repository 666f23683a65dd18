/*
 * A simulated acquisition for benchmarks: samples of the hall in random directions, as a hand-held
 * or multi-pass scanner takes them, where some directions never answer. A sample is a pure function
 * of the room and its number, so that no more than a batch need ever be in memory.
 */
#ifndef DX_BENCH_ROOM_H
#define DX_BENCH_ROOM_H

#include "core/base/pool.h"
#include "drivers/synth/scene.h"

#define DX_ROOM_WAVES 6

struct dx_room {
    struct dx_scene_config scene;
    uint64_t seed;
    double sigma_m;
    double azimuth[2], elevation[2]; /* radians */
    /* A direction answers where a sum of plane waves stays below the level: patches like windows,
     * black and polished things, bounded by curves. */
    struct {
        double k[3], phase;
    } wave[DX_ROOM_WAVES];
    double level;
};

/* `silent`: the share of the directions that do not answer, 0 to below 1. */
void dx_room_init(struct dx_room *room, uint64_t seed, double sigma_m, double silent);

/* Samples `number` to number + n - 1, [3 * n] metres, on the pool (may be NULL). */
void dx_room_sample(double *xyz, const struct dx_room *room, uint32_t number, uint32_t n,
                    struct dx_pool *pool);

#endif
