/*
 * PointCloud2 as a format: points and intensities of every kind, what is refused and why; and out
 * of MCAP files of other programs through the file driver, whatever is in them.
 */
#include "file_fixture.h"
#include "mcap_fixture.h"

#include "drivers/file/ros_cloud.h"

#include <math.h>

enum { CLOUD_LEN = 4096 };

/* ---- messages --------------------------------------------------------------------------------
 */

struct message {
    struct dx_ros_cloud cloud;
    uint8_t bytes[CLOUD_LEN];
    size_t len;
    uint8_t *data; /* of the points, in bytes */
};

/* A cloud with fields x, y, z and, not 0, of an attribute; all of its data zero. */
static void begin_cloud(struct message *m, uint32_t height, uint32_t width, enum dx_ros_type axes,
                        const char *attr, uint8_t attr_type)
{
    static const char *const names[] = {"x", "y", "z"};

    *m = (struct message){.cloud = {.frame_id = "lidar",
                                    .frame_id_len = 5,
                                    .stamp_ns = 5,
                                    .height = height,
                                    .width = width}};
    for (int k = 0; k < 3; k++)
        dx_ros_cloud_add_field(&m->cloud, names[k], axes);
    if (attr)
        dx_ros_cloud_add_field(&m->cloud, attr, (enum dx_ros_type)attr_type);
    m->len = dx_ros_cloud_len(&m->cloud);
    m->data = dx_ros_cloud_put(&m->cloud, m->bytes, sizeof(m->bytes));
    assert_non_null(m->data);
}

static void set_xyz(struct message *m, size_t k, double x, double y, double z)
{
    const double v[3] = {x, y, z};
    uint8_t *p = m->data + k * m->cloud.point_step;

    for (int i = 0; i < 3; i++)
        if (m->cloud.fields[0].type == DX_ROS_FLOAT64)
            dx_put_u64(p + 8 * i, dx_f64_bits(v[i]));
        else
            dx_put_u32(p + 4 * i, dx_f32_bits((float)v[i]));
}

static int decode(struct dx_xyz_frame *f, const struct message *m, struct dx_err *err)
{
    uint8_t *bytes = exact_copy(m->bytes, m->len);
    int rc = dx_format_ros.decode(f, bytes, m->len, err);

    free(bytes);
    return rc;
}

static void expect_refused(const struct message *m, const char *text)
{
    struct dx_xyz_frame f = {0};
    struct dx_err err = {""};

    assert_int_equal(decode(&f, m, &err), -EBADMSG);
    if (!strstr(err.text, text))
        fail_msg("'%s', expected '%s'", err.text, text);
    assert_null(f.xyz); /* nothing was allocated for it */
    dx_xyz_frame_fini(&f);
}

static void reads_points(void **state)
{
    static const enum dx_ros_type types[] = {DX_ROS_FLOAT32, DX_ROS_FLOAT64};
    struct dx_err err = {""};

    (void)state;
    for (size_t t = 0; t < 2; t++) {
        struct dx_xyz_frame f = {0};
        struct message m;

        begin_cloud(&m, 2, 3, types[t], NULL, 0);
        set_xyz(&m, 0, 1, 2, 3);
        set_xyz(&m, 2, NAN, NAN, NAN);
        set_xyz(&m, 3, 4, INFINITY, 6);
        set_xyz(&m, 5, -1, -2, 0.5);
        assert_int_equal(decode(&f, &m, &err), 0);
        assert_int_equal(f.height, 2);
        assert_int_equal(f.width, 3);
        assert_true(f.xyz[0] == 1 && f.xyz[1] == 2 && f.xyz[2] == 3);
        assert_true(f.xyz[15] == -1 && f.xyz[16] == -2 && f.xyz[17] == 0.5);
        for (size_t k = 1; k < 5; k++) /* 1 and 4 are 0 0 0 */
            assert_true(isnan(f.xyz[3 * k]));
        assert_null(f.attr);
        dx_xyz_frame_fini(&f);
    }
}

static void reads_intensities(void **state)
{
    struct dx_xyz_frame f = {0};
    struct dx_err err = {""};
    struct message m;

    (void)state;
    begin_cloud(&m, 2, 2, DX_ROS_FLOAT32, "intensity", DX_ROS_UINT8);
    m.data[12] = 200;
    assert_int_equal(decode(&f, &m, &err), 0);
    assert_int_equal(f.attr_bytes, 1);
    assert_int_equal(f.attr[0], 200);

    begin_cloud(&m, 2, 2, DX_ROS_FLOAT32, "reflectivity", DX_ROS_UINT16);
    dx_put_u16(m.data + 12, 300);
    assert_int_equal(decode(&f, &m, &err), 0);
    assert_int_equal(f.attr_bytes, 2);
    assert_int_equal(f.attr[0], 300);

    /* 0 to 1, as of PCD; what is no number at all is none */
    begin_cloud(&m, 2, 2, DX_ROS_FLOAT32, "intensity", DX_ROS_FLOAT64);
    for (size_t k = 0; k < 4; k++) {
        const double v[4] = {1, 0.5, 1e300, NAN};

        set_xyz(&m, k, 1, 1, 1);
        dx_put_u64(m.data + k * m.cloud.point_step + 12, dx_f64_bits(v[k]));
    }
    assert_int_equal(decode(&f, &m, &err), 0);
    assert_int_equal(f.attr_bytes, 2);
    assert_int_equal(f.attr[0], 65535);
    assert_int_equal(f.attr[1], 32768);
    assert_int_equal(f.attr[2], 0);
    assert_int_equal(f.attr[3], 0);
    dx_xyz_frame_fini(&f);
}

static void refuses_what_is_no_organized_cloud(void **state)
{
    struct message m;

    (void)state;
    begin_cloud(&m, 1, 6, DX_ROS_FLOAT32, NULL, 0);
    expect_refused(&m, "found a cloud of 6 x 1 points, expected an organized one");
    begin_cloud(&m, 6, 1, DX_ROS_FLOAT32, NULL, 0);
    expect_refused(&m, "expected an organized one");
    begin_cloud(&m, 0, 0, DX_ROS_FLOAT32, NULL, 0);
    expect_refused(&m, "expected an organized one");
    begin_cloud(&m, 2, 2, DX_ROS_INT32, NULL, 0);
    expect_refused(&m, "a whole-numbered field 'x', expected one of float32 or float64");

    m.cloud = (struct dx_ros_cloud){.frame_id = "", .height = 2, .width = 2};
    dx_ros_cloud_add_field(&m.cloud, "x", DX_ROS_FLOAT32);
    dx_ros_cloud_add_field(&m.cloud, "z", DX_ROS_FLOAT32);
    m.len = dx_ros_cloud_len(&m.cloud);
    assert_non_null(dx_ros_cloud_put(&m.cloud, m.bytes, sizeof(m.bytes)));
    expect_refused(&m, "no field 'y'");
}

/* Without fields a cloud of any size has no bytes: nothing is allocated for it. */
static void refuses_sizes_without_data(void **state)
{
    static const uint32_t sizes[][2] = {
        {65535, 65535}, {UINT32_MAX, UINT32_MAX}, {65536, 2}, {2, 65536}, {40000, 40000}};
    struct message m = {.cloud = {.frame_id = ""}};

    (void)state;
    for (size_t k = 0; k < sizeof(sizes) / sizeof(sizes[0]); k++) {
        m.cloud.height = sizes[k][0];
        m.cloud.width = sizes[k][1];
        m.len = dx_ros_cloud_len(&m.cloud);
        assert_true(m.len < 64);
        assert_non_null(dx_ros_cloud_put(&m.cloud, m.bytes, sizeof(m.bytes)));
        expect_refused(&m, ", expected ");
    }
    m.cloud.height = m.cloud.width = 16384;
    assert_non_null(dx_ros_cloud_put(&m.cloud, m.bytes, sizeof(m.bytes)));
    expect_refused(&m, "no field 'x'");
}

static void refuses_every_truncation(void **state)
{
    struct message m;

    (void)state;
    begin_cloud(&m, 2, 2, DX_ROS_FLOAT32, "intensity", DX_ROS_FLOAT32);
    for (size_t len = m.len; len-- > 0;) {
        m.len = len;
        expect_refused(&m, "no whole message of sensor_msgs/msg/PointCloud2");
    }
}

/* ---- files -----------------------------------------------------------------------------------
 */

static void declare_topic(struct dx_mcap_writer *w, uint16_t id, const char *topic,
                          const char *schema)
{
    const struct dx_mcap_schema s = {id, dx_mcap_text(schema), dx_mcap_text("ros2msg"),
                                     bytes_of("uint8 x\n")};
    const struct dx_mcap_channel c = {.id = id,
                                      .schema_id = id,
                                      .topic = dx_mcap_text(topic),
                                      .message_encoding = dx_mcap_text("cdr")};

    assert_int_equal(dx_mcap_writer_schema(w, &s), 0);
    assert_int_equal(dx_mcap_writer_channel(w, &c), 0);
}

/* A wall at `x` metres before a camera. */
static void make_wall(struct message *m, double x)
{
    begin_cloud(m, 6, 8, DX_ROS_FLOAT32, NULL, 0);
    for (int row = 0; row < 6; row++)
        for (int col = 0; col < 8; col++)
            set_xyz(m, (size_t)row * 8 + (size_t)col, (col - 4) * 0.1 * x, (row - 3) * 0.1 * x, x);
}

static void put_cloud(struct dx_mcap_writer *w, uint16_t channel, uint64_t time,
                      const struct message *m)
{
    const struct dx_mcap_message out = {
        .channel_id = channel, .log_time = time, .data = {m->bytes, m->len}};

    assert_int_equal(dx_mcap_writer_message(w, &out), 0);
}

/* Topics /a with 3 clouds, not in the order of their times, and one between that has no rows; /b
 * with one; and messages of another kind. */
static struct mem_file make_bag(bool with_b)
{
    const struct dx_mcap_writer_config config = {.chunk_len = 1};
    struct dx_mcap_writer *w = new_writer(&config);
    struct mem_file f = mem_new();
    const struct dx_mcap_sink sink = mem_sink(&f);
    struct message m;

    declare_topic(w, 1, "/a", DX_ROS_CLOUD_NAME);
    if (with_b)
        declare_topic(w, 2, "/b", DX_ROS_CLOUD_NAME);
    declare_topic(w, 3, "/other", "std_msgs/msg/String");
    assert_int_equal(dx_mcap_writer_begin(w, &sink), 0);
    make_wall(&m, 3);
    put_cloud(w, 1, 3000, &m);
    put_cloud(w, 3, 3500, &m);
    make_wall(&m, 1);
    put_cloud(w, 1, 1000, &m);
    begin_cloud(&m, 1, 9, DX_ROS_FLOAT32, NULL, 0);
    put_cloud(w, 1, 2000, &m);
    make_wall(&m, 2);
    put_cloud(w, 1, 2500, &m);
    if (with_b)
        put_cloud(w, 2, 1, &m);
    assert_int_equal(dx_mcap_writer_finish(w), 0);
    dx_mcap_writer_free(w);
    return f;
}

/* Is what was kept the wall at `z` metres, of log time `ns`? */
static void expect_wall(const struct kept *k, double z, uint64_t ns)
{
    float p[3];

    dx_geometry_point(k->geometry, 3, 4, dx_plane_range(&k->plane, 3 * 8 + 4), p);
    assert_true(fabs((double)p[2] - z) < 1e-3);
    assert_true(k->part.stamp.device_ns == ns);
    assert_int_equal(k->part.stamp.clock_id, DX_CLOCK_REALTIME);
}

static void plays_a_bag_in_the_order_of_time(void **state)
{
    struct mem_file f = make_bag(false);
    char *folder = make_folder();
    struct kept k = {0};
    struct dx_device *dev;

    (void)state;
    write_file(folder, "run.mcap", f.bytes, f.len);
    dev = open_path(folder, "run.mcap");
    expect_step(dev, &k, 0, "");
    expect_wall(&k, 1, 1000);
    expect_step(dev, &k, DX_DRIVER_E_CORRUPT, "run.mcap: found a cloud of 9 x 1 points");
    expect_step(dev, &k, 0, "");
    expect_wall(&k, 2, 2500);
    expect_step(dev, &k, 0, "");
    expect_wall(&k, 3, 3000);
    expect_step(dev, &k, DX_DRIVER_E_EOF, "");
    assert_int_equal(k.n_frames, 3);
    close_device(dev);
    kept_fini(&k);
    remove_folder(folder);
    mem_free(&f);
}

/* What a step says when `topic` is asked for. */
static void expect_topic(const char *folder, const char *topic, int want, const char *text)
{
    char *path = path_in(folder, "run.mcap");
    struct dx_file_config config = file_config(path);
    struct kept k = {0};
    struct dx_device *dev;

    config.topic = topic;
    dev = open_device(&config);
    expect_step(dev, &k, want, text);
    close_device(dev);
    kept_fini(&k);
    free(path);
}

static void chooses_a_topic(void **state)
{
    struct mem_file f = make_bag(true);
    char *folder = make_folder();

    (void)state;
    write_file(folder, "run.mcap", f.bytes, f.len);
    expect_topic(folder, NULL, DX_DRIVER_E_CORRUPT,
                 "run.mcap: found clouds on several topics, expected one to be chosen: /a, /b");
    expect_topic(folder, "/b", 0, "");
    expect_topic(folder, "/other", DX_DRIVER_E_CORRUPT,
                 "run.mcap: found no sensor_msgs/msg/PointCloud2 on topic '/other', but on /a, /b");
    remove_folder(folder);
    mem_free(&f);
}

static void says_when_there_are_no_clouds(void **state)
{
    const struct dx_mcap_writer_config config = {.chunk_len = 1};
    struct dx_mcap_writer *w = new_writer(&config);
    struct mem_file f = mem_new();
    const struct dx_mcap_sink sink = mem_sink(&f);
    char *folder = make_folder();

    (void)state;
    assert_int_equal(dx_mcap_writer_begin(w, &sink), 0);
    assert_int_equal(dx_mcap_writer_finish(w), 0);
    dx_mcap_writer_free(w);
    write_file(folder, "run.mcap", f.bytes, f.len);
    expect_topic(folder, NULL, DX_DRIVER_E_CORRUPT, "run.mcap: found no channel of ");
    write_file(folder, "run.mcap", dx_mcap_magic, DX_MCAP_MAGIC_LEN);
    expect_topic(folder, NULL, DX_DRIVER_E_CORRUPT, "run.mcap");
    remove_folder(folder);
    mem_free(&f);
}

/* Frames in chunks that are whole come; that some are not is told at the end, once, as a frame that
 * cannot be decoded. Cut at every byte: no more than was there, and an end. */
static void tells_of_damage(void **state)
{
    struct mem_file f = make_bag(false);
    char *folder = make_folder();
    unsigned n_most = 0;

    (void)state;
    for (size_t len = f.len; len > DX_MCAP_MAGIC_LEN; len -= 7) {
        struct kept k = {0};
        struct dx_err err = {""};
        struct dx_device *dev;
        unsigned n_corrupt = 0;
        int rc;

        write_file(folder, "run.mcap", f.bytes, len);
        dev = open_path(folder, "run.mcap");
        while ((rc = step(dev, &k, &err)) != DX_DRIVER_E_EOF) {
            assert_true(rc == 0 || rc == DX_DRIVER_E_CORRUPT);
            n_corrupt += rc != 0;
            assert_true(n_corrupt <= 2); /* the cloud without rows, and the damage */
        }
        assert_in_range(k.n_frames, 0, 3);
        assert_true(k.n_frames == 3 || n_corrupt > 0);
        n_most = k.n_frames > n_most ? k.n_frames : n_most;
        close_device(dev);
        kept_fini(&k);
        if (len <= DX_MCAP_MAGIC_LEN + 7)
            break;
    }
    assert_int_equal(n_most, 3);
    remove_folder(folder);
    mem_free(&f);
}

static void loops(void **state)
{
    struct mem_file f = make_bag(false);
    char *folder = make_folder(), *path = path_in(folder, "run.mcap");
    struct dx_file_config config = file_config(path);
    struct kept k = {0};
    struct dx_err err = {""};
    struct dx_device *dev;

    (void)state;
    write_file(folder, "run.mcap", f.bytes, f.len);
    config.loop = true;
    dev = open_device(&config);
    for (unsigned n = 0; n < 12; n++)
        assert_int_equal(step(dev, &k, &err), n % 4 == 1 ? DX_DRIVER_E_CORRUPT : 0);
    assert_int_equal(k.n_frames, 9);
    expect_wall(&k, 3, 3000);
    close_device(dev);
    kept_fini(&k);
    free(path);
    remove_folder(folder);
    mem_free(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reads_points),
        cmocka_unit_test(reads_intensities),
        cmocka_unit_test(refuses_what_is_no_organized_cloud),
        cmocka_unit_test(refuses_sizes_without_data),
        cmocka_unit_test(refuses_every_truncation),
        cmocka_unit_test(plays_a_bag_in_the_order_of_time),
        cmocka_unit_test(chooses_a_topic),
        cmocka_unit_test(says_when_there_are_no_clouds),
        cmocka_unit_test(tells_of_damage),
        cmocka_unit_test(loops),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
