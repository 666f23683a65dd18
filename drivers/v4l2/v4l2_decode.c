/* Blocks of the V4L2 driver to frames. */
#include "drivers/v4l2/v4l2_decode.h"

#include "core/base/bytes.h"
#include "drivers/v4l2/v4l2_rows.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>

#define N_CODES 65536
/* Deeper than any range of 16 bits, and a whole number still when stretched. */
#define TOO_DEEP 1e6

void dx_v4l2_decoder_init(struct dx_v4l2_decoder *d, const struct dx_v4l2_config *config)
{
    *d = (struct dx_v4l2_decoder){
        .lens = config->lens,
        .min_m = config->min_m,
        .max_m = config->max_m,
    };
}

static void forget(struct dx_v4l2_decoder *d)
{
    dx_geometry_unref(d->geometry);
    free(d->stretch);
    free(d->depth);
    d->geometry = NULL;
    d->stretch = d->depth = NULL;
    d->told = false;
}

void dx_v4l2_decoder_fini(struct dx_v4l2_decoder *d)
{
    forget(d);
}

/* ---- geometry and tables ------------------------------------------------------------------------
 */

/* Limits in units; a metre's fraction that is not exact in binary must not move them. */
static void set_limits(struct dx_v4l2_decoder *d, double unit_m)
{
    double lo = ceil(d->min_m / unit_m - 1e-6), hi = floor(d->max_m / unit_m + 1e-6);

    d->lo = (uint16_t)(lo < 1 ? 1 : lo > 65535 ? 65535 : lo);
    d->hi = (uint16_t)(d->max_m == 0 || hi > 65535 ? 65535 : hi);
}

static void fill_depths(struct dx_v4l2_decoder *d, const struct dx_v4l2_shape *s)
{
    for (uint32_t code = 0; code < N_CODES; code++) {
        double depth = s->k / (s->d0 - code) / s->unit_m;

        if (code == s->invalid || !(depth >= d->lo - 0.5) ||
            (d->max_m > 0 && depth > d->hi + 0.5)) /* NaN and what lies behind are out as well */
            depth = 0;
        d->depth[code] = (float)(depth < TOO_DEEP ? depth : TOO_DEEP);
    }
}

static int make_tables(struct dx_v4l2_decoder *d, const struct dx_v4l2_shape *s)
{
    set_limits(d, s->unit_m);
    if (d->geometry->model == DX_MODEL_TABLE) {
        d->stretch = calloc((size_t)s->height * s->width, sizeof(*d->stretch));
        if (!d->stretch)
            return -ENOMEM;
        dx_lens_stretch(d->stretch, d->geometry);
    }
    if (s->k != 0) {
        d->depth = calloc(N_CODES, sizeof(*d->depth));
        if (!d->depth)
            return -ENOMEM;
        fill_depths(d, s);
    }
    return 0;
}

static bool same_geometry(const struct dx_v4l2_shape *a, const struct dx_v4l2_shape *b)
{
    return a->width == b->width && a->height == b->height && a->unit_m == b->unit_m;
}

static bool same_meaning(const struct dx_v4l2_shape *a, const struct dx_v4l2_shape *b)
{
    return a->invalid == b->invalid && a->k == b->k && a->d0 == b->d0;
}

int dx_v4l2_decoder_fit(struct dx_v4l2_decoder *d, const struct dx_v4l2_shape *shape,
                        struct dx_err *err)
{
    struct dx_geometry *kept = NULL, *made;
    bool told = d->told;
    int r = 0;

    if (d->geometry && same_geometry(&d->shape, shape)) {
        if (same_meaning(&d->shape, shape)) {
            d->shape = *shape;
            return 0;
        }
        kept = dx_geometry_ref(d->geometry);
    }
    forget(d);
    if (kept) {
        d->geometry = kept;
        d->told = told;
    } else {
        r = dx_lens_geometry(&made, &d->lens, shape->height, shape->width, err);
        if (r)
            return r;
        made->unit_m = (float)shape->unit_m;
        d->geometry = made;
    }
    r = make_tables(d, shape);
    if (r) {
        forget(d);
        return dx_err_set(err, r, "no memory for the tables of %ux%u dexels", shape->width,
                          shape->height);
    }
    d->shape = *shape;
    return 0;
}

/* ---- frames -------------------------------------------------------------------------------------
 */

static void unpack(uint16_t *row, const uint8_t *bytes, const struct dx_v4l2_shape *s)
{
    switch (s->format) {
    case DX_V4L2_Y16_BE:
        dx_v4l2_row_be(row, bytes, s->width);
        break;
    case DX_V4L2_Y10B:
        dx_v4l2_row_10b(row, bytes, s->width);
        break;
    default:
        dx_get_u16s(row, bytes, s->width);
        if (dx_v4l2_format_bits(s->format) < 16)
            dx_v4l2_row_mask(row, s->width, (uint16_t)((1u << dx_v4l2_format_bits(s->format)) - 1));
    }
}

static void fill(struct dx_v4l2_decoder *d, struct dx_plane *plane, const uint8_t *bytes,
                 const struct dx_v4l2_layout *layout)
{
    const struct dx_v4l2_shape *s = &d->shape;
    uint16_t *row = plane->range;
    const float *stretch = d->stretch;

    bytes += layout->at;
    for (uint32_t i = 0; i < s->height; i++, row += s->width, bytes += layout->stride) {
        unpack(row, bytes, s);
        if (d->depth) {
            d->n_beyond += dx_v4l2_row_lookup(row, d->depth, stretch, s->width);
        } else {
            dx_v4l2_row_limit(row, s->width, d->lo, d->hi, (uint16_t)s->invalid);
            if (stretch)
                d->n_beyond += dx_v4l2_row_stretch(row, stretch, s->width);
        }
        if (stretch)
            stretch += s->width;
    }
}

int dx_v4l2_decode(struct dx_v4l2_decoder *d, const struct dx_block *block,
                   const struct dx_frame_sink *sink, struct dx_err *err)
{
    struct dx_frame_part part = {.last = true, .stamp = block->stamp};
    struct dx_v4l2_layout layout;
    struct dx_v4l2_header h;
    struct dx_plane *plane;
    int r = dx_v4l2_header_get(&h, &layout, block, err);

    if (r)
        return r;
    r = dx_v4l2_decoder_fit(d, &h.shape, err);
    if (r) {
        dx_err_prefix(err, block->source);
        return r == -EINVAL ? DX_DRIVER_E_CORRUPT : r;
    }
    if (!d->told) {
        r = sink->geometry(sink->ctx, d->geometry, 0);
        if (r)
            return r;
        d->told = true;
    }
    plane = sink->plane(sink->ctx, d->frame);
    if (!plane)
        return DX_DRIVER_E_AGAIN;
    fill(d, plane, block->bytes + DX_V4L2_HEADER_LEN + h.data_offset, &layout);
    part.frame = d->frame++;
    part.n_cols = h.shape.width;
    sink->deliver(sink->ctx, &part);
    return 0;
}
