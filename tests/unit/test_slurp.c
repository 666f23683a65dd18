/* Files read whole, plain and gzip: the bound, pipes and folders, every truncation. */
#include "file_fixture.h"

#include "drivers/file/slurp.h"

#include <errno.h>
#include <sys/stat.h>
#include <zlib.h>

static void slurps_within_bounds(void **state)
{
    char *folder = make_folder();
    char *path = path_in(folder, "f"), *fifo = path_in(folder, "fifo");
    struct buffer plain = {0}, gz, two = {0};
    struct dx_slurp s = {0};
    struct dx_err err;

    (void)state;
    for (int k = 0; k < 1000; k++)
        buffer_print(&plain, "line %d of a thousand\n", k);
    gz = gzipped(&plain);
    buffer_add(&two, gz.bytes, gz.len); /* two members and rubbish after them */
    buffer_add(&two, gz.bytes, gz.len);
    buffer_add(&two, "\0\0\0", 3);
    write_file(folder, "f", plain.bytes, plain.len);
    assert_int_equal(dx_slurp_file(&s, path, plain.len, &err), 0);
    assert_int_equal(s.len, plain.len);
    assert_int_equal(dx_slurp_file(&s, path, plain.len - 1, &err), -EFBIG);
    write_file(folder, "f", gz.bytes, gz.len);
    assert_int_equal(dx_slurp_file(&s, path, plain.len, &err), 0);
    assert_int_equal(s.len, plain.len);
    assert_memory_equal(s.bytes, plain.bytes, plain.len);
    assert_int_equal(dx_slurp_file(&s, path, plain.len - 1, &err), -EFBIG);
    assert_non_null(strstr(err.text, "f: more than "));
    write_file(folder, "f", two.bytes, two.len);
    assert_int_equal(dx_slurp_file(&s, path, 2 * plain.len, &err), 0);
    assert_int_equal(s.len, 2 * plain.len);
    assert_int_equal(mkfifo(fifo, 0600), 0);
    assert_int_equal(dx_slurp_file(&s, fifo, 1000, &err), -EINVAL);
    assert_int_equal(dx_slurp_file(&s, folder, 1000, &err), -EINVAL);
    assert_non_null(strstr(err.text, "not a regular file"));
    dx_slurp_fini(&s);
    buffer_fini(&plain);
    buffer_fini(&two);
    buffer_fini(&gz);
    free(path);
    free(fifo);
    remove_folder(folder);
}

static void slurp_refuses_every_truncated_gzip(void **state)
{
    char *folder = make_folder();
    char *path = path_in(folder, "f");
    struct buffer plain = {0}, gz;
    struct dx_slurp s = {0};
    struct dx_err err;

    (void)state;
    buffer_print(&plain, "some words, some words, some other words\n");
    gz = gzipped(&plain);
    for (size_t len = 2; len < gz.len; len++) {
        write_file(folder, "f", gz.bytes, len);
        assert_int_equal(dx_slurp_file(&s, path, 1000, &err), -EBADMSG);
        assert_non_null(strstr(err.text, "gzip data end early"));
        assert_int_equal(s.len, 0);
    }
    dx_slurp_fini(&s);
    buffer_fini(&plain);
    buffer_fini(&gz);
    free(path);
    remove_folder(folder);
}

/* ---- pace -------------------------------------------------------------------------------------
 */

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slurps_within_bounds),
        cmocka_unit_test(slurp_refuses_every_truncated_gzip),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
