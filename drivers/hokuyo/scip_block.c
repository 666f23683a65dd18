/*
 * The block's bytes: 0 magic, 4 version, 6 length of the header, 8 flags, 12 status, 14 command,
 * 16 first and last step, 20 cluster, 21 skip, 22 class, 24 ARES, AMIN, AMAX, AFRT, DMIN, DMAX,
 * SCAN, 52 number of angles, 56 length of the scan, 60 zeros, 64 device_ns, 72 host_ns, 80
 * arrival_ns, 88 serial (16), 104 model (24). An angle: 0 host_ns, 8 angle (f64), 16 flags, 20
 * zeros.
 */
#include "drivers/hokuyo/scip_block.h"

#include "core/base/bytes.h"
#include "drivers/hokuyo/scip_session.h"

#include <errno.h>
#include <math.h>
#include <string.h>

#define MAGIC     0x50494353u /* "SCIP" */
#define VERSION   1
#define MODEL_LEN 24

static void put_header(uint8_t *p, size_t scan_len, const struct dx_scip_block *b, size_t n_angles)
{
    const uint32_t numbers[] = {b->params.ares, b->params.amin, b->params.amax,    b->params.afrt,
                                b->params.dmin, b->params.dmax, b->params.scan_rpm};

    memset(p, 0, DX_SCIP_BLOCK_HEADER);
    dx_put_u32(p, MAGIC);
    dx_put_u16(p + 4, VERSION);
    dx_put_u16(p + 6, DX_SCIP_BLOCK_HEADER);
    dx_put_u32(p + 8, b->flags);
    dx_put_u16(p + 12, b->status);
    memcpy(p + 14, b->command, 2);
    dx_put_u16(p + 16, b->first);
    dx_put_u16(p + 18, b->last);
    p[20] = b->cluster;
    p[21] = b->skip;
    p[22] = (uint8_t)b->params.class;
    for (size_t k = 0; k < sizeof(numbers) / sizeof(numbers[0]); k++)
        dx_put_u32(p + 24 + 4 * k, numbers[k]);
    dx_put_u32(p + 52, (uint32_t)n_angles);
    dx_put_u32(p + 56, (uint32_t)scan_len);
    dx_put_u64(p + 64, b->device_ns);
    dx_put_u64(p + 72, b->host_ns);
    dx_put_u64(p + 80, b->arrival_ns);
    memcpy(p + 88, b->serial, sizeof(b->serial));
    memcpy(p + 104, b->params.model, MODEL_LEN - 1);
}

uint8_t *dx_scip_block_put(uint8_t *scan, size_t scan_len, const struct dx_scip_block *b,
                           const struct dx_angle_sample *angles, size_t n_angles, size_t *len)
{
    uint8_t *p = scan - n_angles * DX_SCIP_BLOCK_SAMPLE, *start = p - DX_SCIP_BLOCK_HEADER;

    put_header(start, scan_len, b, n_angles);
    for (size_t k = 0; k < n_angles; k++, p += DX_SCIP_BLOCK_SAMPLE) {
        dx_put_u64(p, angles[k].host_ns);
        dx_put_u64(p + 8, dx_f64_bits(angles[k].angle_rad));
        dx_put_u32(p + 16, angles[k].uncertain);
        dx_put_u32(p + 20, 0);
    }
    *len = (size_t)(scan - start) + scan_len;
    return start;
}

struct dx_angle_sample dx_scip_block_angle(const struct dx_scip_block *b, size_t k)
{
    const uint8_t *p = b->angles + k * DX_SCIP_BLOCK_SAMPLE;

    return (struct dx_angle_sample){dx_get_u64(p), dx_f64_from_bits(dx_get_u64(p + 8)),
                                    (dx_get_u32(p + 16) & 1) != 0};
}

static void get_header(struct dx_scip_block *b, const uint8_t *p)
{
    *b = (struct dx_scip_block){
        .flags = dx_get_u32(p + 8),
        .status = dx_get_u16(p + 12),
        .first = dx_get_u16(p + 16),
        .last = dx_get_u16(p + 18),
        .cluster = p[20],
        .skip = p[21],
        .device_ns = dx_get_u64(p + 64),
        .host_ns = dx_get_u64(p + 72),
        .arrival_ns = dx_get_u64(p + 80),
        .n_angles = dx_get_u32(p + 52),
        .scan_len = dx_get_u32(p + 56),
        .params = {.ares = dx_get_u32(p + 24),
                   .amin = dx_get_u32(p + 28),
                   .amax = dx_get_u32(p + 32),
                   .afrt = dx_get_u32(p + 36),
                   .dmin = dx_get_u32(p + 40),
                   .dmax = dx_get_u32(p + 44),
                   .scan_rpm = dx_get_u32(p + 48),
                   .class = p[22] == DX_SCIP_CLASS_UTM ? DX_SCIP_CLASS_UTM : DX_SCIP_CLASS_URG},
    };
    memcpy(b->command, p + 14, 2);
    memcpy(b->serial, p + 88, sizeof(b->serial));
    b->serial[sizeof(b->serial) - 1] = 0;
    memcpy(b->params.model, p + 104, MODEL_LEN - 1);
}

/* Angles ascend in time, and are finite: what is computed from them stays in bounds. */
static int check_angles(const struct dx_scip_block *b, struct dx_err *err)
{
    uint64_t before = 0;

    for (size_t k = 0; k < b->n_angles; k++) {
        struct dx_angle_sample a = dx_scip_block_angle(b, k);

        if ((k > 0 && a.host_ns <= before) || !(fabs(a.angle_rad) < 1e9))
            return dx_err_set(err, -EBADMSG, "angle %zu of %u, at byte %zu, is %g at %llu ns", k,
                              b->n_angles, DX_SCIP_BLOCK_HEADER + k * (size_t)DX_SCIP_BLOCK_SAMPLE,
                              a.angle_rad, (unsigned long long)a.host_ns);
        before = a.host_ns;
    }
    return 0;
}

int dx_scip_block_get(struct dx_scip_block *b, const uint8_t *p, size_t len, struct dx_err *err)
{
    size_t head;

    if (len < DX_SCIP_BLOCK_HEADER || dx_get_u32(p) != MAGIC || dx_get_u16(p + 4) != VERSION ||
        dx_get_u16(p + 6) != DX_SCIP_BLOCK_HEADER)
        return dx_err_set(err, -EBADMSG, "byte 0: no scan of a SCIP scanner, version %d", VERSION);
    get_header(b, p);
    if (b->n_angles > DX_SCIP_BLOCK_ANGLES)
        return dx_err_set(err, -EBADMSG, "byte 52: %u angles, expected at most %d", b->n_angles,
                          DX_SCIP_BLOCK_ANGLES);
    head = DX_SCIP_BLOCK_HEADER + b->n_angles * (size_t)DX_SCIP_BLOCK_SAMPLE;
    if (len < head || b->scan_len != len - head || b->scan_len > DX_SCIP_MAX_REPLY)
        return dx_err_set(err, -EBADMSG,
                          "byte 56: %u angles and a scan of %zu bytes in a block of %zu",
                          b->n_angles, b->scan_len, len);
    b->angles = p + DX_SCIP_BLOCK_HEADER;
    b->scan = p + head;
    if (!dx_scip_params_good(&b->params) || b->first > b->last || b->last >= b->params.ares ||
        b->cluster < 1 || b->cluster > 99 || b->skip > 9)
        return dx_err_set(err, -EBADMSG,
                          "byte 16: steps %u to %u by %u, and constants, are those of no scanner",
                          b->first, b->last, b->cluster);
    return check_angles(b, err);
}
