/* Reads binary little-endian PLY meshes, as out_ply.c writes them: the file is not trusted. */
#ifndef DX_PLY_READ_H
#define DX_PLY_READ_H

#include "core/base/err.h"
#include "tools/mesh.h"

#include <stdbool.h>

/* The file at `path` begins as a PLY does. */
bool dx_ply_probe(const char *path);

/* Errors: -errno, -EBADMSG (with the line or byte offset, what was found, what was expected),
 * -ENOMEM; then *mesh is zeroed. */
int dx_ply_read(struct dx_mesh *mesh, const char *path, struct dx_err *err);

/* The same for bytes in memory. */
int dx_ply_parse(struct dx_mesh *mesh, const uint8_t *bytes, size_t len, struct dx_err *err);

#endif
