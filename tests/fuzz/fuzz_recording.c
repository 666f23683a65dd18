/*
 * What a recording holds, from bytes: pieces of blocks and geometries. What is accepted comes out
 * as the same bytes again (a geometry's, but for its flags, which are read as yes or no). And as a
 * row of pieces, each after its length (2), put together to blocks.
 */
#include "core/base/bytes.h"
#include "drivers/file/recording_join.h"

#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len);

static void try_piece(const uint8_t *bytes, size_t len)
{
    struct dx_recording_piece p;
    uint8_t *again;

    if (dx_recording_get_piece(&p, bytes, len) != 0)
        return;
    if (dx_recording_piece_len(&p) != len)
        abort();
    again = malloc(len);
    if (!again)
        return;
    dx_recording_put_piece(again, &p);
    if (memcmp(again, bytes, len) != 0)
        abort();
    free(again);
}

static void try_geometry(const uint8_t *bytes, size_t len)
{
    struct dx_geometry *g;
    uint8_t attr_bytes;

    if (dx_recording_get_geometry(&g, &attr_bytes, bytes, len) != 0)
        return;
    if (dx_recording_geometry_len(g) != len || attr_bytes > 2)
        abort();
    dx_geometry_unref(g);
}

static void check_block(struct dx_recording_join *join)
{
    const struct dx_block block = dx_recording_joined(join);
    volatile uint8_t sum = 0;

    if (block.len != join->first.block_len || strlen(block.source) > DX_RECORDING_MAX_SOURCE)
        abort();
    for (size_t k = 0; k < block.len; k++)
        sum = (uint8_t)(sum + block.bytes[k]);
}

static void try_join(const uint8_t *bytes, size_t len)
{
    struct dx_recording_join join = {0};

    while (len >= 2) {
        size_t piece_len = dx_get_u16(bytes);
        struct dx_recording_piece p;

        bytes += 2;
        len -= 2;
        piece_len = piece_len < len ? piece_len : len;
        if (dx_recording_get_piece(&p, bytes, piece_len) == 0 &&
            dx_recording_join_take(&join, &p, len % 2) == 1)
            check_block(&join);
        bytes += piece_len;
        len -= piece_len;
    }
    dx_recording_join_fini(&join);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len)
{
    try_piece(bytes, len);
    try_geometry(bytes, len);
    try_join(bytes, len);
    return 0;
}
