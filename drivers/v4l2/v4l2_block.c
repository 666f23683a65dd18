/* Formats, and the header of a block. */
#include "drivers/v4l2/v4l2_block.h"

#include "core/base/bytes.h"

#include <linux/videodev2.h>

#include <errno.h>
#include <math.h>
#include <stdio.h>

#define MAGIC   0x34565844u /* "DXV4" */
#define VERSION 1
#define MAX_K   1e12

static const struct {
    const char *name;
    uint32_t fourcc;
    unsigned bits;
} formats[DX_V4L2_N_FORMATS] = {
    [DX_V4L2_AUTO] = {"auto", 0, 0},
    [DX_V4L2_Z16] = {"Z16", V4L2_PIX_FMT_Z16, 16},
    [DX_V4L2_INZI] = {"INZI", V4L2_PIX_FMT_INZI, 16},
    [DX_V4L2_Y16] = {"Y16", V4L2_PIX_FMT_Y16, 16},
    [DX_V4L2_Y16_BE] = {"Y16_BE", V4L2_PIX_FMT_Y16_BE, 16},
    [DX_V4L2_Y14] = {"Y14", V4L2_PIX_FMT_Y14, 14},
    [DX_V4L2_Y12] = {"Y12", V4L2_PIX_FMT_Y12, 12},
    [DX_V4L2_Y10] = {"Y10", V4L2_PIX_FMT_Y10, 10},
    [DX_V4L2_Y10B] = {"Y10B", V4L2_PIX_FMT_Y10BPACK, 10},
};

const char *dx_v4l2_format_name(unsigned format)
{
    return format < DX_V4L2_N_FORMATS ? formats[format].name : NULL;
}

uint32_t dx_v4l2_format_fourcc(enum dx_v4l2_format format)
{
    return formats[format].fourcc;
}

enum dx_v4l2_format dx_v4l2_format_find(uint32_t fourcc)
{
    for (enum dx_v4l2_format f = DX_V4L2_Z16; f < DX_V4L2_N_FORMATS; f++)
        if (formats[f].fourcc == fourcc)
            return f;
    return DX_V4L2_AUTO;
}

unsigned dx_v4l2_format_bits(enum dx_v4l2_format format)
{
    return formats[format].bits;
}

static size_t row_len(const struct dx_v4l2_shape *s)
{
    return s->format == DX_V4L2_Y10B ? (size_t)s->width / 4 * 5 : 2 * (size_t)s->width;
}

int dx_v4l2_layout(struct dx_v4l2_layout *out, const struct dx_v4l2_shape *s, char why[96])
{
    size_t row = row_len(s);

    if (dx_geometry_table_len(DX_MODEL_PINHOLE, s->height, s->width) == 0) {
        snprintf(why, 96, "image of %ux%u", s->width, s->height);
        return -EINVAL;
    }
    if (s->format == DX_V4L2_Y10B && s->width % 4) {
        snprintf(why, 96, "Y10B image %u wide, expected a multiple of 4", s->width);
        return -EINVAL;
    }
    if (s->bytesperline < row) {
        snprintf(why, 96, "line of %u bytes, expected %zu or more", s->bytesperline, row);
        return -EINVAL;
    }
    out->at = 0;
    out->stride = s->bytesperline;
    if (s->format == DX_V4L2_INZI) {
        /* one line after another of either image; drivers that count both say twice the length */
        if (out->stride == 2 * row)
            out->stride = row;
        out->at = out->stride * s->height;
    }
    out->end = out->at + out->stride * (s->height - 1) + row;
    return 0;
}

void dx_v4l2_header_put(uint8_t bytes[DX_V4L2_HEADER_LEN], const struct dx_v4l2_header *h)
{
    const struct dx_v4l2_shape *s = &h->shape;

    dx_put_u32(bytes, MAGIC);
    dx_put_u16(bytes + 4, VERSION);
    dx_put_u16(bytes + 6, DX_V4L2_HEADER_LEN);
    dx_put_u32(bytes + 8, formats[s->format].fourcc);
    dx_put_u32(bytes + 12, s->width);
    dx_put_u32(bytes + 16, s->height);
    dx_put_u32(bytes + 20, s->bytesperline);
    dx_put_u32(bytes + 24, h->data_offset);
    dx_put_u32(bytes + 28, h->sequence);
    dx_put_u32(bytes + 32, h->flags);
    dx_put_u32(bytes + 36, s->invalid);
    dx_put_u64(bytes + 40, dx_f64_bits(s->unit_m));
    dx_put_u64(bytes + 48, dx_f64_bits(s->k));
    dx_put_u64(bytes + 56, dx_f64_bits(s->d0));
}

static int corrupt(const struct dx_block *block, struct dx_err *err, const char *what)
{
    return dx_err_set(err, DX_DRIVER_E_CORRUPT, "%s: block %llu: %s", block->source,
                      (unsigned long long)block->number, what);
}

static int check_begin(const struct dx_block *block, struct dx_err *err)
{
    struct dx_reader r = dx_reader_init(block->bytes, block->len);
    uint32_t magic = dx_read_u32(&r);
    unsigned version = dx_read_u16(&r), len = dx_read_u16(&r);
    char what[96];

    if (block->len < DX_V4L2_HEADER_LEN)
        snprintf(what, sizeof(what), "length is %zu, expected a header of %d", block->len,
                 DX_V4L2_HEADER_LEN);
    else if (magic != MAGIC)
        snprintf(what, sizeof(what), "byte 0: magic is %08x, expected %08x", magic, MAGIC);
    else if (version != VERSION || len != DX_V4L2_HEADER_LEN)
        snprintf(what, sizeof(what), "byte 4: version %u of %u bytes, expected %d of %d", version,
                 len, VERSION, DX_V4L2_HEADER_LEN);
    else
        return 0;
    return corrupt(block, err, what);
}

static bool meaning_is_good(const struct dx_v4l2_shape *s)
{
    return s->unit_m >= DX_V4L2_MIN_UNIT && s->unit_m <= DX_V4L2_MAX_UNIT && fabs(s->k) <= MAX_K &&
           fabs(s->d0) <= MAX_K; /* false for NaN */
}

int dx_v4l2_header_get(struct dx_v4l2_header *h, struct dx_v4l2_layout *layout,
                       const struct dx_block *block, struct dx_err *err)
{
    struct dx_v4l2_shape *s = &h->shape;
    struct dx_reader r = dx_reader_init(block->bytes, block->len);
    char what[96], why[96];
    uint32_t fourcc;
    int rc = check_begin(block, err);

    if (rc)
        return rc;
    dx_read_bytes(&r, 8);
    fourcc = dx_read_u32(&r);
    s->format = dx_v4l2_format_find(fourcc);
    s->width = dx_read_u32(&r);
    s->height = dx_read_u32(&r);
    s->bytesperline = dx_read_u32(&r);
    h->data_offset = dx_read_u32(&r);
    h->sequence = dx_read_u32(&r);
    h->flags = dx_read_u32(&r);
    s->invalid = dx_read_u32(&r);
    s->unit_m = dx_read_f64(&r);
    s->k = dx_read_f64(&r);
    s->d0 = dx_read_f64(&r);
    if (s->format == DX_V4L2_AUTO)
        snprintf(what, sizeof(what), "byte 8: pixel format %08x, expected one of depth", fourcc);
    else if (dx_v4l2_layout(layout, s, why))
        snprintf(what, sizeof(what), "byte 12: %.80s", why);
    else if (!meaning_is_good(s))
        snprintf(what, sizeof(what), "byte 40: unit %g m, disparity %g, %g", s->unit_m, s->k,
                 s->d0);
    else if (dx_reader_left(&r) < h->data_offset ||
             dx_reader_left(&r) - h->data_offset < layout->end)
        snprintf(what, sizeof(what), "length is %zu, expected %llu for %s of %ux%u", block->len,
                 DX_V4L2_HEADER_LEN + (unsigned long long)h->data_offset + layout->end,
                 formats[s->format].name, s->width, s->height);
    else
        return 0;
    return corrupt(block, err, what);
}
