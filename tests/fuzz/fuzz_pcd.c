/* PCD from outside: a block's length, then its points. */
#include "drivers/file/format.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len);

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len)
{
    struct dx_xyz_frame frame = {0};
    struct dx_err err;
    int64_t block_len = dx_format_pcd.block_len(bytes, len, &err);

    dx_format_pcd.probe(bytes, len);
    /* a file whose length is in doubt is decoded all the same: the driver does so, for the message
     */
    if (block_len < 0 || (uint64_t)block_len > len)
        block_len = (int64_t)len;
    dx_format_pcd.decode(&frame, bytes, (size_t)block_len, &err);
    dx_xyz_frame_fini(&frame);
    return 0;
}
