/*
 * What --stats prints: one JSON object on standard output, numbers of the mesh under the same names
 * in every command. Owned by one thread.
 */
#ifndef DX_STATS_JSON_H
#define DX_STATS_JSON_H

#include "tools/mesh_stats.h"

#include <jansson.h>

/* An object with the statistics of a mesh; NULL: out of memory. */
json_t *dx_stats_json(const struct dx_mesh_stats *stats);
/* [s0, s1, s2] */
json_t *dx_sigma_json(const double sigma[3]);

/* Prints and frees the object (NULL: out of memory). 0; -errno: standard output cannot be
 * written, which main tells; -ENOMEM, having said so. */
int dx_json_print(json_t *object, const char *command);

#endif
