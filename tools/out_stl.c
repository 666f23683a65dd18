/* Binary STL: 80 bytes of text that must not begin with "solid", u32 count, 50 bytes a triangle.
 * f32 only. */
#include "core/base/bytes.h"
#include "tools/out_mesh.h"

#include <math.h>

/* Unit normal by the right-hand rule; zero where the triangle has no area. */
static void normal_of(double n[3], const double a[3], const double b[3], const double c[3])
{
    double u[3], v[3], len;

    for (int k = 0; k < 3; k++) {
        u[k] = b[k] - a[k];
        v[k] = c[k] - a[k];
    }
    n[0] = u[1] * v[2] - u[2] * v[1];
    n[1] = u[2] * v[0] - u[0] * v[2];
    n[2] = u[0] * v[1] - u[1] * v[0];
    len = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int k = 0; k < 3; k++)
        n[k] = len > 0 ? n[k] / len : 0;
}

static void write_stl(FILE *f, const struct dx_mesh *mesh, const struct dx_out_options *options)
{
    uint8_t record[84] = {0};

    snprintf((char *)record, 80, "dexel " DEXELD_VERSION ", metres, %s frame",
             options->world ? "world" : "scanner");
    dx_put_u32(record + 80, mesh->n_triangles);
    fwrite(record, 1, 84, f);
    for (size_t t = 0; t < mesh->n_triangles; t++) {
        struct dx_writer w = dx_writer_init(record, 50);
        double p[4][3]; /* the normal, then the corners */

        for (size_t k = 0; k < 3; k++)
            dx_out_vertex(p[k + 1], mesh, mesh->index[3 * t + k], options);
        normal_of(p[0], p[1], p[2], p[3]);
        for (int k = 0; k < 12; k++)
            dx_write_f32(&w, (float)p[k / 3][k % 3]);
        dx_write_u16(&w, 0);
        fwrite(record, 1, 50, f);
    }
}

const struct dx_mesh_writer dx_mesh_writer_stl = {"stl", write_stl};
