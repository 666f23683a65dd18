/*
 * The recorder of one stream: a thread that writes the raw blocks of its reader to MCAP files
 * (docs/recorder.md). The reader hands them over through a ring of fixed size and never waits:
 * what finds no room is counted, told once in the log, and told in the file as a gap. When the disk
 * fails, the recorder keeps what it has and tries again; nothing but the ring's overflow is lost.
 */
#ifndef DX_RECORDER_H
#define DX_RECORDER_H

#include "daemon/block_ring.h"
#include "daemon/heartbeat.h"
#include "drivers/file/mcap_pack.h"

struct dx_recorder;

/* Where the files come from and go to; called by the recorder's thread alone. */
struct dx_record_store {
    void *ctx;
    /* A new file; its sink is good until close(). `path` (for people) until the next create(). */
    int (*create)(void *ctx, struct dx_mcap_sink *sink, const char **path, uint64_t unix_ns);
    int (*sync)(
        void *ctx); /* what was written is to survive a power cut; also where room is made */
    void (*close)(void *ctx);
};

struct dx_recorder_config {
    const char *name;   /* of the stream, for the log */
    const char *driver; /* the channel's metadata say which one decodes */
    const char *yaml;   /* the stream's configuration; copied */
    size_t yaml_len;
    struct dx_record_store store;
    size_t ring_len;
    enum dx_mcap_compression compression;
    uint64_t split_len, split_ns; /* a file is finished when it is so long; 0: it is not */
    bool start;                   /* record from the first block on */
    uint64_t retry_ns;            /* after an error of the store; 0: 250 ms */
    struct dx_heartbeat *beat;    /* NULL: nobody watches */
};

/* All its memory. Errors: -ENOMEM. */
int dx_recorder_new(struct dx_recorder **out, const struct dx_recorder_config *config,
                    struct dx_err *err);
void dx_recorder_free(struct dx_recorder *r);

/* ---- reader ----------------------------------------------------------------------------------
 */

/* Neither waits. */
void dx_recorder_feed(struct dx_recorder *r, const struct dx_block *block, bool starts_frame);
void dx_recorder_geometry(struct dx_recorder *r, struct dx_geometry *g, uint8_t attr_bytes);

/* ---- its own thread --------------------------------------------------------------------------
 */

/* Returns after dx_recorder_stop, with what was fed before it written and the file finished, unless
 * the store fails. */
void dx_recorder_run(struct dx_recorder *r);

/* One turn of it, for tests: takes what the ring holds, closes chunks that are due at `now_ns` of
 * CLOCK_MONOTONIC. 0, or the store's error: call again later. */
int dx_recorder_turn(struct dx_recorder *r, uint64_t now_ns);

/* ---- any thread ------------------------------------------------------------------------------
 */

/* Once. False: the reader may still feed it, and what it lost last is not told in the file. */
void dx_recorder_stop(struct dx_recorder *r, bool reader_is_back);
void dx_recorder_start_file(struct dx_recorder *r);
void dx_recorder_stop_file(struct dx_recorder *r);

struct dx_recorder_status {
    bool wanted;        /* started */
    bool writing;       /* a file is open */
    int error;          /* of the store, now: negative errno; 0: none */
    uint64_t n_blocks;  /* written, and in the open chunk */
    uint64_t n_dropped; /* blocks that found no room, or no file before they were stopped */
    uint64_t n_bytes;   /* of all files */
    uint64_t n_files;
    size_t waiting; /* bytes in the ring */
    char path[256]; /* of the newest file; its end when it is longer */
};

void dx_recorder_status(struct dx_recorder *r, struct dx_recorder_status *out);

#endif
