/* How much of the smooth surface is meshed, and how much is meshed that is no surface. */
#include "tools/quality.h"

#include <math.h>

#define MM 1e-3

/* ---- figures --------------------------------------------------------------------------------- */

static bool has_samples(const struct dx_quality_rig *rig, uint32_t i, uint32_t j)
{
    size_t k[4];

    dx_quality_corners(rig, i, j, k);
    for (int m = 0; m < 4; m++)
        if (!dx_plane_range(&rig->frame, k[m]))
            return false;
    return true;
}

struct dx_quality_coverage dx_quality_coverage(const struct dx_quality_rig *rig)
{
    const struct dx_tiling *t = &rig->tiling;
    struct dx_quality_coverage c = {0, 0};

    for (uint32_t i = 0; i < t->cell_rows; i++)
        for (uint32_t j = 0; j < t->cell_cols; j++) {
            size_t k = (size_t)i * t->cell_cols + j;

            if (!(rig->class[k] & DX_QUALITY_SMOOTH) || !has_samples(rig, i, j))
                continue;
            c.smooth++;
            c.full += rig->code[k] == DX_CELL_ABC_ACD || rig->code[k] == DX_CELL_ABD_BCD;
        }
    return c;
}

/* Rough edges of cell (i, j), as bits AB, DC, AD, BC, AC, BD. */
enum { AB = 1, DC = 2, AD = 4, BC = 8, AC = 16, BD = 32 };

static unsigned rough_edges(const struct dx_quality_rig *rig, uint32_t i, uint32_t j)
{
    const uint8_t *rough = rig->rough;
    unsigned own, bits = 0;
    size_t k[4];

    dx_quality_corners(rig, i, j, k);
    own = rough[k[0]];
    bits |= own >> DX_EDGE_H & 1 ? AB : 0;
    bits |= own >> DX_EDGE_V & 1 ? AD : 0;
    bits |= own >> DX_EDGE_AC & 1 ? AC : 0;
    bits |= own >> DX_EDGE_BD & 1 ? BD : 0;
    bits |= rough[k[1]] >> DX_EDGE_V & 1 ? BC : 0;
    bits |= rough[k[3]] >> DX_EDGE_H & 1 ? DC : 0;
    return bits;
}

struct dx_quality_veil dx_quality_veil(const struct dx_quality_rig *rig)
{
    enum { ABC = AB | BC | AC, ACD = AC | DC | AD, ABD = AB | BD | AD, BCD = BC | DC | BD };
    static const unsigned triangles[][2] = {
        [DX_CELL_ABC] = {ABC, 0}, [DX_CELL_ACD] = {ACD, 0}, [DX_CELL_ABC_ACD] = {ABC, ACD},
        [DX_CELL_ABD] = {ABD, 0}, [DX_CELL_BCD] = {BCD, 0}, [DX_CELL_ABD_BCD] = {ABD, BCD},
    };
    const struct dx_tiling *t = &rig->tiling;
    struct dx_quality_veil v = {0, 0};

    for (uint32_t i = 0; i < t->cell_rows; i++)
        for (uint32_t j = 0; j < t->cell_cols; j++) {
            size_t k = (size_t)i * t->cell_cols + j;
            unsigned rough;

            if (rig->class[k] & DX_QUALITY_SMOOTH)
                continue;
            v.discontinuities += rig->class[k] & DX_QUALITY_SEEN;
            rough = rough_edges(rig, i, j);
            for (int m = 0; m < 2; m++)
                v.triangles += (triangles[rig->code[k]][m] & rough) != 0;
        }
    return v;
}

/* ---- themes ---------------------------------------------------------------------------------- */

struct drawings {
    struct dx_quality_scan scan;
    unsigned n;
    double sigma_mm[5];
    double bar; /* 0: none */
};

static double percent(uint64_t part, uint64_t whole)
{
    return whole ? 100.0 * (double)part / (double)whole : 0;
}

static int covered(double *value, struct dx_quality_rig *rig, const struct dx_terrain_params *p)
{
    struct dx_quality_coverage c;
    int rc = dx_quality_rig_mesh(rig, p);

    if (rc < 0)
        return rc;
    c = dx_quality_coverage(rig);
    *value = percent(c.full, c.smooth);
    return 0;
}

static int coverage_row(struct dx_quality_table *t, struct dx_quality_rig *rig, double bar)
{
    struct dx_terrain_params p = dx_quality_rig_params(rig), first = p, paper = p, estimated = p;
    struct dx_quality_row *row = dx_quality_row(t, &rig->scene);
    int rc = covered(&row->value[1], rig, &p);

    row->value[0] = (double)dx_quality_coverage(rig).smooth;
    first.rescue = false;
    paper.paper = true;
    paper.cap_m = 0.12;
    estimated.sigma_given = false;
    if (rc == 0)
        rc = covered(&row->value[2], rig, &first);
    if (rc == 0)
        rc = covered(&row->value[3], rig, &paper);
    if (rc == 0)
        rc = covered(&row->value[4], rig, &estimated);
    if (bar > 0)
        dx_quality_hold(row, 1, DX_QUALITY_AT_LEAST, bar);
    return rc;
}

static int each_drawing(const struct dx_quality_run *run, struct dx_quality_table *t,
                        const struct drawings *d,
                        int (*add)(struct dx_quality_table *, struct dx_quality_rig *, double))
{
    struct dx_quality_rig *rig = NULL;
    int rc = dx_quality_run_rig(&rig, run, &d->scan);

    for (unsigned k = 0; rc == 0 && k < d->n; k++) {
        struct dx_quality_draw draw = {.sigma = {d->sigma_mm[k] * MM}, .seed = run->seed};

        dx_quality_rig_draw(rig, &draw);
        rc = add(t, rig, d->bar);
    }
    dx_quality_rig_free(rig);
    return rc;
}

int dx_quality_theme_coverage(struct dx_quality_run *run)
{
    static const struct drawings scans[] = {
        {{DX_SCENE_HALL, 1500, 1000, false}, 5, {0, 2, 10, 20, 50}, 99.9},
        {{DX_SCENE_HALL, 600, 400, false}, 5, {0, 2, 10, 20, 50}, 99.9},
        {{DX_SCENE_OPEN, 1500, 1000, false}, 2, {2, 20}, 99.7},
        {{DX_SCENE_OPEN, 2048, 128, false}, 2, {2, 20}, 98.5},
        {{DX_SCENE_OPEN, 600, 400, false}, 2, {2, 20}, 0},
    };
    struct dx_quality_table t = {
        .theme = "coverage",
        .title = "Coverage of smooth surface",
        .text =
            "Smooth cells with both triangles, by the default rules with the true noise; beside\n"
            "it with the first-order rule alone, by the paper's rule with a sphere of 12 cm,\n"
            "and by the default rules with the noise estimated from the same frame. A cell is\n"
            "smooth when each of its six edges passes the true surface at its middle within 3\n"
            "cm or the spacing of its ends, whichever is more.",
        .column = {{"smooth cells", "smooth_cells", 0},
                   {"coverage %", "coverage_percent", 4},
                   {"first order %", "first_order_percent", 4},
                   {"paper %", "paper_percent", 4},
                   {"estimated %", "estimated_percent", 4}},
    };
    int rc = 0;

    for (size_t k = 0; rc == 0 && k < sizeof(scans) / sizeof(scans[0]); k++)
        rc = each_drawing(run, &t, &scans[k], coverage_row);
    if (rc == 0)
        dx_quality_report_table(run->report, &t);
    return rc;
}

static int veiled(double *value, struct dx_quality_rig *rig, const struct dx_terrain_params *p)
{
    int rc = dx_quality_rig_mesh(rig, p);

    if (rc == 0)
        *value = (double)dx_quality_veil(rig).triangles;
    return rc;
}

static int veil_row(struct dx_quality_table *t, struct dx_quality_rig *rig, double bar)
{
    struct dx_terrain_params p = dx_quality_rig_params(rig), rescue = p, first = p;
    struct dx_quality_row *row = dx_quality_row(t, &rig->scene);
    double *v = row->value;
    int rc = veiled(&v[1], rig, &p);

    v[0] = (double)dx_quality_veil(rig).discontinuities;
    v[2] = v[0] > 0 ? 100 * v[1] / v[0] : 0;
    rescue.mixed = first.mixed = DX_MIXED_OFF;
    first.rescue = false;
    if (rc == 0)
        rc = veiled(&v[3], rig, &rescue);
    if (rc == 0)
        rc = veiled(&v[4], rig, &first);
    v[5] = v[4] > 0 ? v[3] / v[4] : v[3] > 0 ? INFINITY : 1;
    if (bar > 0)
        dx_quality_hold(row, 2, DX_QUALITY_AT_MOST, bar);
    else /* in the hall one triangle is more than a percent */
        dx_quality_hold(row, 5, DX_QUALITY_AT_MOST, 1.01);
    return rc;
}

int dx_quality_theme_veil(struct dx_quality_run *run)
{
    static const struct drawings scans[] = {
        {{DX_SCENE_HALL, 1500, 1000, false}, 3, {0, 2, 10}, 3},
        {{DX_SCENE_HALL, 600, 400, false}, 1, {2}, 0},
        {{DX_SCENE_OPEN, 1500, 1000, false}, 1, {2}, 0},
        {{DX_SCENE_OPEN, 2048, 128, false}, 1, {2}, 0},
    };
    struct dx_quality_table t = {
        .theme = "veil",
        .title = "Veil over discontinuities",
        .text =
            "Triangles with an edge that is off the true surface at its middle by more than 3\n"
            "cm and the spacing of its ends, beside the cells that have such an edge. The\n"
            "second order must not add to them: measured with its rule and without, the filter\n"
            "of mixed samples off in both.",
        .column = {{"discontinuities", "discontinuity_cells", 0},
                   {"veil", "veil_triangles", 0},
                   {"share %", "veil_percent", 2},
                   {"unfiltered", "unfiltered_triangles", 0},
                   {"first order", "first_order_triangles", 0},
                   {"ratio", "rescue_ratio", 3}},
    };
    int rc = 0;

    for (size_t k = 0; rc == 0 && k < sizeof(scans) / sizeof(scans[0]); k++)
        rc = each_drawing(run, &t, &scans[k], veil_row);
    if (rc == 0)
        dx_quality_report_table(run->report, &t);
    return rc;
}
