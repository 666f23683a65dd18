/*
 * The file driver: single files, folders and globs as sequences, gzip, damaged files among good
 * ones, geometry told again when it changes, loop, pace and wake. Real scans where $DEXEL_DATA has
 * them.
 */
#include "file_fixture.h"

#include "core/base/trig.h"
#include "drivers/replay.h"

#include <errno.h>
#include <math.h>
#include <pthread.h>
#include <sys/socket.h>
#include <sys/un.h>

static void make_subfolder(const char *folder, const char *name)
{
    char *path = path_in(folder, name);

    assert_int_equal(mkdir(path, 0700), 0);
    free(path);
}

static void make_socket(const char *folder, const char *name)
{
    struct sockaddr_un addr = {.sun_family = AF_UNIX};
    int fd = socket(AF_UNIX, SOCK_STREAM, 0);

    snprintf(addr.sun_path, sizeof(addr.sun_path), "%s/%s", folder, name);
    assert_int_equal(bind(fd, (struct sockaddr *)&addr, sizeof(addr)), 0);
    close(fd);
}

static void replays_a_file(void **state)
{
    char *folder = make_folder();
    struct dx_device *dev;
    struct kept k = {0};
    char text[200];

    (void)state;
    write_scan(folder, "a.ptx", 0.25, 5, 7);
    dev = open_path(folder, "a.ptx");
    assert_null(dx_file_fit_report(dev));
    dx_file_driver.describe(dev, text, sizeof(text));
    assert_string_equal(text, "a.ptx: 1 file");
    expect_step(dev, &k, 0, "");
    assert_int_equal(k.geometry->model, DX_MODEL_SPINNING);
    assert_true(k.geometry->wrap && k.geometry->pose[3] == 7);
    assert_int_equal(k.attr_bytes, 2);
    assert_int_equal(k.part.n_cols, COLS);
    assert_true(k.part.last && k.part.frame == 0 && k.part.stamp.host_ns > 0);
    for (size_t n = 0; n < COLS * ROWS; n++) {
        const size_t row = n / COLS;

        assert_int_equal(dx_plane_range(&k.plane, n),
                         (uint32_t)rint(5 / (double)k.geometry->unit_m));
        assert_int_equal(dx_plane_attr(&k.plane, n), (uint32_t)rint((double)row / 4 * 65535));
    }
    assert_true(dx_file_fit_report(dev)->rms_dexel < 1e-3);
    dx_file_driver.describe(dev, text, sizeof(text));
    assert_non_null(strstr(text, "a.ptx: 1 file, spinning 12x5, rms "));
    assert_non_null(strstr(text, ", regularity "));
    dx_file_driver.describe(dev, text, 10);
    assert_string_equal(text, "a.ptx: 1 ");
    expect_step(dev, &k, DX_DRIVER_E_EOF, "");
    expect_step(dev, &k, DX_DRIVER_E_EOF, "");
    close_device(dev);
    kept_fini(&k);
    remove_folder(folder);
}

/* Order by name; names that are no recordings and hidden ones are passed over. */
static void replays_a_folder_in_order(void **state)
{
    char *folder = make_folder();
    struct dx_device *dev;
    struct kept k = {0};

    (void)state;
    write_scan(folder, "b2.ptx", 0, 2, 0);
    write_scan(folder, "b1.PTX", 0, 1.9, 0);
    write_scan(folder, "b10.ptx", 0, 2.1, 0);
    write_scan(folder, ".b0.ptx", 0, 2.2, 0);
    write_file(folder, "README", "text\n", 5);
    dev = open_path(folder, "");
    for (int n = 0; n < 3; n++) {
        static const double ranges[] = {1.9, 2.1, 2};

        expect_step(dev, &k, 0, "");
        assert_true(fabs(dx_plane_range(&k.plane, 0) * (double)k.geometry->unit_m - ranges[n]) <
                    1e-4);
        assert_true(k.part.frame == (unsigned)n);
    }
    expect_step(dev, &k, DX_DRIVER_E_EOF, "");
    assert_int_equal(k.n_geometries, 1); /* 2.1 m fits the unit of 1.9 m */
    close_device(dev);
    kept_fini(&k);
    dev = open_path(folder, "b?.*");
    for (int n = 0; n < 2; n++)
        expect_step(dev, &k, 0, "");
    expect_step(dev, &k, DX_DRIVER_E_EOF, "");
    close_device(dev);
    kept_fini(&k);
    remove_folder(folder);
}

static void replays_all_scans_of_a_file(void **state)
{
    char *folder = make_folder();
    struct buffer b = {0};
    struct dx_device *dev;
    struct kept k = {0};

    (void)state;
    add_scan(&b, 0, 2, 0);
    buffer_print(&b, "\r\n");
    add_scan(&b, 0, 2, 1);
    add_scan(&b, 0, 2, 1);
    b.bytes[b.len - 30] = 'x';
    buffer_print(&b, "\n\n");
    write_file(folder, "three.ptx", b.bytes, b.len);
    dev = open_path(folder, "three.ptx");
    expect_step(dev, &k, 0, "");
    expect_step(dev, &k, 0, "");
    assert_int_equal(k.n_geometries, 2); /* another pose */
    assert_true(k.geometry->pose[3] == 1);
    expect_step(dev, &k, DX_DRIVER_E_CORRUPT, "scan 3 of ");
    expect_step(dev, &k, DX_DRIVER_E_EOF, "");
    close_device(dev);
    kept_fini(&k);
    buffer_fini(&b);
    remove_folder(folder);
}

static void expect_refused(const char *folder, const char *name, const char *text)
{
    char *path = path_in(folder, name);
    struct dx_file_config config = file_config(path);
    struct dx_device *dev = NULL;
    struct dx_err err = {""};

    assert_int_equal(dx_file_driver.open(&dev, &config, &err), -EBADMSG);
    assert_non_null(strstr(err.text, text));
    free(path);
}

static void says_what_is_no_recording(void **state)
{
    char *folder = make_folder();
    struct buffer b = {0};
    struct dx_device *dev;
    struct kept k = {0};

    (void)state;
    write_file(folder, "notes.txt", "text\n", 5);
    expect_refused(folder, "notes.txt", "notes.txt: neither PTX nor PCD nor MCAP");
    add_scan(&b, 0, 2, 0);
    write_file(folder, "scan.txt", b.bytes, b.len);
    dev = open_path(folder, "*.txt"); /* one of them is */
    expect_step(dev, &k, DX_DRIVER_E_CORRUPT, "notes.txt: neither PTX nor PCD nor MCAP");
    expect_step(dev, &k, 0, "");
    expect_step(dev, &k, DX_DRIVER_E_EOF, "");
    close_device(dev);
    buffer_print(&b, "rubbish\n");
    write_file(folder, "a.ptx", b.bytes, b.len);
    dev = open_path(folder, "a.ptx");
    expect_step(dev, &k, 0, "");
    expect_step(dev, &k, DX_DRIVER_E_CORRUPT, "a.ptx: line 1: \"rubbish\", expected a number of");
    expect_step(dev, &k, DX_DRIVER_E_EOF, "");
    close_device(dev);
    kept_fini(&k);
    buffer_fini(&b);
    remove_folder(folder);
}

static void tells_a_geometry_that_changed(void **state)
{
    char *folder = make_folder();
    struct dx_device *dev;
    struct kept k = {0};

    (void)state;
    write_scan(folder, "0.ptx", 0, 5, 0);
    write_scan(folder, "1.ptx", 0.4, 5, 0);   /* within half a dexel: kept */
    write_scan(folder, "2.ptx", 0.6, 5, 0);   /* told */
    write_scan(folder, "3.ptx", 0.6, 50, 0);  /* the range does not fit: told */
    write_scan(folder, "4.ptx", 0.6, 5, 0);   /* fits: kept */
    write_scan(folder, "5.ptx", 0.6, 5, 0.5); /* another pose: told */
    dev = open_path(folder, "");
    for (unsigned n = 0; n < 6; n++) {
        static const unsigned told[] = {1, 1, 2, 3, 3, 4};

        expect_step(dev, &k, 0, "");
        assert_int_equal(k.n_geometries, told[n]);
    }
    close_device(dev);
    kept_fini(&k);
    remove_folder(folder);
}

static void makes_the_attribute_asked_for(void **state)
{
    char *folder = make_folder();
    char *path;

    (void)state;
    write_scan(folder, "a.ptx", 0, 5, 0);
    path = path_in(folder, "a.ptx");
    for (int bytes = 0; bytes <= 2; bytes++) {
        struct dx_file_config config = file_config(path);
        struct dx_device *dev;
        struct kept k = {0};

        config.attr_bytes = bytes;
        dev = open_device(&config);
        expect_step(dev, &k, 0, "");
        assert_int_equal(k.attr_bytes, bytes);
        assert_int_equal(dx_plane_attr(&k.plane, 4 * COLS), bytes == 0   ? 0
                                                            : bytes == 1 ? 255
                                                                         : 65535);
        close_device(dev);
        kept_fini(&k);
    }
    free(path);
    remove_folder(folder);
}

/* What is damaged is reported once and by name, and the good files around it come. */
static void passes_over_damaged_files(void **state)
{
    char *folder = make_folder();
    struct buffer plain = {0}, gz;
    struct dx_device *dev;
    struct kept k = {0};

    (void)state;
    add_scan(&plain, 0, 5, 0);
    gz = gzipped(&plain);
    write_file(folder, "0.ptx.gz", gz.bytes, gz.len);
    write_file(folder, "1.ptx.gz", gz.bytes, gz.len - 30);
    gz.bytes[gz.len / 2] ^= 0xff;
    write_file(folder, "2.ptx.gz", gz.bytes, gz.len);
    write_file(folder, "3.ptx", "", 0);
    write_file(folder, "4.ptx", "not a scan\n", 11);
    write_file(folder, "5.ptx", plain.bytes, plain.len - 100);
    write_file(folder, "6.pcd", "\n\n", 2);
    write_file(folder, "7.pcd", plain.bytes, plain.len); /* the content counts, not the name */
    dev = open_path(folder, "");
    expect_step(dev, &k, 0, "");
    expect_step(dev, &k, DX_DRIVER_E_CORRUPT, "1.ptx.gz: byte ");
    expect_step(dev, &k, DX_DRIVER_E_CORRUPT, "2.ptx.gz: byte ");
    expect_step(dev, &k, DX_DRIVER_E_CORRUPT, "3.ptx: empty");
    expect_step(dev, &k, DX_DRIVER_E_CORRUPT,
                "4.ptx: line 1: \"not\", expected a number of columns");
    expect_step(dev, &k, DX_DRIVER_E_CORRUPT, "5.ptx: line ");
    expect_step(dev, &k, DX_DRIVER_E_CORRUPT, "6.pcd: empty");
    expect_step(dev, &k, 0, "");
    expect_step(dev, &k, DX_DRIVER_E_EOF, "");
    assert_int_equal(k.n_frames, 2);
    assert_int_equal(k.n_geometries, 1);
    close_device(dev);
    kept_fini(&k);
    buffer_fini(&plain);
    buffer_fini(&gz);
    remove_folder(folder);
}

/* Pipes that nobody writes to, a socket, a folder. */
static void passes_over_what_is_no_file(void **state)
{
    char *folder = make_folder();
    struct dx_device *dev;
    struct kept k = {0};

    (void)state;
    make_fifo(folder, "0.ptx");
    write_scan(folder, "1.ptx", 0, 5, 0);
    make_fifo(folder, "2.mcap");
    make_subfolder(folder, "3.ptx");
    make_socket(folder, "4.ptx");
    write_scan(folder, "5.ptx", 0, 5, 0);
    dev = open_path(folder, "");
    expect_step(dev, &k, DX_DRIVER_E_CORRUPT, "0.ptx: not a regular file");
    expect_step(dev, &k, 0, "");
    expect_step(dev, &k, DX_DRIVER_E_CORRUPT, "2.mcap: not a regular file");
    expect_step(dev, &k, DX_DRIVER_E_CORRUPT, "3.ptx: not a regular file");
    expect_step(dev, &k, DX_DRIVER_E_CORRUPT, "4.ptx: not a regular file");
    expect_step(dev, &k, 0, "");
    expect_step(dev, &k, DX_DRIVER_E_EOF, "");
    close_device(dev);
    kept_fini(&k);
    remove_folder(folder);
}

/* Looping over nothing but damage ends; over frames it goes on, with growing numbers and stamps. */
static void loops(void **state)
{
    char *folder = make_folder();
    char *path = path_in(folder, "a.ptx");
    struct dx_file_config config = file_config(path);
    struct dx_device *dev;
    struct kept k = {0};

    (void)state;
    config.loop = true;
    config.fps = 4;
    write_file(folder, "a.ptx", "1\n", 2);
    dev = open_device(&config);
    expect_step(dev, &k, DX_DRIVER_E_CORRUPT, "a.ptx: line 2: the file ends");
    expect_step(dev, &k, DX_DRIVER_E_EOF, "");
    close_device(dev);
    write_scan(folder, "a.ptx", 0, 5, 0);
    dev = open_device(&config);
    for (uint64_t n = 0; n < 5; n++) {
        expect_step(dev, &k, 0, "");
        assert_true(k.part.frame == n && k.part.stamp.device_ns == n * 250000000);
        assert_int_equal(k.part.stamp.clock_id, DX_CLOCK_NONE);
    }
    assert_int_equal(k.n_geometries, 1);
    close_device(dev);
    kept_fini(&k);
    free(path);
    remove_folder(folder);
}

static void passes_up_what_the_sink_says(void **state)
{
    char *folder = make_folder();
    struct dx_device *dev;
    struct kept k = {.refuse = -EPERM};

    (void)state;
    write_scan(folder, "a.ptx", 0, 5, 0);
    write_scan(folder, "b.ptx", 0, 5, 0);
    dev = open_path(folder, "");
    expect_step(dev, &k, -EPERM, "");
    k.refuse = 0;
    k.closing = true;
    expect_step(dev, &k, DX_DRIVER_E_AGAIN, "");
    assert_int_equal(k.n_geometries, 1);
    assert_int_equal(k.n_frames, 0);
    close_device(dev);
    kept_fini(&k);
    remove_folder(folder);
}

static void assert_not_opened(const struct dx_file_config *config, int code, const char *message)
{
    struct dx_device *dev;
    struct dx_err err = {""};
    int rc = dx_file_driver.open(&dev, config, &err);

    if (rc != code || !strstr(err.text, message))
        fail_msg("%d \"%s\", expected %d \"%s\"", rc, err.text, code, message);
}

static void refuses_what_is_not_there(void **state)
{
    char *folder = make_folder();
    char *missing = path_in(folder, "a.ptx"), *none = path_in(folder, "*.ptx");
    struct dx_file_config config = file_config(missing);

    (void)state;
    assert_not_opened(&config, -ENOENT, "a.ptx: No such file");
    config.path = none;
    assert_not_opened(&config, -ENOENT, "*.ptx: no such file, and none matches");
    config.path = folder;
    assert_not_opened(&config, -ENOENT, "no recording in this directory, expected *.ptx or *.pcd");
    config.path = "/dev/null";
    assert_not_opened(&config, -EINVAL, "/dev/null: neither a file nor a directory");
    config.path = "";
    assert_not_opened(&config, -EINVAL, "no path");
    config.path = folder;
    config.rate = -1;
    assert_not_opened(&config, -EINVAL, "rate -1");
    config.rate = (double)NAN;
    assert_not_opened(&config, -EINVAL, "rate");
    config.rate = 1;
    config.fps = -3;
    assert_not_opened(&config, -EINVAL, "fps -3");
    config.fps = 0;
    config.attr_bytes = 3;
    assert_not_opened(&config, -EINVAL, "attr_bytes 3");
    dx_file_driver.close(NULL);
    free(missing);
    free(none);
    remove_folder(folder);
}

/* ---- slurp ------------------------------------------------------------------------------------
 */

/* Every point of the plane within half a unit, and the model's residual, of the file's. */
static void replays_real_files(void **state)
{
    static const struct {
        const char *name;
        enum dx_model model;
        uint32_t width, height;
        double valid, max_range;
    } files[] = {
        {"ptx/pump.ptx.gz", DX_MODEL_TABLE, 345, 1074, 0.4189, 5.43},
        {"pcd/grabber-000.pcd", DX_MODEL_PINHOLE, 640, 480, 0.884, 1.71},
        {"pcd/grabber-*.pcd", DX_MODEL_PINHOLE, 640, 480, 0.884, 1.71},
        {"pcd/milk_cartoon_all_small_clorox.pcd", DX_MODEL_PINHOLE, 640, 480, 0.786, 2.06},
        {"pcd/table_scene_mug_stereo_textured.pcd", DX_MODEL_PINHOLE, 640, 480, 0.681, 2.59},
    };
    const char *folder = getenv("DEXEL_DATA");

    (void)state;
    if (!folder || access(folder, R_OK) != 0)
        skip();
    for (size_t n = 0; n < sizeof(files) / sizeof(files[0]); n++) {
        struct dx_device *dev = open_path(folder, files[n].name);
        const struct dx_fit_report *r;
        struct kept k = {0};
        char text[200];

        expect_step(dev, &k, 0, "");
        r = dx_file_fit_report(dev);
        dx_file_driver.describe(dev, text, sizeof(text));
        print_message("%s (spinning %.3g, pinhole %.3g)\n", text, r->rms_spinning, r->rms_pinhole);
        assert_int_equal(k.geometry->model, files[n].model);
        assert_int_equal(k.geometry->width, files[n].width);
        assert_int_equal(k.geometry->height, files[n].height);
        assert_true(fabs(r->valid - files[n].valid) < 1e-3);
        assert_true(fabs(r->max_range_m - files[n].max_range) < 0.01);
        assert_true(r->rms_dexel < 0.01);
        while (k.n_frames < 2 && strchr(files[n].name, '*'))
            expect_step(dev, &k, 0, "");
        assert_int_equal(k.n_geometries, 1);
        expect_step(dev, &k, DX_DRIVER_E_EOF, "");
        close_device(dev);
        kept_fini(&k);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(replays_a_file),
        cmocka_unit_test(replays_a_folder_in_order),
        cmocka_unit_test(replays_all_scans_of_a_file),
        cmocka_unit_test(says_what_is_no_recording),
        cmocka_unit_test(tells_a_geometry_that_changed),
        cmocka_unit_test(makes_the_attribute_asked_for),
        cmocka_unit_test(passes_over_damaged_files),
        cmocka_unit_test(passes_over_what_is_no_file),
        cmocka_unit_test(loops),
        cmocka_unit_test(passes_up_what_the_sink_says),
        cmocka_unit_test(refuses_what_is_not_there),
        cmocka_unit_test(replays_real_files),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
