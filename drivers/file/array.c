/* Geometry and ranges of a file's points. */
#include "drivers/file/array.h"

#include "core/grid/cover.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MAX_DEPARTURE 0.5 /* dexels; above, a frame has another geometry */
#define LIMIT_2_BYTES 65535.0
#define LIMIT_4_BYTES 4294967295.0
/* Of a thinned frame's returns at most one in so many may miss the array; else it is made anew. */
#define MISSES 100

static void drop_represent(struct dx_array *a)
{
    dx_represent_free(a->represent);
    a->represent = NULL;
    free(a->kept);
    a->kept = NULL;
}

void dx_array_fini(struct dx_array *a)
{
    drop_represent(a);
    dx_geometry_unref(a->geometry);
    *a = (struct dx_array){0};
}

static bool thins(const struct dx_array *a)
{
    return a->thin.width != 0;
}

int dx_array_check(const struct dx_thin_options *thin, bool exact, struct dx_err *err)
{
    if ((unsigned)thin->keep >= DX_N_KEEP)
        return dx_err_set(err, -EINVAL, "keep %u, expected less than %d", (unsigned)thin->keep,
                          DX_N_KEEP);
    if (exact && thin->keep == DX_KEEP_MEAN)
        return dx_err_set(err, -EINVAL, "%s", DX_EXACT_NO_MEAN);
    if (thin->width == 0 && thin->height == 0)
        return 0;
    if (thin->width < 2 || thin->height < 2 ||
        dx_geometry_table_len(DX_MODEL_SPINNING, thin->height, thin->width) == 0)
        return dx_err_set(err, -EINVAL,
                          "size %ux%u, expected sides of 2 to %u and at most %u "
                          "dexels",
                          thin->width, thin->height, DX_PLANE_MAX_SIDE, DX_PLANE_MAX_DEXELS);
    return 0;
}

/* The end of a failure that err tells: of these points, but for the memory. */
static int failed(int rc, const char *source, struct dx_err *err)
{
    dx_err_prefix(err, source);
    return rc == -ENOMEM ? rc : DX_DRIVER_E_CORRUPT;
}

/* ---- thinning ------------------------------------------------------------------------------- */

static int make_represent(struct dx_array *a, struct dx_geometry *g)
{
    int rc = dx_represent_new(&a->represent, g, a->thin.keep, a->max_samples);

    if (rc || !a->exact)
        return rc;
    a->kept = calloc((size_t)g->height * g->width, sizeof(*a->kept));
    if (a->kept)
        return 0;
    drop_represent(a);
    return -ENOMEM;
}

/* The points into the representatives of `g`. Only the median's memory depends on how many they
 * may be. */
static int load(struct dx_array *a, struct dx_geometry *g, bool fresh,
                const struct dx_points *points, struct dx_err *err)
{
    const struct dx_samples samples = {
        .n = (size_t)points->height * points->width, .xyz = points->xyz, .attr = points->attr};
    int rc;

    if (fresh || !a->represent || samples.n > a->max_samples) {
        drop_represent(a);
        a->max_samples = a->thin.keep == DX_KEEP_MEDIAN ? (uint32_t)samples.n : UINT32_MAX;
        rc = make_represent(a, g);
        if (rc)
            return dx_err_set(err, rc, "thinning %ux%u points to %ux%u dexels: %s", points->width,
                              points->height, g->width, g->height,
                              rc == -ENOMEM ? "no memory" : "not possible");
    }
    dx_represent_reset(a->represent);
    return dx_represent_add(a->represent, &samples);
}

static bool loaded_holds(const struct dx_array *a)
{
    const struct dx_represent_counts *c = dx_represent_counts(a->represent);

    return (c->outside + c->unfit) * MISSES <= c->outside + c->unfit + c->taken;
}

/* ---- geometry ------------------------------------------------------------------------------- */

static bool fits(const struct dx_geometry *g, double range)
{
    return rint(range / (double)g->unit_m) <= (g->range_bytes == 2 ? LIMIT_2_BYTES : LIMIT_4_BYTES);
}

/* The frame's own geometry says nothing new. */
static bool same_geometry(const struct dx_geometry *g, const struct dx_geometry *fresh,
                          const struct dx_fit_report *report)
{
    bool no_better = fresh->unit_m == g->unit_m && fresh->range_bytes == g->range_bytes;

    return (fits(g, report->max_range_m) || no_better) &&
           dx_geometry_departure(g, fresh) <= MAX_DEPARTURE;
}

static int tell(struct dx_array *a, struct dx_geometry *fresh, uint8_t attr_bytes,
                const struct dx_fit_report *report, const struct dx_frame_sink *sink)
{
    int rc = sink->geometry(sink->ctx, fresh, attr_bytes);

    if (rc)
        return rc;
    dx_geometry_unref(a->geometry);
    a->geometry = dx_geometry_ref(fresh);
    a->attr_bytes = attr_bytes;
    a->report = *report;
    return 0;
}

/* What the points ask for: their grid, or the array that covers it. */
static int make(struct dx_geometry **out, struct dx_fit_report *report, const struct dx_array *a,
                const struct dx_points *points, const double pose[12], struct dx_err *err)
{
    struct dx_geometry *grid;
    int rc = dx_fit_geometry(&grid, report, points, &a->fit, err);

    if (rc)
        return rc;
    memcpy(grid->pose, pose, sizeof(grid->pose));
    grid->exact = a->exact;
    if (!thins(a)) {
        *out = grid;
        return 0;
    }
    rc = dx_cover_geometry(out, grid, a->thin.height, a->thin.width, err);
    dx_geometry_unref(grid);
    return rc;
}

/* 1: the points lie in the geometry that was told; 0: not; negative. */
static int holds(struct dx_array *a, const struct dx_points *points, struct dx_err *err)
{
    int rc;

    if (!thins(a))
        return dx_fit_holds(a->geometry, points, MAX_DEPARTURE);
    rc = load(a, a->geometry, false, points, err);
    return rc ? rc : loaded_holds(a);
}

int dx_array_settle(struct dx_array *a, const struct dx_points *points, const double pose[12],
                    const char *source, const struct dx_frame_sink *sink, struct dx_err *err)
{
    struct dx_geometry *g = a->geometry, *fresh;
    struct dx_fit_report report;
    bool same =
        g && memcmp(g->pose, pose, sizeof(g->pose)) == 0 && a->attr_bytes == points->attr_bytes;
    int rc = same ? holds(a, points, err) : 0;

    if (rc == 1)
        return 0;
    if (rc == 0)
        rc = make(&fresh, &report, a, points, pose, err);
    if (rc)
        return failed(rc, source, err);
    if (!same || !same_geometry(g, fresh, &report)) {
        rc = thins(a) ? load(a, fresh, true, points, err) : 0;
        rc = rc ? failed(rc, source, err) : tell(a, fresh, points->attr_bytes, &report, sink);
        if (rc)
            drop_represent(a); /* of a geometry that nobody knows */
    }
    dx_geometry_unref(fresh);
    return rc;
}

int dx_array_adopt(struct dx_array *a, struct dx_geometry *g, uint8_t attr_bytes,
                   const struct dx_frame_sink *sink)
{
    const struct dx_fit_report none = {0};
    const struct dx_geometry *old = a->geometry;

    if (old && a->attr_bytes == attr_bytes && dx_geometry_departure(old, g) == 0 &&
        old->unit_m == g->unit_m && old->range_bytes == g->range_bytes && old->exact == g->exact &&
        memcmp(old->pose, g->pose, sizeof(g->pose)) == 0)
        return 0;
    drop_represent(a);
    return tell(a, g, attr_bytes, &none, sink);
}

void dx_array_fill(struct dx_array *a, struct dx_plane *plane, const struct dx_points *points)
{
    if (!thins(a)) {
        dx_fit_ranges(plane, a->geometry, points);
        return;
    }
    dx_represent_finish(a->represent, plane, a->kept);
    for (size_t k = 0; a->kept && k < dx_plane_n_dexels(plane); k++)
        for (size_t m = 0; m < 3; m++)
            plane->xyz[3 * k + m] =
                a->kept[k] == UINT32_MAX ? 0 : (float)points->xyz[3 * (size_t)a->kept[k] + m];
}
