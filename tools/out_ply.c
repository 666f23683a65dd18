/*
 * PLY, binary little-endian or text. An attribute is written as `intensity`, and as a grey that
 * viewers show: 8 bits as they are, 16 bits scaled by the mesh's largest.
 */
#include "core/base/bytes.h"
#include "tools/out_mesh.h"

static uint16_t largest_attr(const struct dx_mesh *mesh)
{
    uint16_t max = 1;

    for (size_t v = 0; v < mesh->n_vertices; v++)
        max = mesh->attr[v] > max ? mesh->attr[v] : max;
    return max;
}

static uint8_t grey_of(uint16_t attr, uint8_t attr_bytes, uint16_t largest)
{
    if (attr_bytes == 1)
        return (uint8_t)attr;
    return (uint8_t)(((uint32_t)attr * 255 + largest / 2) / largest);
}

static void put_header(FILE *f, const struct dx_mesh *mesh, const struct dx_out_options *options)
{
    const char *real = options->world ? "double" : "float";

    fprintf(f, "ply\nformat %s 1.0\ncomment dexel " DEXELD_VERSION ", metres, %s frame\n",
            options->ascii ? "ascii" : "binary_little_endian",
            options->world ? "world" : "scanner");
    fprintf(f, "element vertex %u\nproperty %s x\nproperty %s y\nproperty %s z\n", mesh->n_vertices,
            real, real, real);
    if (mesh->normal)
        fprintf(f, "property float nx\nproperty float ny\nproperty float nz\n");
    if (mesh->attr_bytes)
        fprintf(f,
                "property %s intensity\nproperty uchar red\nproperty uchar green\n"
                "property uchar blue\n",
                mesh->attr_bytes == 1 ? "uchar" : "ushort");
    fprintf(f, "element face %u\nproperty list uchar int vertex_indices\nend_header\n",
            mesh->n_triangles);
}

static void put_text(FILE *f, const struct dx_mesh *mesh, const struct dx_out_options *options,
                     uint16_t largest)
{
    double p[3];

    for (size_t v = 0; v < mesh->n_vertices; v++) {
        dx_out_vertex(p, mesh, v, options);
        fprintf(f, options->world ? "%.17g %.17g %.17g" : "%.9g %.9g %.9g", p[0], p[1], p[2]);
        if (mesh->normal) {
            dx_out_normal(p, mesh, v, options);
            fprintf(f, " %.9g %.9g %.9g", p[0], p[1], p[2]);
        }
        if (mesh->attr_bytes) {
            unsigned grey = grey_of(mesh->attr[v], mesh->attr_bytes, largest);

            fprintf(f, " %u %u %u %u", mesh->attr[v], grey, grey, grey);
        }
        putc('\n', f);
    }
    for (size_t t = 0; t < mesh->n_triangles; t++)
        fprintf(f, "3 %u %u %u\n", mesh->index[3 * t], mesh->index[3 * t + 1],
                mesh->index[3 * t + 2]);
}

static void put_binary(FILE *f, const struct dx_mesh *mesh, const struct dx_out_options *options,
                       uint16_t largest)
{
    uint8_t record[3 * 8 + 3 * 4 + 2 + 3];
    double p[3];

    for (size_t v = 0; v < mesh->n_vertices; v++) {
        struct dx_writer w = dx_writer_init(record, sizeof(record));

        dx_out_vertex(p, mesh, v, options);
        for (int k = 0; k < 3; k++) {
            if (options->world)
                dx_write_f64(&w, p[k]);
            else
                dx_write_f32(&w, (float)p[k]);
        }
        if (mesh->normal)
            dx_out_normal(p, mesh, v, options);
        for (int k = 0; mesh->normal && k < 3; k++)
            dx_write_f32(&w, (float)p[k]);
        if (mesh->attr_bytes == 1)
            dx_write_u8(&w, (uint8_t)mesh->attr[v]);
        if (mesh->attr_bytes == 2)
            dx_write_u16(&w, mesh->attr[v]);
        for (int k = 0; mesh->attr_bytes && k < 3; k++)
            dx_write_u8(&w, grey_of(mesh->attr[v], mesh->attr_bytes, largest));
        fwrite(record, 1, (size_t)(w.p - record), f);
    }
    for (size_t t = 0; t < mesh->n_triangles; t++) {
        record[0] = 3;
        for (size_t k = 0; k < 3; k++)
            dx_put_u32(record + 1 + 4 * k, mesh->index[3 * t + k]);
        fwrite(record, 1, 13, f);
    }
}

static void write_ply(FILE *f, const struct dx_mesh *mesh, const struct dx_out_options *options)
{
    uint16_t largest = mesh->attr_bytes == 2 ? largest_attr(mesh) : 1;

    put_header(f, mesh, options);
    if (options->ascii)
        put_text(f, mesh, options, largest);
    else
        put_binary(f, mesh, options, largest);
}

const struct dx_mesh_writer dx_mesh_writer_ply = {"ply", write_ply};
