/*
 * `dexel record`, `dexel clients` and the like: one request to a running dexeld, about a stream or
 * about the service, and its answer for people or as JSON.
 */
#ifndef DX_STREAM_REQUEST_H
#define DX_STREAM_REQUEST_H

#include <jansson.h>
#include <stdbool.h>

struct dx_stream_request {
    const char *command; /* "dexel record" */
    const char *request; /* "record" */
    const char *help;
    /* Takes the verb and what follows it into the request. 0; -EINVAL having said what is wrong. */
    int (*take)(json_t *request, int n, char **words);
    void (*show)(const json_t *reply); /* to standard output */
    bool of_service;                   /* there is no --stream */
    /* One option more, with a value; NULL: none. Taken as words are. */
    const char *option;
    int (*take_option)(json_t *request, const char *value);
};

/* The exit status. */
int dx_stream_request_run(const struct dx_stream_request *r, int argc, char **argv);

/* Says "COMMAND: found 'WORD', expected EXPECTED" and returns -EINVAL; `word` NULL: nothing. */
int dx_stream_request_bad(const char *command, const char *word, const char *expected);

#define DX_STREAM_REQUEST_HELP                                                                     \
    "  --stream NAME  which stream; not needed where there is only one\n" DX_SERVICE_REQUEST_HELP

#define DX_SERVICE_REQUEST_HELP                                                                    \
    "  --socket PATH  control socket, or a mesh socket with one beside it (PATH.control);\n"       \
    "                 default $DEXELD_CONTROL, else /run/dexeld/control.sock\n"                    \
    "  --json         the service's own line\n"

#endif
