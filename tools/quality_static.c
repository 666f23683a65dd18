/* What frame after frame of a scene that stands still does to the published array and its tiles. */
#include "tools/quality.h"

#include <math.h>
#include <stdio.h>

#define MM 1e-3

/* ---- the figure ------------------------------------------------------------------------------ */

static double published_rms(const struct dx_quality_rig *rig, const struct dx_terrain *t)
{
    const struct dx_plane *plane = dx_terrain_published(t);
    const double *s = rig->scene.sigma;
    double sum = 0, unit = (double)rig->geometry->unit_m;
    uint64_t n = 0;

    for (uint32_t i = 0; i < plane->height; i++)
        for (uint32_t j = 0; j < plane->width; j++) {
            uint32_t range = dx_plane_range(plane, (size_t)i * plane->width + j);
            double r = dx_quality_sight(rig, i, j)->range, e;

            if (!range || isinf(r))
                continue;
            e = (unit * range - r) / (s[0] + r * (s[1] + r * s[2]));
            sum += e * e;
            n++;
        }
    return n ? sqrt(sum / (double)n) : 0;
}

int dx_quality_static(struct dx_quality_static *out, struct dx_quality_rig *rig,
                      const struct dx_terrain_params *params, const struct dx_quality_draw *draw,
                      uint32_t settling, uint32_t n_frames)
{
    struct dx_quality_draw next = *draw;
    struct dx_terrain *t;
    uint64_t n_changed = 0;
    int rc = dx_terrain_new(&t, rig->geometry, params, 0);

    if (rc < 0)
        return rc;
    for (next.frame = 0; next.frame < n_frames; next.frame++) {
        uint32_t n;

        dx_quality_rig_draw(rig, &next);
        dx_terrain_publish(t, &rig->frame, 0, rig->frame.width, NULL);
        n = dx_terrain_commit(t, NULL);
        n_changed += next.frame >= settling ? n : 0;
    }
    out->rms_sigma = published_rms(rig, t);
    out->changed = (double)n_changed /
                   ((double)dx_tiling_n_tiles(&rig->tiling) * (double)(n_frames - settling));
    dx_terrain_free(t);
    return 0;
}

/* ---- the theme ------------------------------------------------------------------------------- */

/* Frames `settling` to `n_frames` of the hall, counted from 1 in the note. */
static int static_row(struct dx_quality_table *t, struct dx_quality_rig *rig,
                      const struct dx_quality_draw *draw, uint32_t settling, uint32_t n_frames,
                      bool smooth)
{
    struct dx_quality_static s;
    struct dx_terrain_params p;
    struct dx_quality_row *row;
    int rc;

    dx_quality_rig_draw(rig, draw);
    p = dx_quality_rig_params(rig);
    p.ingest.filter = DX_FILTER_MEAN;
    p.smooth = smooth;
    rc = dx_quality_static(&s, rig, &p, draw, settling, n_frames);
    if (rc < 0)
        return rc;
    row = dx_quality_row(t, &rig->scene);
    snprintf(row->note, sizeof(row->note), "frames %u to %u%s", settling + 1, n_frames,
             smooth ? ", smoothed" : "");
    row->value[0] = draw->sigma[0] > 0 ? s.rms_sigma : NAN;
    row->value[1] = 100 * s.changed;
    return 0;
}

int dx_quality_theme_static(struct dx_quality_run *run)
{
    static const struct {
        double sigma;
        uint32_t settling, n_frames;
        double rms_bar, changed_bar; /* 0: the first has none */
        bool smooth;
    } cases[] = {{0, 1, 8, 0, 0, false},
                 {10 * MM, 16, 64, 0.25, 15, false},
                 {10 * MM, 64, 128, 0, 2, false},
                 {10 * MM, 16, 64, 0.12, 15, true},
                 {10 * MM, 64, 128, 0.1, 2, true}};
    const struct dx_quality_scan hall = {DX_SCENE_HALL, 600, 400, false};
    struct dx_quality_table t = {
        .theme = "static",
        .title = "Scenes that stand still",
        .text =
            "Root mean square distance of the published ranges from the true ones, in sigmas of\n"
            "the noise, after the last frame; and the share of tiles that a frame changes, in\n"
            "the mean. Smoothed along the beam besides in the last two rows.",
        .column = {{"rms / sigma", "rms_sigma", 4}, {"tiles %", "changed_percent", 2}},
    };
    struct dx_quality_rig *rig = NULL;
    int rc = dx_quality_run_rig(&rig, run, &hall);

    for (size_t k = 0; rc == 0 && k < sizeof(cases) / sizeof(cases[0]); k++) {
        const struct dx_quality_draw draw = {.sigma = {cases[k].sigma}, .seed = run->seed};
        struct dx_quality_row *row = &t.row[t.n_rows];

        rc = static_row(&t, rig, &draw, cases[k].settling, cases[k].n_frames, cases[k].smooth);
        if (rc == 0 && cases[k].rms_bar > 0)
            dx_quality_hold(row, 0, DX_QUALITY_AT_MOST, cases[k].rms_bar);
        if (rc == 0)
            dx_quality_hold(row, 1, DX_QUALITY_AT_MOST, cases[k].changed_bar);
    }
    dx_quality_rig_free(rig);
    if (rc == 0)
        dx_quality_report_table(run->report, &t);
    return rc;
}
