/* Ray intersections in closed form, and the paint of surfaces. */
#include "drivers/synth/shapes.h"

#include "core/base/trig.h"

#include <math.h>

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

struct dx_ray dx_ray_make(double x, double y, double z)
{
    return (struct dx_ray){{x, y, z}, {1 / x, 1 / y, 1 / z}, x * x + y * y + z * z};
}

void dx_shape_bound(struct dx_shape *s)
{
    double r2 = 0;

    s->power = 0;
    if (s->kind == DX_SHAPE_BOX) {
        for (int k = 0; k < 3; k++) {
            double half = (s->b[k] - s->a[k]) / 2;

            s->centre[k] = (s->a[k] + s->b[k]) / 2;
            r2 += half * half;
        }
    } else if (s->kind == DX_SHAPE_SPHERE || s->kind == DX_SHAPE_BUBBLE) {
        for (int k = 0; k < 3; k++)
            s->centre[k] = s->a[k];
        r2 = s->b[0] * s->b[0];
    } else if (s->kind == DX_SHAPE_POLE) {
        double half = (s->b[2] - s->a[2]) / 2;

        s->centre[0] = s->a[0];
        s->centre[1] = s->a[1];
        s->centre[2] = (s->a[2] + s->b[2]) / 2;
        r2 = s->b[0] * s->b[0] + half * half;
    } else {
        return;
    }
    s->power = dot(s->centre, s->centre) - r2;
}

static double hit_room(const struct dx_shape *s, const struct dx_ray *ray, int *face)
{
    double best = INFINITY;

    for (int k = 0; k < 3; k++) {
        int upper = ray->d[k] > 0;
        double t = (upper ? s->b[k] : s->a[k]) * ray->inv[k];

        if (ray->d[k] != 0 && t < best) {
            best = t;
            *face = 2 * k + upper;
        }
    }
    return best;
}

static double hit_box(const struct dx_shape *s, const struct dx_ray *ray, int *face)
{
    double enter = 0, leave = INFINITY;
    int side = -1;

    for (int k = 0; k < 3; k++) {
        int down = ray->d[k] < 0;
        double near, far;

        if (ray->d[k] == 0) {
            if (s->a[k] > 0 || s->b[k] < 0)
                return INFINITY;
            continue;
        }
        near = (down ? s->b[k] : s->a[k]) * ray->inv[k];
        far = (down ? s->a[k] : s->b[k]) * ray->inv[k];
        if (near > enter) {
            enter = near;
            side = 2 * k + down;
        }
        if (far < leave)
            leave = far;
    }
    if (side < 0 || enter > leave)
        return INFINITY;
    *face = side;
    return enter;
}

/* The line's closest approach to the centre is (c.d)/d.d; the roots lie around it. */
static double hit_sphere(const struct dx_shape *s, const struct dx_ray *ray, int far)
{
    double along = dot(s->centre, ray->d);
    double disc = along * along - ray->dd * s->power;

    if (disc < 0 || (!far && along < 0))
        return INFINITY;
    return (along + (far ? sqrt(disc) : -sqrt(disc))) / ray->dd;
}

static double hit_pole(const struct dx_shape *s, const struct dx_ray *ray)
{
    double flat = ray->d[0] * ray->d[0] + ray->d[1] * ray->d[1];
    double along = s->a[0] * ray->d[0] + s->a[1] * ray->d[1];
    double power = s->a[0] * s->a[0] + s->a[1] * s->a[1] - s->b[0] * s->b[0];
    double disc = along * along - flat * power, t;

    if (disc < 0 || along <= 0)
        return INFINITY;
    t = (along - sqrt(disc)) / flat;
    return t * ray->d[2] >= s->a[2] && t * ray->d[2] <= s->b[2] ? t : INFINITY;
}

static double hit_fence(const struct dx_shape *s, const struct dx_ray *ray)
{
    double flat = sqrt(ray->d[0] * ray->d[0] + ray->d[1] * ray->d[1]);
    double t = s->b[0] / flat, sector;

    if (flat == 0 || t * ray->d[2] < s->a[2] || t * ray->d[2] > s->b[2])
        return INFINITY;
    sector = floor((dx_atan2(ray->d[1], ray->d[0]) - s->a[0]) / s->a[1]);
    return sector - 2 * floor(sector / 2) == 0 ? t : INFINITY;
}

double dx_shape_hit(const struct dx_shape *s, const struct dx_ray *ray, int *face)
{
    *face = 0;
    if (s->power > 0) {
        double along = dot(s->centre, ray->d);

        if (along < 0 || s->power * ray->dd > along * along)
            return INFINITY;
    }
    switch (s->kind) {
    case DX_SHAPE_ROOM:
        return hit_room(s, ray, face);
    case DX_SHAPE_BOX:
        return hit_box(s, ray, face);
    case DX_SHAPE_SPHERE:
        return hit_sphere(s, ray, 0);
    case DX_SHAPE_BUBBLE:
        return hit_sphere(s, ray, 1);
    case DX_SHAPE_POLE:
        return hit_pole(s, ray);
    case DX_SHAPE_FENCE:
        return hit_fence(s, ray);
    case DX_SHAPE_PLANE:
        break;
    }

    double t = s->b[0] / dot(s->a, ray->d);
    return t > 0 ? t : INFINITY;
}

/* Cosine between the ray and the surface's normal at the hit p. */
static double incidence(const struct dx_shape *s, const struct dx_ray *ray, const double p[3],
                        int face)
{
    double n[3] = {0, 0, 0};

    switch (s->kind) {
    case DX_SHAPE_ROOM:
    case DX_SHAPE_BOX:
        n[face / 2] = 1;
        break;
    case DX_SHAPE_PLANE:
        n[0] = s->a[0], n[1] = s->a[1], n[2] = s->a[2];
        break;
    case DX_SHAPE_FENCE:
        n[0] = p[0], n[1] = p[1];
        break;
    case DX_SHAPE_SPHERE:
    case DX_SHAPE_BUBBLE:
        n[0] = p[0] - s->a[0], n[1] = p[1] - s->a[1], n[2] = p[2] - s->a[2];
        break;
    case DX_SHAPE_POLE:
        n[0] = p[0] - s->a[0], n[1] = p[1] - s->a[1];
        break;
    }
    return fabs(dot(n, ray->d)) / sqrt(dot(n, n) * ray->dd);
}

/* A square wave along x: 0 and 1, `width` metres each. */
static int stripe(double x, double width)
{
    double k = floor(x / width);

    return k - 2 * floor(k / 2) != 0;
}

static double room_albedo(const double p[3], int face, int up, int up_sign)
{
    int u = (up + 1) % 3, v = (up + 2) % 3, axis = face / 2;

    if (axis != up)
        return stripe(p[u] + p[v], 1.0) ? 0.75 : 0.55;
    if ((face & 1) == (up_sign > 0))
        return 0.85;
    return stripe(p[u], 0.5) != stripe(p[v], 0.5) ? 0.65 : 0.25;
}

double dx_shape_shade(const struct dx_shape *s, const struct dx_ray *ray, double t, int face,
                      int up, int up_sign)
{
    double p[3] = {t * ray->d[0], t * ray->d[1], t * ray->d[2]};
    double albedo = s->paint == DX_PAINT_ROOM ? room_albedo(p, face, up, up_sign) : s->albedo;

    return albedo * incidence(s, ray, p, face);
}
