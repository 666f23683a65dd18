/*
 * The synthetic driver: analytic scenes, ray cast, with seeded noise, drop-outs and mixed pixels;
 * the same bytes on every machine. A raw block names a frame and the first column of a part of it;
 * decode() casts the rays.
 */
#ifndef DX_SYNTH_H
#define DX_SYNTH_H

#include "drivers/driver.h"
#include "drivers/synth/scene.h"

struct dx_synth_config {
    struct dx_scene_config scene;
    double fps;         /* frames a second of simulated time */
    double rate;        /* 1 real time, N times; 0 = max */
    uint64_t n_frames;  /* 0: endless */
    bool loop;          /* after n_frames start again */
    uint32_t part_cols; /* deliver columns as they come, so many at a time; 0: whole frames */
};

extern const struct dx_driver dx_synth_driver;

#endif
