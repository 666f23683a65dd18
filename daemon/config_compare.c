/*
 * Configurations beside each other: what differs, what of the one in force stays while the service
 * runs, and a stream's part as a copy of its own. All of it walks the table of keys.
 */
#include "daemon/config_origin.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

static const char *text_of(const struct dx_config_key *key, const void *base)
{
    const char *text;

    memcpy(&text, (const char *)base + key->at, sizeof(text));
    return text ? text : "";
}

bool dx_config_value_same(const struct dx_config_key *key, const void *a, const void *b)
{
    const char *at = a, *bt = b;
    size_t other_len = key->type == DX_CONFIG_SIZE ? sizeof(uint32_t) : sizeof(bool);

    switch (key->type) {
    case DX_CONFIG_MAP:
    case DX_CONFIG_DRIVER:
    case DX_CONFIG_STREAMS:
        return true; /* their keys are compared */
    case DX_CONFIG_NAME:
    case DX_CONFIG_PATH:
        return !strcmp(text_of(key, a), text_of(key, b));
    default:
        return !memcmp(at + key->at, bt + key->at, key->size) &&
               (!key->other || !memcmp(at + key->other, bt + key->other, other_len));
    }
}

bool dx_config_stream_same(const struct dx_stream_config *a, const struct dx_stream_config *b)
{
    const struct dx_config_key *key;

    if (strcmp(a->driver, b->driver))
        return false;
    for (key = dx_config_keys; key->path; key++)
        if (dx_config_key_applies(key, a->driver) && !dx_config_value_same(key, a, b))
            return false;
    return true;
}

static bool is_text(const struct dx_config_key *key)
{
    return key->type == DX_CONFIG_NAME || key->type == DX_CONFIG_PATH;
}

int dx_config_stream_copy(struct dx_stream_config **out, const struct dx_stream_config *from)
{
    struct dx_stream_config *copy = malloc(sizeof(*copy));
    const struct dx_config_key *key;
    int r = 0;

    if (!copy)
        return -ENOMEM;
    *copy = *from;
    for (key = dx_config_keys; key->path; key++) {
        char *text = NULL;

        if (!is_text(key) || !dx_config_key_applies(key, from->driver))
            continue;
        if (r == 0 && !(text = strdup(text_of(key, from))))
            r = -ENOMEM; /* the rest is NULL: none of it is the original's any more */
        memcpy((char *)copy + key->at, &text, sizeof(text));
    }
    if (r) {
        dx_config_stream_free(copy);
        return r;
    }
    *out = copy;
    return 0;
}

void dx_config_stream_free(struct dx_stream_config *stream)
{
    const struct dx_config_key *key;

    if (!stream)
        return;
    for (key = dx_config_keys; key->path; key++)
        if (dx_config_key_applies(key, stream->driver))
            dx_config_value_free(key, stream);
    free(stream);
}

/* Texts change hands with their pointers. */
static void exchange(const struct dx_config_key *key, struct dx_config *a, struct dx_config *b)
{
    unsigned char *at = (unsigned char *)a + key->at, *bt = (unsigned char *)b + key->at;

    for (size_t k = 0; k < key->size; k++) {
        unsigned char byte = at[k];

        at[k] = bt[k];
        bt[k] = byte;
    }
}

unsigned dx_config_keep_fixed(struct dx_config *next, struct dx_config *in_force,
                              const char *differing[DX_CONFIG_MAX_FIXED])
{
    const struct dx_config_key *key;
    unsigned n = 0;

    for (key = dx_config_keys; key->path; key++) {
        uint32_t *from, *from_before;

        if (dx_config_key_in_stream(key) || key->type == DX_CONFIG_STREAMS || key->live)
            continue;
        from = dx_config_origin(next->origins, 0, key);
        from_before = dx_config_origin(in_force->origins, 0, key);
        if (*from_before == DX_CONFIG_FROM_MANAGER) {
            *from = *from_before;
        } else if (!dx_config_value_same(key, next, in_force) && n < DX_CONFIG_MAX_FIXED) {
            differing[n++] = key->path;
            *from |= DX_CONFIG_NEXT_START;
        }
        exchange(key, next, in_force); /* the same one, too: others may hold its text */
    }
    return n;
}
