/*
 * What a filter makes of a scene that stands still: how many tiles a frame changes, and how far the
 * published ranges are from the truth. Everything from the configuration and its seed: the same
 * figures on every machine.
 */
#ifndef DX_QUALITY_STATIC_H
#define DX_QUALITY_STATIC_H

#include "core/grid/terrain.h"
#include "drivers/synth/scene.h"

struct dx_quality_static_config {
    struct dx_scene_config scene;
    struct dx_terrain_params params;
    uint32_t warm;     /* the figures begin after so many frames: the mean has filled */
    uint32_t settled;  /* from here on the scene counts as settled; the error is taken here */
    uint32_t n_frames; /* in all; more than `settled` */
};

/* Hall, 1500 x 1000 in millimetres, noise of 5 mm, mean with its defaults; frames 17-64, 65-150. */
void dx_quality_static_default(struct dx_quality_static_config *c);

/* Shares are of all tiles, means over frames. */
struct dx_quality_static {
    uint32_t n_tiles;
    double settling;  /* share of tiles that a frame changes, after `warm` up to `settled` */
    double settled;   /* the same after `settled` */
    double rms_sigma; /* of (published - truth) / sigma, after `settled` frames */
    double rms_end;   /* the same after the last frame */
    double publish_s; /* seconds a frame, median over all: dx_terrain_publish alone */
};

/* Errors: -EINVAL (scene, parameters, frames), -ENOMEM. */
int dx_quality_static_run(struct dx_quality_static *q, const struct dx_quality_static_config *c,
                          struct dx_pool *pool);

#endif
