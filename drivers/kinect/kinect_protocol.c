/* The camera's control messages. */
#include "drivers/kinect/kinect_protocol.h"

#include "core/base/bytes.h"

#define FIXED_AT 94 /* of four f32 in the payload of FIXED */

size_t dx_kinect_request_put(uint8_t bytes[DX_KINECT_MESSAGE_LEN + 2 * DX_KINECT_MAX_WORDS],
                             uint16_t command, uint16_t tag, const uint16_t *words,
                             unsigned n_words)
{
    bytes[0] = 'G';
    bytes[1] = 'M';
    dx_put_u16(bytes + 2, (uint16_t)n_words);
    dx_put_u16(bytes + 4, command);
    dx_put_u16(bytes + 6, tag);
    for (unsigned k = 0; k < n_words; k++)
        dx_put_u16(bytes + DX_KINECT_MESSAGE_LEN + 2 * k, words[k]);
    return DX_KINECT_MESSAGE_LEN + 2 * (size_t)n_words;
}

const uint8_t *dx_kinect_reply_get(const uint8_t *bytes, size_t len, uint16_t command, uint16_t tag,
                                   size_t *payload_len, struct dx_err *err)
{
    size_t words;

    if (len < DX_KINECT_MESSAGE_LEN || bytes[0] != 'R' || bytes[1] != 'B') {
        dx_err_set(err, 0, "found %zu bytes that are no reply", len);
        return NULL;
    }
    words = dx_get_u16(bytes + 2);
    if (dx_get_u16(bytes + 4) != command || dx_get_u16(bytes + 6) != tag) {
        dx_err_set(err, 0, "found the reply to command 0x%02x, tag %u, expected 0x%02x, %u",
                   dx_get_u16(bytes + 4), dx_get_u16(bytes + 6), command, tag);
        return NULL;
    }
    if (DX_KINECT_MESSAGE_LEN + 2 * words != len) {
        dx_err_set(err, 0, "found a reply of %zu bytes that tells %zu words", len, words);
        return NULL;
    }
    *payload_len = 2 * words;
    return bytes + DX_KINECT_MESSAGE_LEN;
}

void dx_kinect_start_writes(struct dx_kinect_write out[DX_KINECT_N_START], int bits)
{
    out[0] = (struct dx_kinect_write){DX_KINECT_PROJECTOR_CYCLE, 0};
    out[1] = (struct dx_kinect_write){DX_KINECT_DEPTH_STREAM, 0};
    out[2] = (struct dx_kinect_write){DX_KINECT_DEPTH_FORMAT, bits == 11 ? 3 : 2};
    out[3] = (struct dx_kinect_write){DX_KINECT_DEPTH_SIZE, 1}; /* 640 x 480 */
    out[4] = (struct dx_kinect_write){DX_KINECT_DEPTH_FPS, 30};
    out[5] = (struct dx_kinect_write){DX_KINECT_DEPTH_STREAM, 2};
    out[6] = (struct dx_kinect_write){DX_KINECT_DEPTH_MIRROR, 0};
}

void dx_kinect_near_writes(struct dx_kinect_write out[2], bool near)
{
    out[0] = (struct dx_kinect_write){DX_KINECT_PROJECTOR, near ? 7 : 30};
    out[1] = (struct dx_kinect_write){DX_KINECT_NEAR, near ? 0 : 400};
}

bool dx_kinect_fixed_get(struct dx_kinect_constants *c, const uint8_t *payload, size_t len)
{
    const uint8_t *p = payload + FIXED_AT;

    if (len < FIXED_AT + 16)
        return false;
    c->emitter_cm = dx_f32_from_bits(dx_get_u32(p));
    c->rcmos_cm = dx_f32_from_bits(dx_get_u32(p + 4));
    c->reference_mm = dx_f32_from_bits(dx_get_u32(p + 8));
    c->pixel_mm = dx_f32_from_bits(dx_get_u32(p + 12));
    return true;
}

bool dx_kinect_shift_get(struct dx_kinect_constants *c, const uint8_t *payload, size_t len)
{
    if (len < 4)
        return false;
    c->shift = dx_get_u16(payload + 2); /* a status lies before it */
    return true;
}
