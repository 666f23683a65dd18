/* Names of recordings, and which of them are removed. */
#include "file_fixture.h"

#include "daemon/record_files.h"

#include <errno.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

static void checks_patterns(void **state)
{
    (void)state;
    assert_null(dx_record_files_check("/rec/hall-%Y%m%dT%H%M%S.mcap"));
    assert_null(dx_record_files_check("hall.mcap"));
    assert_null(dx_record_files_check("100%%-%F.mcap"));
    assert_non_null(dx_record_files_check("/rec/hall"));
    assert_non_null(dx_record_files_check("/rec/.mcap"));
    assert_non_null(dx_record_files_check("/rec/%Y/hall.mcap"));
    assert_non_null(dx_record_files_check("/rec/%n.mcap"));
    assert_non_null(dx_record_files_check("/rec/%.mcap"));
}

/* A file of 1000 bytes, changed at `age` seconds of the epoch. */
static void put_file(const char *folder, const char *name, time_t age)
{
    const struct timespec times[2] = {{.tv_sec = age}, {.tv_sec = age}};
    char *path = path_in(folder, name);
    int fd = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0600);

    assert_true(fd >= 0);
    assert_int_equal(ftruncate(fd, 1000), 0);
    assert_int_equal(futimens(fd, times), 0);
    close(fd);
    free(path);
}

static bool is_there(const char *folder, const char *name)
{
    char *path = path_in(folder, name);
    bool there = access(path, F_OK) == 0;

    free(path);
    return there;
}

/* 2023-11-14 22:13:20 UTC */
#define WHEN 1700000000000000000u

static void names_files_by_time(void **state)
{
    char *folder = make_folder(), *pattern = path_in(folder, "r-%Y%m%dT%H%M%S.mcap");
    struct dx_record_files f;

    (void)state;
    dx_record_files_init(&f, pattern, 0);
    for (int n = 0; n < 3; n++)
        assert_int_equal(dx_record_files_create(&f, WHEN + 5), 0);
    dx_record_files_close(&f);
    assert_true(is_there(folder, "r-20231114T221320.mcap"));
    assert_true(is_there(folder, "r-20231114T221320_0002.mcap"));
    assert_true(is_there(folder, "r-20231114T221320_0003.mcap"));
    assert_int_equal(dx_record_files_trim(&f), 0); /* all stay */
    free(pattern);
    pattern = path_in(folder, "none/r.mcap");
    dx_record_files_init(&f, pattern, 0);
    assert_int_equal(dx_record_files_create(&f, WHEN), -ENOENT);
    free(pattern);
    remove_folder(folder);
}

/* The oldest go, never the open one, never what the pattern could not have named. */
static void removes_the_oldest(void **state)
{
    static const char *const others[] = {"r-hall.mcap", "r-20231114T221320.mcap.bak",
                                         "r-20231114T221320_a.mcap", "q-20231114T221320.mcap"};
    char *folder = make_folder(), *pattern = path_in(folder, "r-%Y%m%dT%H%M%S.mcap");
    struct dx_record_files f;

    (void)state;
    for (size_t k = 0; k < 4; k++)
        put_file(folder, others[k], 1);
    put_file(folder, "r-20231114T221321.mcap", 100);
    put_file(folder, "r-20231114T221320_0002.mcap", 20);
    put_file(folder, "r-20231114T221320_0003.mcap", 10);
    dx_record_files_init(&f, pattern, 2500);
    assert_int_equal(dx_record_files_create(&f, WHEN), 0);
    assert_int_equal(ftruncate(f.fd, 1200), 0);
    assert_int_equal(dx_record_files_trim(&f), 2);
    assert_true(is_there(folder, "r-20231114T221320_0004.mcap"));
    assert_true(is_there(folder, "r-20231114T221321.mcap"));
    assert_false(is_there(folder, "r-20231114T221320_0002.mcap"));
    assert_int_equal(ftruncate(f.fd, 9000), 0);
    assert_int_equal(dx_record_files_trim(&f), 1); /* too long by itself: it stays */
    assert_true(is_there(folder, "r-20231114T221320_0004.mcap"));
    for (size_t k = 0; k < 4; k++)
        assert_true(is_there(folder, others[k]));
    dx_record_files_close(&f);
    free(pattern);
    remove_folder(folder);
}

/* What was removed does not give its number away: the order of names is that of the files. */
static void numbers_only_grow(void **state)
{
    char *folder = make_folder(), *pattern = path_in(folder, "r-%Y.mcap");
    struct dx_record_files f;
    char name[32];

    (void)state;
    dx_record_files_init(&f, pattern, 1500);
    for (unsigned n = 1; n <= 6; n++) {
        assert_int_equal(dx_record_files_create(&f, WHEN), 0);
        assert_int_equal(ftruncate(f.fd, 1000), 0);
        assert_int_equal(dx_record_files_trim(&f), n > 1);
        snprintf(name, sizeof(name), n == 1 ? "r-2023.mcap" : "r-2023_%04u.mcap", n);
        assert_true(is_there(folder, name));
    }
    dx_record_files_close(&f);
    assert_int_equal(unlink(f.path), 0); /* the last one, too */
    assert_int_equal(dx_record_files_create(&f, WHEN), 0);
    assert_true(is_there(folder, "r-2023_0007.mcap"));
    dx_record_files_close(&f);
    free(pattern);
    remove_folder(folder);
}

/* Of two recorders in one place neither removes what the other writes. */
static void spares_what_another_writes(void **state)
{
    char *folder = make_folder(), *pattern = path_in(folder, "r.mcap");
    struct dx_record_files a, b;

    (void)state;
    dx_record_files_init(&a, pattern, 100);
    dx_record_files_init(&b, pattern, 100);
    assert_int_equal(dx_record_files_create(&a, WHEN), 0);
    assert_int_equal(dx_record_files_create(&b, WHEN), 0);
    assert_int_equal(ftruncate(a.fd, 1000), 0);
    assert_int_equal(ftruncate(b.fd, 1000), 0);
    assert_int_equal(dx_record_files_trim(&b), 0);
    dx_record_files_close(&a);
    assert_int_equal(dx_record_files_trim(&b), 1);
    assert_false(is_there(folder, "r.mcap"));
    assert_true(is_there(folder, "r_0002.mcap"));
    dx_record_files_close(&b);
    free(pattern);
    remove_folder(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(checks_patterns),
        cmocka_unit_test(names_files_by_time),
        cmocka_unit_test(removes_the_oldest),
        cmocka_unit_test(numbers_only_grow),
        cmocka_unit_test(spares_what_another_writes),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
