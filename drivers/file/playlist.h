/*
 * The recordings that a replay reads, one after the other: which files, what they say about the
 * stream, and their blocks put together again. One owner, one thread.
 */
#ifndef DX_PLAYLIST_H
#define DX_PLAYLIST_H

#include "drivers/driver.h"
#include "drivers/file/mcap_read.h"
#include "drivers/file/recording.h"

struct dx_playlist;

/* Does the path (file, directory or pattern) name recordings of dexeld, and not clouds of another
 * program? Its first file that can be read decides. */
bool dx_playlist_wants(const char *path);

/* Looks at every file. `tell` may be NULL. Errors: -EBADMSG (no recording, or not all of one
 * stream), -ENOMEM, from open; err names the file. */
int dx_playlist_new(struct dx_playlist **out, const char *path, void (*tell)(const char *text),
                    struct dx_err *err);
void dx_playlist_free(struct dx_playlist *p);

/* The configuration of the stream, YAML; the playlist's. */
const char *dx_playlist_config(const struct dx_playlist *p, size_t *len);
size_t dx_playlist_n_files(const struct dx_playlist *p);
/* Log times of the first and the last message, ns. */
uint64_t dx_playlist_start(const struct dx_playlist *p);
uint64_t dx_playlist_end(const struct dx_playlist *p);

struct dx_playlist_block {
    struct dx_block block; /* the playlist's memory, until the next call */
    uint64_t log_time;
    bool starts_frame;
};

/* 0; DX_DRIVER_E_EOF; negative with err. Damage is passed over, and told when a file ends. */
int dx_playlist_next(struct dx_playlist *p, struct dx_playlist_block *out, struct dx_err *err);

/* Goes to the first frame that begins at log time `time` or later. 0, or negative with err. */
int dx_playlist_seek(struct dx_playlist *p, uint64_t time, struct dx_err *err);

/* The geometry that was in force at log time `time`, a reference of the caller's, in the open file.
 * False: none is known, or it cannot be used, which is told. */
bool dx_playlist_geometry(struct dx_playlist *p, uint64_t time, struct dx_geometry **g,
                          uint8_t *attr_bytes);

#endif
