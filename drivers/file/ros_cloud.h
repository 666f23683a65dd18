/*
 * sensor_msgs/msg/PointCloud2 of ROS 2: the text of its schema for a recording, and the message to
 * CDR and back. An organized cloud has a height above 1; a point without return is NaN. Views point
 * into the caller's memory.
 */
#ifndef DX_ROS_CLOUD_H
#define DX_ROS_CLOUD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define DX_ROS_MAX_FIELDS 32 /* of a cloud that is read; more are refused */

/* For a Schema record of encoding "ros2msg", and the encoding of its channels' messages. */
#define DX_ROS_CLOUD_NAME "sensor_msgs/msg/PointCloud2"
extern const char dx_ros_cloud_schema[];

enum dx_ros_type {
    DX_ROS_INT8 = 1,
    DX_ROS_UINT8 = 2,
    DX_ROS_INT16 = 3,
    DX_ROS_UINT16 = 4,
    DX_ROS_INT32 = 5,
    DX_ROS_UINT32 = 6,
    DX_ROS_FLOAT32 = 7,
    DX_ROS_FLOAT64 = 8,
};

/* Bytes of a value; 0: no such type. */
size_t dx_ros_type_len(uint8_t type);

struct dx_ros_field {
    const char *name;
    uint32_t name_len;
    uint32_t offset; /* in the point */
    uint8_t type;
    uint32_t count;
};

struct dx_ros_cloud {
    uint64_t stamp_ns; /* of the UNIX epoch */
    const char *frame_id;
    uint32_t frame_id_len;
    uint32_t height, width;
    struct dx_ros_field fields[DX_ROS_MAX_FIELDS];
    uint32_t n_fields;
    bool is_big_endian, is_dense;
    uint32_t point_step, row_step;
    const uint8_t *data; /* height rows of row_step bytes */
    uint32_t data_len;
};

/* Appends a field of one value behind those that are there, and makes points and rows longer by it.
 */
void dx_ros_cloud_add_field(struct dx_ros_cloud *c, const char *name, enum dx_ros_type type);

/* Bytes of the encoded message, with data of height * row_step bytes. */
size_t dx_ros_cloud_len(const struct dx_ros_cloud *c);
/* Encodes all but the data (and is_dense behind them), and returns where they go: the caller fills
 * height * row_step bytes. NULL: more than `cap`. */
uint8_t *dx_ros_cloud_put(const struct dx_ros_cloud *c, uint8_t *out, size_t cap);

/* Reads a message and checks that its fields lie in a point, its points in a row, its rows in the
 * data. -EBADMSG. */
int dx_ros_cloud_get(struct dx_ros_cloud *out, const uint8_t *bytes, size_t len);
/* The field of this name, or NULL. */
const struct dx_ros_field *dx_ros_cloud_field(const struct dx_ros_cloud *c, const char *name);
/* A field's first value of a point, as a number. */
double dx_ros_cloud_value(const struct dx_ros_cloud *c, const struct dx_ros_field *f, uint32_t row,
                          uint32_t col);

#endif
