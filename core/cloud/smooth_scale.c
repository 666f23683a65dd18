/* What Q needs to know of a cloud: spacing, noise, and with them the widths. */
#include "core/cloud/smooth_cloud.h"

#include "core/base/trig.h"
#include "core/cloud/sample.h"
#include "core/cloud/smooth_fit.h"
#include "core/cloud/spacing.h"

#include <errno.h>
#include <math.h>

#define N_SIDE      16 /* neighbours of which the farthest tells the density */
#define WIDE        2.25 /* spacings: the width with which curvature is measured, and of paraboloids */
#define LEAST_SW    1.25 /* of planes */
#define MOST_SW     2.0
#define SR_OF_NOISE 1.8 /* what is farther out is no noise */
#define LEAST_SR    0.5
#define MIN_POINTS  24 /* below, a cloud tells no curvature */

/* The k-th of points of density d is at pi d r^2 = k - 1/3 in the median. */
double dx_cloud_side(const struct dx_cloud *c)
{
    struct dx_sample_median m = {.n = 0};

    for (uint32_t k = 0; k < dx_sample_n(c); k++) {
        struct dx_near near[N_SIDE];
        const uint32_t n = dx_cloud_nearest(c, dx_sample_rank(c, k), N_SIDE, near);

        if (n > 0)
            dx_sample_insert(&m, sqrt((double)near[n - 1].d2 * DX_PI / (n - 1.0 / 3)));
    }
    return m.n && m.value[m.n / 2] > 1 ? m.value[m.n / 2] : 1;
}

/* The median of |mean curvature| over a sample, in 1 / spacings. */
static double curvature(const struct dx_cloud *c, double spacing)
{
    const double radius = 3 * WIDE * spacing;
    struct dx_sample_median m = {.n = 0};

    for (uint32_t k = 0; c->n >= MIN_POINTS && k < dx_sample_n(c); k++) {
        struct dx_near near[DX_ROBUST_MAX_POINTS];
        struct dx_robust_points p;
        struct dx_robust_plane plane;
        struct dx_robust_quadric q;
        const int32_t *at = c->at[dx_sample_rank(c, k)];
        uint32_t n_steps;

        p.n = dx_cloud_within(c, at, radius < DX_CLOUD_LATTICE ? (int32_t)radius : DX_CLOUD_LATTICE,
                              near, DX_ROBUST_MAX_POINTS);
        if (p.n > DX_ROBUST_MAX_POINTS)
            continue;
        for (uint32_t i = 0; i < p.n; i++) {
            p.x[i] = (c->at[near[i].rank][0] - at[0]) / spacing;
            p.y[i] = (c->at[near[i].rank][1] - at[1]) / spacing;
            p.z[i] = (c->at[near[i].rank][2] - at[2]) / spacing;
        }
        dx_robust_weigh(&p, WIDE);
        if (dx_robust_plane(&plane, &n_steps, &p, WIDE, WIDE, DX_ROBUST_SETTLED) ==
                DX_ROBUST_DONE &&
            dx_robust_quadric(&q, &p, &plane, WIDE))
            dx_sample_insert(&m, fabs(q.term[3] + q.term[5]));
    }
    return m.n ? m.value[m.n / 2] : 0;
}

static double sixth_root(double x)
{
    return x > 0 ? dx_exp(dx_log(x) / 6) : 0;
}

/*
 * A plane shrinks curvature H by H sw^2; of noise s, spacings, s / (2 sw sqrt(pi)) is left. The sum
 * of their squares is least at sw^6 = s^2 / (8 pi H^2).
 */
static double best_width(double noise, double h)
{
    const double sw = h > 1e-6 ? sixth_root(noise * noise / (8 * DX_PI * h * h)) : MOST_SW;

    return sw < LEAST_SW ? LEAST_SW : sw > MOST_SW ? MOST_SW : sw;
}

static int check(const struct dx_cloud_smooth_config *c, struct dx_err *err)
{
    if (c->sw != 0 && !(c->sw >= 0.5 && c->sw <= 4))
        return dx_err_set(err, -EINVAL, "sw is %g spacings, expected 0.5 to 4", c->sw);
    if (c->sr != 0 && !(c->sr >= 0.1 && c->sr <= 10))
        return dx_err_set(err, -EINVAL, "sr is %g spacings, expected 0.1 to 10", c->sr);
    return 0;
}

int dx_cloud_smooth_find(struct dx_cloud_smooth_scale *scale, const struct dx_cloud *c,
                         const struct dx_cloud_smooth_config *config, struct dx_err *err)
{
    const int rc = check(config, err);

    *scale = (struct dx_cloud_smooth_scale){.spacing = 1, .sw = config->sw, .sr = config->sr};
    scale->quadric = config->quadric;
    if (rc < 0)
        return rc;
    if (c->n) {
        scale->spacing = dx_cloud_side(c);
        scale->noise = dx_cloud_noise(c);
        scale->curvature = curvature(c, scale->spacing);
    }
    if (scale->sw == 0)
        scale->sw =
            config->quadric ? WIDE : best_width(scale->noise / scale->spacing, scale->curvature);
    if (scale->sr == 0)
        scale->sr = fmax(SR_OF_NOISE * scale->noise / scale->spacing, LEAST_SR);
    return 0;
}
