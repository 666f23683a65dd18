/*
 * foxglove_msgs/msg/SceneUpdate of ROS 2: the text of its schema for a recording, and a mesh as one
 * entity of it in CDR. An entity replaces the one that had its id, and stays until it is replaced
 * or deleted. Nothing is owned: the arrays are the caller's.
 */
#ifndef DX_ROS_SCENE_H
#define DX_ROS_SCENE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* For a Schema record of encoding "ros2msg", and the encoding of its channels' messages. */
#define DX_ROS_SCENE_NAME "foxglove_msgs/msg/SceneUpdate"
extern const char dx_ros_scene_schema[];

/* Triangles of one entity. Three indices each; none at all: the update has no entity. */
struct dx_ros_scene {
    uint64_t stamp_ns;                  /* of the UNIX epoch */
    const char *frame_id;               /* in which the points are */
    const char *id;                     /* of the entity */
    bool clears;                        /* all that was sent before is deleted */
    double position[3], orientation[4]; /* of the points in the frame; quaternion x, y, z, w */
    const float *points;                /* [n_points][3], metres */
    uint32_t n_points;
    const uint32_t *indices; /* [n_indices] */
    uint32_t n_indices;
    double color[4];     /* red, green, blue, alpha, each 0..1: of all points */
    const float *colors; /* [n_points][4], or NULL: of each */
};

/* Bytes of the encoded message, and writes it into room of `cap` bytes; when it does not fit, what
 * was written is of no use. */
size_t dx_ros_scene_put(const struct dx_ros_scene *s, uint8_t *out, size_t cap);

#endif
