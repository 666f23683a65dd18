/* Normals, light, colour maps. */
#include "tools/shade.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

const uint8_t dx_shade_background[3] = {236, 238, 240};

#define SMOOTHING                                                                                  \
    3 /* passes; range noise at the spacing of dexels would be all one saw otherwise */

/* ---- normals
 * -------------------------------------------------------------------------------------- */

static float dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(float out[3], const float a[3], const float b[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static void normalize(float v[3])
{
    float len = sqrtf(dot(v, v));

    for (int k = 0; k < 3; k++)
        v[k] = len > 0 ? v[k] / len : 0;
}

static void normalize_all(float *normal, size_t n)
{
    for (size_t v = 0; v < n; v++)
        normalize(normal + 3 * v);
}

/* Sum of the triangles' normals by area. */
static void face_normals(float *normal, const struct dx_mesh *mesh)
{
    memset(normal, 0, mesh->n_vertices * 3 * sizeof(*normal));
    for (size_t t = 0; t < mesh->n_triangles; t++) {
        const uint32_t *i = mesh->index + 3 * t;
        const float *a = mesh->xyz + 3 * (size_t)i[0], *b = mesh->xyz + 3 * (size_t)i[1],
                    *c = mesh->xyz + 3 * (size_t)i[2];
        float u[3], w[3], n[3];

        for (int k = 0; k < 3; k++) {
            u[k] = b[k] - a[k];
            w[k] = c[k] - a[k];
        }
        cross(n, u, w);
        for (size_t k = 0; k < 9; k++)
            normal[3 * (size_t)i[k / 3] + k % 3] += n[k % 3];
    }
    normalize_all(normal, mesh->n_vertices);
}

/* Each normal plus those of its neighbours that look the same way: creases stay. */
static void smooth(float *out, const float *normal, const struct dx_mesh *mesh)
{
    memcpy(out, normal, mesh->n_vertices * 3 * sizeof(*out));
    for (size_t k = 0; k < 3 * (size_t)mesh->n_triangles; k++) {
        size_t a = mesh->index[k], b = mesh->index[k % 3 == 2 ? k - 2 : k + 1];
        float like = dot(normal + 3 * a, normal + 3 * b), weight = like > 0 ? like * like : 0;

        for (size_t c = 0; c < 3; c++) {
            out[3 * a + c] += weight * normal[3 * b + c];
            out[3 * b + c] += weight * normal[3 * a + c];
        }
    }
    normalize_all(out, mesh->n_vertices);
}

static int vertex_normals(float **out, const struct dx_mesh *mesh)
{
    size_t len = mesh->n_vertices * 3 * sizeof(float) + 1;
    float *now = malloc(len), *next = malloc(len);

    if (!now || !next) {
        free(now);
        free(next);
        return -ENOMEM;
    }
    face_normals(now, mesh);
    for (int k = 0; k < SMOOTHING; k++) {
        float *swap = now;

        smooth(next, now, mesh);
        now = next;
        next = swap;
    }
    free(next);
    *out = now;
    return 0;
}

/* ---- colour
 * --------------------------------------------------------------------------------------- */

static float clamp01(float x)
{
    return x < 0 ? 0 : x > 1 ? 1 : x;
}

/* Even steps of lightness from dark blue to yellow, after viridis (van der Walt and Smith, CC0). */
static void range_colour(float rgb[3], float x)
{
    static const uint8_t map[9][3] = {{68, 1, 84},    {71, 44, 122},  {59, 81, 139},
                                      {44, 113, 142}, {33, 144, 141}, {39, 173, 129},
                                      {92, 200, 99},  {170, 220, 50}, {253, 231, 37}};
    float at = 0.6f + clamp01(x) * 7.4f; /* from where shading still shows */
    int k = at < 7 ? (int)at : 7;

    for (int c = 0; c < 3; c++)
        rgb[c] = (float)map[k][c] + (at - (float)k) * (float)(map[k + 1][c] - map[k][c]);
}

/* Values at two and ninety-eight percent of a sample, so that strays do not flatten the picture. */
struct span {
    float low, high;
};

static int compare_floats(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;

    return (x > y) - (x < y);
}

static int span_of(struct span *s, const float *values, size_t n_values)
{
    size_t step = n_values / 50000 + 1, n = 0;
    float *sample = malloc((n_values / step + 1) * sizeof(*sample));

    *s = (struct span){0, 1};
    if (!sample)
        return -ENOMEM;
    for (size_t k = 0; k < n_values; k += step)
        sample[n++] = values[k];
    if (n) {
        qsort(sample, n, sizeof(*sample), compare_floats);
        s->low = sample[n / 50];
        s->high = sample[n - 1 - n / 50];
    }
    if (!(s->high > s->low))
        s->high = s->low + 1;
    free(sample);
    return 0;
}

static float in_span(const struct span *s, float v)
{
    return clamp01((v - s->low) / (s->high - s->low));
}

static float lamp(const float n[3], const float direction[3])
{
    float x = dot(n, direction);

    return x > 0 ? x : 0;
}

/* The sky more than the ground, a lamp at the eye, and a stronger one above it to the left; 0..1.
 */
static float light(const float n[3], const float to_eye[3], const float up[3])
{
    float key[3], left[3];

    cross(left, to_eye, up);
    for (int k = 0; k < 3; k++)
        key[k] = to_eye[k] + 0.4f * up[k] + 0.55f * left[k];
    normalize(key);
    return 0.22f + 0.16f * (0.5f + 0.5f * dot(n, up)) + 0.26f * lamp(n, to_eye) +
           0.42f * lamp(n, key);
}

struct painter {
    enum dx_shade shade;
    const struct dx_mesh *mesh;
    const float *normal, *value, *distance;
    struct span values, distances;
    float eye[3], up[3];
};

static void paint(float rgb[3], const struct painter *p, size_t v)
{
    static const float clay[3] = {238, 229, 214};
    float to_eye[3], lit, fade;

    for (int k = 0; k < 3; k++)
        to_eye[k] = p->eye[k] - p->mesh->xyz[3 * v + (size_t)k];
    normalize(to_eye);
    lit = light(p->normal + 3 * v, to_eye, p->up);
    memcpy(rgb, clay, sizeof(clay));
    if (p->shade == DX_SHADE_ATTR) {
        rgb[0] = rgb[1] = rgb[2] = 24 + 222 * in_span(&p->values, p->value[v]);
        lit = 0.55f + 0.5f * lit;
    } else if (p->shade == DX_SHADE_RANGE) {
        range_colour(rgb, in_span(&p->values, p->value[v]));
        lit = 0.4f + 0.7f * lit;
    }
    fade = 0.25f * in_span(&p->distances, p->distance[v]);
    for (int k = 0; k < 3; k++) {
        rgb[k] = 255 * clamp01(rgb[k] * lit / 255);
        rgb[k] += fade * ((float)dx_shade_background[k] - rgb[k]);
    }
}

static float length_from(const float p[3], const float from[3])
{
    float d[3] = {p[0] - from[0], p[1] - from[1], p[2] - from[2]};

    return sqrtf(dot(d, d));
}

int dx_shade_vertices(float *rgb, const struct dx_mesh *mesh, enum dx_shade shade,
                      const struct dx_camera *camera, const double up[3])
{
    static const float scanner[3] = {0, 0, 0};
    size_t n = mesh->n_vertices;
    float *value = malloc(n * sizeof(*value) + 1), *distance = malloc(n * sizeof(*distance) + 1);
    float *normal = NULL;
    struct painter p = {.shade = shade, .mesh = mesh, .value = value, .distance = distance};
    int rc = value && distance ? vertex_normals(&normal, mesh) : -ENOMEM;

    p.normal = normal;
    for (int k = 0; k < 3; k++) {
        p.eye[k] = (float)camera->eye[k];
        p.up[k] = (float)up[k];
    }
    for (size_t v = 0; rc == 0 && v < n; v++) {
        value[v] = shade == DX_SHADE_ATTR && mesh->attr ? (float)mesh->attr[v]
                                                        : length_from(mesh->xyz + 3 * v, scanner);
        distance[v] = length_from(mesh->xyz + 3 * v, p.eye);
    }
    if (rc == 0)
        rc = span_of(&p.values, value, n);
    if (rc == 0)
        rc = span_of(&p.distances, distance, n);
    for (size_t v = 0; rc == 0 && v < n; v++)
        paint(rgb + 3 * v, &p, v);
    free(normal);
    free(distance);
    free(value);
    return rc;
}
