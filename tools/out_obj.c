/* Wavefront OBJ: v, vn and f lines, indices from 1. OBJ has no place for an attribute. */
#include "tools/out_mesh.h"

static void write_obj(FILE *f, const struct dx_mesh *mesh, const struct dx_out_options *options)
{
    double p[3];

    fprintf(f, "# dexel " DEXELD_VERSION ", metres, %s frame\n",
            options->world ? "world" : "scanner");
    for (size_t v = 0; v < mesh->n_vertices; v++) {
        dx_out_vertex(p, mesh, v, options);
        fprintf(f, options->world ? "v %.17g %.17g %.17g\n" : "v %.9g %.9g %.9g\n", p[0], p[1],
                p[2]);
    }
    for (size_t v = 0; mesh->normal && v < mesh->n_vertices; v++) {
        dx_out_normal(p, mesh, v, options);
        fprintf(f, "vn %.9g %.9g %.9g\n", p[0], p[1], p[2]);
    }
    for (size_t t = 0; t < mesh->n_triangles; t++) {
        uint32_t a = mesh->index[3 * t] + 1, b = mesh->index[3 * t + 1] + 1,
                 c = mesh->index[3 * t + 2] + 1;

        if (mesh->normal)
            fprintf(f, "f %u//%u %u//%u %u//%u\n", a, a, b, b, c, c);
        else
            fprintf(f, "f %u %u %u\n", a, b, c);
    }
}

const struct dx_mesh_writer dx_mesh_writer_obj = {"obj", write_obj};
