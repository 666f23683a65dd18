/*
 * PLY: the vertices of a text header's element `vertex`, as text or binary of either byte order.
 * Elements before it are skipped, lists and all. What comes after is not looked at, but for the
 * faces of a mesh.
 */
#include "drivers/file/points_priv.h"
#include "drivers/file/triangles_priv.h"

#include "core/base/bytes.h"
#include "drivers/file/text_cursor.h"

#include <errno.h>
#include <math.h>
#include <string.h>

#define MAX_ELEMENTS   16
#define MAX_PROPERTIES 64

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

struct property {
    enum scalar type;
    bool is_list;
    enum scalar count_type;
    int axis; /* 0..2; -1: another */
    bool is_face;
};

struct element {
    uint32_t n;
    uint32_t n_properties;
    struct property property[MAX_PROPERTIES];
};

enum form { TEXT, LITTLE, BIG };

struct ply {
    enum form form;
    bool has_form;
    uint32_t n_elements;
    int vertex; /* the element; -1: none yet */
    int face;
    struct dx_triangle_list *triangles; /* NULL: faces are not wanted */
    struct element element[MAX_ELEMENTS];
    struct dx_text_cursor c; /* in the header, then in text data */
    struct dx_reader r;      /* in binary data */
    const uint8_t *start;
};

/* ---- header --------------------------------------------------------------------------------- */

static bool takes(struct dx_text_cursor *c, const char *word)
{
    return dx_text_next_word(c) && dx_text_takes(c, word);
}

static int take_scalar(struct dx_text_cursor *c, enum scalar *out)
{
    for (int k = 0; k < N_SCALARS; k++)
        if (takes(c, scalars[k].names[0]) || takes(c, scalars[k].names[1])) {
            *out = (enum scalar)k;
            return 0;
        }
    return dx_text_error(c, c->p, "a type, as float or uchar");
}

static int read_form(struct ply *s)
{
    static const char *const forms[] = {"ascii", "binary_little_endian", "binary_big_endian"};

    for (int k = 0; k < 3; k++)
        if (takes(&s->c, forms[k])) {
            s->form = (enum form)k;
            s->has_form = true;
            return 0;
        }
    return dx_text_error(&s->c, s->c.p, "ascii, binary_little_endian or binary_big_endian");
}

static int read_element(struct ply *s)
{
    struct element *e = &s->element[s->n_elements];
    const bool is_vertex = takes(&s->c, "vertex"), is_face = !is_vertex && takes(&s->c, "face");
    const char *q;
    uint64_t n;

    if (s->n_elements == MAX_ELEMENTS)
        return dx_text_error(&s->c, s->c.p, "at most 16 elements");
    if (!is_vertex && !is_face && dx_text_next_word(&s->c)) /* its name */
        while (!dx_text_ends_word(&s->c, s->c.p))
            s->c.p++;
    dx_text_next_word(&s->c);
    q = dx_number_parse_u64(s->c.p, s->c.end, &n);
    if (!q || n > DX_POINT_LIST_MAX)
        return dx_text_error(&s->c, s->c.p, "a number of elements, at most 2^30");
    s->c.p = q;
    if (is_vertex && s->vertex < 0)
        s->vertex = (int)s->n_elements;
    if (is_face && s->face < 0)
        s->face = (int)s->n_elements;
    *e = (struct element){.n = (uint32_t)n};
    s->n_elements++;
    return 0;
}

static int read_property(struct ply *s)
{
    static const char *const axes[] = {"x", "y", "z"};
    struct property p = {.axis = -1};
    struct element *e;
    int rc = 0;

    dx_text_next_word(&s->c);
    if (s->n_elements == 0)
        return dx_text_error(&s->c, s->c.p, "an element before its properties");
    e = &s->element[s->n_elements - 1];
    if (e->n_properties == MAX_PROPERTIES)
        return dx_text_error(&s->c, s->c.p, "at most 64 properties of an element");
    p.is_list = takes(&s->c, "list");
    if (p.is_list)
        rc = take_scalar(&s->c, &p.count_type);
    if (rc == 0)
        rc = take_scalar(&s->c, &p.type);
    for (int k = 0; k < 3 && rc == 0 && !p.is_list; k++)
        if (takes(&s->c, axes[k]))
            p.axis = k;
    p.is_face = rc == 0 && p.is_list && s->face == (int)s->n_elements - 1 &&
                (takes(&s->c, "vertex_indices") || takes(&s->c, "vertex_index"));
    e->property[e->n_properties++] = p;
    return rc;
}

/* One line; 1: it was the last. */
static int read_line(struct ply *s)
{
    int rc = 0;

    if (takes(&s->c, "end_header"))
        rc = 1;
    else if (takes(&s->c, "format"))
        rc = read_form(s);
    else if (takes(&s->c, "element"))
        rc = read_element(s);
    else if (takes(&s->c, "property"))
        rc = read_property(s);
    else if (!takes(&s->c, "comment") && !takes(&s->c, "obj_info"))
        return dx_text_error(&s->c, s->c.p, "a line of a PLY header");
    if (rc >= 0)
        dx_text_skip_line(&s->c);
    return rc;
}

static int read_header(struct ply *s)
{
    unsigned axes = 0;
    int rc;

    if (!takes(&s->c, "ply"))
        return dx_text_error(&s->c, s->c.p, "ply");
    dx_text_skip_line(&s->c);
    do
        rc = read_line(s);
    while (rc == 0);
    if (rc < 0)
        return rc;
    for (uint32_t k = 0; s->vertex >= 0 && k < s->element[s->vertex].n_properties; k++)
        if (s->element[s->vertex].property[k].axis >= 0)
            axes |= 1u << s->element[s->vertex].property[k].axis;
    if (!s->has_form || axes != 7)
        return dx_err_set(s->c.err, -EBADMSG,
                          "line %llu: the header ends, expected a format and vertices with x, y "
                          "and z",
                          (unsigned long long)s->c.line - 1);
    return 0;
}

/* ---- data ----------------------------------------------------------------------------------- */

static uint64_t reversed(uint64_t v, uint8_t len)
{
    return __builtin_bswap64(v) >> (64 - 8 * len);
}

static int take_binary(struct ply *s, enum scalar type, double *out)
{
    const uint8_t len = scalars[type].len;
    const size_t at = (size_t)(s->r.p - s->start);
    const uint8_t *p = dx_read_bytes(&s->r, len);
    uint64_t v;

    if (!p)
        return dx_err_set(s->c.err, -EBADMSG, "byte %zu: the file ends, expected more %s", at,
                          s->triangles ? "vertices or faces" : "vertices");
    v = len == 1 ? *p : len == 2 ? dx_get_u16(p) : len == 4 ? dx_get_u32(p) : dx_get_u64(p);
    if (s->form == BIG)
        v = reversed(v, len);
    switch (type) {
    case F32:
        *out = (double)dx_f32_from_bits((uint32_t)v);
        break;
    case F64:
        *out = dx_f64_from_bits(v);
        break;
    case I8:
    case I16:
    case I32:
        *out = (double)((int64_t)(v << (64 - 8 * len)) >> (64 - 8 * len));
        break;
    default:
        *out = (double)v;
    }
    return 0;
}

static int take_value(struct ply *s, enum scalar type, double *out)
{
    if (s->form != TEXT)
        return take_binary(s, type, out);
    dx_text_skip_blank_lines(&s->c);
    return dx_text_number(&s->c, out, "a number of a vertex");
}

static int take_property(struct ply *s, const struct property *p, double xyz[3])
{
    double n = 1, value = 0;
    struct dx_face face = {0};
    int rc = p->is_list ? take_value(s, p->count_type, &n) : 0;

    if (rc == 0 && !(n >= 0 && n <= DX_POINT_LIST_MAX))
        return dx_err_set(s->c.err, -EBADMSG, "%s %llu: a list of %.0f values, expected 0 to 2^30",
                          s->form == TEXT ? "line" : "before byte",
                          s->form == TEXT ? (unsigned long long)s->c.line
                                          : (unsigned long long)(s->r.p - s->start),
                          n);
    for (double k = 0; k < n && rc == 0; k++) {
        rc = take_value(s, p->type, &value);
        if (rc == 0 && p->is_face && s->triangles)
            rc = dx_face_add(&face, s->triangles, value, s->c.err);
    }
    if (p->axis >= 0)
        xyz[p->axis] = value;
    return rc;
}

static int take_element(struct ply *s, const struct element *e, double xyz[3])
{
    int rc = 0;

    for (uint32_t k = 0; k < e->n_properties && rc == 0; k++)
        rc = take_property(s, &e->property[k], xyz);
    return rc;
}

/* The least that an element takes: bytes, or a digit and a blank for each value. */
static uint64_t least_len(const struct ply *s, const struct element *e)
{
    uint64_t len = 0;

    for (uint32_t k = 0; k < e->n_properties; k++) {
        const struct property *p = &e->property[k];

        len += s->form == TEXT ? 2 : scalars[p->is_list ? p->count_type : p->type].len;
    }
    return len;
}

/* The last element that is wanted. */
static int last_of(const struct ply *s)
{
    return s->triangles && s->face > s->vertex ? s->face : s->vertex;
}

static int check_len(const struct ply *s)
{
    const uint64_t left = (uint64_t)(s->c.end - s->c.p);
    uint64_t least = 0;

    for (int k = 0; k <= last_of(s); k++)
        least += least_len(s, &s->element[k]) * s->element[k].n;
    if (left + 1 < least)
        return dx_err_set(s->c.err, -EBADMSG, "byte %zu: %llu bytes are left, expected %llu",
                          (size_t)((const uint8_t *)s->c.p - s->start), (unsigned long long)left,
                          (unsigned long long)least);
    return 0;
}

int dx_triangles_ply_parse(struct dx_triangle_list *list, struct dx_point_list *points,
                           const uint8_t *bytes, size_t len, struct dx_err *err)
{
    struct ply s = {.vertex = -1,
                    .face = -1,
                    .triangles = list,
                    .c = dx_text_cursor_init(bytes, len, err),
                    .start = bytes};
    double xyz[3] = {NAN, NAN, NAN};
    int rc = read_header(&s);

    if (rc >= 0)
        rc = check_len(&s);
    if (rc >= 0)
        rc = dx_point_list_reserve(points, s.element[s.vertex].n, err);
    if (rc < 0)
        return rc;
    s.r = dx_reader_init(s.c.p, (size_t)(s.c.end - s.c.p));
    for (int e = 0; e <= last_of(&s); e++)
        for (uint32_t k = 0; k < s.element[e].n && s.element[e].n_properties; k++) {
            rc = take_element(&s, &s.element[e], xyz);
            if (rc == 0 && e == s.vertex)
                rc = dx_point_list_add(points, xyz, err);
            if (rc < 0)
                return rc;
        }
    return 0;
}

static int ply_parse(struct dx_point_list *list, const uint8_t *bytes, size_t len,
                     struct dx_err *err)
{
    return dx_triangles_ply_parse(NULL, list, bytes, len, err);
}

static bool ply_probe(const uint8_t *bytes, size_t len)
{
    return len >= 4 && memcmp(bytes, "ply", 3) == 0 && (bytes[3] == '\n' || bytes[3] == '\r');
}

const struct dx_points_format dx_points_ply = {".ply", ply_probe, ply_parse};
