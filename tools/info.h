/*
 * `dexel info`: for each kind of file a function that tells about it as one JSON object, which is
 * printed as it is or for people. To add a kind: a file info_NAME.c, listed in cmd_info.c. Every
 * object has
 *   file, format     what it is
 *   sound            nothing is damaged; null: nothing was found, but not all was read
 *   damage           [{offset, bytes, text}], and damaged: how many in all
 * and of scans and of messages what the format has: frames, geometry, width, height, valid;
 * channels with counts, times and gaps.
 */
#ifndef DX_INFO_H
#define DX_INFO_H

#include "core/base/err.h"
#include "drivers/driver.h"

#include <jansson.h>
#include <stdbool.h>
#include <stdint.h>

struct dx_info_options {
    bool quick;      /* the index alone, not all the data */
    uint64_t gap_ns; /* between messages of a channel, what is longer is a gap */
};

struct dx_info_kind {
    /* It is this kind's, by the first bytes of a file (none of a directory or a glob). */
    bool (*probe)(const char *path, const uint8_t *bytes, size_t len);
    /* Fills `out`. Errors: -errno with err; a file that is merely damaged is none. */
    int (*tell)(json_t *out, const char *path, const struct dx_info_options *o, struct dx_err *err);
};

extern const struct dx_info_kind dx_info_mcap, dx_info_folder, dx_info_scan;

/* Of an MCAP file all but its frames; `driver` gets the one that decodes it, NULL where none does.
 * Errors: -errno with err. */
int dx_info_mcap_file(json_t *out, const struct dx_driver **driver, const char *path,
                      const struct dx_info_options *o, struct dx_err *err);

/* "sound", "damaged" and "damage", which is taken; n places, of which `damage` need not list all.
 */
void dx_info_sound(json_t *out, uint64_t n, json_t *damage, const struct dx_info_options *o);

/* An item of "damage". */
json_t *dx_info_damage(uint64_t offset, uint64_t len, const char *text);

/* Decodes every frame: tells frames, geometry, width, height, valid ...; the first 64
 * that cannot be decoded go into the list `damage`, and all are counted unless n_damaged is NULL.
 * Errors: -errno with err. */
int dx_info_frames(json_t *out, json_t *damage, uint64_t *n_damaged, const struct dx_driver *driver,
                   const char *path, struct dx_err *err);

/* The same of recordings and clouds: what cannot be decoded is told as "not_decoded". False: it is
 * a recording of dexeld, and nothing can decode it. `driver` may be NULL. */
bool dx_info_decode(json_t *out, const struct dx_driver *driver, const char *path);

/* The object as indented lines; lists of objects as blocks. */
void dx_info_print(const json_t *object);

#endif
