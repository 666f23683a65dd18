/* Edge functions in fixed point, one pass over the bounding box. */
#include "tools/raster.h"

#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define SUBPIXELS 256
#define FAR_PX    4194304.0f /* 2^22 pixels: products of two stay below 2^62 */

int dx_raster_init(struct dx_raster *r, uint32_t width, uint32_t height, const uint8_t rgb[3])
{
    size_t n = (size_t)width * height;

    *r = (struct dx_raster){.width = width, .height = height};
    if (!width || !height || width > DX_RASTER_MAX_SIDE || height > DX_RASTER_MAX_SIDE)
        return -EINVAL;
    r->depth = malloc(n * sizeof(*r->depth));
    r->rgb = malloc(n * 3);
    if (!r->depth || !r->rgb) {
        dx_raster_fini(r);
        return -ENOMEM;
    }
    for (size_t k = 0; k < n; k++) {
        r->depth[k] = INFINITY;
        memcpy(r->rgb + 3 * k, rgb, 3);
    }
    return 0;
}

void dx_raster_fini(struct dx_raster *r)
{
    free(r->depth);
    free(r->rgb);
    *r = (struct dx_raster){0};
}

/* E(p) = (b-a) x (p-a): positive inside, for the orientation that has a positive area. */
struct edge {
    int64_t at;             /* at the pixel under way */
    int64_t step_x, step_y; /* to the next pixel */
    int64_t row;            /* at the first pixel of the row */
    int64_t bias;           /* -1 where points on the edge belong to the neighbour */
    float per_px;           /* distance in pixels = E * per_px */
};

struct fixed {
    int64_t x, y;
};

struct box {
    int64_t x0, y0, x1, y1; /* pixels, the last ones outside */
};

static struct edge edge_between(struct fixed a, struct fixed b, const struct box *box)
{
    int64_t dx = b.x - a.x, dy = b.y - a.y;
    int64_t px = box->x0 * SUBPIXELS + SUBPIXELS / 2, py = box->y0 * SUBPIXELS + SUBPIXELS / 2;
    bool top_left = (dy == 0 && dx > 0) || dy < 0;
    struct edge e = {
        .step_x = -dy * SUBPIXELS, .step_y = dx * SUBPIXELS, .bias = top_left ? 0 : -1};

    e.row = dx * (py - a.y) - dy * (px - a.x);
    e.per_px = 1.0f / (SUBPIXELS * sqrtf((float)(dx * dx + dy * dy)));
    return e;
}

static int64_t clamp(int64_t v, int64_t max)
{
    return v < 0 ? 0 : v > max ? max : v;
}

static struct box box_of(const struct dx_raster *r, const struct fixed p[3])
{
    struct fixed min = p[0], max = p[0];

    for (int k = 1; k < 3; k++) {
        min.x = p[k].x < min.x ? p[k].x : min.x;
        min.y = p[k].y < min.y ? p[k].y : min.y;
        max.x = p[k].x > max.x ? p[k].x : max.x;
        max.y = p[k].y > max.y ? p[k].y : max.y;
    }
    return (struct box){
        clamp(min.x / SUBPIXELS - 1, r->width), clamp(min.y / SUBPIXELS - 1, r->height),
        clamp(max.x / SUBPIXELS + 1, r->width), clamp(max.y / SUBPIXELS + 1, r->height)};
}

static void put_pixel(struct dx_raster *r, size_t k, const struct dx_raster_vertex *const v[3],
                      const float weight[3], float shade)
{
    float depth = weight[0] * v[0]->depth + weight[1] * v[1]->depth + weight[2] * v[2]->depth;

    if (!(depth < r->depth[k]))
        return;
    r->depth[k] = depth;
    for (int c = 0; c < 3; c++) {
        float x = weight[0] * v[0]->rgb[c] + weight[1] * v[1]->rgb[c] + weight[2] * v[2]->rgb[c];

        x = x * shade + 0.5f;
        r->rgb[3 * k + (size_t)c] = (uint8_t)(x < 0 ? 0 : x > 255 ? 255 : x);
    }
}

static void put_if_inside(struct dx_raster *r, size_t k, const struct dx_raster_vertex *const v[3],
                          const struct edge e[3], float per_area)
{
    float shade = 1;

    for (int i = 0; i < 3; i++) {
        if (e[i].at + e[i].bias < 0)
            return;
        if ((float)e[i].at * e[i].per_px < 0.5f * r->edge_px)
            shade = 0.55f;
    }
    /* The edge opposite a vertex gives its weight. */
    put_pixel(
        r, k, v,
        (float[3]){(float)e[1].at * per_area, (float)e[2].at * per_area, (float)e[0].at * per_area},
        shade);
}

static void fill(struct dx_raster *r, const struct dx_raster_vertex *const v[3],
                 const struct fixed p[3], float per_area)
{
    struct box box = box_of(r, p);
    struct edge e[3];

    for (int k = 0; k < 3; k++)
        e[k] = edge_between(p[k], p[(k + 1) % 3], &box);
    for (int64_t y = box.y0; y < box.y1; y++) {
        for (int k = 0; k < 3; k++)
            e[k].at = e[k].row;
        for (int64_t x = box.x0; x < box.x1; x++) {
            put_if_inside(r, (size_t)(y * r->width + x), v, e, per_area);
            for (int k = 0; k < 3; k++)
                e[k].at += e[k].step_x;
        }
        for (int k = 0; k < 3; k++)
            e[k].row += e[k].step_y;
    }
}

void dx_raster_triangle(struct dx_raster *r, const struct dx_raster_vertex v[3])
{
    const struct dx_raster_vertex *order[3] = {&v[0], &v[1], &v[2]};
    struct fixed p[3];
    int64_t area;

    for (int k = 0; k < 3; k++) {
        if (!(fabsf(v[k].x) < FAR_PX && fabsf(v[k].y) < FAR_PX && isfinite(v[k].depth)))
            return;
        p[k] = (struct fixed){llrintf(v[k].x * SUBPIXELS), llrintf(v[k].y * SUBPIXELS)};
    }
    area = (p[1].x - p[0].x) * (p[2].y - p[0].y) - (p[1].y - p[0].y) * (p[2].x - p[0].x);
    if (area == 0)
        return;
    if (area < 0) {
        struct fixed swap = p[1];

        p[1] = p[2];
        p[2] = swap;
        order[1] = &v[2];
        order[2] = &v[1];
        area = -area;
    }
    fill(r, order, p, 1.0f / (float)area);
}

void dx_raster_halve(uint8_t *rgb, const struct dx_raster *r)
{
    uint32_t width = r->width / 2, height = r->height / 2;
    size_t stride = 3 * (size_t)r->width;

    for (size_t y = 0; y < height; y++)
        for (size_t x = 0; x < width; x++)
            for (size_t c = 0; c < 3; c++) {
                const uint8_t *p = r->rgb + 2 * y * stride + 6 * x + c;

                rgb[3 * (y * width + x) + c] =
                    (uint8_t)((p[0] + p[3] + p[stride] + p[stride + 3] + 2) / 4);
            }
}
