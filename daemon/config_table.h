/*
 * Inside the configuration: the table of keys, and what its rows can do: find each other, take a
 * value from text, give it back, say what they allow. Constant; used before threads start.
 */
#ifndef DX_CONFIG_TABLE_H
#define DX_CONFIG_TABLE_H

#include "daemon/config.h"

enum dx_config_type {
    DX_CONFIG_MAP,
    DX_CONFIG_DRIVER,  /* a map that also chooses the driver of its name */
    DX_CONFIG_STREAMS, /* the list of streams */
    DX_CONFIG_BOOL,    /* bool */
    DX_CONFIG_UINT,    /* uint32_t, uint64_t */
    DX_CONFIG_NUMBER,  /* double, or a word */
    DX_CONFIG_NUMBERS, /* double[3]: a number, a list of 1 to 3, or a word; missing ones are 0 */
    DX_CONFIG_CHOICE,  /* a word: int, an enum, uint8_t */
    DX_CONFIG_SIZE,    /* COLUMNSxROWS, or a word (both 0): uint32_t width; height is at `other` */
    DX_CONFIG_NAME,    /* char *, letters, digits and ._- */
    DX_CONFIG_PATH,    /* char * */
};

struct dx_config_word {
    const char *text; /* NULL ends the list */
    int value;
};

struct dx_config_key {
    const char *path; /* "streams[].mesh.tilt" */
    enum dx_config_type type;
    uint16_t at, size; /* the field, in dx_stream_config below "streams[].", else in dx_config */
    uint16_t other;  /* SIZE: the height; NUMBERS: a bool, true when numbers were given (0: none) */
    double min, max; /* of numbers, of each side of a size, of the bytes of a text */
    const struct dx_config_word *words;
    const char *(*word)(unsigned value); /* or the words by number, NULL past the last */
    const char *preset;                  /* the default, as it would be written; NULL: none */
    bool required;
    bool three;       /* NUMBERS: of a list all three, no fewer */
    bool live;        /* of the service: a reload applies it; else it holds from the next start */
    const char *help; /* sentences, one a line */
};

#define DX_CONFIG_MAX_KEYS 192
extern const struct dx_config_key
    dx_config_keys[]; /* ends with a NULL path; maps before their keys */

/* The last part of a path: "tilt". */
const char *dx_config_key_name(const struct dx_config_key *key);
bool dx_config_key_in_stream(const struct dx_config_key *key);

/* Is `key` directly inside `map` (NULL: the top)? The keys of a stream are inside "streams". */
bool dx_config_key_inside(const struct dx_config_key *key, const struct dx_config_key *map);

/* Does a stream of this driver have the key? */
bool dx_config_key_applies(const struct dx_config_key *key, const char *driver);

/* The key of a path, or NULL. */
const struct dx_config_key *dx_config_key_find(const char *path);
/* The key called `name` in a map, or NULL. */
const struct dx_config_key *dx_config_key_child(const struct dx_config_key *map, const char *name);
/* The one that `name` was probably meant to be, or NULL. */
const struct dx_config_key *dx_config_key_nearest(const struct dx_config_key *map,
                                                  const char *name);

/* Puts a value into `base` (dx_config or dx_stream_config). -EINVAL when the key does not allow it.
 */
int dx_config_value_set(const struct dx_config_key *key, void *base, const char *text);
/* Item `i` (0-2) of NUMBERS. */
int dx_config_value_set_item(const struct dx_config_key *key, void *base, unsigned i,
                             const char *text);
/* As it would be written in a file. */
void dx_config_value_print(const struct dx_config_key *key, const void *base, FILE *out);
void dx_config_value_free(const struct dx_config_key *key, void *base);
/* Maps and lists are always the same: their keys are values of their own. */
bool dx_config_value_same(const struct dx_config_key *key, const void *a, const void *b);

/* "a number from 0 to 89" */
#define DX_CONFIG_ALLOWED_LEN 200
void dx_config_value_allowed(const struct dx_config_key *key, char text[DX_CONFIG_ALLOWED_LEN]);
/* The same for one item of NUMBERS. */
void dx_config_value_allowed_item(const struct dx_config_key *key,
                                  char text[DX_CONFIG_ALLOWED_LEN]);

/* Gives a field its default where it has one; -ENOMEM. */
int dx_config_value_preset(const struct dx_config_key *key, void *base);

/* Text from outside for an error: cut, control characters replaced, in quotes. */
#define DX_CONFIG_QUOTE_LEN 64
void dx_config_quote(char out[DX_CONFIG_QUOTE_LEN], const char *text);

/* Makes `config` empty with the defaults of the top, and room for `n` streams. -ENOMEM. */
int dx_config_init(struct dx_config *config, uint32_t n);

#endif
