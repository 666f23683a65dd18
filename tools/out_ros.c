/* Frames to messages of ROS 2. */
#include "tools/out_ros.h"

#include "core/base/pool.h"
#include "drivers/file/mcap_record.h"
#include "drivers/file/ros_cloud.h"
#include "drivers/file/ros_scene.h"
#include "tools/mesh_store.h"
#include "tools/ros_part.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A mesh is 24 bytes a vertex and 12 a triangle, of which there are two a vertex; and what comes
 * before. */
#define VERTEX_LEN 48
#define SCENE_HEAD 4096
/* A chunk is a message and the definitions of its channel. */
#define MAX_LEN (DX_MCAP_MAX_CHUNK - ((size_t)1 << 20) - 4096)
/* Later frames may be larger than the first one, within this in one message. */
#define MIN_LEN ((size_t)16 << 20)

enum { CLOUD = 1, SCENE = 2 }; /* channels, and their schemas */

const char *const dx_ros_whats[] = {[DX_ROS_NONE] = "none",
                                    [DX_ROS_CLOUDS] = "clouds",
                                    [DX_ROS_MESH] = "mesh",
                                    [DX_ROS_BOTH] = "both",
                                    NULL};

static bool has(const struct dx_out_ros *o, enum dx_ros_what what)
{
    return o->what == what || o->what == DX_ROS_BOTH;
}

/* What a call returned, in words. */
static int failed(struct dx_out_ros *o, int rc, struct dx_err *err)
{
    if (rc == DX_MCAP_E_FULL)
        return dx_err_set(err, -EFBIG, "%s: more than one file can hold", o->file.path);
    return rc ? dx_err_set(err, rc, "%s: cannot be written: %s", o->file.path, strerror(-rc)) : 0;
}

/* ---- the file --------------------------------------------------------------------------------
 */

static int declare(struct dx_mcap_writer *w, uint16_t id, const char *topic, const char *name,
                   const char *schema)
{
    const struct dx_mcap_schema s = {
        id, dx_mcap_text(name), dx_mcap_text("ros2msg"), {(const uint8_t *)schema, strlen(schema)}};
    /* the profile "ros2" asks for it; nothing is known of it here */
    const struct dx_mcap_pair qos = {dx_mcap_text("offered_qos_profiles"), dx_mcap_text("")};
    uint8_t map[64];
    struct dx_writer out = dx_writer_init(map, sizeof(map));
    struct dx_mcap_channel c = {.id = id,
                                .schema_id = id,
                                .topic = dx_mcap_text(topic),
                                .message_encoding = dx_mcap_text("cdr")};
    int rc = dx_mcap_writer_schema(w, &s);

    dx_mcap_put_pairs(&out, &qos, 1);
    c.metadata = (struct dx_mcap_bytes){map, (size_t)(out.p - map)};
    return rc ? rc : dx_mcap_writer_channel(w, &c);
}

/* Room for messages of `len` bytes, and the writer that takes them. */
static int begin(struct dx_out_ros *o, size_t len)
{
    const struct dx_mcap_writer_config config = {
        .compression = DX_MCAP_ZSTD, .max_message = len, .profile = "ros2"};
    const struct dx_mcap_sink sink = dx_mcap_sink_fd(fileno(o->file.stream));
    int rc;

    o->message = malloc(len);
    o->message_cap = len;
    if (!o->message)
        return -ENOMEM;
    rc = dx_mcap_writer_new(&o->writer, &config, NULL);
    if (rc == 0 && has(o, DX_ROS_CLOUDS))
        rc = declare(o->writer, CLOUD, DX_ROS_CLOUD_TOPIC, DX_ROS_CLOUD_NAME, dx_ros_cloud_schema);
    if (rc == 0 && has(o, DX_ROS_MESH))
        rc = declare(o->writer, SCENE, DX_ROS_MESH_TOPIC, DX_ROS_SCENE_NAME, dx_ros_scene_schema);
    return rc ? rc : dx_mcap_writer_begin(o->writer, &sink);
}

static int put(struct dx_out_ros *o, uint16_t channel, uint32_t sequence, uint64_t time, size_t len)
{
    const struct dx_mcap_message m = {.channel_id = channel,
                                      .sequence = sequence,
                                      .log_time = time,
                                      .publish_time = time,
                                      .data = {o->message, len}};

    return dx_mcap_writer_message(o->writer, &m);
}

int dx_out_ros_open(struct dx_out_ros *o, const char *path, enum dx_ros_what what,
                    const struct dx_terrain_params *params, struct dx_err *err)
{
    int rc;

    *o = (struct dx_out_ros){.what = what, .params = *params};
    rc = dx_out_file_open(&o->file, path, err);
    if (rc < 0)
        return rc;
    if (has(o, DX_ROS_MESH)) {
        rc = failed(o, dx_pool_new(&o->pool, 0), err);
    }
    if (rc < 0)
        dx_out_ros_abort(o);
    return rc;
}

int dx_out_ros_commit(struct dx_out_ros *o, struct dx_err *err)
{
    int rc = o->writer ? failed(o, dx_mcap_writer_finish(o->writer), err)
                       : dx_err_set(err, -ENODATA, "%s: not written: no frames", o->file.path);

    if (rc == 0)
        rc = dx_out_file_commit(&o->file, err);
    dx_out_ros_abort(o);
    return rc;
}

void dx_out_ros_abort(struct dx_out_ros *o)
{
    dx_mcap_writer_free(o->writer);
    dx_out_file_abort(&o->file);
    dx_terrain_free(o->terrain);
    dx_pool_free(o->pool);
    dx_ros_part_free(o->part);
    free(o->message);
    *o = (struct dx_out_ros){0};
}

/* ---- clouds ----------------------------------------------------------------------------------
 */

static struct dx_ros_cloud cloud_of(const struct dx_plane *plane, uint64_t time)
{
    struct dx_ros_cloud c = {.stamp_ns = time,
                             .frame_id = DX_ROS_FRAME,
                             .frame_id_len = sizeof(DX_ROS_FRAME) - 1,
                             .height = plane->height,
                             .width = plane->width};

    dx_ros_cloud_add_field(&c, "x", DX_ROS_FLOAT32);
    dx_ros_cloud_add_field(&c, "y", DX_ROS_FLOAT32);
    dx_ros_cloud_add_field(&c, "z", DX_ROS_FLOAT32);
    if (plane->attr_bytes)
        dx_ros_cloud_add_field(&c, "intensity", DX_ROS_FLOAT32);
    return c;
}

/* A return's own point where the plane has them; the intensity from 0 to 1, as PCD has it. */
static void put_point(uint8_t *to, const struct dx_plane *plane, const struct dx_geometry *g,
                      uint32_t row, uint32_t col)
{
    size_t k = (size_t)row * plane->width + col;
    uint32_t range = dx_plane_range(plane, k);
    float p[4] = {NAN, NAN, NAN, 0};

    if (range && plane->xyz)
        memcpy(p, plane->xyz + 3 * k, 3 * sizeof(*p));
    else if (range)
        dx_geometry_point(g, row, col, range, p);
    if (range && plane->attr_bytes)
        p[3] = (float)(dx_plane_attr(plane, k) / (plane->attr_bytes == 1 ? 255.0 : 65535.0));
    dx_put_f32s(to, p, plane->attr_bytes ? 4 : 3);
}

static int add_cloud(struct dx_out_ros *o, const struct dx_plane *plane,
                     const struct dx_geometry *g, uint64_t time)
{
    const struct dx_ros_cloud c = cloud_of(plane, time);
    uint8_t *to = dx_ros_cloud_put(&c, o->message, o->message_cap);

    if (!to)
        return -EMSGSIZE;
    for (uint32_t row = 0; row < plane->height; row++)
        for (uint32_t col = 0; col < plane->width; col++, to += c.point_step)
            put_point(to, plane, g, row, col);
    return put(o, CLOUD, o->n_frames, time, dx_ros_cloud_len(&c));
}

/* ---- meshes ----------------------------------------------------------------------------------
 */

static int weld(struct dx_mesh *mesh, const struct dx_terrain *t)
{
    const struct dx_geometry *g = dx_terrain_geometry(t);
    const struct dx_tiling *tiling = dx_terrain_tiling(t);
    struct {
        struct dx_tile tile;
        struct dx_tile_mesh mesh;
    } *x = malloc(sizeof(*x));
    struct dx_mesh_store *store = NULL;
    int rc = x ? dx_mesh_store_new(&store, g->height, g->width, g->wrap, 0) : -ENOMEM;

    for (uint32_t n = 0; rc == 0 && n < dx_tiling_n_tiles(tiling); n++) {
        if (!dx_terrain_tile(t, n, &x->tile))
            continue;
        dx_tile_mesh_build(&x->mesh, &x->tile, tiling, g);
        x->mesh.attr_bytes = 0;
        rc = dx_mesh_store_set_mesh(store, &x->mesh);
    }
    if (rc == 0) {
        dx_mesh_store_set_caps(store, dx_terrain_caps(t) & DX_CAP_FIRST,
                               dx_terrain_caps(t) & DX_CAP_LAST, g->flip);
        dx_mesh_store_commit(store);
        rc = dx_mesh_store_weld(mesh, store);
    }
    dx_mesh_store_free(store);
    free(x);
    return rc;
}

/* An entity of its own for each part; the first message takes those of the frame before away. */
static int put_parts(struct dx_out_ros *o, const struct dx_mesh *mesh, uint64_t time)
{
    struct dx_ros_scene s = {.stamp_ns = time,
                             .frame_id = DX_ROS_FRAME,
                             .clears = true,
                             .orientation = {0, 0, 0, 1},
                             .color = {0.75, 0.75, 0.75, 1}};
    uint32_t first = 0, n = 0;
    int rc = dx_ros_part_begin(o->part, mesh);

    do {
        char id[32];
        size_t len;

        if (rc)
            break;
        first = dx_ros_part_next(o->part, mesh, first);
        snprintf(id, sizeof(id), "mesh/%u", n++);
        s.id = id;
        s.points = o->part->xyz;
        s.n_points = o->part->n_vertices;
        s.indices = o->part->index;
        s.n_indices = o->part->n_indices;
        len = dx_ros_scene_put(&s, o->message, o->message_cap);
        rc = len > o->message_cap ? -EMSGSIZE : put(o, SCENE, o->n_scenes++, time, len);
        s.clears = false;
    } while (first < mesh->n_triangles);
    return rc;
}

static int add_mesh(struct dx_out_ros *o, const struct dx_plane *plane, uint64_t time)
{
    struct dx_mesh mesh = {0};
    int rc;

    dx_terrain_publish(o->terrain, plane, 0, plane->width, o->pool);
    dx_terrain_commit(o->terrain, o->pool);
    o->params = *dx_terrain_params(o->terrain);
    rc = weld(&mesh, o->terrain);
    if (rc == 0)
        rc = put_parts(o, &mesh, time);
    dx_mesh_fini(&mesh);
    return rc;
}

/* ---- frames ----------------------------------------------------------------------------------
 */

/* Bytes of the message for the mesh of so many dexels; of its first part, when it is too large. */
static size_t scene_len(size_t n_dexels)
{
    return n_dexels < MAX_LEN / VERTEX_LEN ? n_dexels * VERTEX_LEN + SCENE_HEAD : MAX_LEN;
}

int dx_out_ros_geometry(struct dx_out_ros *o, struct dx_geometry *g, uint8_t attr_bytes,
                        struct dx_err *err)
{
    size_t len = scene_len((size_t)g->height * g->width);
    int rc;

    if (!has(o, DX_ROS_MESH))
        return 0;
    if (o->writer && len > o->message_cap)
        len = o->message_cap;
    dx_terrain_free(o->terrain);
    dx_ros_part_free(o->part);
    o->terrain = NULL;
    o->part = NULL;
    rc = dx_ros_part_new(&o->part, (uint32_t)((len - SCENE_HEAD) / VERTEX_LEN));
    if (rc == 0)
        rc = dx_terrain_new(&o->terrain, g, &o->params, attr_bytes);
    return failed(o, rc, err);
}

/* For the messages of a frame, and of others like it. */
static size_t room_for(const struct dx_out_ros *o, size_t cloud_len, size_t n_dexels)
{
    size_t len = has(o, DX_ROS_MESH) ? scene_len(n_dexels) : 0;

    len = len > cloud_len ? len : cloud_len;
    return len > MIN_LEN ? len : MIN_LEN;
}

int dx_out_ros_add(struct dx_out_ros *o, const struct dx_plane *plane, const struct dx_geometry *g,
                   uint64_t time, struct dx_err *err)
{
    const struct dx_ros_cloud c = cloud_of(plane, time);
    size_t len = has(o, DX_ROS_CLOUDS) ? dx_ros_cloud_len(&c) : 0;
    int rc = 0;

    if (len > MAX_LEN)
        return dx_err_set(err, -EFBIG,
                          "%s: a cloud of %u x %u points is %zu MiB, expected less than 63 in a "
                          "message; a smaller array helps (--size)",
                          o->file.path, plane->width, plane->height, len >> 20);
    if (!o->writer)
        rc = begin(o, room_for(o, len, dx_plane_n_dexels(plane)));
    if (rc == 0 && has(o, DX_ROS_CLOUDS))
        rc = add_cloud(o, plane, g, time);
    if (rc == 0 && has(o, DX_ROS_MESH))
        rc = add_mesh(o, plane, time);
    o->n_frames++;
    return failed(o, rc, err);
}
