/*
 * What a Kinect sends, from anybody: packets put together, replies read, and the frame that comes
 * of it, and the bytes themselves as a block, decoded. The first byte chooses.
 */
#include "drivers/kinect/kinect_decode.h"
#include "drivers/kinect/kinect_protocol.h"

#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len);

#define MAX_STEPS 24 /* frames are long, and inputs many */

static struct dx_plane plane;
static uint8_t frames[2][DX_KINECT_PIXELS / 8 * 11];
static unsigned n_frames;

static int sink_geometry(void *ctx, struct dx_geometry *g, uint8_t attr_bytes)
{
    (void)ctx;
    dx_plane_fini(&plane);
    return dx_plane_init_for(&plane, g, attr_bytes);
}

static struct dx_plane *sink_plane(void *ctx, uint64_t number)
{
    (void)ctx;
    (void)number;
    return &plane;
}

static void sink_deliver(void *ctx, const struct dx_frame_part *part)
{
    (void)ctx;
    (void)part;
}

static void decode(const uint8_t *bytes, size_t len)
{
    static const struct dx_kinect_config config = {.bits = 11, .max_m = 10, .cx = -1, .cy = -1};
    const struct dx_frame_sink sink = {NULL, sink_geometry, sink_plane, sink_deliver};
    const struct dx_block block = {.bytes = bytes, .len = len, .source = "fuzz"};
    struct dx_kinect_decoder d;
    struct dx_err err;

    dx_kinect_decoder_init(&d, &config);
    dx_kinect_decode(&d, &block, &sink, &err);
    dx_kinect_decode(&d, &block, &sink, &err);
    dx_kinect_decoder_fini(&d);
}

/* A header from outside before a frame of the right length. */
static void decode_header(const uint8_t *bytes, size_t len)
{
    static uint8_t block[DX_KINECT_HEADER_LEN + DX_KINECT_PIXELS / 8 * 11];

    if (len < DX_KINECT_HEADER_LEN)
        return;
    memcpy(block, bytes, DX_KINECT_HEADER_LEN);
    memset(block + DX_KINECT_HEADER_LEN, bytes[len - 1], sizeof(block) - DX_KINECT_HEADER_LEN);
    decode(block, DX_KINECT_HEADER_LEN + dx_kinect_frame_len(block[8] == 10 ? 10 : 11));
}

static uint8_t *take(void *ctx, const struct dx_kinect_frame *frame)
{
    unsigned n_lost = 0;

    (void)ctx;
    for (unsigned k = 0; k < DX_KINECT_MAX_PACKETS; k++)
        n_lost += frame->lost[k / 8] >> k % 8 & 1;
    if (n_lost != frame->n_lost)
        abort();
    return frames[++n_frames % 2];
}

/* Three bytes a packet: how far the sequence goes on, the flag, the length; with 0 0 0 the packet
 * is what the frame wants next. */
static void assemble(const uint8_t *bytes, size_t len, int bits)
{
    static uint8_t packet[DX_KINECT_PACKET_LEN + 64];
    struct dx_kinect_assembler a;
    uint8_t sequence = 0;

    dx_kinect_assembler_init(&a, bits, frames[n_frames % 2], take, NULL);
    for (size_t k = 0; k + 3 <= len && k < 3 * MAX_STEPS; k += 3) {
        uint8_t gap = bytes[k] & 0x87, flag = bytes[k + 1], cut = bytes[k + 2];
        unsigned repeat = flag >> 4 == 0 ? 1 + 16u * (flag & 15) : 1;

        for (unsigned r = 0; r < repeat; r++) {
            size_t want = dx_kinect_payload_len(a.frame_len, a.at);
            size_t n = DX_KINECT_PACKET_HEADER_LEN + want;

            packet[0] = cut == 255 ? 'X' : 'R';
            packet[1] = 'B';
            packet[3] = flag >> 4                 ? flag
                        : a.at == 0               ? DX_KINECT_FIRST
                        : a.at + 1 == a.n_packets ? DX_KINECT_LAST
                                                  : DX_KINECT_MIDDLE;
            sequence = (uint8_t)(sequence + gap + 1);
            packet[5] = sequence;
            packet[8] = cut;
            n = cut > 128 ? n - (cut - 128u) % n : n + cut % 64;
            /* A copy of its own length: a read beyond it is seen. */
            uint8_t *exact = malloc(n ? n : 1);

            memcpy(exact, packet, n);
            dx_kinect_assembler_feed(&a, exact, n);
            free(exact);
        }
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len)
{
    struct dx_kinect_constants c;
    struct dx_err err;
    const uint8_t *payload;
    size_t n;

    if (len < 1)
        return 0;
    switch (bytes[0] % 5) {
    case 0:
    case 1:
        assemble(bytes + 1, len - 1, 10 + bytes[0] % 5);
        break;
    case 2:
        decode(bytes + 1, len - 1);
        break;
    case 3:
        decode_header(bytes + 1, len - 1);
        break;
    default:
        payload = dx_kinect_reply_get(bytes + 1, len - 1, DX_KINECT_FIXED, 3, &n, &err);
        if (payload && dx_kinect_fixed_get(&c, payload, n) && dx_kinect_shift_get(&c, payload, n))
            dx_kinect_constants_wrong(&c);
    }
    return 0;
}
