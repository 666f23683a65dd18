/* Points of files from outside: the first byte chooses the name by which the rest is told. */
#include "drivers/file/points.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len);

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len)
{
    static const char *const names[] = {"a.xyz", "a.ply", "a.pcd", "a.obj", "a.stl", "a.ptx"};
    struct dx_point_list list = {0};
    struct dx_err err;

    if (len)
        dx_point_list_parse(&list, bytes + 1, len - 1, names[bytes[0] % 6], &err);
    dx_point_list_fini(&list);
    return 0;
}
