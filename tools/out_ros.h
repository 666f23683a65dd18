/*
 * An MCAP file for ROS 2 tools and Foxglove: of each frame a PointCloud2, a SceneUpdate with its
 * mesh, or both. Points are in the scanner's frame. One thread's.
 */
#ifndef DX_OUT_ROS_H
#define DX_OUT_ROS_H

#include "core/grid/terrain.h"
#include "drivers/file/mcap_write.h"
#include "tools/mesh.h"
#include "tools/out_file.h"

#define DX_ROS_CLOUD_TOPIC "/dexel/points"
#define DX_ROS_MESH_TOPIC  "/dexel/mesh"
#define DX_ROS_FRAME       "scanner"

/* NULL-terminated, by enum dx_ros_what: "none", "clouds", "mesh", "both". */
enum dx_ros_what { DX_ROS_NONE, DX_ROS_CLOUDS, DX_ROS_MESH, DX_ROS_BOTH };
extern const char *const dx_ros_whats[];

struct dx_out_ros {
    struct dx_out_file file;
    enum dx_ros_what what;
    struct dx_mcap_writer *writer; /* from the first frame on */
    uint8_t *message;
    size_t message_cap;
    uint32_t n_frames, n_scenes;

    /* the mesh */
    struct dx_terrain_params params; /* sigma: the estimate, once a frame has told it */
    struct dx_terrain *terrain;      /* of the geometry that was told last */
    struct dx_pool *pool;
    struct dx_ros_part *part;
};

/* `params` is for meshes. Errors: -errno, the path in the text; zeroed then. */
int dx_out_ros_open(struct dx_out_ros *o, const char *path, enum dx_ros_what what,
                    const struct dx_terrain_params *params, struct dx_err *err);

/* Before the first frame, and when it changes. */
int dx_out_ros_geometry(struct dx_out_ros *o, struct dx_geometry *g, uint8_t attr_bytes,
                        struct dx_err *err);
/* A whole frame, at `time` of the UNIX epoch, ns. */
int dx_out_ros_add(struct dx_out_ros *o, const struct dx_plane *plane, const struct dx_geometry *g,
                   uint64_t time, struct dx_err *err);

/* Puts the file in its place; no frame at all is -ENODATA. `o` is zeroed, whatever is returned. */
int dx_out_ros_commit(struct dx_out_ros *o, struct dx_err *err);
/* Takes it back. Zeroed is fine. */
void dx_out_ros_abort(struct dx_out_ros *o);

#endif
