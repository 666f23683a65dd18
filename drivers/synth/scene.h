/*
 * Analytic scenes and the scanner that looks at them (ALGORITHMS 6.2, 7.1). A dexel of a frame is a
 * pure function of the configuration, the frame number and its place. Used by the synthetic driver,
 * `dexel sim`, tests and benchmarks.
 */
#ifndef DX_SCENE_H
#define DX_SCENE_H

#include "core/grid/geometry.h"
#include "core/grid/plane.h"

enum dx_scene {
    DX_SCENE_HALL,   /* room 16 x 11 x 3.5 m, six boxes, four spheres; full turn */
    DX_SCENE_OPEN,   /* open ground, far walls, the same objects */
    DX_SCENE_SPHERE, /* sphere from inside */
    DX_SCENE_STAIRS,
    DX_SCENE_POLES,      /* poles one to three dexels wide before a wall */
    DX_SCENE_FENCE,      /* alternating pickets before a wall */
    DX_SCENE_CREASE,     /* two planes that meet at 17 degrees to the grid */
    DX_SCENE_MOVING_BOX, /* pinhole camera, a box that crosses a static room */
    DX_N_SCENES,
};

struct dx_scene_config {
    enum dx_scene scene;
    uint32_t height, width;
    double sigma[3]; /* noise: s0 + s1 r + s2 r^2, metres */
    double dropout;  /* share of dexels without a return */
    double mixed;    /* share of dexels at range steps > 0.3 m that are a mix of both */
    uint64_t seed;
    double unit_m;             /* 0: 1 mm */
    uint8_t attr_bytes;        /* 0, 1, 2: reflectance by surface and incidence */
    bool flip_rows, flip_cols; /* the device counts the other way */
};

const char *dx_scene_name(unsigned scene); /* NULL past the last */
const char *dx_scene_help(unsigned scene); /* one line; NULL past the last */
int dx_scene_from_name(const char *name);  /* or -1 */

/* Defaults of a scene: size, unit, no noise. */
void dx_scene_config_default(struct dx_scene_config *c, enum dx_scene scene);

/* Spinning scanners: row 0 is the lowest elevation, columns follow the azimuth counter-clockwise;
 * flips mirror the tables. Four bytes a range where the scene's reach does not fit two at the unit.
 * Errors: -EINVAL (scene, sizes, unit), -ENOMEM. */
int dx_scene_geometry(struct dx_geometry **out, const struct dx_scene_config *c);

/* Columns [col0, col0 + n_cols) of frame `number`, into a plane of the geometry's size. */
void dx_scene_cast(struct dx_plane *plane, const struct dx_geometry *g,
                   const struct dx_scene_config *c, uint64_t number, uint32_t col0,
                   uint32_t n_cols);

/* The noise-free range (metres; pinhole: depth) that a dexel of frame `number` sees; INFINITY if
 * none. */
double dx_scene_truth(const struct dx_geometry *g, const struct dx_scene_config *c, uint64_t number,
                      uint32_t row, uint32_t col);

/* The same along n directions of any kind, [3 * n], not of zero length: distances from the origin,
 * in metres. The scene alone of `c` is asked for. */
void dx_scene_look(double *distance, const double *dir, size_t n, const struct dx_scene_config *c,
                   uint64_t number);

#endif
