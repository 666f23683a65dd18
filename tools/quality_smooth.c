/* What smoothing along the beam makes of the ranges, beside the true ones. */
#include "tools/quality.h"

#include <assert.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MM   1e-3
#define NEAR 3 /* dexels from a crease or a silhouette */

/* ---- where a dexel stands -------------------------------------------------------------------- */

enum place {
    FLAT = 0,
    BY_CREASE = 1,
    BY_SILHOUETTE = 2,
    ON_CREASE = 4
}; /* the last with the 2nd */

/* Sets `bit` for the dexels within `near` of the corners of cell (i, j). */
static void mark_around(uint8_t *place, const struct dx_quality_rig *rig, uint32_t i, uint32_t j,
                        uint32_t near, enum place bit)
{
    const uint32_t height = rig->geometry->height, width = rig->geometry->width;

    for (uint32_t p = i < near ? 0 : i - near; p < height && p <= i + 1 + near; p++)
        for (uint32_t q = 0; q <= 1 + 2 * near; q++) {
            uint32_t col = (j + width - near + q) % width;

            if (rig->geometry->wrap || (j + q >= near && j + q - near < width))
                place[(size_t)p * width + col] |= (uint8_t)bit;
        }
}

static void find_places(uint8_t *place, const struct dx_quality_rig *rig)
{
    const struct dx_tiling *t = &rig->tiling;

    for (uint32_t i = 0; i < t->cell_rows; i++)
        for (uint32_t j = 0; j < t->cell_cols; j++) {
            uint8_t class = rig->class[(size_t)i * t->cell_cols + j];

            if (class & DX_QUALITY_CROSSED) {
                mark_around(place, rig, i, j, NEAR, BY_CREASE);
                mark_around(place, rig, i, j, 0, ON_CREASE);
            } else if (!(class & DX_QUALITY_SMOOTH)) {
                mark_around(place, rig, i, j, NEAR, BY_SILHOUETTE);
            }
        }
}

/* ---- figures --------------------------------------------------------------------------------- */

static double root_mean(double sum, uint64_t n)
{
    return n ? sqrt(sum / (double)n) : NAN;
}

/* Adds a plane's errors, in sigmas, to the places that they are of. */
struct errors {
    double flat, crease, silhouette, on_crease;
    uint64_t n_flat, n_crease, n_silhouette, n_on_crease;
};

static void add_error(struct errors *e, uint8_t place, double error)
{
    const double square = error * error;

    if (place == FLAT) {
        e->flat += square;
        e->n_flat++;
    }
    if (place & BY_SILHOUETTE) { /* a crease that ends there counts for that */
        e->silhouette += square;
        e->n_silhouette++;
    } else if (place & BY_CREASE) {
        e->crease += square;
        e->n_crease++;
        e->on_crease += place & ON_CREASE ? square : 0;
        e->n_on_crease += (place & ON_CREASE) != 0;
    }
}

static struct dx_quality_smooth errors_of(const struct dx_quality_rig *rig,
                                          const struct dx_plane *plane, const uint8_t *place,
                                          const double s[3])
{
    const double unit = (double)rig->geometry->unit_m;
    struct errors e = {0};

    for (uint32_t i = 0; i < plane->height; i++)
        for (uint32_t j = 0; j < plane->width; j++) {
            const size_t k = (size_t)i * plane->width + j;
            const double r = dx_quality_sight(rig, i, j)->range;
            const uint32_t range = dx_plane_range(plane, k);

            if (range && !isinf(r))
                add_error(&e, place[k], (unit * range - r) / (s[0] + r * (s[1] + r * s[2])));
        }
    return (struct dx_quality_smooth){.flat = root_mean(e.flat, e.n_flat),
                                      .crease = root_mean(e.crease, e.n_crease),
                                      .silhouette = root_mean(e.silhouette, e.n_silhouette),
                                      .on_crease = root_mean(e.on_crease, e.n_on_crease)};
}

static double largest_move(const struct dx_quality_rig *rig, const struct dx_plane *plane,
                           const double s[3])
{
    const double unit = (double)rig->geometry->unit_m;
    double most = 0;

    for (size_t k = 0; k < dx_plane_n_dexels(plane); k++) {
        const double r = unit * dx_plane_range(&rig->frame, k);
        const double d = fabs(unit * dx_plane_range(plane, k) - r) / (s[0] + r * (s[1] + r * s[2]));

        most = d > most ? d : most;
    }
    return most;
}

int dx_quality_smooth(struct dx_quality_smooth out[3], struct dx_quality_rig *rig,
                      const struct dx_quality_draw *draw)
{
    const struct dx_quality_draw quiet = {.seed = draw->seed};
    const size_t n_dexels = dx_plane_n_dexels(&rig->frame);
    uint8_t *place = calloc(n_dexels, 1);
    struct dx_terrain_params p;
    int rc = -ENOMEM;

    assert(n_dexels > 0);
    if (!place)
        return rc;
    find_places(place, rig);
    dx_quality_rig_draw(rig, &quiet);
    memcpy(rig->scene.sigma, draw->sigma, sizeof(rig->scene.sigma));
    p = dx_quality_rig_params(rig);
    p.smooth = true;
    rc = dx_quality_rig_mesh(rig, &p);
    if (rc == 0)
        out[2] = errors_of(rig, dx_terrain_published(rig->terrain), place, draw->sigma);
    dx_quality_rig_draw(rig, draw);
    if (rc == 0)
        rc = dx_quality_rig_mesh(rig, &p);
    if (rc == 0) {
        const struct dx_plane *plane = dx_terrain_published(rig->terrain);

        out[0] = errors_of(rig, &rig->frame, place, draw->sigma);
        out[1] = errors_of(rig, plane, place, draw->sigma);
        out[1].largest_move = largest_move(rig, plane, draw->sigma);
    }
    free(place);
    return rc;
}

/* ---- the theme ------------------------------------------------------------------------------- */

static int smooth_row(struct dx_quality_table *t, struct dx_quality_rig *rig,
                      const struct dx_quality_draw *draw)
{
    struct dx_quality_smooth s[3];
    struct dx_quality_row *row;
    int rc = dx_quality_smooth(s, rig, draw);

    if (rc)
        return rc;
    row = dx_quality_row(t, &rig->scene);
    row->value[0] = s[0].flat;
    row->value[1] = s[1].flat;
    row->value[2] = s[0].crease;
    row->value[3] = s[1].crease;
    row->value[4] = s[0].silhouette;
    row->value[5] = s[1].silhouette;
    row->value[6] = s[2].on_crease;
    row->value[7] = s[1].largest_move;
    dx_quality_hold(row, 1, DX_QUALITY_AT_MOST, 0.35);
    dx_quality_hold(row, 3, DX_QUALITY_AT_MOST, 0.55);
    dx_quality_hold(row, 6, DX_QUALITY_AT_MOST, 1);
    return 0;
}

int dx_quality_theme_smooth(struct dx_quality_run *run)
{
    static const struct dx_quality_scan scans[] = {{DX_SCENE_HALL, 1500, 1000, false},
                                                   {DX_SCENE_HALL, 600, 400, false},
                                                   {DX_SCENE_OPEN, 1500, 1000, false},
                                                   {DX_SCENE_OPEN, 2048, 128, false}};
    static const double sigma_mm[] = {2, 10, 20};
    struct dx_quality_table t = {
        .theme = "smooth",
        .title = "Ranges smoothed along the beam",
        .text =
            "Root mean square distance of ranges from the true ones, in sigmas of the noise, "
            "before\n"
            "and after (in, out) smoothing by the default rules with the true noise, in units of "
            "1\n"
            "mm: on flat parts, and within three dexels of creases and of silhouettes, those "
            "being\n"
            "cells whose corners are of more than one face, and cells that are not smooth. The "
            "bias\n"
            "is what smoothing by the same noise does to ranges without any, at the corners of\n"
            "cells that a crease crosses. Moved most: how far a sample is from what became of it.",
        .column = {{"flat in", "flat_in", 3},
                   {"flat out", "flat_out", 3},
                   {"crease in", "crease_in", 3},
                   {"crease out", "crease_out", 3},
                   {"silhouette in", "silhouette_in", 3},
                   {"silhouette out", "silhouette_out", 3},
                   {"crease bias", "crease_bias", 3},
                   {"moved most", "moved_most", 2}},
    };
    int rc = 0;

    for (size_t c = 0; rc == 0 && c < sizeof(scans) / sizeof(scans[0]); c++) {
        struct dx_quality_rig *rig = NULL;

        rc = dx_quality_run_rig(&rig, run, &scans[c]);
        for (size_t k = 0; rc == 0 && k < sizeof(sigma_mm) / sizeof(sigma_mm[0]); k++) {
            const struct dx_quality_draw draw = {.sigma = {sigma_mm[k] * MM}, .seed = run->seed};

            rc = smooth_row(&t, rig, &draw);
        }
        dx_quality_rig_free(rig);
    }
    if (rc == 0)
        dx_quality_report_table(run->report, &t);
    return rc;
}
