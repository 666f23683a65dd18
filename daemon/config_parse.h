/*
 * Inside the configuration: the YAML parser and what it hands to the checks that look at several
 * keys at once (config_check.c): where in the file each value was.
 */
#ifndef DX_CONFIG_PARSE_H
#define DX_CONFIG_PARSE_H

#include "daemon/config_table.h"

/* Counted from 1; line 0: the key is not in the file. */
struct dx_config_mark {
    unsigned line, column;
};

struct dx_config_marks {
    struct dx_config_mark of[1 + DX_CONFIG_MAX_STREAMS][DX_CONFIG_MAX_KEYS]; /* [0]: the top */
    struct dx_config_mark stream[1 + DX_CONFIG_MAX_STREAMS];
};

/* Sets "file:line:column: path: text" and returns -EINVAL. */
__attribute__((format(printf, 5, 6))) int dx_config_fail(struct dx_err *err, const char *file,
                                                         struct dx_config_mark mark,
                                                         const char *path, const char *fmt, ...);

/* Fills an initialised configuration, key by key. -EINVAL, -ENOMEM; the caller then frees it. */
int dx_config_parse_yaml(struct dx_config *config, struct dx_config_marks *marks, const char *file,
                         const void *bytes, size_t len, struct dx_err *err);

/* Do the values go with each other? -EINVAL. */
int dx_config_check(const struct dx_config *config, const struct dx_config_marks *marks,
                    const char *file, struct dx_err *err);

#endif
