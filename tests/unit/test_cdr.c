/* CDR and PointCloud2: the worked message of the design notes, both byte orders, lengths that lie.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "drivers/file/cdr.h"
#include "drivers/file/ros_cloud.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Stamp 1700000000.5, frame "lidar", 1 x 2 points: (1, 2, 3) and no return. */
static const uint8_t worked[137] = {
    0x00, 0x01, 0x00, 0x00, 0x00, 0xf1, 0x53, 0x65, 0x00, 0x65, 0xcd, 0x1d, 0x06, 0x00, 0x00, 0x00,
    0x6c, 0x69, 0x64, 0x61, 0x72, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x02, 0x00, 0x00, 0x00,
    0x03, 0x00, 0x00, 0x00, 0x02, 0x00, 0x00, 0x00, 0x78, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x07, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x02, 0x00, 0x00, 0x00, 0x79, 0x00, 0x00, 0x00,
    0x04, 0x00, 0x00, 0x00, 0x07, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x02, 0x00, 0x00, 0x00,
    0x7a, 0x00, 0x00, 0x00, 0x08, 0x00, 0x00, 0x00, 0x07, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x0c, 0x00, 0x00, 0x00, 0x18, 0x00, 0x00, 0x00, 0x18, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x80, 0x3f, 0x00, 0x00, 0x00, 0x40, 0x00, 0x00, 0x40, 0x40, 0x00, 0x00, 0xc0, 0x7f,
    0x00, 0x00, 0xc0, 0x7f, 0x00, 0x00, 0xc0, 0x7f, 0x00,
};

static struct dx_ros_cloud worked_cloud(void)
{
    struct dx_ros_cloud c = {.stamp_ns = UINT64_C(1700000000500000000),
                             .frame_id = "lidar",
                             .frame_id_len = 5,
                             .height = 1,
                             .width = 2};

    dx_ros_cloud_add_field(&c, "x", DX_ROS_FLOAT32);
    dx_ros_cloud_add_field(&c, "y", DX_ROS_FLOAT32);
    dx_ros_cloud_add_field(&c, "z", DX_ROS_FLOAT32);
    return c;
}

static void writes_the_worked_message(void **state)
{
    const float xyz[6] = {1, 2, 3, NAN, NAN, NAN};
    struct dx_ros_cloud c = worked_cloud();
    uint8_t bytes[137], *data;

    (void)state;
    assert_int_equal(dx_ros_cloud_len(&c), sizeof(worked));
    data = dx_ros_cloud_put(&c, bytes, sizeof(bytes));
    assert_non_null(data);
    dx_put_f32s(data, xyz, 6);
    assert_memory_equal(bytes, worked, sizeof(worked));
    for (size_t cap = 0; cap < sizeof(worked); cap++) {
        uint8_t *less = malloc(cap ? cap : 1);

        assert_null(dx_ros_cloud_put(&c, less, cap));
        free(less);
    }
}

static void check_worked(const struct dx_ros_cloud *c)
{
    static const char *const names[] = {"x", "y", "z"};

    assert_true(c->stamp_ns == UINT64_C(1700000000500000000));
    assert_int_equal(c->frame_id_len, 5);
    assert_memory_equal(c->frame_id, "lidar", 5);
    assert_int_equal(c->height, 1);
    assert_int_equal(c->width, 2);
    assert_int_equal(c->n_fields, 3);
    assert_false(c->is_dense);
    for (int k = 0; k < 3; k++) {
        const struct dx_ros_field *f = dx_ros_cloud_field(c, names[k]);

        assert_non_null(f);
        assert_true(dx_ros_cloud_value(c, f, 0, 0) == k + 1);
        assert_true(isnan(dx_ros_cloud_value(c, f, 0, 1)));
    }
    assert_null(dx_ros_cloud_field(c, "intensity"));
}

static void reads_the_worked_message(void **state)
{
    struct dx_ros_cloud c;

    (void)state;
    assert_int_equal(dx_ros_cloud_get(&c, worked, sizeof(worked)), 0);
    check_worked(&c);
}

static void refuses_every_truncation(void **state)
{
    struct dx_ros_cloud c;

    (void)state;
    for (size_t len = 0; len < sizeof(worked); len++) {
        uint8_t *cut = malloc(len ? len : 1);

        assert_non_null(cut);
        memcpy(cut, worked, len);
        assert_int_equal(dx_ros_cloud_get(&c, cut, len), -EBADMSG);
        free(cut);
    }
}

/* A message that another machine wrote: all counts and steps the other way round. */
static void reads_big_endian(void **state)
{
    /* offsets of the 32-bit values in the worked message */
    static const uint8_t words[] = {4,  8,  12, 24, 28, 32, 36,  44,  52,
                                    56, 64, 72, 76, 84, 92, 100, 104, 108};
    uint8_t bytes[sizeof(worked)];
    struct dx_ros_cloud c;

    (void)state;
    memcpy(bytes, worked, sizeof(worked));
    bytes[1] = 0;
    bytes[96] = 1; /* is_bigendian: the data too */
    for (size_t k = 0; k < sizeof(words); k++)
        dx_put_u32(bytes + words[k], __builtin_bswap32(dx_get_u32(bytes + words[k])));
    for (size_t k = 112; k < 136; k += 4)
        dx_put_u32(bytes + k, __builtin_bswap32(dx_get_u32(bytes + k)));
    assert_int_equal(dx_ros_cloud_get(&c, bytes, sizeof(bytes)), 0);
    assert_true(c.is_big_endian);
    check_worked(&c);
}

static void expect_refused(size_t at, uint32_t v)
{
    uint8_t bytes[sizeof(worked)];
    struct dx_ros_cloud c;

    memcpy(bytes, worked, sizeof(worked));
    dx_put_u32(bytes + at, v);
    assert_int_equal(dx_ros_cloud_get(&c, bytes, sizeof(bytes)), -EBADMSG);
}

static void refuses_what_does_not_fit(void **state)
{
    (void)state;
    expect_refused(0, 0x00000200);  /* not plain CDR */
    expect_refused(12, 0xffffffff); /* a text longer than the message */
    expect_refused(24, 2);          /* height: rows that are not there */
    expect_refused(28, 3);          /* width: points that do not fit into a row */
    expect_refused(32, 0xffffffff); /* fields */
    expect_refused(44, 9);          /* a field that begins in a point and ends behind it */
    expect_refused(44, 0xffffffff);
    expect_refused(52, 0x20000001); /* a count whose bytes overflow */
    expect_refused(100, 8);         /* points shorter than their fields */
    expect_refused(104, 0xfffffff0);
    expect_refused(108, 0xffffffff);
}

static void values_of_every_type(void **state)
{
    struct dx_ros_cloud c = {.frame_id = "", .height = 1, .width = 1};
    static const double want[] = {-2, 254, -3, 65533, -4, 4294967292.0, 0.5, -0.25};
    uint8_t bytes[400], *data;

    (void)state;
    for (int type = DX_ROS_INT8; type <= DX_ROS_FLOAT64; type++)
        dx_ros_cloud_add_field(&c, "v", (enum dx_ros_type)type);
    assert_int_equal(c.point_step, 26);
    data = dx_ros_cloud_put(&c, bytes, sizeof(bytes));
    assert_non_null(data);
    data[0] = data[1] = 0xfe;
    dx_put_u16(data + 2, 0xfffd);
    dx_put_u16(data + 4, 0xfffd);
    dx_put_u32(data + 6, 0xfffffffc);
    dx_put_u32(data + 10, 0xfffffffc);
    dx_put_u32(data + 14, dx_f32_bits(0.5f));
    dx_put_u64(data + 18, dx_f64_bits(-0.25));
    assert_int_equal(dx_ros_cloud_get(&c, bytes, dx_ros_cloud_len(&c)), 0);
    for (uint32_t k = 0; k < 8; k++)
        assert_true(dx_ros_cloud_value(&c, &c.fields[k], 0, 0) == want[k]);
}

/* f64 is aligned to 8, counted from behind the head; read back across the gap. */
static void aligns_from_behind_the_head(void **state)
{
    uint8_t bytes[64];
    struct dx_cdr_writer w = dx_cdr_writer_init(bytes, sizeof(bytes));
    struct dx_cdr_reader r;
    uint32_t len;

    (void)state;
    dx_cdr_put_u8(&w, 7);
    dx_cdr_put_f64(&w, 1.5);
    dx_cdr_put_text(&w, "", 0);
    assert_int_equal(w.len, 4 + 8 + 8 + 5);
    r = dx_cdr_reader_init(bytes, w.len);
    assert_int_equal(dx_cdr_get_u8(&r), 7);
    assert_true(dx_cdr_get_f64(&r) == 1.5);
    assert_string_equal(dx_cdr_get_text(&r, &len), "");
    assert_int_equal(len, 0);
    assert_false(r.failed);
    assert_int_equal(dx_cdr_get_u32(&r), 0);
    assert_true(r.failed);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(writes_the_worked_message),   cmocka_unit_test(reads_the_worked_message),
        cmocka_unit_test(refuses_every_truncation),    cmocka_unit_test(reads_big_endian),
        cmocka_unit_test(refuses_what_does_not_fit),   cmocka_unit_test(values_of_every_type),
        cmocka_unit_test(aligns_from_behind_the_head),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
