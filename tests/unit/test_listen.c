/* The socket that the service makes: when its address is another's, and what it says then. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "daemon/server_priv.h"

static char folder[32], path[64], lock_path[80];
static int lock_error;     /* of the next flock(2) */
static int listen_error;   /* of listen(2) */
static bool lock_vanishes; /* its owner removes the file before the next one is locked */

int __real_flock(int fd, int operation);
int __wrap_flock(int fd, int operation);
int __real_listen(int fd, int backlog);
int __wrap_listen(int fd, int backlog);

int __wrap_listen(int fd, int backlog)
{
    errno = listen_error;
    return listen_error ? -1 : __real_listen(fd, backlog);
}

int __wrap_flock(int fd, int operation)
{
    errno = lock_error;
    if (lock_error)
        return -1;
    if (lock_vanishes)
        assert_int_equal(unlink(lock_path), 0);
    lock_vanishes = false;
    return __real_flock(fd, operation);
}

static int setup(void **state)
{
    (void)state;
    strcpy(folder, "/tmp/dexeld-listen-XXXXXX");
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof(path), "%s/mesh", folder);
    snprintf(lock_path, sizeof(lock_path), "%s.lock", path);
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    lock_error = listen_error = 0;
    unlink(path);
    return rmdir(folder); /* fails when a lock is left */
}

/* Refused so, with that text; nothing is left open. */
static void expect_refused(const char *at, int error, const char *text)
{
    struct dx_listener l = {.fd = -1, .lock_fd = -1};
    struct dx_err err = {""};

    assert_int_equal(dx_listener_open(&l, at, "none", &err), error);
    assert_non_null(strstr(err.text, text));
    dx_listener_close(&l);
}

static void somebody_else_answers(void **state)
{
    struct sockaddr_un at = {.sun_family = AF_UNIX};
    int fd = socket(AF_UNIX, SOCK_STREAM, 0), client = socket(AF_UNIX, SOCK_STREAM, 0);
    char text[128];

    (void)state;
    strcpy(at.sun_path, path);
    assert_int_equal(bind(fd, (struct sockaddr *)&at, sizeof(at)), 0);
    assert_int_equal(listen(fd, 4), 0);
    snprintf(text, sizeof(text), "%s: another service answers here", path);
    expect_refused(path, -EADDRINUSE, text);
    assert_int_equal(connect(client, (struct sockaddr *)&at, sizeof(at)), 0); /* and goes on */
    close(client);
    close(fd);
}

static void too_long_a_path(void **state)
{
    char longer[200];

    (void)state;
    memset(longer, 'x', sizeof(longer) - 1);
    longer[sizeof(longer) - 1] = '\0';
    expect_refused(longer, -ENAMETOOLONG, "a socket path has at most 107 bytes");
}

static void one_service_at_a_socket(void **state)
{
    struct dx_listener first = {.fd = -1, .lock_fd = -1};
    struct dx_err err = {""};

    (void)state;
    assert_int_equal(dx_listener_open(&first, path, "none", &err), 0);
    expect_refused(path, -EADDRINUSE, "mesh.lock: another service has this socket");
    assert_int_equal(access(path, F_OK), 0);
    dx_listener_close(&first);
    assert_int_equal(access(path, F_OK), -1);
}

/* As on a file system that has none: there is no other service to look for. */
static void no_lock_is_not_another_service(void **state)
{
    (void)state;
    lock_error = ENOLCK;
    expect_refused(path, -ENOLCK, "mesh.lock: No locks available");
    assert_int_equal(unlink(lock_path), 0);
}

/* What was locked is no longer the file of that name: a third service would lock another one. */
static void a_lock_that_was_removed_is_made_anew(void **state)
{
    struct dx_listener l = {.fd = -1, .lock_fd = -1};
    struct dx_err err = {""};
    struct stat held, named;

    (void)state;
    lock_vanishes = true;
    assert_int_equal(dx_listener_open(&l, path, "none", &err), 0);
    assert_int_equal(fstat(l.lock_fd, &held), 0);
    assert_int_equal(stat(lock_path, &named), 0);
    assert_int_equal(held.st_ino, named.st_ino);
    dx_listener_close(&l);
}

/* Nobody can connect to what is left of it, and the next service would have to find that out. */
static void what_cannot_listen_leaves_nothing(void **state)
{
    (void)state;
    listen_error = ENOBUFS;
    expect_refused(path, -ENOBUFS, "No buffer space available");
    assert_int_equal(access(path, F_OK), -1);
    assert_int_equal(access(lock_path, F_OK), -1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(somebody_else_answers, setup, teardown),
        cmocka_unit_test_setup_teardown(too_long_a_path, setup, teardown),
        cmocka_unit_test_setup_teardown(one_service_at_a_socket, setup, teardown),
        cmocka_unit_test_setup_teardown(no_lock_is_not_another_service, setup, teardown),
        cmocka_unit_test_setup_teardown(what_cannot_listen_leaves_nothing, setup, teardown),
        cmocka_unit_test_setup_teardown(a_lock_that_was_removed_is_made_anew, setup, teardown),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
