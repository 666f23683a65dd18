/*
 * What a camera's pixels look at: a pinhole, with or without the distortion of its lens (Brown's
 * model, radial k1 k2 k3, tangential p1 p2, the order and signs of the usual calibration tools).
 * Rays are undistorted once, when the geometry is made. Plain functions; any thread. The same bits
 * on every machine.
 */
#ifndef DX_LENS_H
#define DX_LENS_H

#include "core/base/err.h"
#include "core/grid/geometry.h"

/* Of cx, cy: the middle of the image. */
#define DX_LENS_CENTRE (-2147483648.0)

/* Pixels: the centre of the first one is (0, 0). */
struct dx_lens {
    double fx, fy; /* fy 0: as fx */
    double cx, cy;
    double k1, k2, p1, p2, k3;
};

bool dx_lens_is_straight(const struct dx_lens *lens);

/* Puts numbers for what was left to the image's size. */
void dx_lens_settle(struct dx_lens *lens, uint32_t height, uint32_t width);

/* Where the lens puts what is seen at ray (x, y, 1), still in units of the focal length. */
void dx_lens_distort(const struct dx_lens *lens, const double ray[2], double bent[2]);

/* The ray (x, y, 1) that a settled lens puts at (row, col). -ERANGE: none, the model folds before
 * it gets there. */
int dx_lens_ray(const struct dx_lens *lens, double row, double col, double ray[2]);

/* Whether an image of this size can have the lens, by its edges and a grid of its pixels: 0, or
 * -EINVAL with text. */
int dx_lens_check(const struct dx_lens *lens, uint32_t height, uint32_t width, struct dx_err *err);

/*
 * The geometry of an image: a pinhole where the lens is straight, which takes depths as they are;
 * else a table of unit directions, which wants ranges (dx_lens_stretch). Errors: -EINVAL (with
 * text), -ENOMEM.
 */
int dx_lens_geometry(struct dx_geometry **out, const struct dx_lens *lens, uint32_t height,
                     uint32_t width, struct dx_err *err);

/* Of a table of dx_lens_geometry(): range for a depth of 1, for each dexel. */
void dx_lens_stretch(float *stretch, const struct dx_geometry *g);

#endif
