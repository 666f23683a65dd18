/* Meshes of files from outside: the first byte chooses the name by which the rest is told. */
#include "drivers/file/triangles.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len);

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len)
{
    static const char *const names[] = {"a.ply", "a.obj", "a.stl"};
    struct dx_triangle_list triangles = {0};
    struct dx_point_list points = {0};
    struct dx_err err;

    if (len)
        dx_triangle_list_parse(&triangles, &points, bytes + 1, len - 1, names[bytes[0] % 3], &err);
    dx_triangle_list_fini(&triangles);
    dx_point_list_fini(&points);
    return 0;
}
