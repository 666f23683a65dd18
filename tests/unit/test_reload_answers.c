/* `dexel reload`: what it makes of the answers of a service, which is a thread here. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "tools/cmd.h"

#include <getopt.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

static char dir[] = "/tmp/dexeld-reload-XXXXXX", path[64];
static int listener;
static char told[256];

static int setup(void **state)
{
    struct sockaddr_un addr = {.sun_family = AF_UNIX};

    (void)state;
    if (!mkdtemp(dir))
        return -1;
    snprintf(path, sizeof(path), "%s/control", dir);
    snprintf(addr.sun_path, sizeof(addr.sun_path), "%s", path);
    listener = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    return listener < 0 || bind(listener, (struct sockaddr *)&addr, sizeof(addr)) < 0 ||
                   listen(listener, 1) < 0
               ? -1
               : 0;
}

static int teardown(void **state)
{
    (void)state;
    close(listener);
    unlink(path);
    return rmdir(dir);
}

/* A connection whose request has been read. */
static int take_request(void)
{
    int fd = accept(listener, NULL, NULL);
    char byte;

    while (recv(fd, &byte, 1, 0) == 1 && byte != '\n')
        ;
    return fd;
}

static void *answer_once(void *line)
{
    int fd = take_request();

    send(fd, line, strlen(line), MSG_NOSIGNAL);
    close(fd);
    return NULL;
}

/* The exit status; what was printed, errors included. */
static int reload(char said[1024], char *line)
{
    char *argv[] = {"reload", "--socket", path, NULL};
    FILE *capture = tmpfile();
    int out = dup(1), err = dup(2), status;
    pthread_t thread;
    size_t len;

    assert_non_null(capture);
    assert_int_equal(pthread_create(&thread, NULL, answer_once, line), 0);
    fflush(stdout);
    assert_int_equal(dup2(fileno(capture), 1), 1);
    assert_int_equal(dup2(fileno(capture), 2), 2);
    optind = 0;
    status = cmd_reload(3, argv);
    fflush(stdout);
    assert_int_equal(dup2(out, 1), 1);
    assert_int_equal(dup2(err, 2), 2);
    pthread_join(thread, NULL);
    close(out);
    close(err);
    rewind(capture);
    len = fread(said, 1, 1023, capture);
    said[len] = '\0';
    fclose(capture);
    return status;
}

static void names_are_shown(void **state)
{
    char said[1024];

    (void)state;
    assert_int_equal(reload(said, "{\"added\":[\"hall\",\"box\"],\"changed\":[],\"removed\":[],"
                                  "\"unchanged\":[\"hill\"],\"restart\":[\"socket\"]}\n"),
                     0);
    assert_string_equal(said, "2 added: hall, box\n0 changed\n0 removed\n1 unchanged: hill\n"
                              "from the next start on: socket\n");
}

static void what_is_no_name_is_refused(void **state)
{
    static char *const lines[] = {
        "{\"added\":[],\"changed\":[\"hall\",1],\"removed\":[],\"unchanged\":[]}\n",
        "{\"added\":[],\"changed\":[null],\"removed\":[],\"unchanged\":[]}\n",
        "{\"added\":[],\"changed\":{\"hall\":1},\"removed\":[],\"unchanged\":[]}\n",
        "{\"added\":[],\"changed\":\"hall\",\"removed\":[],\"unchanged\":[]}\n",
    };
    char said[1024];

    (void)state;
    for (size_t k = 0; k < sizeof(lines) / sizeof(lines[0]); k++) {
        assert_int_equal(reload(said, lines[k]), 1);
        assert_string_equal(said, "dexel reload: the service: found something else in 'changed', "
                                  "expected names\n");
    }
    assert_int_equal(reload(said, "{\"added\":[],\"restart\":[{}]}\n"), 1);
    assert_non_null(strstr(said, "'restart'"));
    assert_null(strstr(said, "added"));
}

/* Answers once a line has come to the other end of standard error. */
static void *answer_late(void *said)
{
    int fd = take_request();
    ssize_t n = read(*(int *)said, told, sizeof(told) - 1);
    static const char answer[] = "{\"error\":\"a.yaml:3: no\"}\n";

    told[n > 0 ? n : 0] = '\0';
    send(fd, answer, strlen(answer), MSG_NOSIGNAL);
    close(fd);
    return NULL;
}

/* Nobody is left to wonder, and the answer is waited for all the same. */
static void a_long_wait_is_told(void **state)
{
    char *argv[] = {"reload", "--socket", path, NULL};
    char answer[256];
    int err = dup(2), ends[2], status;
    pthread_t thread;
    ssize_t n;

    (void)state;
    assert_int_equal(pipe(ends), 0);
    assert_int_equal(pthread_create(&thread, NULL, answer_late, &ends[0]), 0);
    assert_int_equal(dup2(ends[1], 2), 2);
    optind = 0;
    status = cmd_reload(3, argv);
    assert_int_equal(dup2(err, 2), 2);
    pthread_join(thread, NULL);
    close(err);
    close(ends[1]);
    assert_int_equal(status, 1);
    assert_string_equal(told, "dexel reload: the service is still opening sources, and goes "
                              "on by itself\n");
    n = read(ends[0], answer, sizeof(answer) - 1);
    assert_true(n > 0);
    answer[n] = '\0';
    assert_non_null(strstr(answer, path));
    assert_non_null(strstr(answer, ": the service: a.yaml:3: no\n"));
    close(ends[0]);
}

/* Its end is told as that, and not as a socket that speaks another language. */
static void a_service_that_goes_is_told(void **state)
{
    char said[1024];

    (void)state;
    assert_int_equal(reload(said, ""), 1);
    assert_non_null(strstr(said, ": dexeld has gone before it answered\n"));
    assert_int_equal(reload(said, "HTTP/1.1 400\r\n"), 1);
    assert_non_null(
        strstr(said, ": found no JSON line in answer, expected one; this seems to be "));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_are_shown),
        cmocka_unit_test(what_is_no_name_is_refused),
        cmocka_unit_test(a_long_wait_is_told),
        cmocka_unit_test(a_service_that_goes_is_told),
    };

    return cmocka_run_group_tests(tests, setup, teardown);
}
