/*
 * dexel mesh of unorganized points, by any mode of the table: the front end that modes share
 * (mesh_mode.h tells how one is added). Its options are read in mesh_cloud_args.c. One thread.
 */
#ifndef DX_MESH_CLOUD_H
#define DX_MESH_CLOUD_H

#include "tools/cloud_read.h"
#include "tools/mesh_mode.h"
#include "tools/mesh_repair_run.h"

struct dx_mesh_cloud_args {
    const struct dx_mesh_mode *mode;
    void *config; /* the mode's parameters */
    struct dx_cloud_source source;
    const char *out;
    double viewpoint[3];
    unsigned n_threads;
    uint64_t memory_mb; /* 0: what is free */
    struct dx_mesh_repair_args repair;
    bool has_viewpoint, ascii, stats, progress;
};

/* 0; DX_ARG_E_HELP; -EINVAL having said why, -ENOMEM. To be freed in each case. */
int dx_mesh_cloud_args_parse(struct dx_mesh_cloud_args *a, const struct dx_mesh_mode *mode,
                             int argc, char **argv);
void dx_mesh_cloud_args_fini(struct dx_mesh_cloud_args *a);

/* The exit status. */
int dx_mesh_cloud(const struct dx_mesh_mode *mode, int argc, char **argv);

#endif
