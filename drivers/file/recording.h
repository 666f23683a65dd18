/*
 * What a recording is inside its MCAP file (docs/recorder.md): raw blocks of a device as messages
 * of one channel, each in one piece or in several, and attachments that make it replay by itself.
 * Pure functions; reading leaves views into the given bytes and trusts nothing.
 */
#ifndef DX_RECORDING_H
#define DX_RECORDING_H

#include "drivers/driver.h"

#define DX_RECORDING_TOPIC         "/dexel/raw"
#define DX_RECORDING_ENCODING      "x-dexel-raw"
#define DX_RECORDING_CHANNEL       1
#define DX_RECORDING_CONFIG        "dexeld.yaml" /* attachment: the stream's configuration */
#define DX_RECORDING_CONFIG_NAME   "dexeld.yaml of the recording" /* in errors about it */
#define DX_RECORDING_CONFIG_TYPE   "application/yaml"
#define DX_RECORDING_GEOMETRY      "geometry" /* attachment: in force from its log time on */
#define DX_RECORDING_GEOMETRY_TYPE "application/x-dexel-geometry"
#define DX_RECORDING_GAP           "dexel.gap" /* metadata: blocks that were not recorded */

#define DX_RECORDING_PIECE         ((size_t)256 << 10) /* most bytes of a block in a message */
#define DX_RECORDING_MAX_BLOCK     ((size_t)1 << 30)   /* a longer one counts as damaged */
#define DX_RECORDING_HEAD          40                  /* before source and bytes */
#define DX_RECORDING_MAX_SOURCE    4128                /* of a source's name */

#define DX_RECORDING_STARTS_FRAME  0x1u /* the block before it ended a frame, or there was none */
#define DX_RECORDING_FIRST         0x2u /* of a stay of the device: dx_block.first */

/* A message: `len` bytes at `offset` of a block of `block_len`. */
struct dx_recording_piece {
    uint64_t number, device_ns;
    uint32_t clock_id;
    uint16_t flags;
    uint64_t block_len, offset;
    const char *source; /* not NUL-terminated; in the first piece of a block only */
    uint16_t source_len;
    const uint8_t *bytes;
    size_t len;
};

/* The piece of a block that begins at `offset`, as long as it may be. */
struct dx_recording_piece dx_recording_piece_of(const struct dx_block *block, bool starts_frame,
                                                size_t offset);
size_t dx_recording_piece_len(const struct dx_recording_piece *p);
/* Room of dx_recording_piece_len(). */
void dx_recording_put_piece(uint8_t *out, const struct dx_recording_piece *p);
/* -EBADMSG: shorter than it says, or beyond the block's end or the bounds. */
int dx_recording_get_piece(struct dx_recording_piece *out, const uint8_t *bytes, size_t len);

size_t dx_recording_geometry_len(const struct dx_geometry *g);
void dx_recording_put_geometry(uint8_t *out, const struct dx_geometry *g, uint8_t attr_bytes);
/* A new geometry, the caller's. -EBADMSG, -ENOMEM. */
int dx_recording_get_geometry(struct dx_geometry **out, uint8_t *attr_bytes, const uint8_t *bytes,
                              size_t len);

#endif
