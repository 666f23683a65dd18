/* Organized formats as clouds: the returns of all scans of a file, in the world's frame. */
#include "drivers/file/points_priv.h"

#include "drivers/file/format.h"

#include <errno.h>
#include <math.h>

static int add_frame(struct dx_point_list *list, const struct dx_xyz_frame *f, struct dx_err *err)
{
    const size_t n = (size_t)f->height * f->width;
    int rc = dx_point_list_reserve(list, n, err);

    for (size_t k = 0; k < n && rc == 0; k++) {
        const double *p = f->xyz + 3 * k, *m = f->pose;
        double world[3];

        if (isnan(p[0]))
            continue;
        for (int i = 0; i < 3; i++)
            world[i] = m[4 * i] * p[0] + m[4 * i + 1] * p[1] + m[4 * i + 2] * p[2] + m[4 * i + 3];
        rc = dx_point_list_add(list, world, err);
    }
    return rc;
}

static int ptx_parse(struct dx_point_list *list, const uint8_t *bytes, size_t len,
                     struct dx_err *err)
{
    struct dx_xyz_frame f = {0};
    int rc = 0;

    while (len > 0 && rc == 0) {
        const int64_t block_len = dx_format_ptx.block_len(bytes, len, err);

        if (block_len <= 0 || (uint64_t)block_len > len) {
            rc = (int)block_len;
            break;
        }
        rc = dx_format_ptx.decode(&f, bytes, (size_t)block_len, err);
        if (rc == 0)
            rc = add_frame(list, &f, err);
        bytes += block_len;
        len -= (size_t)block_len;
    }
    dx_xyz_frame_fini(&f);
    return rc;
}

static int pcd_parse(struct dx_point_list *list, const uint8_t *bytes, size_t len,
                     struct dx_err *err)
{
    struct dx_xyz_frame f = {0};
    int rc = dx_pcd_decode_any(&f, bytes, len, err);

    if (rc == 0)
        rc = add_frame(list, &f, err);
    dx_xyz_frame_fini(&f);
    return rc;
}

static bool pcd_probe(const uint8_t *bytes, size_t len)
{
    return dx_format_pcd.probe(bytes, len);
}

/* A PTX begins as lines of numbers do: its name tells. */
const struct dx_points_format dx_points_ptx = {".ptx", NULL, ptx_parse};
const struct dx_points_format dx_points_pcd = {".pcd", pcd_probe, pcd_parse};
