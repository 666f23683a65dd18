/*
 * What the beams meet, and what the sensor makes of it: noise-free sights, a row at a time, and the
 * dexels that noise, mixing and drop-outs turn them into. Between scene.c and synth.c, which keeps
 * sights of frames.
 */
#ifndef DX_SIGHT_H
#define DX_SIGHT_H

#include "drivers/synth/world.h"

struct dx_sight {
    double range; /* metres; pinhole: depth; INFINITY: nothing there */
    float shade;  /* reflectance times cosine of incidence, 0..1 */
};

/* What a ray from the origin along `dir` meets; the range counts lengths of `dir`. */
struct dx_sight dx_sight_along(const struct dx_world *w, const double dir[3]);

/* Sights of columns [col0, col0 + n) of a row; columns go around where the grid wraps, and are
 * empty beyond its ends where it does not. */
void dx_sight_row(struct dx_sight *out, const struct dx_world *w, const struct dx_geometry *g,
                  uint32_t row, int64_t col0, uint32_t n);

/* The sensor at one frame. */
struct dx_sensor {
    const struct dx_scene_config *config;
    double unit_m, max_units;
    double attr_scale;
    bool noisy;
    uint64_t frame_hash;
};

void dx_sensor_init(struct dx_sensor *s, const struct dx_geometry *g,
                    const struct dx_scene_config *c, uint64_t number);

/*
 * Dexels [col0, col0 + n) of a row from their sights. With mixed pixels the sights of all four
 * neighbours are read: here[-1], here[n], and `above` and `below`, NULL outside the grid.
 */
void dx_sensor_row(struct dx_plane *plane, const struct dx_sensor *s, uint32_t row, uint32_t col0,
                   uint32_t n, const struct dx_sight *here, const struct dx_sight *above,
                   const struct dx_sight *below);

#endif
