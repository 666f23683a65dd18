/* Choice of the model for a frame of organized points, and what goes with it: unit, seam, report.
 */
#include "core/grid/fit_model.h"

#include "core/base/trig.h"

#include <errno.h>

/* Models whose rms residual is above this (dexels) are not used. */
#define GOOD_RMS 0.1
/* A table whose azimuths the spinning model follows no better than this has no seam. */
#define SEAM_RMS 1.0
/* Columns that cover 360 degrees to this share of a step close the seam; the least width that may.
 */
#define SEAM_TOLERANCE 0.1
#define MIN_WRAP_WIDTH 8
#define MIN_VALID      16

static uint64_t count_valid(const struct dx_points *points)
{
    size_t n = (size_t)points->height * points->width;
    uint64_t valid = 0;

    for (size_t k = 0; k < n; k++)
        valid += dx_fit_valid(points->xyz + 3 * k);
    return valid;
}

static int check(const struct dx_points *points, const struct dx_fit_options *options,
                 uint64_t *valid, struct dx_err *err)
{
    if (dx_geometry_table_len(DX_MODEL_TABLE, points->height, points->width) == 0 ||
        points->height < 2 || points->width < 2) /* a line has no cells */
        return dx_err_set(err, -EINVAL,
                          "grid of %ux%u points, expected sides of 2 to %u and at most %u",
                          points->width, points->height, DX_PLANE_MAX_SIDE, DX_PLANE_MAX_DEXELS);
    if (!(options->unit_m >= 0) || options->unit_m > 1e6)
        return dx_err_set(err, -EINVAL, "unit of %g m, expected 0 to 1e6", options->unit_m);
    if (options->seam == 1 && points->width < MIN_WRAP_WIDTH)
        return dx_err_set(err, -EINVAL, "seam closed on %u columns, expected at least %d",
                          points->width, MIN_WRAP_WIDTH);
    *valid = count_valid(points);
    if (*valid < MIN_VALID)
        return dx_err_set(err, -ENODATA, "%u of %ux%u points are returns, expected at least %d",
                          (unsigned)*valid, points->width, points->height, MIN_VALID);
    return 0;
}

static bool closes(const struct dx_fit_model *spinning)
{
    double turn = fabs(spinning->col.step) * spinning->col.n;

    return spinning->rms < SEAM_RMS && spinning->col.n >= MIN_WRAP_WIDTH &&
           fabs(turn - 2 * DX_PI) <= SEAM_TOLERANCE * fabs(spinning->col.step);
}

static void set_unit(struct dx_geometry *g, double max_range, double unit)
{
    g->unit_m = (float)(unit > 0 ? unit : dx_geometry_unit_for(max_range));
    g->range_bytes = rint(max_range / (double)g->unit_m) > 65535 ? 4 : 2;
}

static double max_range(const struct dx_points *points, enum dx_model model)
{
    size_t n = (size_t)points->height * points->width;
    double largest = 0;

    for (size_t k = 0; k < n; k++) {
        const double *p = points->xyz + 3 * k;
        double r;

        if (!dx_fit_valid(p))
            continue;
        r = model == DX_MODEL_PINHOLE ? p[2] : sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
        largest = r > largest ? r : largest;
    }
    return largest;
}

static void report_model(struct dx_fit_report *report, const struct dx_fit_model *m)
{
    bool tangents = m->kind == DX_MODEL_PINHOLE;
    double uneven = dx_fit_axis_irregularity(&m->col) + dx_fit_axis_irregularity(&m->row);

    report->regularity = sqrt(uneven / ((double)m->col.n + m->row.n));
    report->azimuth_step_deg = dx_deg(tangents ? dx_atan2(m->col.step, 1) : m->col.step);
    report->elevation_step_deg = dx_deg(tangents ? dx_atan2(m->row.step, 1) : m->row.step);
}

/* The geometry of the better of the two models, or the table. */
static int choose(struct dx_geometry **out, struct dx_fit_report *report,
                  const struct dx_points *points, const struct dx_fit_options *options,
                  const struct dx_fit_model *spinning, const struct dx_fit_model *pinhole)
{
    const struct dx_fit_model *best = pinhole->rms < spinning->rms ? pinhole : spinning;
    bool good = best->rms < GOOD_RMS;
    struct dx_geometry *g;
    int rc = good ? dx_fit_to_separable(&g, best) : dx_fit_to_table(&g, best, points);

    if (rc)
        return rc;
    report->rms_dexel = good ? best->rms : 0;
    report->rms_spinning = spinning->rms;
    report->rms_pinhole = pinhole->rms;
    report_model(report, best);
    report->max_range_m = max_range(points, g->model);
    set_unit(g, report->max_range_m, options->unit_m);
    if (g->model != DX_MODEL_PINHOLE)
        g->wrap = options->seam == -1 ? closes(spinning) : options->seam == 1;
    dx_geometry_orient(g);
    *out = g;
    return 0;
}

int dx_fit_geometry(struct dx_geometry **out, struct dx_fit_report *report,
                    const struct dx_points *points, const struct dx_fit_options *options,
                    struct dx_err *err)
{
    struct dx_fit_model spinning = {0}, pinhole = {0};
    uint64_t valid = 0;
    int rc = check(points, options, &valid, err);

    if (rc)
        return rc;
    *report = (struct dx_fit_report){0};
    report->valid = (double)valid / ((double)points->height * points->width);
    rc = dx_fit_model_init(&spinning, DX_MODEL_SPINNING, points);
    if (rc == 0)
        rc = dx_fit_model_init(&pinhole, DX_MODEL_PINHOLE, points);
    if (rc == 0)
        rc = dx_fit_spinning(&spinning, points);
    if (rc == 0) {
        dx_fit_pinhole(&pinhole, points);
        rc = choose(out, report, points, options, &spinning, &pinhole);
    }
    dx_fit_model_fini(&pinhole);
    dx_fit_model_fini(&spinning);
    return rc == 0 ? 0
                   : dx_err_set(err, rc, "no memory to fit %ux%u points", points->width,
                                points->height);
}
