/*
 * Isochronous packets to frames. A packet is 12 bytes of header ("RB", flag, sequence, ticks), then
 * 1748 bytes of the frame, less in its last one. USB repeats nothing: what is lost leaves a hole,
 * which is known by the sequence. Owned by one thread.
 */
#ifndef DX_KINECT_PACKETS_H
#define DX_KINECT_PACKETS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define DX_KINECT_PACKET_HEADER_LEN 12
#define DX_KINECT_PAYLOAD_LEN       1748
#define DX_KINECT_PACKET_LEN        (DX_KINECT_PACKET_HEADER_LEN + DX_KINECT_PAYLOAD_LEN)
#define DX_KINECT_MAX_PACKETS       256 /* of a frame, at least */
#define DX_KINECT_MAX_GAP           5   /* packets lost in a row, above which a frame is given up */

enum dx_kinect_flag {
    DX_KINECT_FIRST = 0x71,
    DX_KINECT_MIDDLE = 0x72,
    DX_KINECT_LAST = 0x75,
};

/* A frame that is complete, save for its holes: bytes 0xFF. */
struct dx_kinect_frame {
    uint8_t *bytes;
    uint32_t ticks; /* of the device's clock */
    uint32_t n_lost;
    uint8_t lost[DX_KINECT_MAX_PACKETS / 8]; /* bit k % 8 of byte k / 8: packet k */
};

struct dx_kinect_counts {
    uint64_t n_packets;        /* that came */
    uint64_t n_lost;           /* that did not */
    uint64_t n_bad;            /* that came, and were no packets of a frame */
    uint64_t n_frames;         /* given */
    uint64_t n_frames_lost;    /* given up for what they lacked */
    uint64_t n_frames_damaged; /* given up for what did not fit */
};

struct dx_kinect_assembler {
    size_t frame_len;
    unsigned n_packets; /* of a frame */
    /* Called with each frame; returns where the next one goes. */
    uint8_t *(*done)(void *ctx, const struct dx_kinect_frame *frame);
    void *ctx;

    struct dx_kinect_frame frame; /* that is being filled */
    bool synced;                  /* we know which packet is next */
    uint8_t sequence;             /* of the next */
    unsigned at;                  /* its place in the frame */
    struct dx_kinect_counts counts;
};

/* For frames of 10 or 11 bits a code; the first one goes to `bytes`. */
void dx_kinect_assembler_init(struct dx_kinect_assembler *a, int bits, uint8_t *bytes,
                              uint8_t *(*done)(void *ctx, const struct dx_kinect_frame *frame),
                              void *ctx);
void dx_kinect_assembler_feed(struct dx_kinect_assembler *a, const uint8_t *packet, size_t len);

/* Packets of a frame, and the payload of packet `k`. */
unsigned dx_kinect_n_packets(size_t frame_len);
size_t dx_kinect_payload_len(size_t frame_len, unsigned k);

#endif
