/* A request on the control socket of the server under test, and its answer. */
#ifndef CONTROL_ASK_H
#define CONTROL_ASK_H

#include "tests/unit/server_client.h"

#include <jansson.h>

/* The next line of answer, parsed; a fresh reference. A byte at a time, so that what follows stays
 * where it is. */
static inline json_t *control_hear(int fd)
{
    static char reply[1 << 16];
    size_t len = 0;
    json_t *o;

    do {
        assert_true(len < sizeof(reply));
        assert_int_equal(recv(fd, reply + len, 1, 0), 1);
    } while (reply[len++] != '\n');
    o = json_loadb(reply, len, 0, NULL);
    assert_non_null(o);
    return o;
}

static inline void control_say(int fd, const char *line)
{
    assert_int_equal(send(fd, line, strlen(line), MSG_NOSIGNAL), strlen(line));
}

static inline json_t *control_ask(int fd, const char *line)
{
    control_say(fd, line);
    return control_hear(fd);
}

/* The answer is an error whose text has this in it. */
static inline void control_expect_error(json_t *reply, const char *text)
{
    const char *error = json_string_value(json_object_get(reply, "error"));

    assert_non_null(error);
    if (!strstr(error, text))
        fail_msg("the error is '%s', expected '%s' in it", error, text);
    json_decref(reply);
}

#endif
