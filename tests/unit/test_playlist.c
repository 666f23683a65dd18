/* What a playlist makes of names that are no files. */
#include "played_fixture.h"

#include "drivers/file/playlist.h"

#include <errno.h>

static void expect_no_playlist(const char *path, const char *text)
{
    struct dx_playlist *p = NULL;
    struct dx_err err = {""};

    assert_int_equal(dx_playlist_new(&p, path, NULL, &err), -EINVAL);
    if (!strstr(err.text, text))
        fail_msg("found '%s', expected '%s'", err.text, text);
}

/* A pipe among recordings, the first of them or not, and one among scans. */
static void does_not_wait_for_a_pipe(void **state)
{
    char *folder = make_folder(), *first = path_in(folder, "a.mcap");
    char *scans = make_folder();

    (void)state;
    record(folder, "b.mcap", YAML(5), 0);
    make_fifo(folder, "a.mcap");
    assert_true(dx_playlist_wants(folder));
    expect_no_playlist(folder, "a.mcap: not a regular file");
    assert_int_equal(unlink(first), 0);
    make_fifo(folder, "c.mcap");
    assert_true(dx_playlist_wants(folder));
    expect_no_playlist(folder, "c.mcap: not a regular file");
    make_fifo(scans, "a.ptx");
    write_scan(scans, "b.ptx", 0, 5, 0);
    assert_false(dx_playlist_wants(scans));
    free(first);
    remove_folder(folder);
    remove_folder(scans);
}

/* The name has come to mean a pipe since the playlist looked at it. */
static void a_later_file_that_became_a_pipe(void **state)
{
    char *folder = make_folder(), *later = path_in(folder, "r_0003.mcap");
    struct dx_playlist_block block;
    struct dx_playlist *p;
    struct dx_err err = {""};
    int rc;

    (void)state;
    record(folder, "r.mcap", YAML(5), 1500000000u);
    assert_int_equal(dx_playlist_new(&p, folder, NULL, &err), 0);
    assert_int_equal(unlink(later), 0);
    make_fifo(folder, "r_0003.mcap");
    while ((rc = dx_playlist_next(p, &block, &err)) == 0)
        ;
    assert_int_equal(rc, -EINVAL);
    assert_non_null(strstr(err.text, "r_0003.mcap: not a regular file"));
    dx_playlist_free(p);
    free(later);
    remove_folder(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(does_not_wait_for_a_pipe),
        cmocka_unit_test(a_later_file_that_became_a_pipe),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
