/*
 * What stands where in each scene, and the field of view of the scanner that looks at it. A world
 * is the scene at one frame: made on the stack, read by rays.
 */
#ifndef DX_WORLD_H
#define DX_WORLD_H

#include "drivers/synth/scene.h"
#include "drivers/synth/shapes.h"

#define DX_WORLD_MAX_SHAPES 40

/* The scanner of a scene: spinning, sampled at half steps between the limits; or pinhole with the
 * given focal length in image widths (angles 0). */
struct dx_view {
    double azimuth_deg[2], elevation_deg[2];
    double focal;
};

struct dx_world_spec {
    const char *name, *help;
    uint32_t height, width; /* of the scanner unless configured */
    struct dx_view view;
    double reach_m; /* farther than everything */
    const struct dx_shape *shape;
    unsigned n_shapes;
};

extern const struct dx_world_spec dx_world_specs[DX_N_SCENES];

struct dx_world {
    unsigned n;
    int up, up_sign; /* see dx_shape_shade */
    struct dx_shape shape[DX_WORLD_MAX_SHAPES];
};

/* The scene of `c` at frame `number`. */
void dx_world_init(struct dx_world *w, const struct dx_scene_config *c, uint64_t number);

/* Whether frames differ in more than noise. */
bool dx_world_moves(enum dx_scene scene);

/* Dexels of `g` (MOVING_BOX) that the moving shape can cover in frame `number`: [row0,row1) x
 * [col0,col1). */
struct dx_rect {
    uint32_t row0, row1, col0, col1;
};

struct dx_rect dx_world_moving_rect(const struct dx_geometry *g, const struct dx_world *w);

#endif
