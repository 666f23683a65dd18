/* Isochronous packets to frames. */
#include "drivers/kinect/kinect_packets.h"

#include "core/base/bytes.h"

#include <string.h>

unsigned dx_kinect_n_packets(size_t frame_len)
{
    return (unsigned)((frame_len + DX_KINECT_PAYLOAD_LEN - 1) / DX_KINECT_PAYLOAD_LEN);
}

size_t dx_kinect_payload_len(size_t frame_len, unsigned k)
{
    size_t left = frame_len - (size_t)k * DX_KINECT_PAYLOAD_LEN;

    return left < DX_KINECT_PAYLOAD_LEN ? left : DX_KINECT_PAYLOAD_LEN;
}

void dx_kinect_assembler_init(struct dx_kinect_assembler *a, int bits, uint8_t *bytes,
                              uint8_t *(*done)(void *ctx, const struct dx_kinect_frame *frame),
                              void *ctx)
{
    memset(a, 0, sizeof(*a));
    a->frame_len = (size_t)640 * 480 / 8 * (size_t)bits;
    a->n_packets = dx_kinect_n_packets(a->frame_len);
    a->frame.bytes = bytes;
    a->done = done;
    a->ctx = ctx;
}

static void begin(struct dx_kinect_assembler *a)
{
    uint8_t *bytes = a->frame.bytes;

    memset(&a->frame, 0, sizeof(a->frame));
    a->frame.bytes = bytes;
    a->at = 0;
}

/* One place further; the last one ends the frame. */
static void advance(struct dx_kinect_assembler *a)
{
    if (++a->at < a->n_packets)
        return;
    a->counts.n_frames++;
    a->frame.bytes = a->done(a->ctx, &a->frame);
    begin(a);
}

static void lose(struct dx_kinect_assembler *a)
{
    memset(a->frame.bytes + (size_t)a->at * DX_KINECT_PAYLOAD_LEN, 0xff,
           dx_kinect_payload_len(a->frame_len, a->at));
    a->frame.lost[a->at / 8] |= (uint8_t)(1u << a->at % 8);
    a->frame.n_lost++;
    a->counts.n_lost++;
    advance(a);
}

static void give_up(struct dx_kinect_assembler *a, uint64_t *count)
{
    a->synced = false;
    ++*count;
}

static uint8_t flag_at(const struct dx_kinect_assembler *a)
{
    if (a->at == 0)
        return DX_KINECT_FIRST;
    return a->at + 1 == a->n_packets ? DX_KINECT_LAST : DX_KINECT_MIDDLE;
}

/* Brings the place in step with a packet's sequence. False: too much is missing. */
static bool catch_up(struct dx_kinect_assembler *a, uint8_t sequence)
{
    unsigned gap = (uint8_t)(sequence - a->sequence);

    if (gap > DX_KINECT_MAX_GAP) {
        a->counts.n_lost += gap;
        return false;
    }
    for (; gap > 0; gap--)
        lose(a);
    return true;
}

void dx_kinect_assembler_feed(struct dx_kinect_assembler *a, const uint8_t *packet, size_t len)
{
    size_t want, payload = len - DX_KINECT_PACKET_HEADER_LEN;
    uint32_t ticks;

    a->counts.n_packets++;
    if (len < DX_KINECT_PACKET_HEADER_LEN || packet[0] != 'R' || packet[1] != 'B') {
        a->counts.n_bad++; /* its place will be a hole */
        return;
    }
    if (a->synced && !catch_up(a, packet[5]))
        give_up(a, &a->counts.n_frames_lost);
    if (a->synced && packet[3] != flag_at(a))
        give_up(a, &a->counts.n_frames_damaged);
    if (!a->synced) {
        if (packet[3] != DX_KINECT_FIRST)
            return;
        begin(a);
        a->synced = true;
    }
    a->sequence = (uint8_t)(packet[5] + 1);
    want = dx_kinect_payload_len(a->frame_len, a->at);
    /* Only the last one may be longer than it need be. */
    if (payload < want || (payload > want && want == DX_KINECT_PAYLOAD_LEN)) {
        a->counts.n_bad++;
        lose(a);
        return;
    }
    ticks = dx_get_u32(packet + 8);
    if (ticks) /* the first one of a frame may have none */
        a->frame.ticks = ticks;
    memcpy(a->frame.bytes + (size_t)a->at * DX_KINECT_PAYLOAD_LEN,
           packet + DX_KINECT_PACKET_HEADER_LEN, want);
    advance(a);
}
