/* Which writer, and the way from a mesh to a whole file. */
#include "tools/out_mesh.h"

#include "tools/out_file.h"

#include <errno.h>
#include <string.h>
#include <strings.h>

static const struct dx_mesh_writer *const writers[] = {
    &dx_mesh_writer_ply,
    &dx_mesh_writer_obj,
    &dx_mesh_writer_stl,
};

const struct dx_mesh_writer *dx_mesh_writer_for(const char *path, struct dx_err *err)
{
    const char *slash = strrchr(path, '/'), *dot = strrchr(slash ? slash : path, '.');

    for (size_t k = 0; dot && k < sizeof(writers) / sizeof(writers[0]); k++)
        if (strcasecmp(dot + 1, writers[k]->extension) == 0)
            return writers[k];
    dx_err_set(err, -EINVAL, "%s: found extension '%s', expected .ply, .obj or .stl", path,
               dot ? dot : "");
    return NULL;
}

int dx_out_mesh(const char *path, const struct dx_mesh *mesh, const struct dx_out_options *options,
                struct dx_err *err)
{
    const struct dx_mesh_writer *writer = dx_mesh_writer_for(path, err);
    struct dx_out_file file;
    int rc;

    if (!writer)
        return -EINVAL;
    rc = dx_out_file_open(&file, path, err);
    if (rc < 0)
        return rc;
    writer->write(file.stream, mesh, options);
    return dx_out_file_commit(&file, err);
}

void dx_out_vertex(double p[3], const struct dx_mesh *mesh, size_t v,
                   const struct dx_out_options *options)
{
    const float *q = mesh->xyz + 3 * v;
    const double *m = options->pose;

    for (int k = 0; k < 3; k++)
        p[k] = options->world ? m[4 * k] * (double)q[0] + m[4 * k + 1] * (double)q[1] +
                                    m[4 * k + 2] * (double)q[2] + m[4 * k + 3]
                              : (double)q[k];
}

void dx_out_normal(double n[3], const struct dx_mesh *mesh, size_t v,
                   const struct dx_out_options *options)
{
    const float *q = mesh->normal + 3 * v;
    const double *m = options->pose;

    for (int k = 0; k < 3; k++)
        n[k] = options->world ? m[4 * k] * (double)q[0] + m[4 * k + 1] * (double)q[1] +
                                    m[4 * k + 2] * (double)q[2]
                              : (double)q[k];
}
