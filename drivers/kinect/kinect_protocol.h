/*
 * The camera's control messages: 8 bytes of header ("GM" from the host, "RB" from the device; words
 * of payload, command, tag), then 16-bit words, all little-endian. Pure functions, any thread.
 * Source: the OpenKinect project's notes on the protocol.
 */
#ifndef DX_KINECT_PROTOCOL_H
#define DX_KINECT_PROTOCOL_H

#include "core/base/err.h"
#include "drivers/kinect/kinect_depth.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define DX_KINECT_MESSAGE_LEN 8
#define DX_KINECT_MAX_WORDS   8     /* of our requests */
#define DX_KINECT_REPLY_LEN   0x200 /* what is asked for; a reply of that length is none */

enum dx_kinect_command {
    DX_KINECT_WRITE = 0x03, /* register, value */
    DX_KINECT_FIXED = 0x04, /* the constants that were fixed when it was made */
    DX_KINECT_ALGORITHM = 0x16,
};

enum dx_kinect_register {
    DX_KINECT_DEPTH_STREAM = 0x06, /* 0 stop, 2 start */
    DX_KINECT_DEPTH_FORMAT = 0x12,
    DX_KINECT_DEPTH_SIZE = 0x13,
    DX_KINECT_DEPTH_FPS = 0x14,
    DX_KINECT_PROJECTOR = 0x15, /* brightness, 1..50 */
    DX_KINECT_DEPTH_MIRROR = 0x17,
    DX_KINECT_PROJECTOR_CYCLE = 0x105,
    DX_KINECT_NEAR = 0x2ef,
};

struct dx_kinect_write {
    uint16_t reg, value;
};

/* Writes a request; returns its length. */
size_t dx_kinect_request_put(uint8_t bytes[DX_KINECT_MESSAGE_LEN + 2 * DX_KINECT_MAX_WORDS],
                             uint16_t command, uint16_t tag, const uint16_t *words,
                             unsigned n_words);

/* Is this the whole reply to the request? Its payload, or NULL with a text. */
const uint8_t *dx_kinect_reply_get(const uint8_t *bytes, size_t len, uint16_t command, uint16_t tag,
                                   size_t *payload_len, struct dx_err *err);

/* The registers that start the depth stream, in order. */
#define DX_KINECT_N_START 7
void dx_kinect_start_writes(struct dx_kinect_write out[DX_KINECT_N_START], int bits);
/* Kinect for Windows: near mode on or off; between the two 100 ms go by. */
void dx_kinect_near_writes(struct dx_kinect_write out[2], bool near);

/* From the payloads of FIXED and of ALGORITHM 0. False: too short. */
bool dx_kinect_fixed_get(struct dx_kinect_constants *c, const uint8_t *payload, size_t len);
bool dx_kinect_shift_get(struct dx_kinect_constants *c, const uint8_t *payload, size_t len);

#endif
