/* What mixed samples do to the mesh, and what drop-outs leave of it. */
#include "tools/quality.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define MM 1e-3

/* ---- mixed samples --------------------------------------------------------------------------- */

struct touch {
    const uint8_t *mixed; /* a dexel */
    struct dx_quality_mixed *count;
};

static void count_touch(void *ctx, const struct dx_quality_triangle *t)
{
    struct touch *c = ctx;

    if (c->mixed[t->id[0]] || c->mixed[t->id[1]] || c->mixed[t->id[2]])
        c->count->touching++;
    else
        c->count->others++;
}

int dx_quality_mixed(struct dx_quality_mixed *out, const struct dx_quality_rig *rig)
{
    uint32_t width = rig->geometry->width;
    uint8_t *mixed = calloc(dx_plane_n_dexels(&rig->frame), 1);
    struct touch c = {mixed, out};
    int rc;

    *out = (struct dx_quality_mixed){0};
    if (!mixed)
        return -ENOMEM;
    for (uint32_t i = 0; i < rig->geometry->height; i++)
        for (uint32_t j = 0; j < width; j++) {
            mixed[(size_t)i * width + j] = dx_quality_rig_mixed(rig, i, j);
            out->samples += mixed[(size_t)i * width + j];
        }
    rc = dx_quality_each_triangle(rig, count_touch, &c);
    free(mixed);
    return rc;
}

static int mixed_rows(struct dx_quality_table *t, struct dx_quality_rig *rig)
{
    static const char *const names[] = {"off", "axis", "strict"};
    struct dx_terrain_params p = dx_quality_rig_params(rig);
    struct dx_quality_mixed off = {0}, m;

    for (int k = DX_MIXED_OFF; k <= DX_MIXED_STRICT; k++) {
        struct dx_quality_row *row = dx_quality_row(t, &rig->scene);
        double *v = row->value;
        int rc;

        p.mixed = (enum dx_mixed)k;
        rc = dx_quality_rig_mesh(rig, &p);
        if (rc == 0)
            rc = dx_quality_mixed(&m, rig);
        if (rc)
            return rc;
        if (k == DX_MIXED_OFF)
            off = m;
        snprintf(row->note, sizeof(row->note), "%s", names[k]);
        v[0] = (double)m.samples;
        v[1] = (double)m.touching;
        v[2] = 100 * (1 - (double)m.touching / (double)off.touching);
        v[3] = (double)m.others;
        v[4] = 100 * (1 - (double)m.others / (double)off.others);
        if (k == DX_MIXED_AXIS && rig->scene.sigma[0] <= 2 * MM)
            dx_quality_hold(row, 2, DX_QUALITY_AT_LEAST, 45);
        if (k == DX_MIXED_AXIS)
            dx_quality_hold(row, 4, DX_QUALITY_AT_MOST, 0.1);
    }
    return 0;
}

int dx_quality_theme_mixed(struct dx_quality_run *run)
{
    static const struct dx_quality_draw draws[] = {
        {.sigma = {0}, .mixed = 0.7},
        {.sigma = {2 * MM}, .mixed = 0.7},
        {.sigma = {10 * MM}, .mixed = 0.7},
    };
    struct dx_quality_table t = {
        .theme = "mixed",
        .title = "Mixed samples",
        .text = "Where a neighbour's true range differs by more than 30 cm, seven of ten samples\n"
                "are a uniform mix of both. Triangles that touch one, with the filter of mixed\n"
                "samples off, axis (the default) and strict, and the other triangles that the\n"
                "filter costs. The cut is held to its bar up to 2 mm of noise: a mixed sample\n"
                "within the noise of a surface is like any other of its samples.",
        .column = {{"mixed samples", "mixed_samples", 0},
                   {"touching", "touching_triangles", 0},
                   {"cut %", "cut_percent", 2},
                   {"others", "other_triangles", 0},
                   {"lost %", "others_lost_percent", 4}},
    };
    const struct dx_quality_scan hall = {DX_SCENE_HALL, 1500, 1000, false};
    struct dx_quality_rig *rig = NULL;
    int rc = dx_quality_run_rig(&rig, run, &hall);

    for (size_t k = 0; rc == 0 && k < sizeof(draws) / sizeof(draws[0]); k++) {
        struct dx_quality_draw draw = draws[k];

        draw.seed = run->seed;
        dx_quality_rig_draw(rig, &draw);
        rc = mixed_rows(&t, rig);
    }
    dx_quality_rig_free(rig);
    if (rc == 0)
        dx_quality_report_table(run->report, &t);
    return rc;
}

/* ---- drop-outs ------------------------------------------------------------------------------- */

static void add_area(void *ctx, const struct dx_quality_triangle *t)
{
    uint64_t *sum = ctx;
    int64_t x1 = t->col[1] - t->col[0], y1 = t->row[1] - t->row[0];
    int64_t x2 = t->col[2] - t->col[0], y2 = t->row[2] - t->row[0];

    *sum += (uint64_t)llabs(x1 * y2 - x2 * y1);
}

int dx_quality_area(uint64_t *half_cells, const struct dx_quality_rig *rig)
{
    *half_cells = 0;
    return dx_quality_each_triangle(rig, add_area, half_cells);
}

static int area_of(uint64_t *area, struct dx_quality_rig *rig, uint8_t bridge)
{
    struct dx_terrain_params p = dx_quality_rig_params(rig);
    int rc;

    p.bridge = bridge;
    rc = dx_quality_rig_mesh(rig, &p);
    return rc ? rc : dx_quality_area(area, rig);
}

/* Bars hold the default, one missing dexel bridged, on the surface without edges of its own. */
static void hold_area(struct dx_quality_row *row, double dropout)
{
    if (row->scene.scene != DX_SCENE_CREASE)
        return;
    if (dropout <= 0.01)
        dx_quality_hold(row, 1, DX_QUALITY_AT_LEAST, 99.99);
    else if (dropout <= 0.05)
        dx_quality_hold(row, 1, DX_QUALITY_AT_LEAST, 99.8);
}

static int dropout_rows(struct dx_quality_table *t, struct dx_quality_rig *rig, double sigma,
                        uint64_t seed)
{
    static const double shares[] = {0.01, 0.05, 0.10, 0.20};
    struct dx_quality_draw draw = {.sigma = {sigma}, .seed = seed};
    uint64_t whole, area;
    int rc;

    dx_quality_rig_draw(rig, &draw);
    rc = area_of(&whole, rig, 0);
    for (size_t k = 0; rc == 0 && k < sizeof(shares) / sizeof(shares[0]); k++) {
        struct dx_quality_row *row;

        draw.dropout = shares[k];
        dx_quality_rig_draw(rig, &draw);
        row = dx_quality_row(t, &rig->scene);
        for (uint8_t bridge = 0; rc == 0 && bridge <= 2; bridge++) {
            rc = area_of(&area, rig, bridge);
            if (rc == 0)
                row->value[bridge] = 100 * (double)area / (double)whole;
        }
        hold_area(row, shares[k]);
    }
    return rc;
}

int dx_quality_theme_dropouts(struct dx_quality_run *run)
{
    static const struct {
        struct dx_quality_scan scan;
        double sigma;
    } scans[] = {
        {{DX_SCENE_CREASE, 1000, 1000, false}, 0},
        {{DX_SCENE_HALL, 600, 400, false}, 2 * MM},
        {{DX_SCENE_HALL, 1500, 1000, false}, 2 * MM},
    };
    struct dx_quality_table t = {
        .theme = "dropouts",
        .title = "Area left by drop-outs",
        .text = "Area of the index plane under triangles, beside the same scan without drop-outs,\n"
                "when no missing dexel, one (the default) or two in a row may be bridged. The\n"
                "crease is two planes without a discontinuity: all that is lost there is lost to\n"
                "drop-outs.",
        .column = {{"bridge 0 %", "bridge_0_percent", 3},
                   {"bridge 1 %", "bridge_1_percent", 3},
                   {"bridge 2 %", "bridge_2_percent", 3}},
    };
    int rc = 0;

    for (size_t k = 0; rc == 0 && k < sizeof(scans) / sizeof(scans[0]); k++) {
        struct dx_quality_rig *rig = NULL;

        rc = dx_quality_run_rig(&rig, run, &scans[k].scan);
        if (rc == 0)
            rc = dropout_rows(&t, rig, scans[k].sigma, run->seed);
        dx_quality_rig_free(rig);
    }
    if (rc == 0)
        dx_quality_report_table(run->report, &t);
    return rc;
}
