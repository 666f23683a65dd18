/*
 * A SCIP scanner from outside. First byte odd: the rest is what it sends, in pieces, to a session
 * that answers; even: a raw block for the decoder. What is found must be in bounds.
 */
#include "drivers/hokuyo/hokuyo.h"
#include "drivers/hokuyo/scip_block.h"
#include "drivers/hokuyo/scip_session.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#define MS 1000000u

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len);

/* ---- the decoder ------------------------------------------------------------------------------
 */

struct sink {
    struct dx_geometry *geometry;
    struct dx_plane plane;
    bool has_plane;
};

static int on_geometry(void *ctx, struct dx_geometry *g, uint8_t attr_bytes)
{
    struct sink *s = ctx;

    dx_geometry_unref(s->geometry);
    s->geometry = dx_geometry_ref(g);
    dx_plane_fini(&s->plane);
    s->has_plane = false;
    if ((size_t)g->height * g->width > 1u << 22) /* the time is for other inputs */
        return -ENOMEM;
    s->has_plane = dx_plane_init_for(&s->plane, g, attr_bytes) == 0;
    return s->has_plane ? 0 : -ENOMEM;
}

static struct dx_plane *on_plane(void *ctx, uint64_t number)
{
    struct sink *s = ctx;

    (void)number;
    return s->has_plane ? &s->plane : NULL;
}

static void on_deliver(void *ctx, const struct dx_frame_part *part)
{
    struct sink *s = ctx;

    if (part->n_cols == 0 || part->col0 + part->n_cols > s->geometry->width)
        abort();
}

static void decode(const uint8_t *bytes, size_t len)
{
    static const struct dx_hokuyo_config configs[] = {
        {.first_step = -1, .last_step = -1, .cluster = 1, .stage = {.angle = {.rpm = 10}}},
        {.attr_bytes = 2,
         .first_step = -1,
         .last_step = -1,
         .cluster = 1,
         .echo = DX_HOKUYO_ECHO_STRONGEST,
         .stage = {.angle = {.rpm = 10},
                   .sweep = DX_STAGE_HALF,
                   .angles_deg = {0, 90, 0},
                   .columns = 64,
                   .mean = true}},
        {.first_step = -1,
         .last_step = -1,
         .cluster = 1,
         .stage = {.angle = {.rpm = 10, .swing_deg = 90},
                   .sweep = DX_STAGE_SWING,
                   .columns = 64,
                   .exact = true,
                   .offset_m = {0.1, 0, 0}}},
    };
    struct sink s = {0};
    const struct dx_frame_sink sink = {&s, on_geometry, on_plane, on_deliver};
    struct dx_block block = {.bytes = bytes, .len = len, .source = "fuzz"};
    struct dx_device *dev;
    struct dx_err err;

    for (size_t k = 0; k < sizeof(configs) / sizeof(configs[0]); k++) {
        if (dx_hokuyo_driver.open_decoder(&dev, &configs[k], &err))
            abort();
        for (block.number = 0; block.number < 2; block.number++)
            dx_hokuyo_driver.decode(dev, &block, &sink, &err);
        dx_hokuyo_driver.close(dev);
    }
    dx_geometry_unref(s.geometry);
    dx_plane_fini(&s.plane);
}

/* ---- the session ------------------------------------------------------------------------------
 */

/* The scanner echoes what it was sent where an input says 0x01. */
static void talk(const uint8_t *bytes, size_t len)
{
    const struct dx_scip_want want = {.first_step = -1, .last_step = -1, .cluster = 1};
    struct dx_scip_session s;
    uint64_t now = 1000 * (uint64_t)MS;
    uint8_t said[64];
    size_t n_said = 0;

    if (dx_scip_session_init(&s, &want, 0, now))
        return;
    while (len > 0) {
        bool echo = *bytes == 1;
        size_t n = echo || len < 8 ? 1 : 1 + *bytes % 8;
        const uint8_t *p = echo ? said : bytes;
        size_t left = echo ? n_said : n;

        if (s.out_len) {
            n_said = s.out_len;
            memcpy(said, s.out, n_said);
            dx_scip_session_sent(&s, s.out_len, now);
        }
        while (left > 0) {
            size_t used = dx_scip_session_feed(&s, p, left, now);

            if (used == 0 || used > left || (s.scan_ready && s.scan.len > DX_SCIP_MAX_REPLY))
                abort();
            p += used;
            left -= used;
        }
        now += *bytes == 2 ? 700 * (uint64_t)MS : MS / 4;
        dx_scip_session_tick(&s, now);
        bytes += n;
        len -= n;
    }
    dx_scip_session_fini(&s);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len)
{
    if (len == 0)
        return 0;
    if (bytes[0] & 1)
        talk(bytes + 1, len - 1);
    else
        decode(bytes + 1, len - 1);
    return 0;
}
