/*
 * Messages of ROS 2 as a format: a sensor_msgs/msg/PointCloud2 in CDR is one frame, when it is
 * organized. NaN or 0 0 0 is no return. The attribute is "intensity", else "reflectivity". Messages
 * come out of an MCAP file (cloud_bag.h), or out of a recording.
 */
#include "drivers/file/format.h"

#include "core/grid/plane.h"
#include "drivers/file/ros_cloud.h"

#include <errno.h>

/* The head of plain CDR, of either byte order: no text begins so. */
static bool ros_probe(const uint8_t *bytes, size_t len)
{
    return len > 4 && bytes[0] == 0 && bytes[1] <= 1;
}

/* A block is a message. */
static int64_t ros_block_len(const uint8_t *bytes, size_t len, struct dx_err *err)
{
    (void)bytes;
    (void)err;
    return (int64_t)len;
}

static int check_size(const struct dx_ros_cloud *c, struct dx_err *err)
{
    if (c->height < 2 || c->width < 2)
        return dx_err_set(
            err, -EBADMSG,
            "found a cloud of %u x %u points, expected an organized one: its points in "
            "rows (height) and columns (width) as they were scanned",
            c->width, c->height);
    if (c->height > DX_PLANE_MAX_SIDE || c->width > DX_PLANE_MAX_SIDE ||
        (uint64_t)c->height * c->width > DX_PLANE_MAX_DEXELS)
        return dx_err_set(err, -EBADMSG,
                          "found a cloud of %u x %u points, expected sides to %u and at most %u "
                          "points",
                          c->width, c->height, DX_PLANE_MAX_SIDE, DX_PLANE_MAX_DEXELS);
    return 0;
}

static int find_axes(const struct dx_ros_field *axes[3], const struct dx_ros_cloud *c,
                     struct dx_err *err)
{
    static const char *const names[3] = {"x", "y", "z"};

    for (int k = 0; k < 3; k++) {
        axes[k] = dx_ros_cloud_field(c, names[k]);
        if (!axes[k] || axes[k]->type < DX_ROS_FLOAT32)
            return dx_err_set(err, -EBADMSG, "%s field '%s', expected one of float32 or float64",
                              axes[k] ? "a whole-numbered" : "no", names[k]);
    }
    return 0;
}

/* What intensities are is known of small whole numbers alone; others are scaled by their extent. */
static void finish_attr(struct dx_xyz_frame *f, const struct dx_ros_field *attr)
{
    size_t n = (size_t)f->height * f->width;

    if (attr->type != DX_ROS_UINT8 && attr->type != DX_ROS_UINT16) {
        dx_xyz_frame_scale(f);
        return;
    }
    f->attr = f->attr_room;
    f->attr_bytes = attr->type == DX_ROS_UINT8 ? 1 : 2;
    for (size_t k = 0; k < n; k++)
        f->attr[k] = (uint16_t)f->intensity[k];
}

static void take_points(struct dx_xyz_frame *f, const struct dx_ros_cloud *c,
                        const struct dx_ros_field *axes[3], const struct dx_ros_field *attr)
{
    for (uint32_t row = 0; row < c->height; row++)
        for (uint32_t col = 0; col < c->width; col++) {
            size_t k = (size_t)row * c->width + col;
            double v = attr ? dx_ros_cloud_value(c, attr, row, col) : 0;

            dx_xyz_frame_set(f, k, dx_ros_cloud_value(c, axes[0], row, col),
                             dx_ros_cloud_value(c, axes[1], row, col),
                             dx_ros_cloud_value(c, axes[2], row, col));
            /* beyond float there is no intensity; the conversion would be undefined */
            f->intensity[k] = v > -3e38 && v < 3e38 ? (float)v : 0;
        }
}

static int ros_decode(struct dx_xyz_frame *out, const uint8_t *bytes, size_t len,
                      struct dx_err *err)
{
    const struct dx_ros_field *axes[3], *attr;
    struct dx_ros_cloud c;
    int rc = dx_ros_cloud_get(&c, bytes, len);

    if (rc)
        return dx_err_set(err, rc, "no whole message of " DX_ROS_CLOUD_NAME);
    rc = check_size(&c, err);
    if (rc == 0)
        rc = find_axes(axes, &c, err);
    if (rc)
        return rc;
    rc = dx_xyz_frame_reserve(out, c.height, c.width);
    if (rc)
        return dx_err_set(err, rc, "no memory for %u x %u points", c.width, c.height);
    attr = dx_ros_cloud_field(&c, "intensity");
    if (!attr)
        attr = dx_ros_cloud_field(&c, "reflectivity");
    take_points(out, &c, axes, attr);
    if (attr)
        finish_attr(out, attr);
    return 0;
}

const struct dx_format dx_format_ros = {"PointCloud2", ".mcap", ros_probe, ros_block_len,
                                        ros_decode};
