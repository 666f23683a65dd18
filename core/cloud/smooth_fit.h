/*
 * The robust operator Q of Mederos, Velho and de Figueiredo ("Smooth Surface Reconstruction from
 * Noisy Clouds", 2004, section 2.1) at one place: the plane, and optionally the paraboloid, that
 * fits the points near it when those far from it count little. The cost of a plane n.x = t is
 *
 *     F(n, t) = sum of w_q rho(n.q - t),  rho(h) = 1 - exp(-h^2 / (2 sr^2))
 *
 * Each step minimises a bound of F that touches it at the plane before, so that F never grows.
 * Lengths are in one unit, the spacing of the points, from the place. Pure functions, any thread.
 */
#ifndef DX_SMOOTH_FIT_H
#define DX_SMOOTH_FIT_H

#include <stdbool.h>
#include <stdint.h>

#define DX_ROBUST_MAX_POINTS 512
#define DX_ROBUST_MAX_STEPS  50

/* Structure of arrays, for loops over lanes. */
struct dx_robust_points {
    uint32_t n;
    /* at an odd n, place n is used as well */
    double x[DX_ROBUST_MAX_POINTS], y[DX_ROBUST_MAX_POINTS], z[DX_ROBUST_MAX_POINTS];
    double w[DX_ROBUST_MAX_POINTS];      /* by distance alone */
    double weight[DX_ROBUST_MAX_POINTS]; /* of the last step: by distance and height */
};

struct dx_robust_plane {
    double normal[3]; /* unit length, either side */
    double t;
    double sum;   /* of the weights it was fitted with */
    double share; /* of them in those by distance alone: little where there is a crease */
};

/* Positive results. */
enum { DX_ROBUST_DONE = 0, DX_ROBUST_NONE = 1 };

/* Weights w = exp(-r^2 / (2 sw^2)) of points at distance r; needed before all that follows. */
void dx_robust_weigh(struct dx_robust_points *p, double sw);

/* One step from *plane; sr 0: without looking at it, the plane of the weights w. False: the points
 * make no plane. */
bool dx_robust_step(struct dx_robust_plane *plane, struct dx_robust_points *p, double sr);

#define DX_ROBUST_SETTLED 1e-4

/*
 * Steps until t changes by less than `settled` and the normal by less than its square (1 - cos), sr
 * falling to its value from where all points count: the result does not depend on a first normal.
 * *n_steps: how many it took. DX_ROBUST_NONE: fewer than three points have weight, or they are on a
 * line.
 */
int dx_robust_plane(struct dx_robust_plane *plane, uint32_t *n_steps, struct dx_robust_points *p,
                    double sw, double sr, double settled);

/* A paraboloid over a converged plane, z = a + b x + c y + d x^2 + e x y + f y^2, x and y from the
 * place in `u` and `v`. */
struct dx_robust_quadric {
    double u[3], v[3];
    double term[6];
};

/* By the weights of the last step, then robustly by the heights over the paraboloid itself. False:
 * the points do not determine it. */
bool dx_robust_quadric(struct dx_robust_quadric *q, struct dx_robust_points *p,
                       const struct dx_robust_plane *plane, double sr);

#endif
