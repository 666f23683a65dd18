/* dexel info of scans: every frame through the file driver. */
#include "tools/info.h"

#include "drivers/file/format.h"

static const char *format_of(const char *path)
{
    return dx_format_has_ext(path, ".ptx")   ? "PTX"
           : dx_format_has_ext(path, ".pcd") ? "PCD"
                                             : "scans";
}

static int scan_tell(json_t *out, const char *path, const struct dx_info_options *o,
                     struct dx_err *err)
{
    json_t *damage = json_array();
    int rc;

    (void)o; /* scans have no index, and no times */
    json_object_set_new(out, "format", json_string(format_of(path)));
    rc = dx_info_frames(out, damage, path, err);
    json_object_set_new(out, "sound", json_boolean(json_array_size(damage) == 0));
    json_object_set_new(out, "damaged", json_integer((json_int_t)json_array_size(damage)));
    json_object_set_new(out, "damage", damage);
    return rc;
}

static bool scan_probe(const uint8_t *bytes, size_t len)
{
    (void)bytes;
    (void)len;
    return true;
}

const struct dx_info_kind dx_info_scan = {scan_probe, scan_tell};
