/*
 * A scan file or a recording meshed without the service: its frames into terrain mode into a mesh
 * store, by the same calls in the same order as the service makes. One thread, and a pool for the
 * tiles.
 */
#ifndef DX_OFFLINE_H
#define DX_OFFLINE_H

#include "core/base/err.h"
#include "tools/args.h"
#include "tools/lod_stats.h"
#include "tools/mesh_store.h"

#define DX_OFFLINE_LAST  UINT64_MAX /* frame: the last one */
#define DX_OFFLINE_PLAIN (-1)       /* encoding: none, tiles as they are */

struct dx_offline_config {
    const char *path;  /* file, directory or glob */
    const char *topic; /* of clouds in MCAP; NULL: the only one */
    struct dx_terrain_args terrain;
    struct dx_thin_options thin;
    bool exact;         /* vertices are the file's own points */
    uint64_t frame;     /* which frame of a sequence, from 0, or DX_OFFLINE_LAST */
    unsigned n_threads; /* 0: one a processor */
    struct dx_lod_level lod;
    bool lod_stats; /* fill struct dx_offline's */
    int encoding;   /* enum dx_encoding that tiles pass through, or DX_OFFLINE_PLAIN */
};

struct dx_offline {
    struct dx_mesh_store *mesh;
    struct dx_geometry *geometry;
    struct dx_terrain_params params; /* in force: sigma is the estimate */
    struct dx_fit_report fit;
    uint8_t attr_bytes;
    uint64_t frame;          /* the one meshed */
    double mesh_s;           /* computing its tiles */
    struct dx_lod_stats lod; /* when a level was asked for, and its statistics */
};

/* Errors: -errno with text (a corrupt frame, no such frame, ranges that q16 cannot carry, exact
 * points by their ranges); *o is then zeroed. */
int dx_offline_run(struct dx_offline *o, const struct dx_offline_config *config,
                   struct dx_err *err);
void dx_offline_fini(struct dx_offline *o);

/* After the last option: what the path takes. 0; -EINVAL having said why. */
int dx_offline_check(const struct dx_offline_config *config, const char *command);

#endif
