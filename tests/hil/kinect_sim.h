/*
 * A Kinect's camera as bytes: answers to control messages, and the packets of its depth endpoint
 * from codes or depths, with faults on demand. Knows nothing of USB: unit tests feed it to the
 * driver's parts, a device program puts it behind a guest's controller. One thread.
 */
#ifndef DX_KINECT_SIM_H
#define DX_KINECT_SIM_H

#include "drivers/kinect/kinect_depth.h"
#include "drivers/kinect/kinect_packets.h"

#include <stdbool.h>

#define KINECT_SIM_N_REGISTERS 0x400

struct kinect_sim_faults {
    uint32_t lose_ppm;                       /* packets that are lost by chance */
    unsigned lose_at, lose_n;                /* and n of each frame from this one on */
    uint32_t magic_ppm, flag_ppm, short_ppm; /* wrong magic, wrong flag, cut */
    unsigned idle_every;                     /* each so many packets, an empty one besides */
    unsigned n_silent;                       /* replies that come empty, for each request */
    unsigned n_stale;                        /* and then replies with the tag of before */
    bool refuse;                             /* registers answer status 1 */
};

struct kinect_sim {
    struct dx_kinect_constants constants;
    bool windows;
    struct kinect_sim_faults faults;
    /* The frame that is sent again and again; its length by the format register. */
    uint8_t packed[DX_KINECT_PIXELS / 8 * 11];
    uint16_t registers[KINECT_SIM_N_REGISTERS];
    /* the stream */
    uint64_t random;
    unsigned at; /* next packet of the frame */
    uint8_t sequence;
    uint32_t ticks, ticks_a_frame;
    uint64_t n_frames; /* sent to the end */
    /* the conversation */
    uint8_t reply[512];
    size_t reply_len;
    unsigned n_silent, n_stale;
    unsigned n_requests;
};

/* Usual constants, 11 bits, all codes 2047, stopped. */
void kinect_sim_init(struct kinect_sim *sim);
int kinect_sim_bits(const struct kinect_sim *sim);
bool kinect_sim_streams(const struct kinect_sim *sim);
/* What is sent from the next frame's beginning on: 640 * 480 codes, or millimetres (0: none). */
void kinect_sim_codes(struct kinect_sim *sim, const uint16_t *codes);
void kinect_sim_depths(struct kinect_sim *sim, const uint16_t *mm);

/* The next packet of the endpoint; 0: an empty one. It may be one that a fault has changed; those
 * that are lost are passed over. */
size_t kinect_sim_packet(struct kinect_sim *sim, uint8_t packet[DX_KINECT_PACKET_LEN]);

/* Control transfers of the vendor: bytes that came, bytes that go (-1: stall). */
int kinect_sim_out(struct kinect_sim *sim, const uint8_t *bytes, size_t len);
int kinect_sim_in(struct kinect_sim *sim, uint8_t *bytes, size_t len);

/* Packs codes as the camera does. */
void kinect_sim_pack(uint8_t *packed, const uint16_t *codes, size_t n, int bits);

#endif
