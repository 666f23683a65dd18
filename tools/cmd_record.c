/* dexel record: starts and ends the recording of a stream, and tells how it goes. */
#include "tools/cmd.h"
#include "tools/recording_state.h"
#include "tools/stream_request.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

static const char command[] = "dexel record";

static const char help[] =
    "usage: dexel record start|stop|status [--stream NAME] [--socket PATH] [--json]\n"
    "Starts or ends the recording of a stream of a running dexeld, whose configuration says where\n"
    "to (record.path), or tells how it goes.\n\n" DX_STREAM_REQUEST_HELP;

static int take(json_t *request, int n, char **words)
{
    static const char *const verbs[] = {"start", "stop", "status"};

    if (n > 1)
        return dx_stream_request_bad(command, words[1], "one word: start, stop or status");
    for (size_t k = 0; n == 1 && k < sizeof(verbs) / sizeof(verbs[0]); k++)
        if (!strcmp(words[0], verbs[k]))
            return json_object_set_new(request, "do", json_string(verbs[k]));
    return dx_stream_request_bad(command, n > 0 ? words[n - 1] : NULL, "start, stop or status");
}

static double number(const json_t *reply, const char *key)
{
    return json_number_value(json_object_get(reply, key));
}

/* The file, if there is one: that which is tried for has its error. */
static void show_path(const json_t *reply)
{
    const char *path = json_string_value(json_object_get(reply, "path"));
    const char *error = json_string_value(json_object_get(reply, "error_text"));

    if (error)
        printf("; %s%s%s, it is tried again", path ? path : "", path ? ": " : "", error);
    else if (path)
        printf("; newest %s", path);
}

static void show(const json_t *reply)
{
    printf("%s: %.0f blocks in %.0f files, %.1f MB; %.0f blocks lost", dx_recording_state(reply),
           number(reply, "blocks"), number(reply, "files"), number(reply, "bytes") * 1e-6,
           number(reply, "dropped"));
    show_path(reply);
    putchar('\n');
}

int cmd_record(int argc, char **argv)
{
    static const struct dx_stream_request r = {
        .command = command, .request = "record", .help = help, .take = take, .show = show};

    return dx_stream_request_run(&r, argc, argv);
}
