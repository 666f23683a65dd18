/*
 * Writers of meshes, chosen by the extension of the output: PLY, OBJ, STL. A writer is a room of
 * its own (out_ply.c, ...) that puts a welded mesh on a stream; whether the stream failed is asked
 * once, at the end.
 */
#ifndef DX_OUT_MESH_H
#define DX_OUT_MESH_H

#include "core/base/err.h"
#include "tools/mesh.h"

#include <stdbool.h>
#include <stdio.h>

struct dx_out_options {
    bool ascii;      /* PLY as text */
    bool world;      /* vertices and normals by the pose, in double where the format holds it */
    double pose[12]; /* rows of [R|t], scanner to world */
};

struct dx_mesh_writer {
    const char *extension; /* "ply" */
    void (*write)(FILE *stream, const struct dx_mesh *mesh, const struct dx_out_options *options);
};

extern const struct dx_mesh_writer dx_mesh_writer_ply, dx_mesh_writer_obj, dx_mesh_writer_stl;

/* The writer for a path; NULL (and err) when its extension is none of ours. */
const struct dx_mesh_writer *dx_mesh_writer_for(const char *path, struct dx_err *err);

/* Writes the mesh; on failure there is no file, or the one from before. Errors: -errno. */
int dx_out_mesh(const char *path, const struct dx_mesh *mesh, const struct dx_out_options *options,
                struct dx_err *err);

/* A vertex, or its normal, as it is written: the scanner's own, or by the pose. */
void dx_out_vertex(double p[3], const struct dx_mesh *mesh, size_t v,
                   const struct dx_out_options *options);
void dx_out_normal(double n[3], const struct dx_mesh *mesh, size_t v,
                   const struct dx_out_options *options);

#endif
