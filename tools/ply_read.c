/*
 * A header of lines, then vertex records of fixed length, then faces of three indices. Elements
 * other than vertex and face, and lists other than the faces', are refused.
 */
#include "tools/ply_read.h"

#include "core/base/bytes.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum scalar { I8, U8, I16, U16, I32, U32, F32, F64, N_SCALARS };

static const struct {
    const char *names[2];
    uint8_t len;
} scalars[N_SCALARS] = {
    [I8] = {{"char", "int8"}, 1},      [U8] = {{"uchar", "uint8"}, 1},
    [I16] = {{"short", "int16"}, 2},   [U16] = {{"ushort", "uint16"}, 2},
    [I32] = {{"int", "int32"}, 4},     [U32] = {{"uint", "uint32"}, 4},
    [F32] = {{"float", "float32"}, 4}, [F64] = {{"double", "float64"}, 8},
};

/* What the header says: where the wanted values are in a vertex record. */
enum { X, Y, Z, INTENSITY, N_WANTED };

struct layout {
    uint64_t n_vertices, n_faces;
    size_t vertex_len;
    struct {
        size_t offset;
        int type; /* enum scalar; -1: not there */
    } wanted[N_WANTED];
    int element; /* the one whose properties come: 0 none, 1 vertex, 2 face */
    bool binary, faces_listed;
    unsigned line;
};

static int bad_line(const struct layout *l, const char *line, const char *expected,
                    struct dx_err *err)
{
    return dx_err_set(err, -EBADMSG, "line %u: found '%.60s', expected %s", l->line, line,
                      expected);
}

static int scalar_of(const char *name)
{
    for (int k = 0; k < N_SCALARS; k++)
        if (strcmp(name, scalars[k].names[0]) == 0 || strcmp(name, scalars[k].names[1]) == 0)
            return k;
    return -1;
}

static int add_property(struct layout *l, const char *line, struct dx_err *err)
{
    static const char *const names[N_WANTED] = {"x", "y", "z", "intensity"};
    char type[16], name[64];
    int t = -1;

    if (sscanf(line, "property %15s %63s", type, name) == 2)
        t = scalar_of(type);
    if (t < 0)
        return bad_line(l, line, "property TYPE NAME", err);
    for (int k = 0; k < N_WANTED; k++)
        if (strcmp(name, names[k]) == 0) {
            l->wanted[k].offset = l->vertex_len;
            l->wanted[k].type = t;
        }
    l->vertex_len += scalars[t].len;
    return l->vertex_len > 4096 ? bad_line(l, line, "vertices of at most 4096 bytes", err) : 0;
}

static int read_element(struct layout *l, const char *line, struct dx_err *err)
{
    char name[16];
    unsigned long long n;

    if (sscanf(line, "element %15s %llu", name, &n) != 2)
        return bad_line(l, line, "element NAME COUNT", err);
    if (strcmp(name, "vertex") == 0 && l->element == 0 && n < DX_MESH_MAX_VERTICES) {
        l->element = 1;
        l->n_vertices = n;
    } else if (strcmp(name, "face") == 0 && l->element == 1 && n < DX_MESH_MAX_TRIANGLES) {
        l->element = 2;
        l->n_faces = n;
    } else {
        return bad_line(l, line, "vertices, then faces, of sensible numbers", err);
    }
    return 0;
}

static bool is_face_list(const char *line)
{
    char name[64];

    return sscanf(line, "property list uchar int %63s", name) == 1 ||
           sscanf(line, "property list uint8 int32 %63s", name) == 1 ||
           sscanf(line, "property list uchar uint %63s", name) == 1;
}

static int read_line(struct layout *l, const char *line, struct dx_err *err)
{
    if (l->line == 1)
        return strcmp(line, "ply") == 0 ? 0 : bad_line(l, line, "ply", err);
    if (strncmp(line, "comment", 7) == 0 || strncmp(line, "obj_info", 8) == 0)
        return 0;
    if (strcmp(line, "format binary_little_endian 1.0") == 0) {
        l->binary = true;
        return 0;
    }
    if (strncmp(line, "element ", 8) == 0)
        return read_element(l, line, err);
    if (l->element == 1)
        return add_property(l, line, err);
    if (l->element == 2 && !l->faces_listed && is_face_list(line)) {
        l->faces_listed = true;
        return 0;
    }
    return bad_line(l, line, "a binary_little_endian PLY with faces as 'list uchar int'", err);
}

/* Leaves the reader behind end_header. */
static int read_header(struct layout *l, struct dx_reader *r, struct dx_err *err)
{
    char line[256];

    *l = (struct layout){0};
    for (int k = 0; k < N_WANTED; k++)
        l->wanted[k].type = -1;
    for (;;) {
        const uint8_t *end =
            memchr(r->p, '\n', dx_reader_left(r) < sizeof(line) ? dx_reader_left(r) : sizeof(line));
        size_t len = end ? (size_t)(end - r->p) : 0;
        int rc;

        l->line++;
        if (!end)
            return dx_err_set(err, -EBADMSG, "line %u: found no end of line, expected end_header",
                              l->line);
        memcpy(line, r->p, len);
        line[len && line[len - 1] == '\r' ? len - 1 : len] = '\0';
        r->p = end + 1;
        if (strcmp(line, "end_header") == 0)
            break;
        rc = read_line(l, line, err);
        if (rc < 0)
            return rc;
    }
    if (!l->binary || !l->faces_listed || l->wanted[X].type < 0 || l->wanted[Y].type < 0 ||
        l->wanted[Z].type < 0)
        return bad_line(l, "end_header", "format, x, y, z and faces before it", err);
    return 0;
}

static double value_at(const uint8_t *p, int type)
{
    switch (type) {
    case I8:
        return (int8_t)*p;
    case U8:
        return *p;
    case I16:
        return (int16_t)dx_get_u16(p);
    case U16:
        return dx_get_u16(p);
    case I32:
        return (int32_t)dx_get_u32(p);
    case U32:
        return dx_get_u32(p);
    case F32:
        return (double)dx_f32_from_bits(dx_get_u32(p));
    default:
        return dx_f64_from_bits(dx_get_u64(p));
    }
}

static int read_vertices(struct dx_mesh *mesh, const struct layout *l, struct dx_reader *r,
                         struct dx_err *err)
{
    for (size_t v = 0; v < mesh->n_vertices; v++) {
        const uint8_t *p = dx_read_bytes(r, l->vertex_len); /* the length was checked */

        for (size_t k = 0; k < 3; k++) {
            float x = (float)value_at(p + l->wanted[k].offset, l->wanted[k].type);

            if (!isfinite(x))
                return dx_err_set(err, -EBADMSG,
                                  "vertex %zu: found a coordinate that is not finite", v);
            mesh->xyz[3 * v + k] = x;
        }
        if (mesh->attr)
            mesh->attr[v] =
                (uint16_t)value_at(p + l->wanted[INTENSITY].offset, l->wanted[INTENSITY].type);
    }
    return 0;
}

static int read_faces(struct dx_mesh *mesh, struct dx_reader *r, struct dx_err *err)
{
    for (size_t t = 0; t < mesh->n_triangles; t++) {
        uint8_t n = dx_read_u8(r);

        if (n != 3)
            return dx_err_set(err, -EBADMSG, "face %zu: found %u vertices, expected 3", t, n);
        for (size_t k = 0; k < 3; k++) {
            uint32_t v = dx_read_u32(r);

            if (v >= mesh->n_vertices)
                return dx_err_set(err, -EBADMSG, "face %zu: found vertex %u, expected less than %u",
                                  t, v, mesh->n_vertices);
            mesh->index[3 * t + k] = v;
        }
    }
    return 0;
}

int dx_ply_parse(struct dx_mesh *mesh, const uint8_t *bytes, size_t len, struct dx_err *err)
{
    struct dx_reader r = dx_reader_init(bytes, len);
    struct layout l;
    int attr_type, rc;

    *mesh = (struct dx_mesh){0};
    rc = read_header(&l, &r, err);
    if (rc < 0)
        return rc;
    /* Both products fit: counts below 2^31, records of at most 4096 bytes. */
    if (l.n_vertices * l.vertex_len + l.n_faces * 13 != dx_reader_left(&r))
        return dx_err_set(
            err, -EBADMSG,
            "byte %zu: found %zu bytes, expected %llu (%llu vertices, %llu triangles)",
            len - dx_reader_left(&r), dx_reader_left(&r),
            (unsigned long long)(l.n_vertices * l.vertex_len + l.n_faces * 13),
            (unsigned long long)l.n_vertices, (unsigned long long)l.n_faces);
    attr_type = l.wanted[INTENSITY].type;
    rc = dx_mesh_init(mesh, l.n_vertices, l.n_faces,
                      attr_type == U8    ? 1
                      : attr_type == U16 ? 2
                                         : 0,
                      0);
    if (rc < 0)
        return dx_err_set(err, rc, "%s", strerror(-rc));
    rc = read_vertices(mesh, &l, &r, err);
    if (rc == 0)
        rc = read_faces(mesh, &r, err);
    if (rc < 0)
        dx_mesh_fini(mesh);
    return rc;
}

bool dx_ply_probe(const char *path)
{
    char start[4] = "";
    FILE *f = fopen(path, "rb");

    if (!f)
        return false;
    if (fread(start, 1, 4, f) != 4)
        start[0] = 0;
    fclose(f);
    return memcmp(start, "ply", 3) == 0 && (start[3] == '\n' || start[3] == '\r');
}

static int slurp(uint8_t **bytes, size_t *len, const char *path)
{
    FILE *f = fopen(path, "rb");
    struct stat st;
    int rc = 0;

    if (!f)
        return -errno;
    if (fstat(fileno(f), &st) < 0) {
        rc = -errno;
    } else {
        *len = (size_t)st.st_size;
        *bytes = malloc(*len + 1);
        if (!*bytes)
            rc = -ENOMEM;
        else if (fread(*bytes, 1, *len, f) != *len)
            rc = -EIO;
    }
    fclose(f);
    return rc;
}

int dx_ply_read(struct dx_mesh *mesh, const char *path, struct dx_err *err)
{
    uint8_t *bytes = NULL;
    size_t len = 0;
    int rc = slurp(&bytes, &len, path);

    *mesh = (struct dx_mesh){0};
    if (rc < 0)
        dx_err_set(err, rc, "%s: %s", path, strerror(-rc));
    else {
        rc = dx_ply_parse(mesh, bytes, len, err);
        if (rc < 0)
            dx_err_prefix(err, path);
    }
    free(bytes);
    return rc;
}
