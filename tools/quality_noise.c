/* The noise that a frame tells, beside the noise that was put into it. */
#include "tools/quality.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>

#define MM 1e-3

/* ---- the figure ------------------------------------------------------------------------------ */

static int by_value(const void *a, const void *b)
{
    uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;

    return (x > y) - (x < y);
}

/* The 5th, 50th and 95th percentile of the ranges, metres; 0 where there are none. */
static int range_percentiles(double out[3], const struct dx_quality_rig *rig)
{
    static const size_t percent[3] = {5, 50, 95};
    size_t n = 0, n_dexels = dx_plane_n_dexels(&rig->frame);
    uint32_t *range = malloc(n_dexels * sizeof(*range));

    if (!range)
        return -ENOMEM;
    for (size_t k = 0; k < n_dexels; k++) {
        range[n] = dx_plane_range(&rig->frame, k);
        n += range[n] != 0;
    }
    qsort(range, n, sizeof(*range), by_value);
    for (int m = 0; m < 3; m++) {
        const size_t k = n ? (n - 1) * percent[m] / 100 : 0;

        out[m] = n ? (double)rig->geometry->unit_m * range[k] : 0;
    }
    free(range);
    return 0;
}

static double sigma_at(const double s[3], double r)
{
    return s[0] + r * (s[1] + r * s[2]);
}

int dx_quality_noise(struct dx_quality_noise *out, const struct dx_quality_rig *rig)
{
    int rc = range_percentiles(out->range_m, rig);

    if (rc < 0)
        return rc;
    out->known = dx_noise_estimate(out->sigma, &rig->frame, rig->geometry);
    for (int k = 0; k < 3; k++)
        out->ratio[k] =
            sigma_at(out->sigma, out->range_m[k]) / sigma_at(rig->scene.sigma, out->range_m[k]);
    return 0;
}

/* ---- the theme ------------------------------------------------------------------------------- */

/* A picket fence is all edges: its rows have no four samples of one plane. */
static bool can_tell(enum dx_scene scene)
{
    return scene != DX_SCENE_FENCE;
}

static int noise_row(struct dx_quality_table *t, const struct dx_quality_rig *rig)
{
    struct dx_quality_row *row = dx_quality_row(t, &rig->scene);
    struct dx_quality_noise noise;
    double worst = 0;
    int rc = dx_quality_noise(&noise, rig);

    if (rc < 0)
        return rc;
    row->value[0] = noise.sigma[0] / MM;
    row->value[1] = noise.sigma[2] / MM;
    for (int k = 0; k < 3; k++) {
        double off = 100 * fabs(noise.ratio[k] - 1);

        row->value[2 + k] = noise.ratio[k];
        worst = off > worst ? off : worst;
    }
    row->value[5] = worst;
    if (!noise.known)
        row->value[5] = NAN;
    if (can_tell(rig->scene.scene))
        dx_quality_hold(row, 5, DX_QUALITY_AT_MOST, 20);
    return 0;
}

int dx_quality_theme_noise(struct dx_quality_run *run)
{
    static const double sigma[][3] = {{2 * MM},  {5 * MM},  {10 * MM},
                                      {20 * MM}, {50 * MM}, {2 * MM, 0, 0.5 * MM}};
    struct dx_quality_table t = {
        .theme = "noise",
        .title = "Noise estimated from one frame",
        .text = "The model s0 + s2 r^2 found in a frame, over the true one at the 5th, 50th and\n"
                "95th percentile of the frame's ranges. The fence is held to no bar: where it\n"
                "stands, no four samples in a row are of one surface.",
        .column = {{"s0 mm", "s0_mm", 3},
                   {"s2 mm/m2", "s2_mm_per_m2", 4},
                   {"near", "ratio_near", 3},
                   {"middle", "ratio_middle", 3},
                   {"far", "ratio_far", 3},
                   {"worst off %", "worst_percent", 1}},
    };
    int rc = 0;

    for (unsigned scene = 0; rc == 0 && scene < DX_N_SCENES; scene++) {
        struct dx_quality_rig *rig = NULL;
        struct dx_scene_config c;

        dx_scene_config_default(&c, (enum dx_scene)scene);
        rc = dx_quality_run_rig(&rig, run,
                                &(struct dx_quality_scan){c.scene, c.width, c.height, false});
        for (size_t k = 0; rc == 0 && k < sizeof(sigma) / sizeof(sigma[0]); k++) {
            struct dx_quality_draw draw = {.sigma = {sigma[k][0], sigma[k][1], sigma[k][2]},
                                           .seed = run->seed};

            dx_quality_rig_draw(rig, &draw);
            rc = noise_row(&t, rig);
        }
        dx_quality_rig_free(rig);
    }
    if (rc == 0)
        dx_quality_report_table(run->report, &t);
    return rc;
}
