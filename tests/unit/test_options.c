/* The command line of dexeld: what it means, and what is said of a wrong one. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <getopt.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "daemon/options.h"

#define MAX_WORDS 16

static char said[4096]; /* on what was listened to */

/* The words after "dexeld", parted by spaces; what goes to `fd` meanwhile is in `said`. */
static int parse(struct dx_options *o, const char *line, int fd)
{
    static char words[256];
    char *argv[MAX_WORDS + 2] = {"dexeld"}, *rest = words;
    int argc = 1, result, kept = dup(fd);
    FILE *heard = tmpfile();
    size_t len;

    assert_non_null(heard);
    snprintf(words, sizeof(words), "%s", line);
    while (*line && (argv[argc] = strsep(&rest, " ")) != NULL)
        argc++;
    optind = 0; /* getopt begins anew */
    fflush(NULL);
    assert_true(dup2(fileno(heard), fd) >= 0);
    result = dx_options_parse(o, argc, argv);
    fflush(NULL);
    assert_true(dup2(kept, fd) >= 0);
    close(kept);
    rewind(heard);
    len = fread(said, 1, sizeof(said) - 1, heard);
    said[len] = '\0';
    fclose(heard);
    return result;
}

static void wrong_ones_are_refused(void **state)
{
    static const struct {
        const char *line, *text;
    } wrong[] = {
        {"", "found neither or both of -c and --replay, expected one"},
        {"-c a.yaml --replay b.mcap --socket s", "found neither or both of -c and --replay"},
        {"-c a.yaml more", "found 'more', expected options only"},
        {"-c a.yaml --loop", "--stamps and --socket go with --replay"},
        {"-c a.yaml --rate max", "go with --replay"},
        {"-c a.yaml --wait 1", "go with --replay"},
        {"-c a.yaml --start 1", "go with --replay"},
        {"-c a.yaml --end 1", "go with --replay"},
        {"-c a.yaml --stamps new", "go with --replay"},
        {"-c a.yaml --socket s", "go with --replay"},
        {"--replay b.mcap --socket s --check", "--check goes with -c"},
        {"--replay b.mcap", "--replay needs --socket PATH"},
        {"-c a.yaml --ready-fd x", "--ready-fd: found 'x', expected a descriptor's number"},
        {"-c a.yaml --ready-fd -1", "--ready-fd: found '-1'"},
        {"-c a.yaml --ready-fd 1048577", "--ready-fd: found '1048577'"},
        {"-c a.yaml --ready-fd=", "--ready-fd: found ''"},
        {"-c", "requires an argument"},
        {"--unknown", "unrecognized option"},
    };

    (void)state;
    for (size_t k = 0; k < sizeof(wrong) / sizeof(*wrong); k++) {
        struct dx_options o;

        if (parse(&o, wrong[k].line, STDERR_FILENO) != 2 || !strstr(said, wrong[k].text))
            fail_msg("dexeld %s: said '%s', expected '%s'", wrong[k].line, said, wrong[k].text);
    }
}

static void a_service_is_its_file(void **state)
{
    struct dx_options o;

    (void)state;
    assert_int_equal(parse(&o, "-c a.yaml", STDERR_FILENO), DX_OPTIONS_RUN);
    assert_string_equal(said, "");
    assert_string_equal(o.config, "a.yaml");
    assert_false(o.check);
    assert_int_equal(o.ready_fd, -1);
    assert_null(o.replay.path);
    assert_int_equal(parse(&o, "--config b.yaml --check --ready-fd 9", STDERR_FILENO),
                     DX_OPTIONS_RUN);
    assert_string_equal(o.config, "b.yaml");
    assert_true(o.check);
    assert_int_equal(o.ready_fd, 9);
}

static void a_replay_has_its_words(void **state)
{
    struct dx_options o;

    (void)state;
    assert_int_equal(parse(&o,
                           "--replay r.mcap --rate max --loop --wait 2 --start 1.5 --end 9 "
                           "--stamps new --socket s",
                           STDERR_FILENO),
                     DX_OPTIONS_RUN);
    assert_null(o.config);
    assert_string_equal(o.replay.path, "r.mcap");
    assert_string_equal(o.replay.rate, "max");
    assert_true(o.replay.loop);
    assert_string_equal(o.replay.wait, "2");
    assert_string_equal(o.replay.start, "1.5");
    assert_string_equal(o.replay.end, "9");
    assert_string_equal(o.replay.stamps, "new");
    assert_string_equal(o.replay.socket, "s");
}

/* The stretch of a recording ends after it starts. */
static void a_stretch_has_a_length(void **state)
{
    struct dx_config config;
    struct dx_options o;
    struct dx_err err = {""};

    (void)state;
    parse(&o, "--replay r.mcap --socket s --start 3 --end 2", STDERR_FILENO);
    assert_true(dx_options_config(&config, &o, &err) < 0);
    assert_non_null(strstr(err.text, "--end: expected more than --start, or 0"));
}

static void what_it_is_goes_to_standard_output(void **state)
{
    struct dx_options o;

    (void)state;
    assert_int_equal(parse(&o, "--help", STDOUT_FILENO), 0);
    assert_int_equal(strncmp(said, "usage: dexeld -c FILE", 21), 0);
    assert_int_equal(parse(&o, "--version", STDOUT_FILENO), 0);
    assert_string_equal(said, "dexeld " DEXELD_VERSION "\n");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(wrong_ones_are_refused),
        cmocka_unit_test(a_service_is_its_file),
        cmocka_unit_test(a_replay_has_its_words),
        cmocka_unit_test(a_stretch_has_a_length),
        cmocka_unit_test(what_it_is_goes_to_standard_output),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
