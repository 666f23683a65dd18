/*
 * Analytic surfaces sampled as unorganized points: stand-ins for the models of the papers, with
 * known topology. The same points on every machine. Pure functions, any thread.
 */
#ifndef DX_SURFACES_H
#define DX_SURFACES_H

#include <stdint.h>

enum dx_surface {
    DX_SURFACE_SPHERE,       /* spiral of equal areas */
    DX_SURFACE_CUBED_SPHERE, /* grids of a cube's faces: symmetric, many points on common circles */
    DX_SURFACE_BUMPY,        /* spiral on a sphere with bumps */
    DX_SURFACE_TORUS,        /* regular grid */
    DX_SURFACE_NESTED,       /* two spheres, the second at `gap` spacings inside the first */
    DX_SURFACE_RANDOM_SPHERE, /* independent, of equal areas: gaps and pairs that nearly meet */
    DX_SURFACE_RANDOM_BUMPY,
    DX_SURFACE_RANDOM_TORUS,
    DX_SURFACE_DOUBLE_TORUS, /* genus 2, points that keep a distance */
    DX_SURFACE_PLATE,        /* genus 5, the same */
    DX_SURFACE_PARABOLOID,   /* open: one rim, regular grid over a disc */
    DX_SURFACE_CYLINDER,     /* open: two rims, regular grid */
    DX_N_SURFACES,
};

struct dx_surface_config {
    enum dx_surface surface;
    uint32_t n; /* about so many points */
    double
        jitter;   /* points are moved on the surface, by so many spacings at most along each axis */
    double noise; /* standard deviation along the normal, spacings */
    double gap;   /* DX_SURFACE_NESTED */
    uint64_t seed;
};

struct dx_surface_points {
    uint32_t n;
    double *xyz;    /* [n][3]; to be freed */
    double spacing; /* square root of the area of a point */
};

const char *dx_surface_name(unsigned surface);       /* NULL past the last */
int dx_surface_from_name(const char *name);          /* or -1 */
int dx_surface_euler(enum dx_surface surface);       /* characteristic of the surface */
uint32_t dx_surface_n_rims(enum dx_surface surface); /* 0: closed */

/* Errors: -EINVAL (surface or n: 64 to 2^27), -ENOMEM. */
int dx_surface_sample(struct dx_surface_points *out, const struct dx_surface_config *config);

#endif
