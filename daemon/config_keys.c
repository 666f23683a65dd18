/*
 * How the rows of the configuration table find each other: which keys a map has, and which one a
 * misspelt name was meant to be.
 */
#include "daemon/config_table.h"

#include <string.h>

#define STREAM_PREFIX "streams[]."

const char *dx_config_key_name(const struct dx_config_key *key)
{
    const char *dot = strrchr(key->path, '.');

    return dot ? dot + 1 : key->path;
}

bool dx_config_key_in_stream(const struct dx_config_key *key)
{
    return !strncmp(key->path, STREAM_PREFIX, strlen(STREAM_PREFIX));
}

bool dx_config_key_inside(const struct dx_config_key *key, const struct dx_config_key *map)
{
    const char *name = dx_config_key_name(key);
    size_t parent_len = name == key->path ? 0 : (size_t)(name - key->path) - 1;
    size_t map_len = map ? strlen(map->path) : 0;

    if (!map)
        return parent_len == 0;
    if (strncmp(key->path, map->path, map_len))
        return false;
    return parent_len == map_len + (map->type == DX_CONFIG_STREAMS ? strlen("[]") : 0);
}

bool dx_config_key_applies(const struct dx_config_key *key, const char *driver)
{
    const char *part = key->path + strlen(STREAM_PREFIX);
    const struct dx_config_key *k;

    if (!dx_config_key_in_stream(key))
        return false;
    for (k = dx_config_keys; k->path; k++) {
        size_t len = strlen(dx_config_key_name(k));

        if (k->type == DX_CONFIG_DRIVER && !strncmp(part, dx_config_key_name(k), len) &&
            (part[len] == '.' || !part[len]))
            return !strcmp(dx_config_key_name(k), driver);
    }
    return true;
}

const struct dx_config_key *dx_config_key_find(const char *path)
{
    const struct dx_config_key *key;

    for (key = dx_config_keys; key->path; key++)
        if (!strcmp(key->path, path))
            return key;
    return NULL;
}

const struct dx_config_key *dx_config_key_child(const struct dx_config_key *map, const char *name)
{
    const struct dx_config_key *key;

    for (key = dx_config_keys; key->path; key++)
        if (dx_config_key_inside(key, map) && !strcmp(dx_config_key_name(key), name))
            return key;
    return NULL;
}

#define MAX_NAME 24

static unsigned least(unsigned a, unsigned b)
{
    return a < b ? a : b;
}

/* Edits between two names: one letter put in, taken out, changed, or exchanged with the next
 * (optimal string alignment). Names of MAX_NAME and more are far from all. */
static unsigned distance(const char *a, const char *b)
{
    unsigned d[MAX_NAME][MAX_NAME];
    size_t a_len = strlen(a), b_len = strlen(b);

    if (a_len >= MAX_NAME || b_len >= MAX_NAME)
        return MAX_NAME;
    for (unsigned i = 0; i <= a_len; i++)
        d[i][0] = i;
    for (unsigned j = 0; j <= b_len; j++)
        d[0][j] = j;
    for (size_t i = 1; i <= a_len; i++) {
        for (size_t j = 1; j <= b_len; j++) {
            d[i][j] = d[i - 1][j - 1] + (a[i - 1] != b[j - 1]);
            d[i][j] = least(d[i][j], least(d[i - 1][j], d[i][j - 1]) + 1);
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                d[i][j] = least(d[i][j], d[i - 2][j - 2] + 1);
        }
    }
    return d[a_len][b_len];
}

const struct dx_config_key *dx_config_key_nearest(const struct dx_config_key *map, const char *name)
{
    const struct dx_config_key *key, *nearest = NULL;
    unsigned best = 3;

    for (key = dx_config_keys; key->path; key++) {
        const char *known = dx_config_key_name(key);
        unsigned d;

        if (!dx_config_key_inside(key, map))
            continue;
        d = distance(name, known);
        if (d < best && d < strlen(known)) {
            best = d;
            nearest = key;
        }
    }
    return nearest;
}
