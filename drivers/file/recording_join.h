/*
 * The pieces of a recording, as they lie in the file, put together to blocks again. A block of
 * which a piece is missing is dropped. One owner, one thread.
 */
#ifndef DX_RECORDING_JOIN_H
#define DX_RECORDING_JOIN_H

#include "drivers/file/recording.h"

/* Zeroed: nothing is begun. */
struct dx_recording_join {
    uint8_t *bytes;
    size_t len, cap;
    bool is_open;
    struct dx_recording_piece first; /* of the block; its texts and bytes are gone */
    char source[DX_RECORDING_MAX_SOURCE + 1];
};

void dx_recording_join_fini(struct dx_recording_join *j);
/* What is begun will not be finished. */
void dx_recording_join_drop(struct dx_recording_join *j);

/* Takes a piece; 1: the block is whole, 0: not yet, or the piece is of no use; -ENOMEM. With
 * `at_frame` only a block that starts a frame is begun. Memory grows with the bytes that are there,
 * not with what a piece says of its block. */
int dx_recording_join_take(struct dx_recording_join *j, const struct dx_recording_piece *piece,
                           bool at_frame);
/* The block that is whole: its memory is the join's, until the next take. */
struct dx_block dx_recording_joined(struct dx_recording_join *j);

#endif
