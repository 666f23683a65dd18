/* The run of dexel mesh --mode smooth: stages in turn, timed, with what each has found and made.
 * One thread, which hands work to the job's pool. */
#ifndef DX_MESH_SMOOTH_H
#define DX_MESH_SMOOTH_H

#include "core/cloud/smooth_stages.h"
#include "tools/mesh_mode.h"

enum dx_smooth_stage {
    DX_STAGE_SMOOTH,
    DX_STAGE_CLUSTER,
    DX_STAGE_REDUCE,
    DX_STAGE_GROW,
    DX_STAGE_REFINE,
    DX_N_SMOOTH_STAGES,
};

extern const char *const dx_smooth_stages[DX_N_SMOOTH_STAGES];

/* Parameters as the options have them; 0 where they are found. */
struct dx_smooth_job_config {
    const char *stages; /* NULL: all */
    uint32_t n_passes;
    int fit, split;
    double sw, sr;
    double max_variation;
    uint32_t min_points, max_points;
    double max_bend_deg, max_angle_deg, max_ratio;
    uint32_t max_loop;
    uint32_t n_refine;
    double tolerance;
};

/* `stages`: bits. */
int dx_smooth_job_run(const struct dx_mesh_job *job, const struct dx_smooth_job_config *config,
                      unsigned stages, struct dx_err *err);

#endif
