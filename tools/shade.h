/*
 * Colours of a mesh's vertices: by its smoothed normals under a sky and a lamp beside the eye, by
 * its attribute, or by range; what is far fades a little. Owned by one thread.
 */
#ifndef DX_SHADE_H
#define DX_SHADE_H

#include "tools/camera.h"
#include "tools/mesh.h"

enum dx_shade { DX_SHADE_NORMAL = 0, DX_SHADE_ATTR = 1, DX_SHADE_RANGE = 2 };

extern const uint8_t dx_shade_background[3];

/* rgb [n_vertices][3], 0..255. Errors: -ENOMEM. */
int dx_shade_vertices(float *rgb, const struct dx_mesh *mesh, enum dx_shade shade,
                      const struct dx_camera *camera, const double up[3]);

#endif
