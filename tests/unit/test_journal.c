/* Lines in the journal: their fields, whom they are about, and that nobody waits for it. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <fcntl.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "daemon/journal.h"
#include "daemon/log.h"

static char dir[32], path[64];
static int journal; /* what the lines come from */

static int bind_journal(void)
{
    struct sockaddr_un addr = {.sun_family = AF_UNIX};
    int fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);

    snprintf(addr.sun_path, sizeof(addr.sun_path), "%s", path);
    return fd >= 0 && bind(fd, (struct sockaddr *)&addr, sizeof(addr)) == 0 ? fd : -1;
}

static int setup(void **state)
{
    (void)state;
    snprintf(dir, sizeof(dir), "/tmp/dx-journal-XXXXXX");
    if (!mkdtemp(dir))
        return -1;
    snprintf(path, sizeof(path), "%s/socket", dir);
    journal = bind_journal();
    dx_log_set_level(LOG_INFO);
    dx_log_to_journal(path);
    return journal < 0 ? -1 : 0;
}

static int teardown(void **state)
{
    (void)state;
    dx_log_to_journal(NULL);
    dx_log_about((struct dx_log_about){0});
    close(journal);
    unlink(path);
    return rmdir(dir);
}

/* The next line, NUL-terminated; "": there is none. */
static const char *received(void)
{
    static char text[4096];
    ssize_t n = recv(journal, text, sizeof(text) - 1, 0);

    text[n > 0 ? n : 0] = '\0';
    return text;
}

static void *begin_beside(void *barrier)
{
    pthread_barrier_wait(barrier);
    for (int k = 0; k < 4; k++) /* fewer than a site may in a second */
        dx_log_info("mesher", "of another thread");
    return NULL;
}

/* The socket is made by whose line is first. For the thread sanitizer, too: of the first test. */
static void test_two_threads_begin(void **state)
{
    pthread_barrier_t barrier;
    pthread_t thread;
    int n = 0;

    (void)state;
    pthread_barrier_init(&barrier, NULL, 2);
    assert_int_equal(pthread_create(&thread, NULL, begin_beside, &barrier), 0);
    pthread_barrier_wait(&barrier);
    for (int k = 0; k < 4; k++)
        dx_log_info("reader", "of this thread");
    pthread_join(thread, NULL);
    pthread_barrier_destroy(&barrier);
    while (*received())
        n++;
    assert_int_equal(n, 8);
}

static void test_fields(void **state)
{
    (void)state;
    dx_log_warning("reader", "%s: found %d\nMESSAGE=forged", "hall", 7);
    assert_string_equal(received(), "SYSLOG_IDENTIFIER=dexeld\nSYSLOG_FACILITY=3\nPRIORITY=4\n"
                                    "SUBSYSTEM=reader\n"
                                    "MESSAGE=reader: hall: found 7 MESSAGE=forged\n");
    dx_log_debug("reader", "not at this level");
    assert_string_equal(received(), "");
}

static void test_about(void **state)
{
    const struct dx_log_about stream = {.stream = "hall"};
    const struct dx_log_about client = {.stream = "hall", .client_pid = 77, .client_uid = 1000};
    struct dx_log_about was;

    (void)state;
    was = dx_log_about(stream);
    assert_null(was.stream);
    dx_log_about_device("A\nFORGED=1");
    dx_log_info("reader", "x");
    assert_non_null(strstr(received(), "\nSTREAM=hall\nDEVICE=A FORGED=1\nMESSAGE=reader: x\n"));
    was = dx_log_about(client);
    assert_string_equal(was.device, "A\nFORGED=1");
    dx_log_info("server", "y");
    assert_non_null(strstr(received(), "\nSTREAM=hall\nCLIENT_PID=77\nCLIENT_UID=1000\nMESSAGE="));
    dx_log_about((struct dx_log_about){0});
    dx_log_info("server", "z");
    assert_null(strstr(received(), "STREAM="));
}

static void *log_other(void *arg)
{
    (void)arg;
    dx_log_info("mesher", "of another thread");
    return NULL;
}

static void test_about_is_a_threads_own(void **state)
{
    pthread_t thread;

    (void)state;
    dx_log_about((struct dx_log_about){.stream = "hall"});
    assert_int_equal(pthread_create(&thread, NULL, log_other, NULL), 0);
    pthread_join(thread, NULL);
    assert_null(strstr(received(), "STREAM="));
}

static void test_a_long_line(void **state)
{
    char text[4000];
    const char *line;

    (void)state;
    memset(text, 'x', sizeof(text));
    text[sizeof(text) - 1] = '\0';
    dx_log_info("room", "%s", text);
    line = received();
    assert_non_null(strstr(line, "\nMESSAGE=room: xxx"));
    assert_int_equal(line[strlen(line) - 1], '\n');
    dx_log_about((struct dx_log_about){.device = text}); /* a field is there whole, or not at all */
    dx_log_info("room", "short");
    line = received();
    assert_null(strstr(line, "DEVICE="));
    assert_non_null(strstr(line, "\nMESSAGE=room: short\n"));
}

/* Nobody reads: lines are dropped, and the sender goes on. The send is one that would wait. */
static void test_a_full_journal_does_not_block(void **state)
{
    static const struct dx_log_about nobody;
    const struct dx_journal_line line = {LOG_INFO, "room", "nobody reads", &nobody};
    int n = 0;

    (void)state;
    for (int k = 0; k < 10000; k++)
        assert_true(dx_journal_send(path, &line));
    while (*received())
        n++;
    assert_in_range(n, 1, 9999);
    assert_true(dx_journal_send(path, &line));
    assert_non_null(strstr(received(), "MESSAGE=nobody reads"));
}

/* A journal that is started anew has another socket at its path; meanwhile standard error is used,
 * with its prefix. */
static void test_a_journal_that_goes(void **state)
{
    int saved = dup(STDERR_FILENO), out[2];
    char text[256];
    ssize_t n;

    (void)state;
    close(journal);
    unlink(path);
    assert_int_equal(pipe2(out, O_NONBLOCK), 0);
    assert_int_equal(dup2(out[1], STDERR_FILENO), STDERR_FILENO);
    dx_log_error("room", "where is it");
    assert_int_equal(dup2(saved, STDERR_FILENO), STDERR_FILENO);
    n = read(out[0], text, sizeof(text) - 1);
    text[n > 0 ? n : 0] = '\0';
    assert_string_equal(text, "<3>dexeld: room: where is it\n");
    close(saved);
    close(out[0]);
    close(out[1]);
    journal = bind_journal();
    assert_true(journal >= 0);
    dx_log_error("room", "there");
    assert_non_null(strstr(received(), "MESSAGE=room: there\n"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_two_threads_begin, setup, teardown),
        cmocka_unit_test_setup_teardown(test_fields, setup, teardown),
        cmocka_unit_test_setup_teardown(test_about, setup, teardown),
        cmocka_unit_test_setup_teardown(test_about_is_a_threads_own, setup, teardown),
        cmocka_unit_test_setup_teardown(test_a_long_line, setup, teardown),
        cmocka_unit_test_setup_teardown(test_a_full_journal_does_not_block, setup, teardown),
        cmocka_unit_test_setup_teardown(test_a_journal_that_goes, setup, teardown),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
