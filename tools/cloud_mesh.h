/* A cloud's mesh, collected from the mode that makes it. One thread. */
#ifndef DX_CLOUD_MESH_H
#define DX_CLOUD_MESH_H

#include "core/cloud/project.h"
#include "tools/out_mesh.h"

/* Bytes that a cloud of n points and its mesh take beside the input, at most but for odd inputs. */
size_t dx_cloud_mesh_most_len(uint32_t n);

/*
 * Points of xyz that a triangle uses, in the order of the input, and the triangles. Where a float
 * does not hold the points, vertices are relative to a whole offset, which `write` adds again.
 * `progress` goes to standard error. Errors: as dx_project; then *mesh is zeroed.
 */
int dx_cloud_mesh(struct dx_mesh *mesh, struct dx_project_stats *stats, const struct dx_cloud *c,
                  const double *xyz, const struct dx_project_config *config, bool progress,
                  struct dx_out_options *write, struct dx_err *err);

#endif
