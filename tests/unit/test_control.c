/* What an operator may ask for on the control socket: clients, devices, log level; and its bounds.
 */
#include "tests/unit/control_ask.h"

#define MAX_CONNECTIONS 16

static json_int_t number_of(const json_t *clients, size_t k)
{
    return json_integer_value(json_object_get(json_array_get(clients, k), "number"));
}

static void test_clients(void **state)
{
    struct fixture *fx = fixture_start(NULL);
    struct client *a = client_start(fx, NULL), *b, *c;
    int fd = client_socket(fx->control, 0);
    json_t *reply, *clients;
    char line[200];

    (void)state;
    client_until_frame(a, 3);
    b = client_start(fx, NULL);
    client_until_frame(b, 3);
    c = client_start(fx, NULL);
    client_until_frame(c, 3);
    reply = control_ask(fd, "{\"request\":\"clients\"}\n");
    clients = json_object_get(reply, "clients");
    assert_int_equal(json_array_size(clients), 3); /* the newest first */
    assert_true(number_of(clients, 1) > 0);
    snprintf(line, sizeof(line),
             "{\"request\":\"clients\",\"do\":\"disconnect\",\"number\":%lld}\n",
             (long long)number_of(clients, 1));
    json_decref(reply);
    reply = control_ask(fd, line);
    assert_int_equal(json_integer_value(json_object_get(reply, "disconnected")), 1);
    json_decref(reply);
    client_until_closed(b);
    assert_int_equal(b->error.code, DX_WIRE_E_DISMISSED);
    assert_string_equal(b->error.text, "disconnected by an operator");
    client_close(b);
    control_expect_error(control_ask(fd, line), "no client of number");
    fixture_frames(fx, 4); /* the others notice nothing */
    client_until_frame(a, 4);
    client_until_frame(c, 4);
    snprintf(line, sizeof(line), "{\"request\":\"clients\",\"do\":\"disconnect\",\"pid\":%d}\n",
             (int)getpid());
    reply = control_ask(fd, line);
    assert_int_equal(json_integer_value(json_object_get(reply, "disconnected")), 2);
    json_decref(reply);
    client_expect_error(a, DX_WIRE_E_DISMISSED);
    client_expect_error(c, DX_WIRE_E_DISMISSED);
    close(fd);
    fixture_stop(fx);
}

static void test_clients_refused(void **state)
{
    struct fixture *fx = fixture_start(NULL);
    int fd = client_socket(fx->control, 0);

    (void)state;
    control_expect_error(control_ask(fd, "{\"request\":\"clients\",\"do\":\"kill\"}\n"),
                         "expected disconnect");
    control_expect_error(control_ask(fd, "{\"request\":\"clients\",\"do\":3}\n"),
                         "expected disconnect");
    control_expect_error(control_ask(fd, "{\"request\":\"clients\",\"do\":\"disconnect\"}\n"),
                         "\"number\" or \"pid\"");
    control_expect_error(
        control_ask(fd, "{\"request\":\"clients\",\"do\":\"disconnect\",\"number\":\"1\"}\n"),
        "\"number\" or \"pid\"");
    close(fd);
    fixture_stop(fx);
}

static void expect_level(int fd, const char *line, const char *level)
{
    json_t *reply = control_ask(fd, line);

    assert_string_equal(json_string_value(json_object_get(reply, "level")), level);
    json_decref(reply);
}

static void test_log_level(void **state)
{
    struct fixture *fx = fixture_start(NULL);
    int fd = client_socket(fx->control, 0);

    (void)state;
    expect_level(fd, "{\"request\":\"log-level\"}\n", "error"); /* the fixture's */
    expect_level(fd, "{\"request\":\"log-level\",\"level\":\"warning\"}\n", "warning");
    assert_int_equal(dx_log_level(), LOG_WARNING);
    control_expect_error(control_ask(fd, "{\"request\":\"log-level\",\"level\":\"loud\"}\n"),
                         "error, warning, notice, info or debug");
    control_expect_error(control_ask(fd, "{\"request\":\"log-level\",\"level\":7}\n"),
                         "error, warning, notice, info or debug");
    expect_level(fd, "{\"request\":\"log-level\"}\n", "warning");
    close(fd);
    fixture_stop(fx);
}

/* The answer comes from another thread; what was asked behind it keeps its place, others their
 * pace, and one who goes meanwhile is no loss. */
static void test_devices(void **state)
{
    struct fixture *fx = fixture_start(NULL);
    int fd = client_socket(fx->control, 0), other = client_socket(fx->control, 0);
    json_t *reply;

    (void)state;
    for (int k = 0; k < 20; k++) {
        int gone = client_socket(fx->control, 0);

        control_say(gone, "{\"request\":\"devices\"}\n");
        close(gone);
        control_say(fd, "{\"request\":\"devices\"}\n{\"request\":\"log-level\"}\n");
        control_say(other, "{\"request\":\"devices\"}\n");
        reply = control_hear(fd);
        assert_true(json_is_array(json_object_get(reply, "devices")));
        assert_true(json_is_array(json_object_get(reply, "errors")));
        json_decref(reply);
        reply = control_hear(fd);
        assert_non_null(json_object_get(reply, "level"));
        json_decref(reply);
        reply = control_hear(other);
        assert_true(json_is_array(json_object_get(reply, "devices")));
        json_decref(reply);
    }
    control_say(fd, "{\"request\":\"devices\"}\n"); /* under way at the end */
    fixture_stop(fx);
    close(other);
    close(fd);
}

static void expect_end(int fd)
{
    char byte;

    assert_true(recv(fd, &byte, 1, 0) <= 0);
    close(fd);
}

static void test_bounds(void **state)
{
    struct fixture *fx = fixture_start(NULL);
    int fd[MAX_CONNECTIONS + 1];
    char line[1100];

    (void)state;
    for (int k = 0; k < MAX_CONNECTIONS; k++) {
        fd[k] = client_socket(fx->control, 0);
        expect_level(fd[k], "{\"request\":\"log-level\"}\n", "error"); /* it was taken in */
    }
    fd[MAX_CONNECTIONS] = client_socket(fx->control, 0);
    control_expect_error(control_hear(fd[0]), "there are 16 at most"); /* the oldest gives way */
    expect_end(fd[0]);
    expect_level(fd[MAX_CONNECTIONS], "{\"request\":\"log-level\"}\n", "error");
    memset(line, ' ', sizeof(line));
    line[1023] = '\0';
    control_say(fd[1], line); /* with what it may have by now it is just as long as may be */
    control_expect_error(control_ask(fd[1], "\n"), "not JSON");
    line[1023] = ' ';
    line[1024] = '\0';
    control_say(fd[1], line);
    control_expect_error(control_hear(fd[1]), "at most 1024 bytes");
    expect_end(fd[1]);
    for (int k = 2; k <= MAX_CONNECTIONS; k++)
        close(fd[k]);
    fixture_stop(fx);
}

/* A client of the mesh protocol is told where it is, at once. */
static void test_a_mesh_client(void **state)
{
    static const uint8_t hello[] = {16, 0, 0, 0, 1, 0, 0, 0, 0xff, 0xff};
    struct fixture *fx = fixture_start(NULL);
    int fd = client_socket(fx->control, 0);

    (void)state;
    assert_int_equal(send(fd, hello, sizeof(hello), MSG_NOSIGNAL), sizeof(hello));
    control_expect_error(control_hear(fd), "this is the control socket");
    expect_end(fd);
    fd = client_socket(fx->control, 0); /* lines before it are answered */
    control_say(fd, " \t\r\n{\"request\":\"log-level\"}\n\x10\n");
    control_expect_error(control_hear(fd), "not JSON");
    json_decref(control_hear(fd));
    control_expect_error(control_hear(fd), "this is the control socket");
    expect_end(fd);
    fixture_stop(fx);
}

static bool is_answered(int fd)
{
    json_t *reply = control_ask(fd, "{\"request\":\"log-level\"}\n");
    bool is = json_object_get(reply, "level") != NULL;

    if (is)
        json_decref(reply);
    else
        control_expect_error(reply, "too many requests: 3 a second (max_requests)");
    return is;
}

/* More than are allowed in a second are refused; the connection stays, and is answered in the next.
 */
static void test_requests_a_second(void **state)
{
    struct fixture *fx =
        fixture_start(&(struct fixture_options){.server = {.limits = {.max_requests = 3}}});
    int fd = client_socket(fx->control, 0), other = client_socket(fx->control, 0);

    (void)state;
    assert_true(is_answered(fd));
    while (is_answered(other)) /* they share the seconds */
        ;
    while (!is_answered(fd))
        ;
    close(other);
    close(fd);
    fixture_stop(fx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_clients),
        cmocka_unit_test(test_clients_refused),
        cmocka_unit_test(test_log_level),
        cmocka_unit_test(test_devices),
        cmocka_unit_test(test_bounds),
        cmocka_unit_test(test_a_mesh_client),
        cmocka_unit_test(test_requests_a_second),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
