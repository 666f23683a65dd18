/* Directions, silence and noise of the simulated acquisition. */
#include "tools/bench_room.h"

#include "core/base/rng.h"
#include "core/base/trig.h"
#include "drivers/synth/world.h"
#include "tools/bench.h"

#include <stdlib.h>

/* Patches of about 6 degrees: their outline is about as long, in dexels, as what the paper's mesh
 * has of boundary (2V - T of its table). */
#define WAVES_PER_RADIAN 32.0

#define N_PROBES         20001 /* directions that settle the level */
#define TASK_LEN         1024
#define WAVE_DRAWS       UINT64_MAX /* streams that no sample's number names */
#define PROBES           (UINT64_MAX - 1)

static void draw_direction(double dir[3], const struct dx_room *room, struct dx_rng *rng)
{
    double az = room->azimuth[0] + (room->azimuth[1] - room->azimuth[0]) * dx_rng_unit(rng);
    double el = room->elevation[0] + (room->elevation[1] - room->elevation[0]) * dx_rng_unit(rng);
    double s, c;

    dx_sincos(el, &dir[2], &c);
    dx_sincos(az, &s, &dir[0]);
    dir[0] *= c;
    dir[1] = s * c;
}

static double wave_sum(const struct dx_room *room, const double dir[3])
{
    double sum = 0;

    for (int w = 0; w < DX_ROOM_WAVES; w++) {
        const double *k = room->wave[w].k;

        sum += dx_sin(k[0] * dir[0] + k[1] * dir[1] + k[2] * dir[2] + room->wave[w].phase);
    }
    return sum;
}

/* ---- making it ------------------------------------------------------------------------------ */

static void draw_waves(struct dx_room *room)
{
    struct dx_rng rng = dx_rng_init(room->seed, WAVE_DRAWS);

    for (int w = 0; w < DX_ROOM_WAVES; w++) {
        double z = 2 * dx_rng_unit(&rng) - 1, az = 2 * DX_PI * dx_rng_unit(&rng), s, c;
        double across = dx_sin(dx_acos(z));

        dx_sincos(az, &s, &c);
        room->wave[w].k[0] = WAVES_PER_RADIAN * across * c;
        room->wave[w].k[1] = WAVES_PER_RADIAN * across * s;
        room->wave[w].k[2] = WAVES_PER_RADIAN * z;
        room->wave[w].phase = 2 * DX_PI * dx_rng_unit(&rng);
    }
}

/* The level that leaves the share of random directions above it. */
static double level_of(const struct dx_room *room, double silent)
{
    struct dx_rng rng = dx_rng_init(room->seed, PROBES);
    double sum[N_PROBES];

    for (int k = 0; k < N_PROBES; k++) {
        double dir[3];

        draw_direction(dir, room, &rng);
        sum[k] = wave_sum(room, dir);
    }
    qsort(sum, N_PROBES, sizeof(*sum), dx_bench_by_value);
    return silent > 0 ? sum[(int)((N_PROBES - 1) * (1 - silent))] : DX_ROOM_WAVES;
}

void dx_room_init(struct dx_room *room, uint64_t seed, double sigma_m, double silent)
{
    const struct dx_view *view = &dx_world_specs[DX_SCENE_HALL].view;

    *room = (struct dx_room){.seed = seed, .sigma_m = sigma_m};
    dx_scene_config_default(&room->scene, DX_SCENE_HALL);
    for (int k = 0; k < 2; k++) {
        room->azimuth[k] = dx_rad(view->azimuth_deg[k]);
        room->elevation[k] = dx_rad(view->elevation_deg[k]);
    }
    draw_waves(room);
    room->level = level_of(room, silent);
}

/* ---- samples -------------------------------------------------------------------------------- */

struct batch {
    const struct dx_room *room;
    double *xyz;
    uint32_t number, n;
};

static void sample_task(void *ctx, uint32_t task, unsigned thread)
{
    const struct batch *b = ctx;
    uint32_t first = task * TASK_LEN, n = b->n - first < TASK_LEN ? b->n - first : TASK_LEN;
    double *xyz = b->xyz + 3 * (size_t)first, distance[TASK_LEN], noise[TASK_LEN];

    (void)thread;
    for (uint32_t k = 0; k < n; k++) {
        struct dx_rng rng = dx_rng_init(b->room->seed, b->number + first + k);

        do
            draw_direction(xyz + 3 * k, b->room, &rng);
        while (wave_sum(b->room, xyz + 3 * k) > b->room->level);
        noise[k] = b->room->sigma_m * dx_rng_normal(&rng);
    }
    dx_scene_look(distance, xyz, n, &b->room->scene, 0);
    for (uint32_t k = 0; k < 3 * n; k++)
        xyz[k] *= distance[k / 3] + noise[k / 3];
}

void dx_room_sample(double *xyz, const struct dx_room *room, uint32_t number, uint32_t n,
                    struct dx_pool *pool)
{
    struct batch b = {room, xyz, number, n};

    dx_pool_run(pool, (n + TASK_LEN - 1) / TASK_LEN, sample_task, &b);
}
