/* How far the mesh is from the truth at the middle of its cells: along creases, and on walls. */
#include "tools/quality.h"

#include "core/base/trig.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MM 1e-3

/* ---- figures --------------------------------------------------------------------------------- */

static bool is_full(uint8_t code)
{
    return code == DX_CELL_ABC_ACD || code == DX_CELL_ABD_BCD;
}

/* The mesh's range less the true one at the middle of the diagonal in use, metres. As in the rig,
 * ranges are lengths of the mean of two unit directions: short of a metre by a millionth or so. */
static double centre_error(const struct dx_quality_rig *rig, uint32_t i, uint32_t j)
{
    bool bd = rig->code[(size_t)i * rig->tiling.cell_cols + j] == DX_CELL_ABD_BCD;
    double unit = (double)rig->geometry->unit_m, r0, r1;
    size_t k[4];

    dx_quality_corners(rig, i, j, k);
    r0 = unit * dx_plane_range(&rig->frame, k[bd]);
    r1 = unit * dx_plane_range(&rig->frame, k[2 + bd]);
    return 2 * r0 * r1 / (r0 + r1) - (double)rig->mid[bd][k[0]];
}

static double root_mean(double sum, uint64_t n)
{
    return n ? sqrt(sum / (double)n) : 0;
}

struct dx_quality_centre dx_quality_centre(const struct dx_quality_rig *rig)
{
    const struct dx_tiling *t = &rig->tiling;
    struct dx_quality_centre c = {0};
    double sum = 0, crossed = 0;

    for (uint32_t i = 0; i < t->cell_rows; i++)
        for (uint32_t j = 0; j < t->cell_cols; j++) {
            size_t k = (size_t)i * t->cell_cols + j;
            double e;

            if (!(rig->class[k] & DX_QUALITY_SMOOTH) || !is_full(rig->code[k]))
                continue;
            e = centre_error(rig, i, j);
            sum += e * e;
            c.cells++;
            if (rig->class[k] & DX_QUALITY_CROSSED) {
                crossed += e * e;
                c.crossed++;
            }
        }
    c.rms_m = root_mean(sum, c.cells);
    c.crossed_rms_m = root_mean(crossed, c.crossed);
    return c;
}

double dx_quality_flicker(const struct dx_quality_rig *rig, const uint8_t *code,
                          const uint8_t *other)
{
    size_t n = (size_t)rig->tiling.cell_rows * rig->tiling.cell_cols;
    uint64_t both = 0, differ = 0;

    for (size_t k = 0; k < n; k++)
        if ((rig->class[k] & DX_QUALITY_SMOOTH) && is_full(code[k]) && is_full(other[k])) {
            both++;
            differ += code[k] != other[k];
        }
    return both ? (double)differ / (double)both : 0;
}

/* Surfaces 1 to 6 are the faces of the first shape, the room; they stand across axes 0, 0, 1, 1, 2,
 * 2. */
static double wall_cosine(const struct dx_quality_rig *rig, uint32_t i, uint32_t j)
{
    uint32_t surface = dx_quality_sight(rig, i, j)->surface;
    double d[3];

    if (surface < 1 || surface > 6)
        return 0;
    dx_geometry_direction(rig->geometry, i, j, d);
    return fabs(d[(surface - 1) / 2]);
}

struct dx_quality_walls dx_quality_walls(const struct dx_quality_rig *rig, double incidence_deg)
{
    const struct dx_tiling *t = &rig->tiling;
    const double *s = rig->scene.sigma;
    double least = dx_cos(dx_rad(incidence_deg)), sum = 0;
    struct dx_quality_walls w = {0};

    for (uint32_t i = 0; i < t->cell_rows; i++)
        for (uint32_t j = 0; j < t->cell_cols; j++) {
            size_t k = (size_t)i * t->cell_cols + j;
            double r, e;

            if (!is_full(rig->code[k]) || wall_cosine(rig, i, j) < least ||
                (rig->class[k] & (DX_QUALITY_SMOOTH | DX_QUALITY_CROSSED)) != DX_QUALITY_SMOOTH)
                continue;
            r = dx_quality_sight(rig, i, j)->range;
            e = centre_error(rig, i, j) / (s[0] + r * (s[1] + r * s[2]));
            sum += e * e;
            w.cells++;
        }
    w.rms_sigma = root_mean(sum, w.cells);
    return w;
}

/* ---- diagonals ------------------------------------------------------------------------------- */

struct diagonal {
    struct dx_quality_centre centre;
    double flicker;
};

/* One rule on two drawings of the noise; the distances are those of the first. */
static int measure_diagonal(struct diagonal *out, struct dx_quality_rig *rig, enum dx_diag diag,
                            const struct dx_quality_draw *draw)
{
    size_t n = (size_t)rig->tiling.cell_rows * rig->tiling.cell_cols;
    struct dx_quality_draw drawings[2] = {*draw, *draw};
    uint8_t *first = malloc(n);
    int rc = first ? 0 : -ENOMEM;

    drawings[1].seed++;
    for (int k = 0; rc == 0 && k < 2; k++) {
        struct dx_terrain_params p;

        dx_quality_rig_draw(rig, &drawings[k]);
        p = dx_quality_rig_params(rig);
        p.diag = diag;
        rc = dx_quality_rig_mesh(rig, &p);
        if (rc == 0 && k == 0) {
            out->centre = dx_quality_centre(rig);
            memcpy(first, rig->code, n);
        }
    }
    if (rc == 0)
        out->flicker = dx_quality_flicker(rig, rig->code, first);
    free(first);
    rig->scene.seed = draw->seed; /* rows tell the first */
    return rc;
}

static double pooled_rms(double a, uint64_t n_a, double b, uint64_t n_b)
{
    return root_mean(a * a * (double)n_a + b * b * (double)n_b, n_a + n_b);
}

/* Both of two scans of one size. */
static struct diagonal pooled(const struct diagonal *a, const struct diagonal *b)
{
    const struct dx_quality_centre *x = &a->centre, *y = &b->centre;

    return (struct diagonal){
        .centre = {.cells = x->cells + y->cells,
                   .crossed = x->crossed + y->crossed,
                   .rms_m = pooled_rms(x->rms_m, x->cells, y->rms_m, y->cells),
                   .crossed_rms_m =
                       pooled_rms(x->crossed_rms_m, x->crossed, y->crossed_rms_m, y->crossed)},
        .flicker = (a->flicker + b->flicker) / 2,
    };
}

/* A scan, beside its mirror image where there is one; the bar holds up to a noise. */
struct creased {
    struct dx_quality_scan scan;
    bool both_ways;
};

static int both_diagonals(struct diagonal *out, struct dx_quality_rig *const rig[2],
                          enum dx_diag diag, const struct dx_quality_draw *draw)
{
    struct diagonal d;
    int rc = measure_diagonal(out, rig[0], diag, draw);

    if (rc || !rig[1])
        return rc;
    rc = measure_diagonal(&d, rig[1], diag, draw);
    if (rc == 0)
        *out = pooled(out, &d);
    return rc;
}

/* The ratio is held up to so much noise. */
#define BAR_SIGMA (2 * MM)

static void hold_bend(struct dx_quality_row *row, bool is_held)
{
    if (is_held)
        dx_quality_hold(row, 4, DX_QUALITY_AT_MOST, 0.8);
    dx_quality_hold(row, 5, DX_QUALITY_AT_MOST, 3);
}

static int diagonal_rows(struct dx_quality_table *t, struct dx_quality_rig *const rig[2],
                         const struct dx_quality_draw *draw)
{
    static const char *const names[] = {"fixed", "short", "bend"};
    double fixed = 0;

    for (int k = DX_DIAG_FIXED; k <= DX_DIAG_BEND; k++) {
        struct diagonal d;
        struct dx_quality_row *row;
        int rc = both_diagonals(&d, rig, (enum dx_diag)k, draw);

        if (rc)
            return rc;
        row = dx_quality_row(t, &rig[0]->scene);
        snprintf(row->note, sizeof(row->note), "%s", names[k]);
        if (k == DX_DIAG_FIXED)
            fixed = d.centre.crossed_rms_m;
        row->value[0] = (double)d.centre.cells;
        row->value[1] = d.centre.rms_m / MM;
        row->value[2] = (double)d.centre.crossed;
        row->value[3] = d.centre.crossed_rms_m / MM;
        row->value[4] = d.centre.crossed_rms_m / fixed;
        row->value[5] = 100 * d.flicker;
        if (k == DX_DIAG_BEND)
            hold_bend(row, draw->sigma[0] <= BAR_SIGMA);
    }
    return 0;
}

static int creased_rows(struct dx_quality_table *t, const struct dx_quality_run *run,
                        const struct creased *c)
{
    static const double sigma[] = {0, 2 * MM, 10 * MM};
    struct dx_quality_scan mirror = c->scan;
    struct dx_quality_rig *rig[2] = {NULL, NULL};
    int rc = dx_quality_run_rig(&rig[0], run, &c->scan);

    mirror.mirrored = true;
    if (rc == 0 && c->both_ways)
        rc = dx_quality_run_rig(&rig[1], run, &mirror);
    for (int m = 0; rc == 0 && m < 3; m++) {
        const struct dx_quality_draw draw = {.sigma = {sigma[m]}, .seed = run->seed};

        rc = diagonal_rows(t, rig, &draw);
    }
    dx_quality_rig_free(rig[0]);
    dx_quality_rig_free(rig[1]);
    return rc;
}

int dx_quality_theme_diagonals(struct dx_quality_run *run)
{
    static const struct creased scans[] = {
        {{DX_SCENE_CREASE, 600, 400, false}, true},
        {{DX_SCENE_CREASE, 150, 100, false}, true},
        {{DX_SCENE_HALL, 1500, 1000, false}, false},
    };
    struct dx_quality_table t = {
        .theme = "diagonals",
        .title = "Diagonals at creases",
        .text =
            "Root mean square of the mesh's distance from the truth, along the beam, at the\n"
            "middle of full smooth cells: all of them, and those whose corners are of more than\n"
            "one face. Flicker is the share of cells whose diagonal differs between the drawing\n"
            "of this seed and that of the next. The two planes are measured together with their\n"
            "mirror image: a fixed diagonal is the right one for one of the two. The bar of the\n"
            "ratio is for noise up to 2 mm. (In the fine scan of two planes a fixed diagonal is\n"
            "off by a millimetre: less than that noise, which no diagonal takes away.)",
        .column = {{"cells", "cells", 0},
                   {"rms mm", "rms_mm", 3},
                   {"crossed", "crossed_cells", 0},
                   {"crossed rms mm", "crossed_rms_mm", 3},
                   {"of fixed", "ratio_to_fixed", 3},
                   {"flicker %", "flicker_percent", 2}},
    };
    int rc = 0;

    for (size_t k = 0; rc == 0 && k < sizeof(scans) / sizeof(scans[0]); k++)
        rc = creased_rows(&t, run, &scans[k]);
    if (rc == 0)
        dx_quality_report_table(run->report, &t);
    return rc;
}

/* ---- walls ----------------------------------------------------------------------------------- */

#define WALL_DEG 20

int dx_quality_theme_walls(struct dx_quality_run *run)
{
    static const double sigma[] = {2 * MM, 5 * MM, 10 * MM, 20 * MM, 50 * MM};
    struct dx_quality_table t = {
        .theme = "walls",
        .title = "Distance from walls",
        .text =
            "Root mean square of the mesh's distance from walls, floor and ceiling, in sigmas\n"
            "of the noise, at the middle of full cells that the beam meets within 20 degrees of\n"
            "the normal. The mean of two samples has 0.707.",
        .column = {{"cells", "cells", 0}, {"rms / sigma", "rms_sigma", 4}},
    };
    const struct dx_quality_scan hall = {DX_SCENE_HALL, 1500, 1000, false};
    struct dx_quality_rig *rig = NULL;
    int rc = dx_quality_run_rig(&rig, run, &hall);

    for (size_t k = 0; rc == 0 && k < sizeof(sigma) / sizeof(sigma[0]); k++) {
        struct dx_quality_draw draw = {.sigma = {sigma[k]}, .seed = run->seed};
        struct dx_terrain_params p;
        struct dx_quality_walls w;
        struct dx_quality_row *row;

        dx_quality_rig_draw(rig, &draw);
        p = dx_quality_rig_params(rig);
        rc = dx_quality_rig_mesh(rig, &p);
        if (rc < 0)
            break;
        w = dx_quality_walls(rig, WALL_DEG);
        row = dx_quality_row(&t, &rig->scene);
        row->value[0] = (double)w.cells;
        row->value[1] = w.rms_sigma;
        dx_quality_hold(row, 1, DX_QUALITY_AT_MOST, 0.75);
    }
    dx_quality_rig_free(rig);
    if (rc == 0)
        dx_quality_report_table(run->report, &t);
    return rc;
}
