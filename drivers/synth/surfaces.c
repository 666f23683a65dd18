/* Surfaces given by their parameters: where a sample is, and its normal. */
#include "drivers/synth/surfaces.h"

#include "core/base/rng.h"
#include "core/base/trig.h"
#include "drivers/synth/surfaces_implicit.h"

#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define GOLDEN_ANGLE 2.39996322972865332
#define MINOR        0.4 /* of a torus, whose major radius is 1 */
#define BUMP         0.12

static const struct {
    const char *name;
    int euler;
    uint32_t n_rims;
} table[DX_N_SURFACES] = {
    [DX_SURFACE_SPHERE] = {"sphere", 2, 0},
    [DX_SURFACE_CUBED_SPHERE] = {"cubed-sphere", 2, 0},
    [DX_SURFACE_BUMPY] = {"bumpy", 2, 0},
    [DX_SURFACE_TORUS] = {"torus", 0, 0},
    [DX_SURFACE_NESTED] = {"nested", 4, 0},
    [DX_SURFACE_RANDOM_SPHERE] = {"random-sphere", 2, 0},
    [DX_SURFACE_RANDOM_BUMPY] = {"random-bumpy", 2, 0},
    [DX_SURFACE_RANDOM_TORUS] = {"random-torus", 0, 0},
    [DX_SURFACE_DOUBLE_TORUS] = {"double-torus", -2, 0},
    [DX_SURFACE_PLATE] = {"plate", -8, 0},
    [DX_SURFACE_PARABOLOID] = {"paraboloid", 1, 1},
    [DX_SURFACE_CYLINDER] = {"cylinder", 0, 2},
};

const char *dx_surface_name(unsigned surface)
{
    return surface < DX_N_SURFACES ? table[surface].name : NULL;
}

int dx_surface_from_name(const char *name)
{
    for (int k = 0; k < DX_N_SURFACES; k++)
        if (!strcmp(name, table[k].name))
            return k;
    return -1;
}

int dx_surface_euler(enum dx_surface surface)
{
    return table[surface].euler;
}

uint32_t dx_surface_n_rims(enum dx_surface surface)
{
    return table[surface].n_rims;
}

/* What draws the points: in the order of their numbers. */
struct sampler {
    const struct dx_surface_config *config;
    struct dx_rng rng;
    double spacing;
    uint32_t n, cap;
    double *xyz;
};

static double swing(struct sampler *s)
{
    return s->config->jitter > 0 ? s->config->jitter * (2 * dx_rng_unit(&s->rng) - 1) : 0;
}

/* Point p with its unit normal; noise is along that. */
static void put(struct sampler *s, const double p[3], const double normal[3])
{
    double noise = 0;

    if (s->n == s->cap)
        return;
    if (s->config->noise > 0)
        noise = s->config->noise * s->spacing * dx_rng_normal(&s->rng);
    for (int k = 0; k < 3; k++)
        s->xyz[3 * (size_t)s->n + (size_t)k] = p[k] + noise * normal[k];
    s->n++;
}

static double bumpy_radius(double z, double azimuth)
{
    const double polar = dx_acos(z), flat = 1 - z * z;

    return 1 + BUMP * dx_sin(6 * azimuth) * flat * dx_cos(5 * polar);
}

/* In direction d, jittered; `radius` or, where that is 0, bumpy. */
static void put_direction(struct sampler *s, const double d[3], double radius)
{
    double p[3], n[3], len = 0;

    for (int k = 0; k < 3; k++)
        n[k] = d[k] + swing(s) * s->spacing;
    len = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int k = 0; k < 3; k++)
        n[k] /= len;
    if (radius == 0)
        radius = bumpy_radius(n[2] > 1 ? 1 : n[2] < -1 ? -1 : n[2], dx_atan2(n[1], n[0]));
    for (int k = 0; k < 3; k++)
        p[k] = radius * n[k];
    put(s, p, n);
}

static void spiral(struct sampler *s, uint32_t n, double radius)
{
    for (uint32_t k = 0; k < n; k++) {
        const double z = 1 - (2 * k + 1.0) / n, r = sqrt(1 - z * z);
        double sn, cs;

        dx_sincos(k * GOLDEN_ANGLE, &sn, &cs);
        put_direction(s, (double[3]){r * cs, r * sn, z}, radius);
    }
}

/* Of equal areas; those of the bumpy one, but for its slopes. */
static void random_directions(struct sampler *s, bool bumpy)
{
    while (s->n < s->cap) {
        const double z = 2 * dx_rng_unit(&s->rng) - 1, a = 2 * DX_PI * dx_rng_unit(&s->rng);
        const double r = sqrt(1 - z * z), radius = bumpy ? bumpy_radius(z, a) : 1;
        double sn, cs;

        if (bumpy && dx_rng_unit(&s->rng) > radius * radius / 1.3)
            continue;
        dx_sincos(a, &sn, &cs);
        put_direction(s, (double[3]){r * cs, r * sn, z}, radius);
    }
}

/* Faces of a cube, edges and corners once. */
static void cubed_sphere(struct sampler *s)
{
    const int m = (int)sqrt((s->cap - 2) / 6.0);

    for (int i = 0; i <= m; i++)
        for (int j = 0; j <= m; j++)
            for (int k = 0; k <= m; k++) {
                const double d[3] = {2.0 * i / m - 1, 2.0 * j / m - 1, 2.0 * k / m - 1};

                if (i == 0 || j == 0 || k == 0 || i == m || j == m || k == m)
                    put_direction(s, d, 1);
                else
                    k = m - 1; /* the inside of the cube */
            }
}

static void put_torus(struct sampler *s, double a, double b)
{
    double sa, ca, sb, cb;

    dx_sincos(a, &sa, &ca);
    dx_sincos(b, &sb, &cb);
    put(s, (double[3]){(1 + MINOR * cb) * ca, (1 + MINOR * cb) * sa, MINOR * sb},
        (double[3]){ca * cb, sa * cb, sb});
}

static void torus(struct sampler *s)
{
    const uint32_t n_minor = (uint32_t)sqrt(s->cap * MINOR), n_major = s->cap / n_minor;

    for (uint32_t i = 0; i < n_major; i++)
        for (uint32_t j = 0; j < n_minor; j++) {
            const double a = i + swing(s), b = j + swing(s);

            put_torus(s, 2 * DX_PI * (a + 1) / n_major, 2 * DX_PI * (b + 1) / n_minor);
        }
}

static void random_torus(struct sampler *s)
{
    while (s->n < s->cap) {
        const double a = 2 * DX_PI * dx_rng_unit(&s->rng), b = 2 * DX_PI * dx_rng_unit(&s->rng);

        if (dx_rng_unit(&s->rng) <= (1 + MINOR * dx_cos(b)) / (1 + MINOR))
            put_torus(s, a, b);
    }
}

/* z = (x^2 + y^2) / 2 over the unit disc. */
static void paraboloid(struct sampler *s)
{
    const double step = sqrt(DX_PI / s->cap);
    const int m = (int)(1 / step);

    for (int i = -m; i <= m; i++)
        for (int j = -m; j <= m; j++) {
            const double x = step * (i + swing(s)), y = step * (j + swing(s));
            const double slope = sqrt(1 + x * x + y * y);

            if (x * x + y * y <= 1)
                put(s, (double[3]){x, y, (x * x + y * y) / 2},
                    (double[3]){-x / slope, -y / slope, 1 / slope});
        }
}

/* Radius 1/2, height 2. */
static void cylinder(struct sampler *s)
{
    const uint32_t n_around = (uint32_t)sqrt(s->cap * DX_PI / 2), n_up = s->cap / n_around;

    for (uint32_t i = 0; i < n_up; i++)
        for (uint32_t j = 0; j < n_around; j++) {
            const double a = 2 * DX_PI * (j + 1 + swing(s)) / n_around,
                         z = 2 * (i + swing(s)) / n_up;
            double sn, cs;

            dx_sincos(a, &sn, &cs);
            put(s, (double[3]){cs / 2, sn / 2, z}, (double[3]){cs, sn, 0});
        }
}

static double area_of(const struct dx_surface_config *c)
{
    switch (c->surface) {
    case DX_SURFACE_TORUS:
    case DX_SURFACE_RANDOM_TORUS:
        return 4 * DX_PI * DX_PI * MINOR;
    case DX_SURFACE_NESTED:
        return 8 * DX_PI;
    case DX_SURFACE_PARABOLOID:
        return DX_PI;
    case DX_SURFACE_CYLINDER:
        return 2 * DX_PI;
    default:
        return 4 * DX_PI;
    }
}

static int draw(struct sampler *s)
{
    const struct dx_surface_config *c = s->config;

    switch (c->surface) {
    case DX_SURFACE_CUBED_SPHERE:
        cubed_sphere(s);
        return 0;
    case DX_SURFACE_TORUS:
        torus(s);
        return 0;
    case DX_SURFACE_NESTED:
        spiral(s, s->cap / 2, 1);
        spiral(s, s->cap - s->n, 1 - c->gap * s->spacing);
        return 0;
    case DX_SURFACE_RANDOM_TORUS:
        random_torus(s);
        return 0;
    case DX_SURFACE_PARABOLOID:
        paraboloid(s);
        return 0;
    case DX_SURFACE_CYLINDER:
        cylinder(s);
        return 0;
    case DX_SURFACE_RANDOM_SPHERE:
    case DX_SURFACE_RANDOM_BUMPY:
        random_directions(s, c->surface == DX_SURFACE_RANDOM_BUMPY);
        return 0;
    case DX_SURFACE_DOUBLE_TORUS:
    case DX_SURFACE_PLATE:
        return dx_implicit_sample(s->xyz, &s->n, &s->spacing, s->cap, c->surface, &s->rng);
    default:
        spiral(s, s->cap, c->surface == DX_SURFACE_BUMPY ? 0 : 1);
        return 0;
    }
}

int dx_surface_sample(struct dx_surface_points *out, const struct dx_surface_config *c)
{
    struct sampler s = {
        .config = c, .cap = c->n, .rng = dx_rng_init(c->seed, (uint64_t)c->surface)};
    int rc;

    *out = (struct dx_surface_points){0};
    if ((unsigned)c->surface >= DX_N_SURFACES || c->n < 64 || c->n > 1u << 27)
        return -EINVAL;
    s.xyz = malloc(3 * (size_t)c->n * sizeof(*s.xyz));
    if (!s.xyz)
        return -ENOMEM;
    s.spacing = sqrt(area_of(c) / c->n);
    rc = draw(&s);
    if (rc < 0) {
        free(s.xyz);
        return rc;
    }
    *out = (struct dx_surface_points){s.n, s.xyz, s.spacing};
    return 0;
}
