/* The file driver with an array of chosen size: geometry, ranges, and what makes a new array. */
#include "file_fixture.h"

#include <errno.h>
#include <math.h>

static struct dx_device *open_thin(const char *folder, const char *name, uint32_t width,
                                   uint32_t height, enum dx_keep keep)
{
    char *path = path_in(folder, name);
    struct dx_file_config config = file_config(path);
    struct dx_device *dev;

    config.thin = (struct dx_thin_options){width, height, keep};
    dev = open_device(&config);
    free(path);
    return dev;
}

static void the_own_size_is_the_own_grid(void **state)
{
    char *folder = make_folder();
    struct kept own = {0}, thin = {0};

    (void)state;
    write_scan(folder, "a.ptx", 0.3, 4, 7);
    for (unsigned keep = 0; keep < DX_N_KEEP; keep++) {
        struct dx_device *a = open_path(folder, "a.ptx");
        struct dx_device *b = open_thin(folder, "a.ptx", COLS, ROWS, (enum dx_keep)keep);

        expect_step(a, &own, 0, "");
        expect_step(b, &thin, 0, "");
        assert_true(dx_geometry_departure(own.geometry, thin.geometry) < 1e-4);
        assert_true(thin.geometry->wrap && own.geometry->wrap);
        assert_memory_equal(own.geometry->pose, thin.geometry->pose, sizeof(own.geometry->pose));
        assert_true(own.geometry->unit_m == thin.geometry->unit_m);
        assert_int_equal(own.plane.attr_bytes, thin.plane.attr_bytes);
        for (size_t k = 0; k < COLS * ROWS; k++) {
            assert_int_equal(dx_plane_range(&own.plane, k), dx_plane_range(&thin.plane, k));
            assert_int_equal(dx_plane_attr(&own.plane, k), dx_plane_attr(&thin.plane, k));
        }
        close_device(a);
        close_device(b);
        kept_fini(&own);
        kept_fini(&thin);
    }
    remove_folder(folder);
}

/* 12 columns to 4, 5 rows to 3: rows at -20, 0, 20 degrees are kept as they are (4 m), and so is
 * their attribute. */
static void a_smaller_array_is_filled(void **state)
{
    char *folder = make_folder();
    struct dx_device *dev;
    struct kept k = {0};
    char text[200];

    (void)state;
    write_scan(folder, "a.ptx", 0, 4, 0);
    dev = open_thin(folder, "a.ptx", 8, 3, DX_KEEP_CENTRE);
    expect_step(dev, &k, 0, "");
    assert_int_equal(k.geometry->model, DX_MODEL_SPINNING);
    assert_true(k.geometry->wrap);
    assert_int_equal(k.plane.width, 8);
    assert_int_equal(k.plane.height, 3);
    assert_int_equal(k.part.n_cols, 8);
    assert_true(k.part.last);
    for (uint32_t row = 0; row < 3; row++)
        for (uint32_t col = 0; col < 8; col++) {
            size_t dexel = row * 8 + col;

            assert_true(fabs(dx_plane_range(&k.plane, dexel) * (double)k.geometry->unit_m - 4) <
                        1e-4);
            assert_int_equal(dx_plane_attr(&k.plane, dexel), (uint32_t)rint(65535 * row / 2.0));
        }
    dx_file_driver.describe(dev, text, sizeof(text));
    assert_non_null(strstr(text, "spinning 8x3"));
    assert_non_null(dx_file_fit_report(dev));
    close_device(dev);
    kept_fini(&k);
    remove_folder(folder);
}

/* A turned scan still lies in the array of the full turn; one that no unit holds does not, and
 * neither does one from another place. */
static void an_array_serves_while_the_points_lie_in_it(void **state)
{
    char *folder = make_folder();
    struct dx_device *dev;
    struct kept k = {0};

    (void)state;
    write_scan(folder, "1.ptx", 0, 4, 0);
    write_scan(folder, "2.ptx", 0.5, 4, 0);
    write_scan(folder, "3.ptx", 0, 400, 0);
    write_scan(folder, "4.ptx", 0, 4, 0);
    write_scan(folder, "5.ptx", 0, 4, 1);
    dev = open_thin(folder, "", 8, 3, DX_KEEP_MEDIAN);
    for (unsigned n = 1; n <= 5; n++) {
        static const unsigned told[] = {1, 1, 2, 2, 3};

        expect_step(dev, &k, 0, "");
        assert_int_equal(k.n_geometries, told[n - 1]);
        for (size_t dexel = 0; dexel < 24; dexel++)
            assert_true(fabs(dx_plane_range(&k.plane, dexel) * (double)k.geometry->unit_m -
                             (n == 3 ? 400 : 4)) < 0.01);
    }
    expect_step(dev, &k, DX_DRIVER_E_EOF, "");
    close_device(dev);
    kept_fini(&k);
    remove_folder(folder);
}

/* A sink that refuses a geometry gets it again with the next frame. */
static void a_refused_geometry_is_told_again(void **state)
{
    char *folder = make_folder();
    struct dx_device *dev;
    struct kept k = {.refuse = -EBUSY};

    (void)state;
    write_scan(folder, "1.ptx", 0, 4, 0);
    write_scan(folder, "2.ptx", 0, 5, 0);
    dev = open_thin(folder, "", 8, 3, DX_KEEP_CENTRE);
    expect_step(dev, &k, -EBUSY, "");
    k.refuse = 0;
    expect_step(dev, &k, 0, "");
    assert_int_equal(k.n_geometries, 1);
    close_device(dev);
    kept_fini(&k);
    remove_folder(folder);
}

static void wrong_sizes_are_refused(void **state)
{
    static const struct dx_thin_options wrong[] = {{1, 5, DX_KEEP_CENTRE},
                                                   {5, 0, DX_KEEP_CENTRE},
                                                   {70000, 5, DX_KEEP_CENTRE},
                                                   {60000, 60000, DX_KEEP_CENTRE},
                                                   {0, 0, DX_N_KEEP}};

    (void)state;
    for (size_t k = 0; k < sizeof(wrong) / sizeof(wrong[0]); k++) {
        struct dx_file_config config = file_config("/nowhere");
        struct dx_device *dev;
        struct dx_err err = {""};

        config.thin = wrong[k];
        assert_int_equal(dx_file_driver.open(&dev, &config, &err), -EINVAL);
        assert_non_null(strstr(err.text, k < 4 ? "file: size " : "file: keep "));
    }
}

/* Two columns of a full turn lie half a turn apart: nothing is between them. */
static void an_array_that_cannot_be_is_a_corrupt_frame(void **state)
{
    char *folder = make_folder();
    struct dx_device *dev;
    struct kept k = {0};

    (void)state;
    write_scan(folder, "a.ptx", 0, 4, 0);
    dev = open_thin(folder, "a.ptx", 2, 3, DX_KEEP_CENTRE);
    expect_step(dev, &k, DX_DRIVER_E_CORRUPT, "a.ptx: thinning 12x5 points to 2x3 dexels");
    assert_int_equal(k.n_geometries, 0);
    close_device(dev);
    remove_folder(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_own_size_is_the_own_grid),
        cmocka_unit_test(a_smaller_array_is_filled),
        cmocka_unit_test(an_array_serves_while_the_points_lie_in_it),
        cmocka_unit_test(a_refused_geometry_is_told_again),
        cmocka_unit_test(wrong_sizes_are_refused),
        cmocka_unit_test(an_array_that_cannot_be_is_a_corrupt_frame),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
