/*
 * Frames of any source to scan files, to a recording, or to messages of ROS. One thread's.
 */
#ifndef DX_CONVERT_H
#define DX_CONVERT_H

#include "drivers/file/file.h"
#include "tools/out_frames.h"
#include "tools/out_ros.h"

#define DX_CONVERT_ALL UINT64_MAX /* frame: all of them */

struct dx_convert_config {
    struct dx_file_config source;
    const char *out;             /* ends in .mcap: a recording, or messages of ROS */
    enum dx_frame_format format; /* of scan files in a folder */
    enum dx_ros_what ros;        /* of an .mcap */
    struct dx_terrain_params terrain;
    uint64_t frame; /* from 0 */
};

bool dx_convert_is_mcap(const char *out);

/* Errors: -errno with text; nothing is left behind then. */
int dx_convert_run(const struct dx_convert_config *config, struct dx_err *err);

#endif
