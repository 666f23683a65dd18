/* dexel replay: pauses, steps and moves the replay of a recording, and tells where it is. */
#include "tools/args.h"
#include "tools/cmd.h"
#include "tools/stream_request.h"

#include <stdio.h>
#include <string.h>

static const char command[] = "dexel replay";

static const char help[] = "usage: dexel replay pause|resume|status [OPTIONS]\n"
                           "       dexel replay seek SECONDS\n"
                           "       dexel replay rate real|max|N\n"
                           "       dexel replay step [FRAMES]\n"
                           "Moves the replay of a recording in a running dexeld: stops it and lets "
                           "it go on, goes to a time\n"
                           "from its start, changes its speed, or plays so many frames (1) and "
                           "pauses.\n\n" DX_STREAM_REQUEST_HELP;

static int take_seek(json_t *request, const char *text)
{
    const struct dx_arg arg = {command, "seek", text};
    double seconds;
    int rc = dx_arg_double(&seconds, &arg, 0, 1e9, "seconds");

    return rc ? rc : json_object_set_new(request, "seconds", json_real(seconds));
}

static int take_rate(json_t *request, const char *text)
{
    const struct dx_arg arg = {command, "rate", text};
    double rate;
    int rc;

    if (!strcmp(text, "real") || !strcmp(text, "max"))
        return json_object_set_new(request, "rate", json_string(text));
    rc = dx_arg_double(&rate, &arg, 0.001, 1000, "real, max or a number");
    return rc ? rc : json_object_set_new(request, "rate", json_real(rate));
}

static int take_step(json_t *request, const char *text)
{
    const struct dx_arg arg = {command, "step", text};
    uint64_t n;
    int rc = dx_arg_u64(&n, &arg, 1, 1000000000, "frames");

    return rc ? rc : json_object_set_new(request, "frames", json_integer((json_int_t)n));
}

/* Verbs, and how many values each has. */
static const struct {
    const char *name;
    int min, max;
    int (*take)(json_t *request, const char *text);
} verbs[] = {
    {"pause", 0, 0, NULL},     {"resume", 0, 0, NULL},    {"status", 0, 0, NULL},
    {"seek", 1, 1, take_seek}, {"rate", 1, 1, take_rate}, {"step", 0, 1, take_step},
};

static int take(json_t *request, int n, char **words)
{
    static const char all[] = "pause, resume, seek SECONDS, rate RATE, step [FRAMES] or status";

    for (size_t k = 0; n > 0 && k < sizeof(verbs) / sizeof(verbs[0]); k++) {
        if (strcmp(words[0], verbs[k].name))
            continue;
        if (n - 1 < verbs[k].min)
            return dx_stream_request_bad(command, NULL, all);
        if (n - 1 > verbs[k].max)
            return dx_stream_request_bad(command, words[verbs[k].max + 1], all);
        if (json_object_set_new(request, "do", json_string(words[0])) != 0)
            return -1;
        return n == 2 ? verbs[k].take(request, words[1]) : 0;
    }
    return dx_stream_request_bad(command, n > 0 ? words[0] : NULL, all);
}

static void show(const json_t *reply)
{
    const json_t *rate = json_object_get(reply, "rate");
    const char *state = json_is_true(json_object_get(reply, "ended"))    ? "ended"
                        : json_is_true(json_object_get(reply, "paused")) ? "paused"
                                                                         : "playing";

    printf("%s at %.3f of %.3f s, %.0f frames, rate ", state,
           json_number_value(json_object_get(reply, "position_s")),
           json_number_value(json_object_get(reply, "length_s")),
           json_number_value(json_object_get(reply, "frames")));
    if (json_is_string(rate))
        puts(json_string_value(rate));
    else
        printf("%g\n", json_number_value(rate));
}

int cmd_replay(int argc, char **argv)
{
    static const struct dx_stream_request r = {
        .command = command, .request = "replay", .help = help, .take = take, .show = show};

    return dx_stream_request_run(&r, argc, argv);
}
