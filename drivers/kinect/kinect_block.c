/* Blocks of the Kinect driver. */
#include "drivers/kinect/kinect_block.h"

#include "core/base/bytes.h"

#define VERSION 1

static const uint8_t magic[4] = {'D', 'X', 'K', 'N'};

void dx_kinect_header_put(uint8_t bytes[DX_KINECT_HEADER_LEN], const struct dx_kinect_header *h)
{
    memset(bytes, 0, DX_KINECT_HEADER_LEN);
    memcpy(bytes, magic, sizeof(magic));
    dx_put_u16(bytes + 4, VERSION);
    dx_put_u16(bytes + 6, DX_KINECT_HEADER_LEN);
    bytes[8] = (uint8_t)h->bits;
    bytes[9] = h->windows;
    bytes[10] = h->near;
    dx_put_u16(bytes + 12, DX_KINECT_WIDTH);
    dx_put_u16(bytes + 14, DX_KINECT_HEIGHT);
    dx_put_u32(bytes + 16, dx_f32_bits(h->constants.emitter_cm));
    dx_put_u32(bytes + 20, dx_f32_bits(h->constants.rcmos_cm));
    dx_put_u32(bytes + 24, dx_f32_bits(h->constants.reference_mm));
    dx_put_u32(bytes + 28, dx_f32_bits(h->constants.pixel_mm));
    dx_put_u16(bytes + 32, h->constants.shift);
    dx_put_u32(bytes + 36, h->ticks);
    dx_put_u32(bytes + 40, h->n_lost);
    dx_put_u32(bytes + 44, h->n_frames_lost);
    dx_put_u32(bytes + 48, h->n_frames_damaged);
    memcpy(bytes + 52, h->lost, sizeof(h->lost));
}

static int corrupt(const struct dx_block *block, unsigned offset, const char *what, unsigned found,
                   struct dx_err *err)
{
    return dx_err_set(err, DX_DRIVER_E_CORRUPT, "%s: block %llu: at byte %u: %s %u", block->source,
                      (unsigned long long)block->number, offset, what, found);
}

/* The header's own words; the length holds. */
static int check_fixed(const struct dx_block *block, struct dx_err *err)
{
    const uint8_t *p = block->bytes;

    if (memcmp(p, magic, sizeof(magic)) != 0)
        return corrupt(block, 0, "expected DXKN, found a first byte of", p[0], err);
    if (dx_get_u16(p + 4) != VERSION)
        return corrupt(block, 4, "expected version 1, found", dx_get_u16(p + 4), err);
    if (dx_get_u16(p + 6) != DX_KINECT_HEADER_LEN)
        return corrupt(block, 6, "expected a header of 96 bytes, found", dx_get_u16(p + 6), err);
    if (p[8] != 10 && p[8] != 11)
        return corrupt(block, 8, "expected 10 or 11 bits a code, found", p[8], err);
    if (dx_get_u16(p + 12) != DX_KINECT_WIDTH)
        return corrupt(block, 12, "expected 640 columns, found", dx_get_u16(p + 12), err);
    if (dx_get_u16(p + 14) != DX_KINECT_HEIGHT)
        return corrupt(block, 14, "expected 480 rows, found", dx_get_u16(p + 14), err);
    return 0;
}

int dx_kinect_header_get(struct dx_kinect_header *h, const struct dx_block *block,
                         struct dx_err *err)
{
    const uint8_t *p = block->bytes;
    size_t want;
    int r;

    if (block->len < DX_KINECT_HEADER_LEN)
        return corrupt(block, 0, "expected a header of 96 bytes, found a block of",
                       (unsigned)block->len, err);
    r = check_fixed(block, err);
    if (r)
        return r;
    *h = (struct dx_kinect_header){
        .bits = p[8],
        .windows = p[9],
        .near = p[10],
        .constants = {dx_f32_from_bits(dx_get_u32(p + 16)), dx_f32_from_bits(dx_get_u32(p + 20)),
                      dx_f32_from_bits(dx_get_u32(p + 24)), dx_f32_from_bits(dx_get_u32(p + 28)),
                      dx_get_u16(p + 32)},
        .ticks = dx_get_u32(p + 36),
        .n_lost = dx_get_u32(p + 40),
        .n_frames_lost = dx_get_u32(p + 44),
        .n_frames_damaged = dx_get_u32(p + 48),
    };
    memcpy(h->lost, p + 52, sizeof(h->lost));
    want = DX_KINECT_HEADER_LEN + dx_kinect_frame_len(h->bits);
    if (block->len != want)
        return dx_err_set(err, DX_DRIVER_E_CORRUPT,
                          "%s: block %llu: length is %zu, expected %zu of %d bits a code",
                          block->source, (unsigned long long)block->number, block->len, want,
                          h->bits);
    if (dx_kinect_constants_wrong(&h->constants))
        return dx_err_set(err, DX_DRIVER_E_CORRUPT,
                          "%s: block %llu: at byte 16: constants of no camera: %s", block->source,
                          (unsigned long long)block->number,
                          dx_kinect_constants_wrong(&h->constants));
    return 0;
}
