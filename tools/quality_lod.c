/* What levels of detail leave out, how far that is from what they keep, and whether they crack. */
#include "tools/lod_stats.h"
#include "tools/quality.h"

#include <stdio.h>

#define MM 1e-3

static int lod_rows(struct dx_quality_table *t, struct dx_quality_rig *rig)
{
    static const struct dx_lod_level levels[] = {
        {.bound = 1 * DX_LOD_PER_SIGMA},
        {.bound = 2 * DX_LOD_PER_SIGMA},
        {.bound = 4 * DX_LOD_PER_SIGMA},
        {.bound = 8 * DX_LOD_PER_SIGMA},
        {.stride = 8},
    };

    for (size_t k = 0; k < sizeof(levels) / sizeof(levels[0]); k++) {
        struct dx_lod_stats q;
        struct dx_quality_row *row;
        int rc = dx_lod_stats_compute(&q, rig->terrain, levels[k]);

        if (rc < 0)
            return rc;
        row = dx_quality_row(t, &rig->scene);
        if (levels[k].stride)
            snprintf(row->note, sizeof(row->note), "stride %u", levels[k].stride);
        else
            snprintf(row->note, sizeof(row->note), "%u sigma", levels[k].bound / DX_LOD_PER_SIGMA);
        row->value[0] = (double)q.triangles;
        row->value[1] = 100 * (double)q.triangles / (double)q.whole;
        row->value[2] = q.max_sigma;
        row->value[3] = q.rms_sigma;
        row->value[4] = (double)q.cracks;
        dx_quality_hold(row, 4, DX_QUALITY_AT_MOST, 0);
    }
    return 0;
}

int dx_quality_theme_lod(struct dx_quality_run *run)
{
    static const struct {
        struct dx_quality_scan scan;
        double sigma, dropout;
    } cases[] = {
        {{DX_SCENE_HALL, 600, 400, false}, 2 * MM, 0},
        {{DX_SCENE_HALL, 600, 400, false}, 10 * MM, 0},
        {{DX_SCENE_HALL, 600, 400, false}, 10 * MM, 0.01},
        {{DX_SCENE_OPEN, 600, 400, false}, 5 * MM, 0},
        {{DX_SCENE_MOVING_BOX, 640, 480, false}, 5 * MM, 0},
    };
    struct dx_quality_table t = {
        .theme = "lod",
        .title = "Levels of detail",
        .text =
            "Triangles of a level, and their share of the whole mesh's; how far the samples that "
            "it\n"
            "leaves out are from its surface along their beams, in sigmas, at most and root of "
            "the\n"
            "mean square (samples on the surface itself have 1); cracks are open edges that the\n"
            "whole mesh does not have.",
        .column = {{"triangles", "triangles", 0},
                   {"of whole %", "share_percent", 1},
                   {"max / sigma", "max_sigma", 1},
                   {"rms / sigma", "rms_sigma", 2},
                   {"cracks", "cracks", 0}},
    };
    int rc = 0;

    for (size_t k = 0; rc == 0 && k < sizeof(cases) / sizeof(cases[0]); k++) {
        const struct dx_quality_draw draw = {
            .sigma = {cases[k].sigma}, .dropout = cases[k].dropout, .seed = run->seed};
        struct dx_quality_rig *rig = NULL;
        struct dx_terrain_params p;

        rc = dx_quality_run_rig(&rig, run, &cases[k].scan);
        if (rc < 0)
            break;
        dx_quality_rig_draw(rig, &draw);
        p = dx_quality_rig_params(rig);
        rc = dx_quality_rig_mesh(rig, &p);
        if (rc == 0)
            rc = lod_rows(&t, rig);
        dx_quality_rig_free(rig);
    }
    if (rc == 0)
        dx_quality_report_table(run->report, &t);
    return rc;
}
