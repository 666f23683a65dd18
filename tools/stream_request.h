/*
 * `dexel record` and `dexel replay`: one request about one stream to a running dexeld, and its
 * answer as a line for people or as JSON.
 */
#ifndef DX_STREAM_REQUEST_H
#define DX_STREAM_REQUEST_H

#include <jansson.h>

struct dx_stream_request {
    const char *command; /* "dexel record" */
    const char *request; /* "record" */
    const char *help;
    /* Takes the verb and what follows it into the request. 0; -EINVAL having said what is wrong. */
    int (*take)(json_t *request, int n, char **words);
    void (*show)(const json_t *reply); /* to standard output */
};

/* The exit status. */
int dx_stream_request_run(const struct dx_stream_request *r, int argc, char **argv);

/* Says "COMMAND: found 'WORD', expected EXPECTED" and returns -EINVAL; `word` NULL: nothing. */
int dx_stream_request_bad(const char *command, const char *word, const char *expected);

#define DX_STREAM_REQUEST_HELP                                                                     \
    "  --stream NAME  which stream; not needed where there is only one\n"                          \
    "  --socket PATH  control socket, or a mesh socket with one beside it (PATH.control);\n"       \
    "                 default $DEXELD_CONTROL, else /run/dexeld/control.sock\n"                    \
    "  --json         the service's own line\n"

#endif
