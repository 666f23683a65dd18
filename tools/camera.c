/* Cameras from the extent of a mesh. */
#include "tools/camera.h"

#include "core/base/trig.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MARGIN 1.04 /* of the image around what is fitted into it */

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(double out[3], const double a[3], const double b[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static void normalize(double v[3])
{
    double len = sqrt(dot(v, v));

    for (int k = 0; k < 3 && len > 0; k++)
        v[k] /= len;
}

static void load(double out[3], const float *p)
{
    for (int k = 0; k < 3; k++)
        out[k] = (double)p[k];
}

/* ---- the frame of a view
 * --------------------------------------------------------------------------- */

/* All points within 60 degrees of +z: a camera looks along it. */
static bool is_camera_frame(const struct dx_mesh *mesh)
{
    double p[3];

    for (size_t v = 0; v < mesh->n_vertices; v++) {
        load(p, mesh->xyz + 3 * v);
        if (p[2] <= 0.5 * sqrt(dot(p, p)))
            return false;
    }
    return true;
}

#define BINS 720

/* The arc about `up` that holds all points: what is left of a turn when its largest gap is taken
 * out. */
static void find_ahead(struct dx_view_frame *f, const struct dx_mesh *mesh, const double x[3],
                       const double y[3])
{
    uint8_t seen[BINS] = {0};
    int gap = 0, gap_end = 0, run = 0;
    double p[3], middle;

    for (size_t v = 0; v < mesh->n_vertices; v++) {
        load(p, mesh->xyz + 3 * v);
        seen[(int)((dx_atan2(dot(p, y), dot(p, x)) + DX_PI) * (BINS / (2 * DX_PI))) % BINS] = 1;
    }
    for (int k = 0; k < 2 * BINS; k++) {
        run = seen[k % BINS] ? 0 : run + 1;
        if (run > gap && run <= BINS) {
            gap = run;
            gap_end = k;
        }
    }
    if (gap < BINS / 60) { /* a turn, but for six degrees */
        gap = 0;
        gap_end = -1;
    }
    f->azimuth_span = (BINS - gap) * (2 * DX_PI / BINS);
    middle = (gap_end + 1 + 0.5 * (BINS - gap)) * (2 * DX_PI / BINS) - DX_PI;
    for (int k = 0; k < 3; k++)
        f->ahead[k] = dx_cos(middle) * x[k] + dx_sin(middle) * y[k];
}

static void find_angles(struct dx_view_frame *f, const struct dx_mesh *mesh)
{
    double right[3], p[3];

    cross(right, f->ahead, f->up);
    f->azimuth[0] = f->elevation[0] = INFINITY;
    f->azimuth[1] = f->elevation[1] = -INFINITY;
    for (size_t v = 0; v < mesh->n_vertices; v++) {
        double x, y, a, e;

        load(p, mesh->xyz + 3 * v);
        x = dot(p, f->ahead);
        y = dot(p, right);
        a = dx_atan2(y, x);
        e = dx_atan2(dot(p, f->up), sqrt(x * x + y * y));
        f->azimuth[0] = fmin(f->azimuth[0], a);
        f->azimuth[1] = fmax(f->azimuth[1], a);
        f->elevation[0] = fmin(f->elevation[0], e);
        f->elevation[1] = fmax(f->elevation[1], e);
    }
}

static int compare_floats(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;

    return (x > y) - (x < y);
}

/* The middle of the coordinates between their first and last percent, and the distance from it that
 * holds 99 of 100 points; from a sample. */
static int find_centre(struct dx_view_frame *f, const struct dx_mesh *mesh)
{
    size_t step = mesh->n_vertices / 50000 + 1, n = 0;
    float *sample = malloc((mesh->n_vertices / step + 1) * sizeof(*sample));

    if (!sample)
        return -ENOMEM;
    for (size_t k = 0; k < 3; k++) {
        n = 0;
        for (size_t v = 0; v < mesh->n_vertices; v += step)
            sample[n++] = mesh->xyz[3 * v + k];
        qsort(sample, n, sizeof(*sample), compare_floats);
        f->centre[k] = 0.5 * ((double)sample[n / 100] + (double)sample[n - 1 - n / 100]);
    }
    n = 0;
    for (size_t v = 0; v < mesh->n_vertices; v += step) {
        double p[3];

        load(p, mesh->xyz + 3 * v);
        for (int k = 0; k < 3; k++)
            p[k] -= f->centre[k];
        sample[n++] = (float)sqrt(dot(p, p));
    }
    qsort(sample, n, sizeof(*sample), compare_floats);
    f->radius = fmax((double)sample[n - 1 - n / 100], 1e-6);
    free(sample);
    return 0;
}

int dx_view_frame_of(struct dx_view_frame *f, const struct dx_mesh *mesh)
{
    static const double axes[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

    if (!mesh->n_vertices)
        return -ENODATA;
    *f = (struct dx_view_frame){.up = {0, 0, 1}};
    if (is_camera_frame(mesh)) {
        memcpy(f->up, (double[]){0, -1, 0}, sizeof(f->up));
        find_ahead(f, mesh, axes[2], axes[0]);
    } else {
        find_ahead(f, mesh, axes[0], axes[1]);
    }
    find_angles(f, mesh);
    return find_centre(f, mesh);
}

/* ---- cameras
 * -------------------------------------------------------------------------------------- */

static void look(struct dx_camera *c, const double forward[3], const double up[3])
{
    memcpy(c->forward, forward, sizeof(c->forward));
    normalize(c->forward);
    cross(c->right, c->forward, up);
    normalize(c->right);
    cross(c->down, c->forward, c->right);
}

static uint32_t height_for(double aspect, uint32_t width)
{
    double height = width * aspect;

    height = height < 0.25 * width ? 0.25 * width : height > 1.25 * width ? 1.25 * width : height;
    return (uint32_t)height;
}

static void panorama(struct dx_camera *c, const struct dx_view_frame *f, uint32_t width,
                     uint32_t *height)
{
    double span = f->azimuth_span * MARGIN;
    double rise = (f->elevation[1] - f->elevation[0]) * MARGIN;
    double middle = 0.5 * (f->elevation[0] + f->elevation[1]);

    if (f->azimuth_span > 1.99 * DX_PI)
        span = 2 * DX_PI;
    if (!*height)
        *height = height_for(rise / span, width);
    look(c, f->ahead, f->up);
    c->panorama = true;
    c->scale = fmin(width / span, *height / fmax(rise, 1e-3));
    c->cx = 0.5 * width;
    c->cy = 0.5 * *height + c->scale * middle;
}

static bool is_stray(const struct dx_view_frame *f, const float *xyz)
{
    double p[3];

    load(p, xyz);
    for (int k = 0; k < 3; k++)
        p[k] -= f->centre[k];
    return dot(p, p) > 1.5 * f->radius * f->radius;
}

/* Scale and centre that show all points in front, or, with `f`, those that are no strays;
 * directions flatter than 80 degrees do not count. */
static void fit_perspective(struct dx_camera *c, const struct dx_view_frame *f,
                            const struct dx_mesh *mesh, uint32_t width, uint32_t *height)
{
    double min[2] = {INFINITY, INFINITY}, max[2] = {-INFINITY, -INFINITY}, size[2];

    for (size_t v = 0; v < mesh->n_vertices; v++) {
        double q[3];

        if (f && is_stray(f, mesh->xyz + 3 * v))
            continue;
        dx_camera_local(q, c, mesh->xyz + 3 * v);
        for (int k = 0; k < 2 && q[2] > 0.17 * sqrt(dot(q, q)); k++) {
            min[k] = fmin(min[k], q[k] / q[2]);
            max[k] = fmax(max[k], q[k] / q[2]);
        }
    }
    for (int k = 0; k < 2; k++)
        size[k] = fmax((max[k] - min[k]) * MARGIN, 1e-6);
    if (!*height)
        *height = height_for(size[1] / size[0], width);
    c->scale = fmin(width / size[0], *height / size[1]);
    c->cx = 0.5 * width - c->scale * 0.5 * (min[0] + max[0]);
    c->cy = 0.5 * *height - c->scale * 0.5 * (min[1] + max[1]);
}

void dx_camera_scanner(struct dx_camera *c, const struct dx_view_frame *f,
                       const struct dx_mesh *mesh, uint32_t width, uint32_t *height)
{
    double e = 0.5 * (f->elevation[0] + f->elevation[1]), forward[3];

    *c = (struct dx_camera){.near_m = 1e-3 * f->radius};
    if (f->azimuth_span > dx_rad(120) || f->elevation[1] - f->elevation[0] > dx_rad(120)) {
        panorama(c, f, width, height);
        return;
    }
    for (int k = 0; k < 3; k++)
        forward[k] = dx_cos(e) * f->ahead[k] + dx_sin(e) * f->up[k];
    look(c, forward, f->up);
    fit_perspective(c, NULL, mesh, width, height);
}

void dx_camera_orbit(struct dx_camera *c, const struct dx_view_frame *f, const struct dx_mesh *mesh,
                     uint32_t width, uint32_t *height, double yaw, double pitch, double dist_m)
{
    const double half_view = dx_rad(16); /* a long lens: parallels stay nearly so */
    const bool fit = dist_m <= 0;
    double right[3], forward[3], up[3];

    cross(right, f->ahead, f->up);
    for (int k = 0; k < 3; k++) {
        double level = dx_cos(yaw) * f->ahead[k] - dx_sin(yaw) * right[k];

        forward[k] = dx_cos(pitch) * level - dx_sin(pitch) * f->up[k];
        up[k] = dx_sin(pitch) * level + dx_cos(pitch) * f->up[k]; /* also straight from above */
    }
    *c = (struct dx_camera){.cull = true};
    if (fit)
        dist_m = f->radius / dx_sin(half_view);
    look(c, forward, up);
    for (int k = 0; k < 3; k++)
        c->eye[k] = f->centre[k] - dist_m * forward[k];
    c->near_m = 1e-3 * dist_m;
    if (fit) {
        fit_perspective(c, f, mesh, width, height);
        return;
    }
    if (!*height)
        *height = width * 3 / 4;
    c->scale = 0.5 * fmin(width, *height) / dx_tan(half_view);
    c->cx = 0.5 * width;
    c->cy = 0.5 * *height;
}

void dx_camera_local(double local[3], const struct dx_camera *c, const float p[3])
{
    double q[3];

    for (int k = 0; k < 3; k++)
        q[k] = (double)p[k] - c->eye[k];
    local[0] = dot(q, c->right);
    local[1] = dot(q, c->down);
    local[2] = dot(q, c->forward);
}
