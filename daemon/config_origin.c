/* Where values are from. */
#include "daemon/config_origin.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

int dx_config_origins_new(struct dx_config_origins **out, const char *file, uint32_t n_streams)
{
    struct dx_config_origins *o = calloc(1, sizeof(*o));

    if (!o)
        return -ENOMEM;
    o->n_places = 1 + n_streams;
    o->file = strdup(file);
    o->from = calloc(o->n_places, sizeof(*o->from));
    if (!o->file || !o->from) {
        dx_config_origins_free(o);
        return -ENOMEM;
    }
    *out = o;
    return 0;
}

void dx_config_origins_free(struct dx_config_origins *o)
{
    if (!o)
        return;
    free(o->from);
    free(o->file);
    free(o);
}

void dx_config_origins_take(struct dx_config_origins *o, const struct dx_config_marks *marks)
{
    for (uint32_t place = 0; place < o->n_places; place++)
        for (uint32_t k = 0; k < DX_CONFIG_MAX_KEYS; k++)
            o->from[place][k] = marks->of[place][k].line;
}

uint32_t *dx_config_origin(struct dx_config_origins *o, uint32_t place,
                           const struct dx_config_key *key)
{
    return &o->from[place][key - dx_config_keys];
}

void dx_config_note_inherited(struct dx_config *config, const char *path)
{
    *dx_config_origin(config->origins, 0, dx_config_key_find(path)) = DX_CONFIG_FROM_MANAGER;
}

/* In a comment: a name of a file may be any bytes. */
static void print_file(FILE *out, const char *name)
{
    for (; *name; name++)
        putc((unsigned char)*name < 0x20 || *name == 0x7f ? '?' : *name, out);
}

static void print_place(FILE *out, const struct dx_config_origins *o, uint32_t line)
{
    if (line == 0) {
        fputs("default", out);
    } else {
        print_file(out, o->file);
        fprintf(out, ":%u", line);
    }
}

void dx_config_origin_print(FILE *out, const struct dx_config_origins *o, uint32_t place,
                            const struct dx_config_key *key)
{
    uint32_t from = o->from[place][key - dx_config_keys];

    if (from == DX_CONFIG_FROM_RECORDING) {
        fputs("the recording", out);
    } else if (from == DX_CONFIG_FROM_OPTION) {
        fputs("the command line", out);
    } else if (from == DX_CONFIG_FROM_REQUEST) {
        fputs("set while the service runs", out);
    } else if (from == DX_CONFIG_FROM_MANAGER) {
        fputs("not in use: the service manager's socket is", out);
    } else if (from & DX_CONFIG_NEXT_START) {
        fputs("as at the start; from the next on: ", out);
        print_place(out, o, from & ~DX_CONFIG_NEXT_START);
    } else {
        print_place(out, o, from);
    }
}
