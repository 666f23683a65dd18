/* dexel info of scans: every frame through the file driver. */
#include "tools/info.h"

#include "drivers/file/format.h"
#include "tools/source.h"

#include <errno.h>

static const char *format_of(const char *path)
{
    return dx_format_has_ext(path, ".ptx")   ? "PTX"
           : dx_format_has_ext(path, ".pcd") ? "PCD"
                                             : "scans";
}

static bool is_mesh(const char *path)
{
    return dx_format_has_ext(path, ".ply") || dx_format_has_ext(path, ".obj") ||
           dx_format_has_ext(path, ".stl");
}

static int scan_tell(json_t *out, const char *path, const struct dx_info_options *o,
                     struct dx_err *err)
{
    /* scans have no index, and no times: all is read */
    const struct dx_info_options all = {.gap_ns = o->gap_ns};
    uint64_t n_damaged = 0;
    json_t *damage;
    int rc;

    if (is_mesh(path))
        return dx_err_set(err, -EINVAL, "%s: a mesh, expected a scan or a recording", path);
    damage = json_array();
    json_object_set_new(out, "format", json_string(format_of(path)));
    rc = dx_info_frames(out, damage, &n_damaged, dx_source_driver(path), path, err);
    dx_info_sound(out, n_damaged, damage, &all);
    return rc;
}

static bool scan_probe(const char *path, const uint8_t *bytes, size_t len)
{
    (void)path;
    (void)bytes;
    (void)len;
    return true;
}

const struct dx_info_kind dx_info_scan = {scan_probe, scan_tell};
