/*
 * Repair as commands have it: dexel mesh --repair of a mesh file, and the same options after any
 * mode. One thread.
 */
#ifndef DX_MESH_REPAIR_RUN_H
#define DX_MESH_REPAIR_RUN_H

#include "core/base/err.h"
#include "tools/mesh_repair.h"

#include <getopt.h>
#include <jansson.h>
#include <stdbool.h>

struct dx_mesh_repair_args {
    bool asked;
    uint32_t max_hole;
};

enum { DX_OPTION_REPAIR = 400, DX_OPTION_REPAIR_HOLES };

/* clang-format off */
#define DX_REPAIR_OPTIONS                                                                          \
    {"repair", no_argument, NULL, DX_OPTION_REPAIR},                                               \
    {"repair-holes", required_argument, NULL, DX_OPTION_REPAIR_HOLES}
/* clang-format on */

#define DX_REPAIR_HELP                                                                             \
    "  --repair            make it a manifold whose triangles agree on their side, without small " \
    "holes\n"                                                                                      \
    "  --repair-holes N    the same, and close holes of at most N edges, 0 to 64 (16)\n"

void dx_mesh_repair_args_default(struct dx_mesh_repair_args *a);
/* One of the two. 0; -EINVAL having said why. */
int dx_mesh_repair_args_set(struct dx_mesh_repair_args *a, int opt, const char *text);

/* Repairs when it was asked for, and tells on standard error what was mended in the mesh of `path`.
 * Errors: -errno with text. */
int dx_mesh_repair_run(struct dx_mesh *mesh, struct dx_mesh_repair *counts,
                       const struct dx_mesh_repair_args *a, const char *path, struct dx_err *err);
json_t *dx_mesh_repair_json(const struct dx_mesh_repair *counts);

/* The command line asks to repair a mesh: it names no mode. */
bool dx_mesh_repair_asked(int argc, char **argv);
/* The exit status. */
int dx_mesh_repair_command(int argc, char **argv);

#endif
