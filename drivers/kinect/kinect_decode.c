/* Blocks of the Kinect driver to frames. */
#include "drivers/kinect/kinect_decode.h"

#include <errno.h>

#define UNIT_M 0.001

void dx_kinect_decoder_init(struct dx_kinect_decoder *d, const struct dx_kinect_config *config)
{
    *d = (struct dx_kinect_decoder){
        .max_m = config->max_m,
        .fx = config->fx,
        .fy = config->fy,
        .cx = config->cx,
        .cy = config->cy,
    };
}

void dx_kinect_decoder_fini(struct dx_kinect_decoder *d)
{
    dx_geometry_unref(d->geometry);
    d->geometry = NULL;
}

static bool same(const struct dx_kinect_constants *a, const struct dx_kinect_constants *b)
{
    return a->emitter_cm == b->emitter_cm && a->reference_mm == b->reference_mm &&
           a->pixel_mm == b->pixel_mm && a->shift == b->shift;
}

/* The camera's own model is a pinhole: a pixel of 640 columns is 2 of `pixel_mm` wide at the
 * reference distance. What is configured goes before. */
static int make_geometry(struct dx_geometry **out, const struct dx_kinect_decoder *d,
                         const struct dx_kinect_constants *c)
{
    double own = (double)c->reference_mm / (2 * (double)c->pixel_mm);
    double fx = d->fx > 0 ? d->fx : own;
    double fy = d->fy > 0 ? d->fy : fx;
    double cx = d->cx >= 0 ? d->cx : (DX_KINECT_WIDTH - 1) / 2.0;
    double cy = d->cy >= 0 ? d->cy : (DX_KINECT_HEIGHT - 1) / 2.0;
    int r = dx_geometry_new_pinhole(out, DX_KINECT_HEIGHT, DX_KINECT_WIDTH, fx, fy, cx, cy);

    if (r)
        return r;
    (*out)->unit_m = (float)UNIT_M;
    (*out)->range_bytes = 2;
    return 0;
}

/* Table and geometry for this block. */
static int settle(struct dx_kinect_decoder *d, const struct dx_kinect_header *h,
                  const struct dx_block *block, struct dx_err *err)
{
    const struct dx_kinect_constants *c = &h->constants;
    struct dx_geometry *g;
    int r;

    if (d->geometry && same(c, &d->constants) && h->bits == d->bits)
        return 0;
    dx_kinect_lut_fill(d->lut, c, h->bits, d->max_m * 1000);
    d->bits = h->bits;
    if (!d->geometry || c->reference_mm != d->constants.reference_mm ||
        c->pixel_mm != d->constants.pixel_mm) {
        r = make_geometry(&g, d, c);
        if (r)
            return dx_err_set(err, r, "%s: block %llu: geometry: %s", block->source,
                              (unsigned long long)block->number,
                              r == -ENOMEM ? "out of memory" : "not possible");
        /* Configured intrinsics are the same whatever the device says. */
        d->told = d->told && dx_geometry_departure(g, d->geometry) == 0;
        if (d->told)
            dx_geometry_unref(g);
        else {
            dx_geometry_unref(d->geometry);
            d->geometry = g;
        }
    }
    d->constants = *c;
    return 0;
}

/* Pixels of whose bits some were in a packet that did not come. */
static void blank_holes(uint16_t *out, const struct dx_kinect_header *h)
{
    size_t frame_len = dx_kinect_frame_len(h->bits);
    unsigned n = dx_kinect_n_packets(frame_len);

    for (unsigned k = 0; k < n; k++)
        if (h->lost[k / 8] >> k % 8 & 1)
            dx_kinect_blank(out, (size_t)k * DX_KINECT_PAYLOAD_LEN,
                            (size_t)k * DX_KINECT_PAYLOAD_LEN + dx_kinect_payload_len(frame_len, k),
                            h->bits);
}

int dx_kinect_decode(struct dx_kinect_decoder *d, const struct dx_block *block,
                     const struct dx_frame_sink *sink, struct dx_err *err)
{
    struct dx_frame_part part = {.n_cols = DX_KINECT_WIDTH, .last = true, .stamp = block->stamp};
    struct dx_kinect_header h;
    struct dx_plane *plane;
    int r = dx_kinect_header_get(&h, block, err);

    if (r)
        return r;
    r = settle(d, &h, block, err);
    if (r)
        return r;
    if (!d->told) {
        r = sink->geometry(sink->ctx, d->geometry, 0);
        if (r)
            return r;
        d->told = true;
    }
    part.frame = d->n_frames;
    plane = sink->plane(sink->ctx, part.frame);
    if (!plane)
        return DX_DRIVER_E_AGAIN;
    dx_kinect_unpack(plane->range, block->bytes + DX_KINECT_HEADER_LEN, DX_KINECT_PIXELS, h.bits,
                     d->lut);
    blank_holes(plane->range, &h);
    d->n_frames++;
    sink->deliver(sink->ctx, &part);
    return 0;
}
