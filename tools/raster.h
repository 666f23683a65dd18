/*
 * A z-buffer triangle rasteriser: screen coordinates in pixels, x to the right, y down, pixel (0,0)
 * covering [0,1) x [0,1). Coverage is decided in integers (1/256 pixel) with the top-left rule, so
 * that triangles that share an edge neither overlap nor leave a gap. Owned by one thread.
 */
#ifndef DX_RASTER_H
#define DX_RASTER_H

#include <stdint.h>

struct dx_raster {
    uint32_t width, height;
    float *depth;  /* nearer is smaller; INFINITY: nothing there */
    uint8_t *rgb;  /* [height * width][3] */
    float edge_px; /* width of the darker line along a triangle's edges; 0: none */
};

struct dx_raster_vertex {
    float x, y, depth;
    float rgb[3]; /* 0..255 */
};

#define DX_RASTER_MAX_SIDE 16384u

/* An image of one colour. Errors: -EINVAL (sides of 0 or above DX_RASTER_MAX_SIDE), -ENOMEM. */
int dx_raster_init(struct dx_raster *r, uint32_t width, uint32_t height, const uint8_t rgb[3]);
void dx_raster_fini(struct dx_raster *r);

/* Draws one triangle of either orientation; depth and colour are linear on the screen. A vertex
 * that is not finite, or far outside, drops the triangle. */
void dx_raster_triangle(struct dx_raster *r, const struct dx_raster_vertex v[3]);

/* Averages blocks of 2x2 pixels into `rgb` [height/2 * width/2][3]. */
void dx_raster_halve(uint8_t *rgb, const struct dx_raster *r);

#endif
