/*
 * Inside the configuration: where each value is from, a number for each key of the top and of each
 * stream. Made when a configuration is, constant afterwards but for a reload.
 */
#ifndef DX_CONFIG_ORIGIN_H
#define DX_CONFIG_ORIGIN_H

#include "daemon/config_parse.h"

/* A number is a line of the file, or one of these; 0: the default. */
#define DX_CONFIG_FROM_RECORDING UINT32_MAX       /* as the recording was meshed */
#define DX_CONFIG_FROM_OPTION    (UINT32_MAX - 1) /* the command line */
#define DX_CONFIG_FROM_MANAGER   (UINT32_MAX - 2) /* a socket that was inherited */
#define DX_CONFIG_FROM_REQUEST   (UINT32_MAX - 3) /* set while the service runs */
/* With a line (0: the default): the value is from the start; that line counts from the next on. */
#define DX_CONFIG_NEXT_START 0x40000000u

struct dx_config_origins {
    char *file;
    uint32_t n_places; /* the top, and the streams */
    uint32_t (*from)[DX_CONFIG_MAX_KEYS];
};

/* All defaults. -ENOMEM. */
int dx_config_origins_new(struct dx_config_origins **out, const char *file, uint32_t n_streams);
void dx_config_origins_free(struct dx_config_origins *o); /* NULL is fine */
/* What the parser has noted. */
void dx_config_origins_take(struct dx_config_origins *o, const struct dx_config_marks *marks);

/* The place of a key: `place` is 0 for the top, 1 + the number of a stream. */
uint32_t *dx_config_origin(struct dx_config_origins *o, uint32_t place,
                           const struct dx_config_key *key);

/* "dexeld.yaml:7", "default" ... */
void dx_config_origin_print(FILE *out, const struct dx_config_origins *o, uint32_t place,
                            const struct dx_config_key *key);

#endif
