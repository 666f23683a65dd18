/* The splitter: whatever pieces the bytes come in, the replies are the same; after damage the next
 * whole reply is found. */
#include "drivers/hokuyo/scip_lines.h"

#include <setjmp.h>
#include <stdarg.h>
#include <string.h>
#include <cmocka.h>

static const char stream[] = "\n\nQT\n00P\n\n"
                             "MD0000108001000\n00P\n\n"
                             "MD0000108001000\n99b\n0N90W\n0CB1Dh00D000>YP]\n\n"
                             "MD0000108001000\n99b\n0N91X\n0CB1Dh00D000>YP]\n\n";
static const char *const replies[] = {
    "QT\n00P\n\n",
    "MD0000108001000\n00P\n\n",
    "MD0000108001000\n99b\n0N90W\n0CB1Dh00D000>YP]\n\n",
    "MD0000108001000\n99b\n0N91X\n0CB1Dh00D000>YP]\n\n",
};
#define N (sizeof(replies) / sizeof(replies[0]))

/* Feeds a piece; checks the replies that become whole. */
static void feed(struct dx_scip_lines *l, const char *bytes, size_t len, size_t *n)
{
    while (len > 0) {
        size_t used = dx_scip_lines_feed(l, (const uint8_t *)bytes, len);

        assert_true(used > 0 && used <= len);
        bytes += used;
        len -= used;
        if (l->done) {
            assert_true(*n < N);
            assert_int_equal(l->len, strlen(replies[*n]));
            assert_memory_equal(l->reply, replies[*n], l->len);
            ++*n;
        }
    }
}

static void split_everywhere(void **state)
{
    size_t len = strlen(stream);

    (void)state;
    for (size_t a = 0; a <= len; a++) {
        struct dx_scip_lines l;
        size_t n = 0;

        assert_int_equal(dx_scip_lines_init(&l, 8), 0);
        feed(&l, stream, a, &n);
        feed(&l, stream + a, len - a, &n);
        assert_int_equal(n, N);
        dx_scip_lines_fini(&l);
    }
    for (size_t step = 1; step < 9; step++) {
        struct dx_scip_lines l;
        size_t n = 0;

        assert_int_equal(dx_scip_lines_init(&l, 0), 0);
        for (size_t at = 0; at < len; at += step)
            feed(&l, stream + at, len - at < step ? len - at : step, &n);
        assert_int_equal(n, N);
        dx_scip_lines_fini(&l);
    }
}

/* The next reply of `text`, or NULL. */
static const char *next(struct dx_scip_lines *l, const char **text)
{
    static char reply[256];

    while (**text) {
        *text += dx_scip_lines_feed(l, (const uint8_t *)*text, strlen(*text));
        if (l->done) {
            assert_true(l->len < sizeof(reply));
            memcpy(reply, l->reply, l->len);
            reply[l->len] = 0;
            return reply;
        }
    }
    return NULL;
}

static void skips_to_the_echo(void **state)
{
    const char *text = "rest of a scan\nmore of it\n\nII\n00P\n\nMD01\n99b\nA\n\nII\n00P\n\n";
    struct dx_scip_lines l;

    (void)state;
    assert_int_equal(dx_scip_lines_init(&l, 0), 0);
    dx_scip_lines_resync(&l, "MD01", 4);
    assert_string_equal(next(&l, &text), "MD01\n99b\nA\n\n");
    assert_int_equal(l.n_skipped, strlen("rest of a scan\nmore of it\n\nII\n00P\n\n"));
    assert_string_equal(next(&l, &text), "II\n00P\n\n"); /* in step again: any reply */
    assert_null(next(&l, &text));
    dx_scip_lines_fini(&l);
}

/* A reply without an end does not fill the memory; the one behind it is whole. */
static void too_long(void **state)
{
    struct dx_scip_lines l;
    static uint8_t line[1000];
    const char *text = "\n\nII\n00P\n\n";
    uint64_t sent = 0;

    (void)state;
    memset(line, '0', sizeof(line));
    line[999] = '\n';
    assert_int_equal(dx_scip_lines_init(&l, 0), 0);
    for (int k = 0; k < 200; k++, sent += sizeof(line)) {
        assert_int_equal(dx_scip_lines_feed(&l, line, sizeof(line)), sizeof(line));
        assert_false(l.done);
        assert_true(l.len <= DX_SCIP_MAX_REPLY);
    }
    assert_true(l.n_skipped > sent / 2);
    assert_string_equal(next(&l, &text), "II\n00P\n\n");
    dx_scip_lines_fini(&l);
}

static void lines_in_turn(void **state)
{
    struct dx_scip_cursor c = {(const uint8_t *)stream + 2, (const uint8_t *)stream + 9};
    const uint8_t *line;
    size_t len;

    (void)state;
    assert_true(dx_scip_next_line(&c, &line, &len));
    assert_int_equal(len, 2);
    assert_memory_equal(line, "QT", 2);
    assert_true(dx_scip_next_line(&c, &line, &len));
    assert_memory_equal(line, "00P", 3);
    assert_false(dx_scip_next_line(&c, &line, &len));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(split_everywhere),
        cmocka_unit_test(skips_to_the_echo),
        cmocka_unit_test(too_long),
        cmocka_unit_test(lines_in_turn),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
