/*
 * What the table of keys prints: the configuration in force as YAML, and the list of keys of
 * dexeld.yaml(5).
 */
#include "daemon/config_origin.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* Spaces before a key of a stream; the first has a dash among them. */
static unsigned indentation(const struct dx_config_key *key)
{
    unsigned n_dots = 0;

    for (const char *p = key->path; *p; p++)
        n_dots += *p == '.';
    return 2 + 2 * n_dots;
}

/* Ends a line, saying where the value is from; `o` NULL: not. */
static void end_line(FILE *out, const struct dx_config_origins *o, uint32_t place,
                     const struct dx_config_key *key)
{
    if (o) {
        fputs("  # ", out);
        dx_config_origin_print(out, o, place, key);
    }
    putc('\n', out);
}

static void print_stream(FILE *out, const struct dx_stream_config *stream,
                         const struct dx_config_origins *o, uint32_t place)
{
    const struct dx_config_key *key;
    bool first = true;

    for (key = dx_config_keys; key->path; key++) {
        bool map = key->type == DX_CONFIG_MAP || key->type == DX_CONFIG_DRIVER;

        if (!dx_config_key_applies(key, stream->driver))
            continue;
        fprintf(out, "%*s%s:%s", (int)indentation(key), first ? "- " : "", dx_config_key_name(key),
                map ? "" : " ");
        dx_config_value_print(key, stream, out);
        end_line(out, map ? NULL : o, place, key);
        first = false;
    }
}

static void print(FILE *out, const struct dx_config *config, const struct dx_config_origins *o)
{
    const struct dx_config_key *key;

    for (key = dx_config_keys; key->path; key++) {
        if (dx_config_key_in_stream(key) || key->type == DX_CONFIG_STREAMS)
            continue;
        fprintf(out, "%s: ", key->path);
        dx_config_value_print(key, config, out);
        end_line(out, o, 0, key);
    }
    fputs("streams:\n", out);
    for (uint32_t i = 0; i < config->n_streams; i++)
        print_stream(out, &config->streams[i], o, 1 + i);
}

void dx_config_print(FILE *out, const struct dx_config *config)
{
    print(out, config, NULL);
}

void dx_config_print_in_force(FILE *out, const struct dx_config *config, int log_level)
{
    uint32_t *from = dx_config_origin(config->origins, 0, dx_config_key_find("log_level"));
    uint32_t from_config = *from;
    struct dx_config now = *config;

    if (log_level != config->log_level)
        *from = DX_CONFIG_FROM_REQUEST;
    now.log_level = log_level;
    print(out, &now, now.origins);
    *from = from_config;
}

/* What is printed is the stream's own text: an attachment tells how to decode, not how to record.
 */
int dx_config_stream_text(char **text, size_t *len, const struct dx_stream_config *stream)
{
    const struct dx_config_key *record = dx_config_key_find("streams[].record"), *key;
    struct dx_stream_config alone = *stream;
    FILE *out = open_memstream(text, len);
    int r = 0;

    if (!out)
        return -ENOMEM;
    alone.record = (struct dx_record_config){0};
    alone.wait = 0;
    for (key = dx_config_keys; key->path && r == 0; key++)
        if (dx_config_key_inside(key, record))
            r = dx_config_value_preset(key, &alone);
    if (r == 0) {
        fputs("streams:\n", out);
        print_stream(out, &alone, NULL, 0);
    }
    free(alone.record.path);
    if (ferror(out))
        r = -ENOMEM;
    if (fclose(out) != 0 && r == 0)
        r = -ENOMEM;
    if (r) {
        free(*text);
        *text = NULL;
    }
    return r;
}

/* A line of mdoc text; one that starts with a dot would be taken for a macro. */
static void print_help(FILE *out, const char *help)
{
    bool start = true;

    for (; *help; help++) {
        if (start && (*help == '.' || *help == '\''))
            fputs("\\&", out);
        if (*help == '\\')
            fputs("\\e", out);
        else
            putc(*help, out);
        start = *help == '\n';
    }
    putc('\n', out);
}

static void print_allowed(FILE *out, const struct dx_config_key *key)
{
    char allowed[DX_CONFIG_ALLOWED_LEN];

    dx_config_value_allowed(key, allowed);
    fprintf(out, "Value: %s", allowed);
    if (key->preset)
        fprintf(out, "; default %s", *key->preset ? key->preset : "empty");
    else if (key->required)
        fputs("; required", out);
    fputs(".\n", out);
}

void dx_config_print_keys(FILE *out)
{
    const struct dx_config_key *key;

    fputs(".Bl -tag -width Ds\n", out);
    for (key = dx_config_keys; key->path; key++) {
        fprintf(out, ".It Ic %s\n", key->path);
        print_help(out, key->help);
        if (key->type != DX_CONFIG_MAP && key->type != DX_CONFIG_DRIVER)
            print_allowed(out, key);
    }
    fputs(".El\n", out);
}
