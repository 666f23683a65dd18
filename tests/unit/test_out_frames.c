/* Writers of frames: what the file driver reads back, what is left behind when writing fails. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "core/base/trig.h"
#include "drivers/file/file.h"
#include "tests/unit/scene_rig.h"
#include "tools/out_frames.h"

#include <dirent.h>
#include <errno.h>
#include <math.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

static char folder[64];

static const char *in_folder(const char *name)
{
    static char path[2][256];
    static unsigned turn;
    char *p = path[turn++ % 2];

    snprintf(p, sizeof(path[0]), "%s/%s", folder, name);
    return p;
}

static unsigned n_entries(const char *path)
{
    DIR *dir = opendir(path);
    unsigned n = 0;

    assert_non_null(dir);
    for (struct dirent *e = readdir(dir); e; e = readdir(dir))
        n += e->d_name[0] != '.';
    closedir(dir);
    return n;
}

static int setup(void **state)
{
    const char *tmp = getenv("TMPDIR");

    (void)state;
    snprintf(folder, sizeof(folder), "%s/dexel-frames-XXXXXX",
             tmp && strlen(tmp) < 32 ? tmp : "/tmp");
    return mkdtemp(folder) ? 0 : -1;
}

static int teardown(void **state)
{
    char command[128];

    (void)state;
    snprintf(command, sizeof(command), "rm -rf '%s'", folder);
    return system(command);
}

/* Reads frames with the file driver. */
struct reader {
    struct dx_device *dev;
    struct dx_geometry *g;
    struct dx_plane plane;
};

static int take_geometry(void *ctx, struct dx_geometry *g, uint8_t attr_bytes)
{
    struct reader *r = ctx;

    dx_geometry_unref(r->g);
    dx_plane_fini(&r->plane);
    r->g = dx_geometry_ref(g);
    return dx_plane_init(&r->plane, g->height, g->width, g->range_bytes, attr_bytes);
}

static struct dx_plane *give_plane(void *ctx, uint64_t number)
{
    (void)number;
    return &((struct reader *)ctx)->plane;
}

static void ignore_part(void *ctx, const struct dx_frame_part *part)
{
    (void)ctx;
    assert_true(part->last);
}

static void reader_open(struct reader *r, const char *path, float unit_m)
{
    const struct dx_file_config config = {
        .path = path, .attr_bytes = -1, .fit = {.unit_m = (double)unit_m, .seam = -1}};
    struct dx_err err = {""};

    memset(r, 0, sizeof(*r));
    if (dx_file_driver.open(&r->dev, &config, &err) || dx_file_driver.start(r->dev, &err))
        fail_msg("%s", err.text);
}

/* False: the end. */
static bool reader_next(struct reader *r)
{
    const struct dx_frame_sink sink = {r, take_geometry, give_plane, ignore_part};
    struct dx_block block;
    struct dx_err err = {""};
    int rc = dx_file_driver.read(r->dev, &block, &err);

    if (rc == DX_DRIVER_E_EOF)
        return false;
    if (rc == 0)
        rc = dx_file_driver.decode(r->dev, &block, &sink, &err);
    if (rc)
        fail_msg("%s", err.text);
    return true;
}

static void reader_close(struct reader *r)
{
    dx_file_driver.close(r->dev);
    dx_geometry_unref(r->g);
    dx_plane_fini(&r->plane);
}

/* The file driver's attribute has 16 bits. */
static uint32_t attr_16(const struct dx_plane *p, size_t k)
{
    return p->attr_bytes == 1 ? 257 * dx_plane_attr(p, k) : dx_plane_attr(p, k);
}

static void expect_same(const struct reader *got, const struct rig *want)
{
    assert_int_equal(got->g->model, want->g->model);
    assert_int_equal(got->g->height, want->g->height);
    assert_int_equal(got->g->width, want->g->width);
    assert_int_equal(got->g->wrap, want->g->wrap);
    assert_int_equal(got->g->flip, want->g->flip);
    assert_true(dx_geometry_departure(got->g, want->g) < 0.05);
    for (size_t k = 0; k < dx_plane_n_dexels(&want->plane); k++) {
        uint32_t a = dx_plane_range(&got->plane, k), b = dx_plane_range(&want->plane, k);

        if (a != b)
            fail_msg("dexel %zu: range %u, expected %u", k, a, b);
        if (want->plane.attr_bytes && b && attr_16(&got->plane, k) != attr_16(&want->plane, k))
            fail_msg("dexel %zu: attribute %u, expected %u", k, dx_plane_attr(&got->plane, k),
                     dx_plane_attr(&want->plane, k));
    }
}

static void write_frames(const char *path, enum dx_frame_format format, struct rig *rig,
                         uint64_t first, uint64_t n)
{
    struct dx_out_frames out;
    struct dx_err err = {""};
    int r = dx_out_frames_open(&out, path, format, &err);

    for (uint64_t k = first; r == 0 && k < first + n; k++) {
        rig_cast(rig, k);
        r = dx_out_frames_add(&out, &rig->plane, rig->g, &err);
    }
    if (r == 0)
        r = dx_out_frames_commit(&out, &err);
    if (r)
        fail_msg("%s", err.text);
}

static void round_trip(const char *name, struct rig *rig)
{
    const char *path = in_folder(name);
    struct reader reader;

    write_frames(path, DX_FRAME_PTX, rig, 1, 1);
    reader_open(&reader, path, rig->g->unit_m);
    assert_true(reader_next(&reader));
    expect_same(&reader, rig);
    assert_false(reader_next(&reader));
    reader_close(&reader);
}

static void every_scene_comes_back(void **state)
{
    static const char *const names[] = {"a.ptx", "a.pcd"};

    (void)state;
    for (unsigned scene = 0; scene < DX_N_SCENES; scene++)
        for (int attr_bytes = 1; attr_bytes <= 2; attr_bytes++)
            for (int k = 0; k < 2; k++) {
                struct rig rig;

                rig_init(&rig, scene, 60, 90);
                rig.config.dropout = 0.05;
                rig.config.sigma[0] = 0.003;
                rig.config.attr_bytes = (uint8_t)attr_bytes;
                rig.config.flip_rows = attr_bytes == 1;
                rig_open(&rig);
                round_trip(names[k], &rig);
                rig_close(&rig);
            }
}

/* A unit finer than the six decimals that PTX is usually written with. */
static void fine_units_come_back(void **state)
{
    struct rig rig;

    (void)state;
    rig_init(&rig, DX_SCENE_MOVING_BOX, 60, 90);
    rig.config.unit_m = 5e-6;
    rig_open(&rig);
    assert_int_equal(rig.g->range_bytes, 4);
    rig_cast(&rig, 1);
    round_trip("fine.ptx", &rig);
    rig_close(&rig);
}

static void set_pose(double pose[12], double angle, double const axis[3])
{
    double s, c;

    dx_sincos(angle, &s, &c);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            double cross = i == j ? 0 : axis[3 - i - j] * ((j - i + 3) % 3 == 1 ? -1 : 1);

            pose[4 * i + j] = (i == j) * c + (1 - c) * axis[i] * axis[j] + s * cross;
        }
    pose[3] = 10.25;
    pose[7] = -3.5;
    pose[11] = 0.125;
}

static void poses_come_back(void **state)
{
    static const double axis[4][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.6, 0, 0.8}};
    static const char *const names[] = {"pose.ptx", "pose.pcd"};

    (void)state;
    for (int n = 0; n < 32; n++) { /* turns beyond 180 degrees: every branch of the quaternion */
        const int turn = n / 8;
        struct reader reader;
        struct rig rig;

        rig_init(&rig, DX_SCENE_CREASE, 20, 30);
        rig_open(&rig);
        set_pose(rig.g->pose, 0.4 + turn * 0.9, axis[n / 2 % 4]);
        round_trip(names[n % 2], &rig);
        reader_open(&reader, in_folder(names[n % 2]), rig.g->unit_m);
        assert_true(reader_next(&reader));
        for (int k = 0; k < 12; k++)
            assert_true(fabs(reader.g->pose[k] - rig.g->pose[k]) < 1e-12);
        reader_close(&reader);
        rig_close(&rig);
    }
}

static void expect_sequence(const char *path, struct rig *rig, uint64_t n)
{
    struct reader reader;

    reader_open(&reader, path, rig->g->unit_m);
    for (uint64_t k = 0; k < n; k++) {
        assert_true(reader_next(&reader));
        rig_cast(rig, k);
        expect_same(&reader, rig);
    }
    assert_false(reader_next(&reader));
    reader_close(&reader);
}

static void sequences_come_back(void **state)
{
    struct rig rig;

    (void)state;
    rig_init(&rig, DX_SCENE_MOVING_BOX, 48, 64);
    rig_open(&rig);
    write_frames(in_folder("many.ptx"), DX_FRAME_PTX, &rig, 0, 3);
    expect_sequence(in_folder("many.ptx"), &rig, 3);
    write_frames(in_folder("ptx"), DX_FRAME_PTX, &rig, 0, 3);
    expect_sequence(in_folder("ptx"), &rig, 3);
    write_frames(in_folder("pcd"), DX_FRAME_PCD, &rig, 0, 12);
    expect_sequence(in_folder("pcd"), &rig, 12);
    assert_int_equal(n_entries(in_folder("pcd")), 12);
    assert_int_equal(access(in_folder("pcd/frame-000011.pcd"), R_OK), 0);
    rig_close(&rig);
}

static void a_pcd_holds_one_frame(void **state)
{
    struct dx_out_frames out;
    struct dx_err err = {""};
    struct rig rig;

    (void)state;
    rig_init(&rig, DX_SCENE_CREASE, 20, 30);
    rig_open(&rig);
    assert_int_equal(dx_out_frames_open(&out, in_folder("one.pcd"), DX_FRAME_PTX, &err), 0);
    assert_int_equal(dx_out_frames_add(&out, &rig.plane, rig.g, &err), 0);
    assert_int_equal(dx_out_frames_add(&out, &rig.plane, rig.g, &err), -EINVAL);
    assert_non_null(strstr(err.text, "one.pcd"));
    dx_out_frames_abort(&out);
    assert_int_equal(access(in_folder("one.pcd"), F_OK), -1);
    dx_out_frames_abort(&out);
    rig_close(&rig);
}

static void nothing_is_left_of_nothing(void **state)
{
    unsigned before = n_entries(folder);
    struct dx_out_frames out;
    struct dx_err err = {""};

    (void)state;
    assert_int_equal(dx_out_frames_open(&out, in_folder("none.ptx"), DX_FRAME_PTX, &err), 0);
    assert_int_equal(dx_out_frames_commit(&out, &err), -ENODATA);
    assert_int_equal(dx_out_frames_open(&out, in_folder("none"), DX_FRAME_PTX, &err), 0);
    assert_int_equal(dx_out_frames_commit(&out, &err), -ENODATA);
    assert_int_equal(n_entries(folder), before);
}

static void bad_places_are_told(void **state)
{
    struct dx_out_frames out;
    struct dx_err err = {""};

    (void)state;
    assert_int_equal(dx_out_frames_open(&out, in_folder("no/such.ptx"), 0, &err), -ENOENT);
    assert_non_null(strstr(err.text, "no/such.ptx"));
    assert_int_equal(dx_out_frames_open(&out, in_folder("no/such"), 0, &err), -ENOENT);
    assert_non_null(strstr(err.text, "no/such"));
    fclose(fopen(in_folder("a-file"), "w"));
    assert_int_equal(dx_out_frames_open(&out, in_folder("a-file"), 0, &err), -ENOTDIR);
    assert_non_null(strstr(err.text, "a-file"));
}

/* What was there before a write that fails stays, and nothing else does. */
static void a_full_disk_leaves_the_old_file(void **state)
{
    static const char *const names[] = {"full.ptx", "full.pcd"};
    struct rlimit old, small = {20000, RLIM_INFINITY};
    struct rig rig;

    (void)state;
    signal(SIGXFSZ, SIG_IGN);
    rig_init(&rig, DX_SCENE_CREASE, 60, 90);
    rig_open(&rig);
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &old), 0);
    small.rlim_max = old.rlim_max;
    for (int k = 0; k < 2; k++) {
        struct dx_out_frames out;
        struct dx_err err = {""};
        struct stat st;
        unsigned before;
        int r;

        fclose(fopen(in_folder(names[k]), "w"));
        before = n_entries(folder);
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
        r = dx_out_frames_open(&out, in_folder(names[k]), DX_FRAME_PTX, &err);
        assert_int_equal(r, 0);
        r = dx_out_frames_add(&out, &rig.plane, rig.g, &err);
        if (r == 0)
            r = dx_out_frames_commit(&out, &err);
        dx_out_frames_abort(&out);
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &old), 0);
        assert_true(r < 0);
        assert_non_null(strstr(err.text, names[k]));
        assert_int_equal(stat(in_folder(names[k]), &st), 0);
        assert_int_equal(st.st_size, 0);
        assert_int_equal(n_entries(folder), before);
    }
    rig_close(&rig);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_scene_comes_back), cmocka_unit_test(fine_units_come_back),
        cmocka_unit_test(poses_come_back),        cmocka_unit_test(sequences_come_back),
        cmocka_unit_test(a_pcd_holds_one_frame),  cmocka_unit_test(nothing_is_left_of_nothing),
        cmocka_unit_test(bad_places_are_told),    cmocka_unit_test(a_full_disk_leaves_the_old_file),
    };

    return cmocka_run_group_tests(tests, setup, teardown);
}
