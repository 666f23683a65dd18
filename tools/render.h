/* A mesh through a camera into an image. Owned by one thread. */
#ifndef DX_RENDER_H
#define DX_RENDER_H

#include "tools/camera.h"
#include "tools/raster.h"

/* Draws the mesh with the colours of its vertices (rgb [n_vertices][3]); the camera is for an image
 * of the raster's size. Errors: -ENOMEM. */
int dx_render_mesh(struct dx_raster *r, const struct dx_mesh *mesh, const float *rgb,
                   const struct dx_camera *camera);

#endif
