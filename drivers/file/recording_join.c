/* Pieces to blocks. */
#include "drivers/file/recording_join.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

void dx_recording_join_fini(struct dx_recording_join *j)
{
    free(j->bytes);
    *j = (struct dx_recording_join){0};
}

void dx_recording_join_drop(struct dx_recording_join *j)
{
    j->is_open = false;
}

static int make_room(struct dx_recording_join *j, size_t len)
{
    size_t cap = j->cap ? j->cap : (size_t)1 << 16;
    uint8_t *more;

    while (cap < len)
        cap *= 2;
    if (cap == j->cap)
        return 0;
    more = realloc(j->bytes, cap);
    if (!more)
        return -ENOMEM;
    j->bytes = more;
    j->cap = cap;
    return 0;
}

/* Does the piece go on where the block that is open stands? */
static bool follows(const struct dx_recording_join *j, const struct dx_recording_piece *piece)
{
    return j->is_open && piece->number == j->first.number && piece->offset == j->len &&
           piece->block_len == j->first.block_len;
}

int dx_recording_join_take(struct dx_recording_join *j, const struct dx_recording_piece *piece,
                           bool at_frame)
{
    int rc;

    if (piece->offset == 0) {
        j->is_open = !at_frame || (piece->flags & DX_RECORDING_STARTS_FRAME);
        j->first = *piece;
        j->len = 0;
        memcpy(j->source, piece->source, piece->source_len);
        j->source[piece->source_len] = '\0';
    } else if (!follows(j, piece)) {
        j->is_open = false;
    }
    if (!j->is_open)
        return 0;
    rc = make_room(j, j->len + piece->len);
    if (rc)
        return rc;
    if (piece->len)
        memcpy(j->bytes + j->len, piece->bytes, piece->len);
    j->len += piece->len;
    return j->len == j->first.block_len;
}

struct dx_block dx_recording_joined(struct dx_recording_join *j)
{
    j->is_open = false;
    return (struct dx_block){
        .bytes = j->len ? j->bytes : NULL,
        .len = j->len,
        .stamp = {.device_ns = j->first.device_ns, .clock_id = j->first.clock_id},
        .number = j->first.number,
        .first = j->first.flags & DX_RECORDING_FIRST,
        .source = j->source,
    };
}
