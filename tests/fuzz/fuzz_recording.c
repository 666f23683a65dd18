/*
 * What a recording holds, from bytes: pieces of blocks and geometries. What is accepted comes out
 * as the same bytes again (a geometry's, but for its flags, which are read as yes or no).
 */
#include "drivers/file/recording.h"

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

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len)
{
    try_piece(bytes, len);
    try_geometry(bytes, len);
    return 0;
}
