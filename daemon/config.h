/*
 * The configuration of the service: a YAML file, or the one that `dexeld --replay` means. Read
 * before any thread starts, and again by a reload, which puts the new one in the place of the old.
 * What keys there are is one table (config_table.c): parser, printer and the list in dexeld.yaml(5)
 * walk it.
 */
#ifndef DX_CONFIG_H
#define DX_CONFIG_H

#include "core/base/err.h"
#include "core/grid/terrain.h"
#include "drivers/file/file.h"
#include "drivers/hokuyo/hokuyo.h"
#include "drivers/kinect/kinect.h"
#include "drivers/rig.h"
#include "drivers/synth/synth.h"
#include "drivers/v4l2/v4l2.h"

#include <stdio.h>

#define DX_CONFIG_MAX_STREAMS 64
#define DX_CONFIG_MAX_LEN     (1u << 20) /* bytes of a file */
#define DX_CONFIG_MAX_SOCKET  107        /* bytes of a socket's path: sun_path without its NUL */

/* `record:` of a stream; docs/recorder.md. */
struct dx_record_config {
    char *path; /* pattern (record_files.h); "": nothing is recorded */
    bool start; /* from the first block on; else when asked */
    int compression;
    uint32_t split_mib, split_s; /* 0: not by this */
    uint32_t keep_mib;           /* 0: all */
    uint32_t buffer_mib;
};

struct dx_stream_config {
    char *name;
    const char *driver; /* for dx_driver_find(): "file", "synthetic" ... */
    union {
        struct dx_file_config file;
        struct dx_synth_config synthetic;
        struct dx_v4l2_config v4l2;
        struct dx_hokuyo_config hokuyo;
        struct dx_kinect_config kinect;
    } source;                  /* its address is what the driver's open() takes */
    struct dx_rig_config gpio; /* of devices */
    struct dx_record_config record;
    uint32_t commit_ms;
    struct dx_terrain_params mesh;
    uint32_t wait; /* a replay starts when so many have subscribed */
    bool lossless; /* a replay that skips no frame (file at rate max) */
    unsigned line; /* of the stream in the file, from 1; 0: not from a file */
};

struct dx_config_origins;

struct dx_config {
    char *socket;
    char *control_socket;
    uint32_t threads;                          /* of the pool; 0: one per processor */
    uint32_t max_clients, max_clients_per_uid; /* of a user; 0: no bound of its own */
    uint32_t client_memory_mib;
    uint32_t max_requests; /* a second */
    int log_level;         /* syslog(3) priority */
    char *metrics_file;    /* "": none */
    uint32_t metrics_s;    /* it is written so often */
    uint32_t n_streams;
    struct dx_stream_config *streams;
    struct dx_config_origins *origins; /* where each value is from */
};

/*
 * Reads a file. Errors, with a text that names file, line, column and key: -EINVAL (contents),
 * -ENOMEM, or what open(2) and read(2) give. On error `config` is empty. Strings live until
 * dx_config_fini().
 */
int dx_config_load(struct dx_config *config, const char *path, struct dx_err *err);

/* The same for bytes in memory; `file` is the name for error texts. */
int dx_config_parse(struct dx_config *config, const char *file, const void *bytes, size_t len,
                    struct dx_err *err);
void dx_config_fini(struct dx_config *config);

/* The words of `dexeld --replay PATH [--rate RATE] [--loop] [--wait N] [--start S] [--end S]
 * [--stamps WORD] --socket SOCKET`. */
struct dx_config_replay {
    const char *path, *socket;
    const char *rate, *wait; /* NULL: not given. Default real; 0, at rate max 1 */
    const char *start, *end, *stamps;
    bool loop;
};

/* One stream "replay", lossless at rate max; the control socket is SOCKET.control. Errors: -EINVAL
 * (the text names the option), -ENOMEM. */
int dx_config_for_replay(struct dx_config *config, const struct dx_config_replay *replay,
                         struct dx_err *err);

/* ---- beside each other -------------------------------------------------------------------------
 */

/* Have two streams the same driver and the same values? Lines do not count. */
bool dx_config_stream_same(const struct dx_stream_config *a, const struct dx_stream_config *b);

/* A copy with texts of its own. -ENOMEM. */
int dx_config_stream_copy(struct dx_stream_config **out, const struct dx_stream_config *from);
void dx_config_stream_free(struct dx_stream_config *stream); /* NULL is fine */

/*
 * The keys that hold from a start to the end (sockets, threads): `next` gets the values that are in
 * force, and `in_force` the others, to be freed with it. Returns how many differed; their paths are
 * constant texts.
 */
#define DX_CONFIG_MAX_FIXED 32
unsigned dx_config_keep_fixed(struct dx_config *next, struct dx_config *in_force,
                              const char *differing[DX_CONFIG_MAX_FIXED]);

/* The socket of this key ("socket", "control_socket") was inherited: what is configured does not
 * count, before and after a reload. */
void dx_config_note_inherited(struct dx_config *config, const char *path);

/* ---- printed -----------------------------------------------------------------------------------
 */

/* The configuration in force, as YAML that reads back as the same. */
void dx_config_print(FILE *out, const struct dx_config *config);
/* The same, with a comment behind each value that says where it is from. The log level may have
 * been set to another one since. */
void dx_config_print_in_force(FILE *out, const struct dx_config *config, int log_level);

/* A configuration of this stream alone, as it lies in a recording: without its `record` and `wait`.
 * *text is the caller's to free. -ENOMEM. */
int dx_config_stream_text(char **text, size_t *len, const struct dx_stream_config *stream);

/* Every key with help, range and default, as the mdoc list in dexeld.yaml(5). */
void dx_config_print_keys(FILE *out);

#endif
