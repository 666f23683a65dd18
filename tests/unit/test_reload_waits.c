/*
 * Reloads whose file takes its time: it is a pipe, from which the configuration comes when the test
 * writes it. Another reload that is asked for meanwhile is made after the first; a service that is
 * to end does not wait for the file.
 */
#include "tests/unit/service_child.h"

#include <fcntl.h>
#include <sys/stat.h>

#define RELOAD "{\"request\":\"reload\"}\n"

static char text[1024]; /* the configuration */

static void file_to_pipe(const struct place *p)
{
    FILE *f = fopen(p->config, "r");

    assert_non_null(f);
    text[fread(text, 1, sizeof(text) - 1, f)] = '\0';
    fclose(f);
    assert_int_equal(unlink(p->config), 0);
    assert_int_equal(mkfifo(p->config, 0600), 0);
}

/* Comes back when the service has opened the file. */
static int await_reader(const struct place *p)
{
    int fd = open(p->config, O_WRONLY);

    assert_true(fd >= 0);
    return fd;
}

static void give(int fd)
{
    assert_int_equal(write(fd, text, strlen(text)), strlen(text));
    close(fd);
}

static pid_t start_on_pipe(const struct place *p)
{
    int ready_fd;
    const pid_t pid = start(p, 0, &ready_fd);

    assert_true(is_ready(ready_fd, 0));
    file_to_pipe(p);
    return pid;
}

static void expect_reloaded(const char *answer)
{
    assert_non_null(answer);
    assert_non_null(strstr(answer, "\"unchanged\":[\"hall\"]"));
}

static void one_more_comes_after_the_first(void **state)
{
    const struct place *p = *state;
    const pid_t pid = start_on_pipe(p);
    const int first = begin_asking(p, RELOAD), file = await_reader(p);
    const int second = begin_asking(p, RELOAD);

    assert_non_null(ask(p, "{\"request\":\"status\"}\n")); /* the second was taken before this */
    give(file);
    expect_reloaded(hear(first, RELOAD));
    give(await_reader(p)); /* it is read again */
    expect_reloaded(hear(second, RELOAD));
    kill(pid, SIGTERM);
    await_end(pid, 0);
    assert_int_equal(p->outcome->result, 0);
}

/* Two who ask for the next reload in the same write: each asks as soon as it is answered, while
 * the reload that has just ended is still being told. One more serves both. */
static void those_who_are_answered_ask_for_the_next(void **state)
{
    const struct place *p = *state;
    const pid_t pid = start_on_pipe(p);
    const int first = begin_asking(p, RELOAD), file = await_reader(p);
    const int second = begin_asking(p, RELOAD RELOAD), third = begin_asking(p, RELOAD RELOAD);

    assert_non_null(ask(p, "{\"request\":\"status\"}\n")); /* they were taken before this */
    give(file);
    expect_reloaded(hear(first, RELOAD));
    give(await_reader(p));
    expect_reloaded(hear_next(second, RELOAD));
    expect_reloaded(hear_next(third, RELOAD));
    give(await_reader(p));
    expect_reloaded(hear(second, RELOAD));
    expect_reloaded(hear(third, RELOAD));
    kill(pid, SIGTERM);
    await_end(pid, 0);
    assert_int_equal(p->outcome->result, 0);
}

static void the_end_does_not_wait_for_the_file(void **state)
{
    const struct place *p = *state;
    const pid_t pid = start_on_pipe(p);
    const int fd = begin_asking(p, RELOAD), file = await_reader(p);

    kill(pid, SIGTERM);
    await_end(pid, 0);
    assert_int_equal(p->outcome->result, DX_SERVICE_E_LEFT);
    assert_int_equal(access(p->mesh, F_OK), -1); /* its sockets are gone all the same */
    assert_null(hear(fd, RELOAD));
    close(file);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(one_more_comes_after_the_first, make_place, remove_place),
        cmocka_unit_test_setup_teardown(those_who_are_answered_ask_for_the_next, make_place,
                                        remove_place),
        cmocka_unit_test_setup_teardown(the_end_does_not_wait_for_the_file, make_place,
                                        remove_place),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
