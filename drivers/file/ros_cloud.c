/* PointCloud2 in CDR. */
#include "drivers/file/ros_cloud.h"

#include "drivers/file/cdr.h"

#include <errno.h>

#define LINE "================================================================================\n"
#define NS   UINT64_C(1000000000)

/* The definitions are facts of the ROS interfaces (common_interfaces, rcl_interfaces); the form, of
 * the "ros2msg" encoding in MCAP's registry. */
const char dx_ros_cloud_schema[] = "std_msgs/Header header\n"
                                   "uint32 height\n"
                                   "uint32 width\n"
                                   "sensor_msgs/PointField[] fields\n"
                                   "bool is_bigendian\n"
                                   "uint32 point_step\n"
                                   "uint32 row_step\n"
                                   "uint8[] data\n"
                                   "bool is_dense\n" LINE "MSG: sensor_msgs/PointField\n"
                                   "uint8 INT8=1\n"
                                   "uint8 UINT8=2\n"
                                   "uint8 INT16=3\n"
                                   "uint8 UINT16=4\n"
                                   "uint8 INT32=5\n"
                                   "uint8 UINT32=6\n"
                                   "uint8 FLOAT32=7\n"
                                   "uint8 FLOAT64=8\n"
                                   "string name\n"
                                   "uint32 offset\n"
                                   "uint8 datatype\n"
                                   "uint32 count\n" LINE "MSG: std_msgs/Header\n"
                                   "builtin_interfaces/Time stamp\n"
                                   "string frame_id\n" LINE "MSG: builtin_interfaces/Time\n"
                                   "int32 sec\n"
                                   "uint32 nanosec\n";

size_t dx_ros_type_len(uint8_t type)
{
    static const uint8_t lens[] = {0, 1, 1, 2, 2, 4, 4, 4, 8};

    return type < sizeof(lens) ? lens[type] : 0;
}

/* ---- writing ----------------------------------------------------------------------------------
 */

void dx_ros_cloud_add_field(struct dx_ros_cloud *c, const char *name, enum dx_ros_type type)
{
    c->fields[c->n_fields++] = (struct dx_ros_field){
        .name = name,
        .name_len = (uint32_t)strlen(name),
        .offset = c->point_step,
        .type = (uint8_t)type,
        .count = 1,
    };
    c->point_step += (uint32_t)dx_ros_type_len((uint8_t)type);
    c->row_step = c->point_step * c->width;
}

/* All of it; where the data go. */
static uint8_t *put(const struct dx_ros_cloud *c, struct dx_cdr_writer *w)
{
    uint8_t *data;

    dx_cdr_put_u32(w, (uint32_t)(c->stamp_ns / NS));
    dx_cdr_put_u32(w, (uint32_t)(c->stamp_ns % NS));
    dx_cdr_put_text(w, c->frame_id, c->frame_id_len);
    dx_cdr_put_u32(w, c->height);
    dx_cdr_put_u32(w, c->width);
    dx_cdr_put_u32(w, c->n_fields);
    for (uint32_t k = 0; k < c->n_fields; k++) {
        dx_cdr_put_text(w, c->fields[k].name, c->fields[k].name_len);
        dx_cdr_put_u32(w, c->fields[k].offset);
        dx_cdr_put_u8(w, c->fields[k].type);
        dx_cdr_put_u32(w, c->fields[k].count);
    }
    dx_cdr_put_u8(w, c->is_big_endian);
    dx_cdr_put_u32(w, c->point_step);
    dx_cdr_put_u32(w, c->row_step);
    data = dx_cdr_put_room(w, (size_t)c->height * c->row_step);
    dx_cdr_put_u8(w, c->is_dense);
    return data;
}

size_t dx_ros_cloud_len(const struct dx_ros_cloud *c)
{
    struct dx_cdr_writer w = dx_cdr_writer_init(NULL, 0);

    put(c, &w);
    return w.len;
}

uint8_t *dx_ros_cloud_put(const struct dx_ros_cloud *c, uint8_t *out, size_t cap)
{
    struct dx_cdr_writer w = dx_cdr_writer_init(out, cap);
    uint8_t *data = put(c, &w);

    return dx_cdr_writer_failed(&w) ? NULL : data;
}

/* ---- reading ----------------------------------------------------------------------------------
 */

static bool is_sound(const struct dx_ros_cloud *c)
{
    for (uint32_t k = 0; k < c->n_fields; k++) {
        const struct dx_ros_field *f = &c->fields[k];
        uint64_t len = dx_ros_type_len(f->type) * (uint64_t)f->count;

        if (dx_ros_type_len(f->type) == 0 || f->offset + len > c->point_step)
            return false;
    }
    return (uint64_t)c->width * c->point_step <= c->row_step &&
           (uint64_t)c->height * c->row_step <= c->data_len;
}

static int get_fields(struct dx_ros_cloud *out, struct dx_cdr_reader *r)
{
    out->n_fields = dx_cdr_get_count(r, 13);
    if (out->n_fields > DX_ROS_MAX_FIELDS)
        return -EBADMSG;
    for (uint32_t k = 0; k < out->n_fields; k++) {
        struct dx_ros_field *f = &out->fields[k];

        f->name = dx_cdr_get_text(r, &f->name_len);
        f->offset = dx_cdr_get_u32(r);
        f->type = dx_cdr_get_u8(r);
        f->count = dx_cdr_get_u32(r);
        /* 0 for 1 is common among writers of one value */
        f->count = f->count ? f->count : 1;
    }
    return r->failed ? -EBADMSG : 0;
}

int dx_ros_cloud_get(struct dx_ros_cloud *out, const uint8_t *bytes, size_t len)
{
    struct dx_cdr_reader r = dx_cdr_reader_init(bytes, len);
    uint32_t s, ns;

    *out = (struct dx_ros_cloud){0};
    s = dx_cdr_get_u32(&r);
    ns = dx_cdr_get_u32(&r);
    out->stamp_ns = s > INT32_MAX ? 0 : s * NS + ns; /* before the epoch: not for a scan */
    out->frame_id = dx_cdr_get_text(&r, &out->frame_id_len);
    out->height = dx_cdr_get_u32(&r);
    out->width = dx_cdr_get_u32(&r);
    if (get_fields(out, &r) < 0)
        return -EBADMSG;
    out->is_big_endian = dx_cdr_get_u8(&r) != 0;
    out->point_step = dx_cdr_get_u32(&r);
    out->row_step = dx_cdr_get_u32(&r);
    out->data = dx_cdr_get_bytes(&r, &out->data_len);
    out->is_dense = dx_cdr_get_u8(&r) != 0;
    return r.failed || !is_sound(out) ? -EBADMSG : 0;
}

const struct dx_ros_field *dx_ros_cloud_field(const struct dx_ros_cloud *c, const char *name)
{
    for (uint32_t k = 0; k < c->n_fields; k++)
        if (c->fields[k].name_len == strlen(name) &&
            memcmp(c->fields[k].name, name, c->fields[k].name_len) == 0)
            return &c->fields[k];
    return NULL;
}

static uint64_t bits_of(const uint8_t *p, size_t len, bool is_big)
{
    uint64_t v = 0;

    for (size_t k = 0; k < len; k++)
        v |= (uint64_t)p[is_big ? len - 1 - k : k] << (8 * k);
    return v;
}

double dx_ros_cloud_value(const struct dx_ros_cloud *c, const struct dx_ros_field *f, uint32_t row,
                          uint32_t col)
{
    const uint8_t *p =
        c->data + (size_t)row * c->row_step + (size_t)col * c->point_step + f->offset;
    uint64_t v = bits_of(p, dx_ros_type_len(f->type), c->is_big_endian);

    switch (f->type) {
    case DX_ROS_INT8:
        return (int8_t)v;
    case DX_ROS_INT16:
        return (int16_t)v;
    case DX_ROS_INT32:
        return (int32_t)v;
    case DX_ROS_FLOAT32:
        return (double)dx_f32_from_bits((uint32_t)v);
    case DX_ROS_FLOAT64:
        return dx_f64_from_bits(v);
    default:
        return (double)v;
    }
}
