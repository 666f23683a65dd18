/* Vertices to the screen once each, then triangles: clipped at the near plane, or unrolled at the
 * seam. */
#include "tools/render.h"

#include "core/base/trig.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

struct scene {
    struct dx_raster *raster;
    const struct dx_mesh *mesh;
    const struct dx_camera *camera;
    const float *rgb;
    double *local; /* [n_vertices][3] in the camera's axes */
};

/* ---- perspective
 * ---------------------------------------------------------------------------------- */

struct corner {
    double p[3]; /* right, down, forward */
    float rgb[3];
};

static struct dx_raster_vertex project(const struct dx_camera *c, const struct corner *k)
{
    /* -1/z is linear on the screen, and smaller when nearer. */
    return (struct dx_raster_vertex){(float)(c->cx + c->scale * k->p[0] / k->p[2]),
                                     (float)(c->cy + c->scale * k->p[1] / k->p[2]),
                                     (float)(-1 / k->p[2]),
                                     {k->rgb[0], k->rgb[1], k->rgb[2]}};
}

static struct corner between(const struct corner *a, const struct corner *b, double near_m)
{
    double t = (near_m - a->p[2]) / (b->p[2] - a->p[2]);
    struct corner out;

    for (int k = 0; k < 3; k++) {
        out.p[k] = a->p[k] + t * (b->p[k] - a->p[k]);
        out.rgb[k] = a->rgb[k] + (float)t * (b->rgb[k] - a->rgb[k]);
    }
    out.p[2] = near_m;
    return out;
}

/* The part of a triangle before the near plane: 0, 3 or 4 corners. */
static int clip(struct corner out[4], const struct corner in[3], double near_m)
{
    int n = 0;

    for (int k = 0; k < 3; k++) {
        const struct corner *a = &in[k], *b = &in[(k + 1) % 3];

        if (a->p[2] >= near_m)
            out[n++] = *a;
        if ((a->p[2] >= near_m) != (b->p[2] >= near_m))
            out[n++] = between(a, b, near_m);
    }
    return n;
}

/* Counter-clockwise triangles show their face; on a screen with y down these have a negative area.
 */
static bool seen_from_behind(const struct dx_raster_vertex v[3])
{
    return (v[1].x - v[0].x) * (v[2].y - v[0].y) >= (v[1].y - v[0].y) * (v[2].x - v[0].x);
}

static void draw_perspective(const struct scene *s, const uint32_t index[3])
{
    struct corner in[3], out[4];
    int n;

    for (int k = 0; k < 3; k++) {
        memcpy(in[k].p, s->local + 3 * (size_t)index[k], sizeof(in[k].p));
        memcpy(in[k].rgb, s->rgb + 3 * (size_t)index[k], sizeof(in[k].rgb));
    }
    n = clip(out, in, s->camera->near_m);
    for (int k = 2; k < n; k++) {
        struct dx_raster_vertex v[3] = {project(s->camera, &out[0]),
                                        project(s->camera, &out[k - 1]),
                                        project(s->camera, &out[k])};

        if (!s->camera->cull || !seen_from_behind(v))
            dx_raster_triangle(s->raster, v);
    }
}

/* ---- panorama
 * ------------------------------------------------------------------------------------- */

static struct dx_raster_vertex unroll(const struct scene *s, uint32_t i)
{
    const double *p = s->local + 3 * (size_t)i;
    const struct dx_camera *c = s->camera;
    double level = sqrt(p[0] * p[0] + p[2] * p[2]);
    const float *rgb = s->rgb + 3 * (size_t)i;

    return (struct dx_raster_vertex){(float)(c->cx + c->scale * dx_atan2(p[0], p[2])),
                                     (float)(c->cy + c->scale * dx_atan2(p[1], level)),
                                     (float)sqrt(level * level + p[1] * p[1]),
                                     {rgb[0], rgb[1], rgb[2]}};
}

/* A triangle across the back is drawn at both ends of the image; one that holds a pole has no place
 * in it. */
static void draw_panorama(const struct scene *s, const uint32_t index[3])
{
    float turn = (float)(2 * DX_PI * s->camera->scale);
    struct dx_raster_vertex v[3];

    for (int k = 0; k < 3; k++) {
        v[k] = unroll(s, index[k]);
        while (k && v[k].x - v[0].x > 0.5f * turn)
            v[k].x -= turn;
        while (k && v[k].x - v[0].x < -0.5f * turn)
            v[k].x += turn;
    }
    if (fabsf(v[1].x - v[2].x) > 0.5f * turn)
        return;
    for (int copy = -1; copy <= 1; copy++) {
        struct dx_raster_vertex w[3] = {v[0], v[1], v[2]};

        for (int k = 0; k < 3; k++)
            w[k].x += (float)copy * turn;
        dx_raster_triangle(s->raster, w);
    }
}

int dx_render_mesh(struct dx_raster *r, const struct dx_mesh *mesh, const float *rgb,
                   const struct dx_camera *camera)
{
    struct scene s = {.raster = r, .mesh = mesh, .camera = camera, .rgb = rgb};

    s.local = malloc((size_t)mesh->n_vertices * 3 * sizeof(*s.local) + 1);
    if (!s.local)
        return -ENOMEM;
    for (size_t v = 0; v < mesh->n_vertices; v++)
        dx_camera_local(s.local + 3 * v, camera, mesh->xyz + 3 * v);
    for (size_t t = 0; t < mesh->n_triangles; t++) {
        if (camera->panorama)
            draw_panorama(&s, mesh->index + 3 * t);
        else
            draw_perspective(&s, mesh->index + 3 * t);
    }
    free(s.local);
    return 0;
}
