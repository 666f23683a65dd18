/*
 * PCD (Point Cloud Library): a text header, then points row by row as text, as packed structures,
 * or, after LZF compression, as one array per field. NaN or 0 0 0 is no return. The attribute is
 * `intensity` (8-bit unsigned times 257, 16-bit unsigned as it is, others by their range:
 * dx_xyz_frame_scale), else the luminance of `rgb` or `rgba` (bits 0x00RRGGBB, also when the type
 * says float).
 */
#include "drivers/file/format.h"

#include "core/base/bytes.h"
#include "drivers/file/pcd_header.h"

#include <errno.h>
#include <liblzf/lzf.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* An LZF match makes at most 264 bytes of 3. */
#define LZF_MAX_RATIO 88u

/* What of a point is used. */
struct roles {
    const struct dx_pcd_field *x, *y, *z;
    const struct dx_pcd_field *attr; /* NULL: none */
    bool colour;                     /* attr is packed RGB */
};

/* Values of one field, binary: that of point k is at base + k * stride. */
struct column {
    const uint8_t *base;
    size_t stride;
    uint32_t size;
    char type;
};

static int find_roles(struct roles *r, const struct dx_pcd_header *h, struct dx_err *err)
{
    static const char *const colours[] = {"rgb", "rgba"};

    *r = (struct roles){dx_pcd_field_find(h, "x"), dx_pcd_field_find(h, "y"),
                        dx_pcd_field_find(h, "z"), dx_pcd_field_find(h, "intensity"), false};
    if (!r->x || !r->y || !r->z)
        return dx_err_set(err, -EBADMSG, "FIELDS without x, y or z, expected all three");
    for (int k = 0; k < 2 && !r->attr; k++) {
        r->attr = dx_pcd_field_find(h, colours[k]);
        r->colour = r->attr != NULL;
    }
    return 0;
}

static uint64_t load_bits(const struct column *c, size_t k)
{
    const uint8_t *p = c->base + k * c->stride;

    switch (c->size) {
    case 1:
        return *p;
    case 2:
        return dx_get_u16(p);
    case 4:
        return dx_get_u32(p);
    default:
        return dx_get_u64(p);
    }
}

static double load(const struct column *c, size_t k)
{
    uint64_t bits = load_bits(c, k);
    unsigned spare = 64 - 8 * c->size;

    if (c->type == 'F')
        return c->size == 8 ? dx_f64_from_bits(bits) : (double)dx_f32_from_bits((uint32_t)bits);
    if (c->type == 'U')
        return (double)bits;
    return (double)((int64_t)(bits << spare) >> spare);
}

/* 8 bits of luminance (ITU-R BT.601). */
static uint16_t luminance(uint32_t rgb)
{
    uint32_t r = rgb >> 16 & 255, g = rgb >> 8 & 255, b = rgb & 255;

    return (uint16_t)((299 * r + 587 * g + 114 * b + 500) / 1000);
}

/* The bits of a colour that was written as a number. */
static uint32_t colour_of_number(double v, char type)
{
    if (type == 'F')
        return fabs(v) < 1e38 ? dx_f32_bits((float)v) : 0;
    return v > -2147483649.0 && v < 4294967296.0 ? (uint32_t)(int64_t)v : 0;
}

static float to_intensity(double v)
{
    return fabs(v) < 1e30 ? (float)v : 0;
}

/* Makes the attribute of what the points left in `intensity` or, for colours, in `attr_room`. */
static void finish_attr(struct dx_xyz_frame *f, const struct roles *r)
{
    size_t n = (size_t)f->height * f->width;
    uint16_t times;

    if (!r->attr)
        return;
    if (r->colour) {
        f->attr = f->attr_room;
        f->attr_bytes = 1;
        return;
    }
    if (r->attr->type != 'U' || r->attr->size > 2) {
        dx_xyz_frame_scale(f);
        return;
    }
    f->attr = f->attr_room;
    f->attr_bytes = 2;
    times = r->attr->size == 1 ? 257 : 1;
    for (size_t k = 0; k < n; k++)
        f->attr[k] = (uint16_t)(f->intensity[k] * times);
}

static struct column column_of(const struct dx_pcd_field *f, const uint8_t *data, size_t stride)
{
    return (struct column){data, stride, f->size, f->type};
}

#define BLOCK 256 /* points at a time */

/* Values [at, at + n) of a field; nearly all are f32. */
static void load_block(double *out, const struct column *c, size_t at, size_t n)
{
    const uint8_t *p = c->base + at * c->stride;

    if (c->type != 'F' || c->size != 4) {
        for (size_t j = 0; j < n; j++)
            out[j] = load(c, at + j);
        return;
    }
    for (size_t j = 0; j < n; j++)
        out[j] = (double)dx_f32_from_bits(dx_get_u32(p + j * c->stride));
}

static void take_attr(struct dx_xyz_frame *f, const struct column *attr, bool colour, size_t at,
                      size_t n)
{
    double v[BLOCK];

    if (colour) {
        for (size_t k = at; k < at + n; k++)
            f->attr_room[k] = luminance((uint32_t)load_bits(attr, k));
        return;
    }
    load_block(v, attr, at, n);
    for (size_t j = 0; j < n; j++)
        f->intensity[at + j] = to_intensity(v[j]);
}

static void take_columns(struct dx_xyz_frame *f, const struct column xyz[3],
                         const struct column *attr, bool colour)
{
    const size_t n_points = (size_t)f->height * f->width;

    for (size_t at = 0; at < n_points; at += BLOCK) {
        const size_t n = n_points - at < BLOCK ? n_points - at : BLOCK;
        double v[3][BLOCK];

        for (int k = 0; k < 3; k++)
            load_block(v[k], &xyz[k], at, n);
        for (size_t j = 0; j < n; j++)
            dx_xyz_frame_set(f, at + j, v[0][j], v[1][j], v[2][j]);
        if (attr)
            take_attr(f, attr, colour, at, n);
    }
}

static int too_short(const struct dx_text_cursor *c, const uint8_t *start, uint64_t expected)
{
    return dx_err_set(c->err, -EBADMSG, "byte %zu: %zu bytes are left, expected %llu",
                      (size_t)((const uint8_t *)c->p - start), (size_t)(c->end - c->p),
                      (unsigned long long)expected);
}

/* A header and the place of its data in a block. */
struct pcd {
    struct dx_pcd_header h;
    struct roles roles;
    struct dx_text_cursor c;
    const uint8_t *start; /* of the block */
};

static int decode_binary(struct dx_xyz_frame *out, const struct pcd *s)
{
    const struct roles *r = &s->roles;
    const uint8_t *data = (const uint8_t *)s->c.p;
    size_t stride = s->h.stride;
    struct column xyz[3] = {column_of(r->x, data + r->x->offset, stride),
                            column_of(r->y, data + r->y->offset, stride),
                            column_of(r->z, data + r->z->offset, stride)};
    struct column attr = {0};

    if (r->attr)
        attr = column_of(r->attr, data + r->attr->offset, stride);
    take_columns(out, xyz, r->attr ? &attr : NULL, r->colour);
    return 0;
}

/* Fields are whole arrays, in the order of the header. */
static struct column array_of(const struct pcd *s, const struct dx_pcd_field *f,
                              const uint8_t *data)
{
    size_t n = (size_t)s->h.width * s->h.height;

    return column_of(f, data + n * f->offset, (size_t)f->size * f->count);
}

static int decode_compressed(struct dx_xyz_frame *out, const struct pcd *s)
{
    const struct roles *r = &s->roles;
    const uint8_t *in = (const uint8_t *)s->c.p;
    uint32_t in_len = dx_get_u32(in), len = dx_get_u32(in + 4);
    uint8_t *data = malloc(len);

    if (!data)
        return dx_err_set(s->c.err, -ENOMEM, "no memory to decompress %u bytes", len);
    if (lzf_decompress(in + 8, in_len, data, len) != len) {
        free(data);
        return dx_err_set(s->c.err, -EBADMSG, "byte %zu: damaged LZF data, expected %u bytes of %u",
                          (size_t)(in + 8 - s->start), len, in_len);
    }
    struct column xyz[3] = {array_of(s, r->x, data), array_of(s, r->y, data),
                            array_of(s, r->z, data)};
    struct column attr = {0};

    if (r->attr)
        attr = array_of(s, r->attr, data);
    take_columns(out, xyz, r->attr ? &attr : NULL, r->colour);
    free(data);
    return 0;
}

/* One point: the values of a line that are used, in `v` x y z attribute. */
static int read_point(struct dx_text_cursor *c, const struct pcd *s, double v[4])
{
    const struct roles *r = &s->roles;

    for (uint32_t k = 0; k < s->h.n_values; k++) {
        double value;
        int rc = dx_text_number(c, &value, "a number for each field");

        if (rc)
            return rc;
        if (k == r->x->index)
            v[0] = value;
        else if (k == r->y->index)
            v[1] = value;
        else if (k == r->z->index)
            v[2] = value;
        else if (r->attr && k == r->attr->index)
            v[3] = value;
    }
    return dx_text_end_line(c);
}

static int decode_ascii(struct dx_xyz_frame *out, const struct pcd *s)
{
    struct dx_text_cursor c = s->c;
    size_t n = (size_t)out->height * out->width;

    for (size_t k = 0; k < n; k++) {
        double v[4] = {NAN, NAN, NAN, 0};
        int rc = read_point(&c, s, v);

        if (rc)
            return rc;
        dx_xyz_frame_set(out, k, v[0], v[1], v[2]);
        if (s->roles.colour)
            out->attr_room[k] = luminance(colour_of_number(v[3], s->roles.attr->type));
        else
            out->intensity[k] = to_intensity(v[3]);
    }
    dx_text_skip_blank_lines(&c);
    return c.p == c.end ? 0 : dx_text_error(&c, c.p, "the end of the file");
}

/* The data's length against the header's sizes, before anything is allocated. */
static int check_len(const struct pcd *s)
{
    uint64_t n = (uint64_t)s->h.width * s->h.height, left = (uint64_t)(s->c.end - s->c.p);
    const uint8_t *p = (const uint8_t *)s->c.p;
    uint32_t in_len, len;

    if (s->h.data == DX_PCD_ASCII) /* a digit and a blank for each value */
        return left + 1 < 2 * n * s->h.n_values ? too_short(&s->c, s->start, 2 * n * s->h.n_values)
                                                : 0;
    if (s->h.data == DX_PCD_BINARY)
        return left < n * s->h.stride ? too_short(&s->c, s->start, n * s->h.stride) : 0;
    if (left < 8)
        return too_short(&s->c, s->start, 8);
    in_len = dx_get_u32(p);
    len = dx_get_u32(p + 4);
    if (left - 8 < in_len)
        return too_short(&s->c, s->start, 8 + (uint64_t)in_len);
    if (len != n * s->h.stride || len > (uint64_t)LZF_MAX_RATIO * in_len)
        return dx_err_set(
            s->c.err, -EBADMSG, "byte %zu: %u bytes decompressed from %u, expected %llu",
            (size_t)(p + 4 - s->start), len, in_len, (unsigned long long)(n * s->h.stride));
    return 0;
}

/* Rows of [R|t] of "tx ty tz qw qx qy qz"; a zero quaternion turns nothing. */
static void set_pose(double pose[12], const double v[7])
{
    double largest = 0, norm = 0, q[4];

    for (int k = 0; k < 4; k++)
        largest = fabs(v[3 + k]) > largest ? fabs(v[3 + k]) : largest;
    for (int k = 0; k < 4; k++) {
        q[k] = largest > 0 ? v[3 + k] / largest : k == 0;
        norm += q[k] * q[k];
    }
    for (int k = 0; k < 4; k++)
        q[k] /= sqrt(norm);
    pose[0] = 1 - 2 * (q[2] * q[2] + q[3] * q[3]);
    pose[1] = 2 * (q[1] * q[2] - q[0] * q[3]);
    pose[2] = 2 * (q[1] * q[3] + q[0] * q[2]);
    pose[4] = 2 * (q[1] * q[2] + q[0] * q[3]);
    pose[5] = 1 - 2 * (q[1] * q[1] + q[3] * q[3]);
    pose[6] = 2 * (q[2] * q[3] - q[0] * q[1]);
    pose[8] = 2 * (q[1] * q[3] - q[0] * q[2]);
    pose[9] = 2 * (q[2] * q[3] + q[0] * q[1]);
    pose[10] = 1 - 2 * (q[1] * q[1] + q[2] * q[2]);
    for (int k = 0; k < 3; k++)
        pose[4 * k + 3] = v[k];
}

static int pcd_open(struct pcd *s, const uint8_t *bytes, size_t len, bool any, struct dx_err *err)
{
    int rc;

    s->start = bytes;
    s->c = dx_text_cursor_init(bytes, len, err);
    rc = any ? dx_pcd_header_read_any(&s->h, &s->c) : dx_pcd_header_read(&s->h, &s->c);
    if (rc == 0)
        rc = find_roles(&s->roles, &s->h, err);
    return rc ? rc : check_len(s);
}

/* A comment that says so, or a first keyword of the header. */
static bool pcd_probe(const uint8_t *bytes, size_t len)
{
    static const char *const starts[] = {"# .PCD", "VERSION ", "FIELDS "};

    for (size_t k = 0; k < sizeof(starts) / sizeof(starts[0]); k++)
        if (len >= strlen(starts[k]) && memcmp(bytes, starts[k], strlen(starts[k])) == 0)
            return true;
    return false;
}

/* A file is one frame. */
static int64_t pcd_block_len(const uint8_t *bytes, size_t len, struct dx_err *err)
{
    struct dx_text_cursor c = dx_text_cursor_init(bytes, len, err);
    struct pcd s;
    int rc;

    dx_text_skip_blank_lines(&c);
    if (c.p == c.end)
        return 0;
    rc = pcd_open(&s, bytes, len, false, err);
    return rc ? rc : (int64_t)len;
}

static int decode(struct dx_xyz_frame *out, const uint8_t *bytes, size_t len, bool any,
                  struct dx_err *err)
{
    static int (*const decoders[])(struct dx_xyz_frame *, const struct pcd *) = {
        decode_ascii, decode_binary, decode_compressed};
    struct pcd s;
    int rc = pcd_open(&s, bytes, len, any, err);

    if (rc)
        return rc;
    rc = dx_xyz_frame_reserve(out, s.h.height, s.h.width);
    if (rc)
        return dx_err_set(err, rc, "no memory for %u x %u points", s.h.width, s.h.height);
    set_pose(out->pose, s.h.viewpoint);
    rc = decoders[s.h.data](out, &s);
    if (rc == 0)
        finish_attr(out, &s.roles);
    return rc;
}

static int pcd_decode(struct dx_xyz_frame *out, const uint8_t *bytes, size_t len,
                      struct dx_err *err)
{
    return decode(out, bytes, len, false, err);
}

int dx_pcd_decode_any(struct dx_xyz_frame *out, const uint8_t *bytes, size_t len,
                      struct dx_err *err)
{
    return decode(out, bytes, len, true, err);
}

const struct dx_format dx_format_pcd = {"PCD", ".pcd", pcd_probe, pcd_block_len, pcd_decode};
