/* SceneUpdate in CDR. */
#include "drivers/file/ros_scene.h"

#include "drivers/file/cdr.h"

#define NS UINT64_C(1000000000)

/* The kinds of deletion. */
#define DELETE_ALL 1

/* Field lists are facts of the interfaces (foxglove_msgs, geometry_msgs, builtin_interfaces): their
 * order is the order in CDR. The form is that of the "ros2msg" encoding in MCAP's registry. */
#define TYPE(name)                                                                                 \
    "================================================================================\n"           \
    "MSG: " name "\n"
#define POSE   "geometry_msgs/Pose pose\n"
#define COLOR  "foxglove_msgs/Color color\n"
#define COLORS "foxglove_msgs/Color[] colors\n"
#define POINTS "geometry_msgs/Point[] points\n"
#define XYZ    "float64 x\nfloat64 y\nfloat64 z\n"

/* clang-format off */
const char dx_ros_scene_schema[] =
    "foxglove_msgs/SceneEntityDeletion[] deletions\n"
    "foxglove_msgs/SceneEntity[] entities\n"
    TYPE("foxglove_msgs/SceneEntityDeletion")
    "uint8 MATCHING_ID=0\n"
    "uint8 ALL=1\n"
    "builtin_interfaces/Time timestamp\n"
    "uint8 type\n"
    "string id\n"
    TYPE("foxglove_msgs/SceneEntity")
    "builtin_interfaces/Time timestamp\n"
    "string frame_id\n"
    "string id\n"
    "builtin_interfaces/Duration lifetime\n"
    "bool frame_locked\n"
    "foxglove_msgs/KeyValuePair[] metadata\n"
    "foxglove_msgs/ArrowPrimitive[] arrows\n"
    "foxglove_msgs/CubePrimitive[] cubes\n"
    "foxglove_msgs/SpherePrimitive[] spheres\n"
    "foxglove_msgs/CylinderPrimitive[] cylinders\n"
    "foxglove_msgs/LinePrimitive[] lines\n"
    "foxglove_msgs/TriangleListPrimitive[] triangles\n"
    "foxglove_msgs/TextPrimitive[] texts\n"
    "foxglove_msgs/ModelPrimitive[] models\n"
    TYPE("foxglove_msgs/KeyValuePair")
    "string key\n"
    "string value\n"
    TYPE("foxglove_msgs/ArrowPrimitive")
    POSE
    "float64 shaft_length\n"
    "float64 shaft_diameter\n"
    "float64 head_length\n"
    "float64 head_diameter\n"
    COLOR
    TYPE("foxglove_msgs/CubePrimitive")
    POSE
    "geometry_msgs/Vector3 size\n"
    COLOR
    TYPE("foxglove_msgs/SpherePrimitive")
    POSE
    "geometry_msgs/Vector3 size\n"
    COLOR
    TYPE("foxglove_msgs/CylinderPrimitive")
    POSE
    "geometry_msgs/Vector3 size\n"
    "float64 bottom_scale\n"
    "float64 top_scale\n"
    COLOR
    TYPE("foxglove_msgs/LinePrimitive")
    "uint8 LINE_STRIP=0\n"
    "uint8 LINE_LOOP=1\n"
    "uint8 LINE_LIST=2\n"
    "uint8 type\n"
    POSE
    "float64 thickness\n"
    "bool scale_invariant\n"
    POINTS
    COLOR
    COLORS
    "uint32[] indices\n"
    TYPE("foxglove_msgs/TriangleListPrimitive")
    POSE
    POINTS
    COLOR
    COLORS
    "uint32[] indices\n"
    TYPE("foxglove_msgs/TextPrimitive")
    POSE
    "bool billboard\n"
    "float64 font_size\n"
    "bool scale_invariant\n"
    COLOR
    "string text\n"
    TYPE("foxglove_msgs/ModelPrimitive")
    POSE
    "geometry_msgs/Vector3 scale\n"
    COLOR
    "bool override_color\n"
    "string url\n"
    "string media_type\n"
    "uint8[] data\n"
    TYPE("foxglove_msgs/Color")
    "float64 r\n"
    "float64 g\n"
    "float64 b\n"
    "float64 a\n"
    TYPE("geometry_msgs/Pose")
    "geometry_msgs/Point position\n"
    "geometry_msgs/Quaternion orientation\n"
    TYPE("geometry_msgs/Point")
    XYZ
    TYPE("geometry_msgs/Vector3")
    XYZ
    TYPE("geometry_msgs/Quaternion")
    XYZ
    "float64 w\n"
    TYPE("builtin_interfaces/Time")
    "int32 sec\n"
    "uint32 nanosec\n"
    TYPE("builtin_interfaces/Duration")
    "int32 sec\n"
    "uint32 nanosec\n";
/* clang-format on */

static void put_text(struct dx_cdr_writer *w, const char *text)
{
    dx_cdr_put_text(w, text, strlen(text));
}

static void put_time(struct dx_cdr_writer *w, uint64_t ns)
{
    dx_cdr_put_u32(w, (uint32_t)(ns / NS));
    dx_cdr_put_u32(w, (uint32_t)(ns % NS));
}

static void put_f64s(struct dx_cdr_writer *w, const double *v, size_t n)
{
    for (size_t k = 0; k < n; k++)
        dx_cdr_put_f64(w, v[k]);
}

static void put_f32s(struct dx_cdr_writer *w, const float *v, size_t n)
{
    for (size_t k = 0; k < n; k++)
        dx_cdr_put_f64(w, (double)v[k]);
}

static void put_triangles(struct dx_cdr_writer *w, const struct dx_ros_scene *s)
{
    put_f64s(w, s->position, 3);
    put_f64s(w, s->orientation, 4);
    dx_cdr_put_u32(w, s->n_points);
    put_f32s(w, s->points, 3 * (size_t)s->n_points);
    put_f64s(w, s->color, 4);
    dx_cdr_put_u32(w, s->colors ? s->n_points : 0);
    if (s->colors)
        put_f32s(w, s->colors, 4 * (size_t)s->n_points);
    dx_cdr_put_u32(w, s->n_indices);
    for (uint32_t k = 0; k < s->n_indices; k++)
        dx_cdr_put_u32(w, s->indices[k]);
}

static void put_entity(struct dx_cdr_writer *w, const struct dx_ros_scene *s)
{
    put_time(w, s->stamp_ns);
    put_text(w, s->frame_id);
    put_text(w, s->id);
    put_time(w, 0); /* lifetime: until it is replaced */
    dx_cdr_put_u8(w, false);
    for (int k = 0; k < 6; k++) /* metadata, arrows, cubes, spheres, cylinders, lines */
        dx_cdr_put_u32(w, 0);
    dx_cdr_put_u32(w, 1);
    put_triangles(w, s);
    for (int k = 0; k < 2; k++) /* texts, models */
        dx_cdr_put_u32(w, 0);
}

size_t dx_ros_scene_put(const struct dx_ros_scene *s, uint8_t *out, size_t cap)
{
    struct dx_cdr_writer w = dx_cdr_writer_init(out, cap);

    dx_cdr_put_u32(&w, s->clears);
    if (s->clears) {
        put_time(&w, s->stamp_ns);
        dx_cdr_put_u8(&w, DELETE_ALL);
        put_text(&w, "");
    }
    dx_cdr_put_u32(&w, s->n_indices > 0);
    if (s->n_indices > 0)
        put_entity(&w, s);
    return w.len;
}
