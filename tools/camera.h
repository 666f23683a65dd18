/*
 * Where a mesh is looked at from. A panorama keeps azimuth and elevation (a whole turn fits); a
 * perspective camera stands anywhere. Distances in metres, image sizes in pixels. Plain values; one
 * thread.
 */
#ifndef DX_CAMERA_H
#define DX_CAMERA_H

#include "tools/mesh.h"

#include <stdbool.h>

struct dx_camera {
    bool panorama;
    double eye[3];
    double right[3], down[3], forward[3]; /* orthonormal */
    double scale;  /* pixels a radian (panorama), or focal length in pixels */
    double cx, cy; /* where `forward` meets the image */
    double near_m; /* perspective: what is nearer is cut off */
    bool cull;     /* leave out triangles seen from behind */
};

/* How the mesh lies around its scanner: what the views below are built from. */
struct dx_view_frame {
    double up[3], ahead[3];          /* orthonormal; ahead: the middle of what the scanner saw */
    double azimuth_span;             /* of the points about `up`, radians; 2 pi for a full turn */
    double azimuth[2], elevation[2]; /* about `ahead`, radians, growing to the right and up */
    double centre[3], radius;        /* of nearly all of the points (a few strays do not count) */
};

/* A mesh whose points all lie about +z is a camera's (x right, y down); else z is up. -ENOMEM, or
 * -ENODATA without a vertex. */
int dx_view_frame_of(struct dx_view_frame *f, const struct dx_mesh *mesh);

/* From the scanner: a panorama where it saw more than 120 degrees, else perspective. Chooses an
 * image height for the width when *height is 0. */
void dx_camera_scanner(struct dx_camera *c, const struct dx_view_frame *f,
                       const struct dx_mesh *mesh, uint32_t width, uint32_t *height);

/*
 * Perspective from outside, looking at the middle: yaw to the right of the scanner's own direction
 * and pitch above it, radians; dist_m from the middle, 0: all fits. Back faces are left out, so
 * that a room's near walls do not hide it.
 */
void dx_camera_orbit(struct dx_camera *c, const struct dx_view_frame *f, const struct dx_mesh *mesh,
                     uint32_t width, uint32_t *height, double yaw, double pitch, double dist_m);

/* A point in the camera's own axes: to the right, down, forward. */
void dx_camera_local(double local[3], const struct dx_camera *c, const float p[3]);

#endif
