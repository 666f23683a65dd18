/* Ranges of a scan, laid out by its stage. */
#include "drivers/hokuyo/scip_decoder.h"

#include "drivers/hokuyo/scip_session.h"

#include "core/base/trig.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct dx_scip_decoder {
    struct dx_hokuyo_config config; /* of it no texts */
    struct dx_turning_stage *stage;
    uint32_t n;          /* values that the arrays hold */
    uint32_t *range;     /* [n] */
    uint16_t *intensity; /* [n] */
    struct dx_angle_sample angles[DX_SCIP_BLOCK_ANGLES];
    char model[32];
    uint64_t n_scans;
    struct dx_scip_tally tally; /* of the last scan */
};

int dx_scip_decoder_new(struct dx_scip_decoder **out, const struct dx_hokuyo_config *config,
                        struct dx_err *err)
{
    struct dx_scip_decoder *d = calloc(1, sizeof(*d));
    int r;

    if (!d)
        return dx_err_set(err, -ENOMEM, "hokuyo: no memory");
    d->config = *config;
    r = dx_stage_new(&d->stage, &d->config.stage, err);
    if (r) {
        dx_scip_decoder_free(d);
        return r;
    }
    *out = d;
    return 0;
}

void dx_scip_decoder_free(struct dx_scip_decoder *d)
{
    if (!d)
        return;
    dx_stage_free(d->stage);
    free(d->range);
    free(d->intensity);
    free(d);
}

static int hold(struct dx_scip_decoder *d, uint32_t n, struct dx_err *err)
{
    if (n <= d->n)
        return 0;
    free(d->range);
    free(d->intensity);
    d->range = calloc(n, sizeof(*d->range));
    d->intensity = calloc(n, sizeof(*d->intensity));
    d->n = d->range && d->intensity ? n : 0;
    return d->n ? 0 : dx_err_set(err, -ENOMEM, "hokuyo: no memory");
}

struct dx_line_shape dx_scip_decoder_shape(const struct dx_scip_block *b, uint8_t attr_bytes)
{
    double step = 2 * DX_PI / b->params.ares, centre = b->first + (b->cluster - 1) / 2.0;

    return (struct dx_line_shape){
        .n = dx_scip_n_values(b->first, b->last, b->cluster),
        .angle0_rad = (centre - b->params.afrt) * step,
        .step_rad = step * b->cluster,
        .max_m = b->params.dmax * 0.001,
        .lines_s = 1e9 / dx_scip_period_ns(&b->params) / (b->skip + 1),
        .attr_bytes = attr_bytes,
    };
}

static struct dx_line line_of(const struct dx_scip_decoder *d, const struct dx_scip_block *b,
                              struct dx_angle_sample *angles, const struct dx_block *block)
{
    double step_ns = dx_scip_period_ns(&b->params) / b->params.ares;

    for (uint32_t k = 0; k < b->n_angles; k++)
        angles[k] = dx_scip_block_angle(b, k);
    return (struct dx_line){
        .host_ns = b->host_ns + (uint64_t)(step_ns * (b->first + (b->cluster - 1) / 2.0)),
        .step_ns = step_ns * b->cluster,
        .range = d->range,
        .attr = d->config.attr_bytes ? d->intensity : NULL,
        .angle = angles,
        .n_angles = b->n_angles,
        .stamp = block->stamp,
    };
}

static enum dx_scip_echo choice(const struct dx_hokuyo_config *c)
{
    return c->echo == DX_HOKUYO_ECHO_LAST        ? DX_SCIP_LAST
           : c->echo == DX_HOKUYO_ECHO_STRONGEST ? DX_SCIP_STRONGEST
                                                 : DX_SCIP_FIRST;
}

/* A block's ranges into d->range. */
static int unpack(struct dx_scip_decoder *d, const struct dx_scip_block *b, uint32_t n,
                  struct dx_err *err)
{
    struct dx_scip_format format;
    struct dx_scip_head head;
    int r = hold(d, n, err);

    if (r)
        return r;
    if (!dx_scip_format_of(&format, b->command))
        return dx_err_set(err, -EBADMSG, "byte 14: unknown command");
    if (!dx_scip_scan_check(&head, b->scan, b->scan_len))
        return dx_err_set(err, -EBADMSG, "byte %zu: a damaged scan",
                          DX_SCIP_BLOCK_HEADER + b->n_angles * (size_t)DX_SCIP_BLOCK_SAMPLE);
    return dx_scip_scan_decode(d->range, NULL, d->intensity, n, &d->tally, &b->params, &format,
                               choice(&d->config), head.data, err);
}

static int spoilt(const struct dx_block *block, int r, struct dx_err *err)
{
    char where[96];

    snprintf(where, sizeof(where), "%.60s: block %llu", block->source ? block->source : "?",
             (unsigned long long)block->number);
    dx_err_prefix(err, where);
    return r == -EBADMSG || r == -EINVAL ? DX_DRIVER_E_CORRUPT : r;
}

int dx_scip_decoder_decode(struct dx_scip_decoder *d, const struct dx_block *block,
                           const struct dx_frame_sink *sink, struct dx_err *err)
{
    struct dx_scip_block b;
    struct dx_line_shape shape;
    struct dx_line line;
    uint32_t n;
    int r = dx_scip_block_get(&b, block->bytes, block->len, err);

    if (block->first)
        dx_stage_restart(d->stage);
    if (r)
        return spoilt(block, r, err);
    n = dx_scip_n_values(b.first, b.last, b.cluster);
    r = unpack(d, &b, n, err);
    if (r)
        return spoilt(block, r, err);
    shape = dx_scip_decoder_shape(&b, d->config.attr_bytes);
    r = dx_stage_shape(d->stage, &shape, sink, err);
    if (r)
        return r < 0 ? spoilt(block, r, err) : r;
    memcpy(d->model, b.params.model, sizeof(d->model));
    line = line_of(d, &b, d->angles, block);
    d->n_scans++;
    return dx_stage_put(d->stage, &line, sink);
}

void dx_scip_decoder_describe(const struct dx_scip_decoder *d, char *text, size_t len)
{
    const struct dx_geometry *g = dx_stage_geometry(d->stage);
    struct dx_stage_counts c = dx_stage_counts(d->stage);

    if (!g) {
        snprintf(text, len, "hokuyo: no scan yet");
        return;
    }
    snprintf(
        text, len,
        "%s: %llu scans, %ux%u, %s; the last one: %u returns, %u codes, %u beyond; values late "
        "%llu, outside %llu, of unknown angle %llu",
        d->model, (unsigned long long)d->n_scans, g->width, g->height,
        dx_stage_layout_text(d->stage), d->tally.n_returns, d->tally.n_near, d->tally.n_far,
        (unsigned long long)c.n_late, (unsigned long long)c.n_outside,
        (unsigned long long)c.n_uncertain);
}
