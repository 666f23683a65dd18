/* Meshes of files from outside: the first byte chooses the name by which the rest is told; or it is
 * a PLY as `dexel render` reads one. */
#include "drivers/file/triangles.h"
#include "tools/ply_read.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len);

static void parse_list(const uint8_t *bytes, size_t len, const char *name)
{
    struct dx_triangle_list triangles = {0};
    struct dx_point_list points = {0};
    struct dx_err err;

    dx_triangle_list_parse(&triangles, &points, bytes, len, name, &err);
    dx_triangle_list_fini(&triangles);
    dx_point_list_fini(&points);
}

static void parse_mesh(const uint8_t *bytes, size_t len)
{
    struct dx_mesh mesh;
    struct dx_err err;

    dx_ply_parse(&mesh, bytes, len, &err);
    dx_mesh_fini(&mesh);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len)
{
    static const char *const names[] = {"a.ply", "a.obj", "a.stl"};

    if (len && bytes[0] % 4 < 3)
        parse_list(bytes + 1, len - 1, names[bytes[0] % 4]);
    else if (len)
        parse_mesh(bytes + 1, len - 1);
    return 0;
}
