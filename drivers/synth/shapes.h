/*
 * Shapes that rays from the scanner's origin can hit, and how bright they look. Pure functions of
 * constant data, any thread. Lengths in metres, in the scanner's frame.
 */
#ifndef DX_SHAPES_H
#define DX_SHAPES_H

#include <stdint.h>

enum dx_shape_kind {
    DX_SHAPE_ROOM,   /* axis-aligned box around the origin, corners a and b, seen from inside */
    DX_SHAPE_BOX,    /* axis-aligned box, corners a and b, the origin outside */
    DX_SHAPE_SPHERE, /* centre a, radius b[0]; the origin outside */
    DX_SHAPE_BUBBLE, /* the same with the origin inside */
    DX_SHAPE_POLE,  /* upright tube: axis through a[0], a[1]; radius b[0]; a[2] <= z <= b[2], b[2] >
                       0 */
    DX_SHAPE_PLANE, /* points p with a.p = b[0] */
    DX_SHAPE_FENCE, /* pickets at distance b[0] around the origin, a[2] <= z <= b[2]: every second
                       sector of a[1] radians, from azimuth a[0] on, is solid */
};

enum dx_paint {
    DX_PAINT_PLAIN,
    DX_PAINT_ROOM, /* checkerboard floor, striped walls, plain ceiling */
};

struct dx_shape {
    enum dx_shape_kind kind;
    double a[3], b[3];
    enum dx_paint paint;
    double albedo;
    /* Bounding sphere, for dx_shape_bound: centre, and |centre|^2 - radius^2; 0 where there is
     * none. */
    double centre[3], power;
};

/* A ray from the origin; the hit is at t * d, so t is the range (or depth) when d is a direction of
 * the geometry. */
struct dx_ray {
    double d[3], inv[3], dd; /* direction, its reciprocals, its squared length */
};

struct dx_ray dx_ray_make(double x, double y, double z);

/* Fills the bounding sphere. */
void dx_shape_bound(struct dx_shape *s);

/* The t of the first hit, INFINITY if none; `face` tells the sides of boxes apart (axis * 2 +
 * upper). */
double dx_shape_hit(const struct dx_shape *s, const struct dx_ray *ray, int *face);

/* Reflectance times the cosine of incidence, 0..1, at the hit. `up` is the axis that points up or
 * down, `up_sign` which of them. */
double dx_shape_shade(const struct dx_shape *s, const struct dx_ray *ray, double t, int face,
                      int up, int up_sign);

#endif
