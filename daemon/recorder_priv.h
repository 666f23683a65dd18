/* What the two files of the recorder share. All but the ring's producer side, the semaphore and the
 * atomics is its thread's. */
#ifndef DX_RECORDER_PRIV_H
#define DX_RECORDER_PRIV_H

#include "daemon/counters.h"
#include "daemon/recorder.h"
#include "drivers/file/recording_write.h"

#include <pthread.h>
#include <semaphore.h>

/* How far the beginning of a file has come. */
enum dx_recorder_opening {
    DX_OPEN_NOT,
    DX_OPEN_CREATED,
    DX_OPEN_BEGUN,
    DX_OPEN_CONFIG,
    DX_OPEN_DONE
};

struct dx_recorder {
    struct dx_recorder_config config;
    char *yaml;
    struct dx_block_ring ring;
    sem_t wake; /* posted for every block, and by whoever changes wanted or stop */
    atomic_bool wanted, stop;
    bool reader_is_back; /* written before stop, read after it */
    atomic_bool told;    /* that blocks are lost: said once until the ring has been empty again */
    _Atomic uint64_t n_dropped; /* the reader's */

    /* the thread's */
    struct dx_mcap_writer *writer;
    enum dx_recorder_opening opening;
    struct dx_mcap_sink sink;
    bool goes_on;            /* the next file begins where the last one ended */
    uint64_t unix_offset_ns; /* of log times to host stamps */
    uint64_t file_start_ns;  /* log time of its first block */
    uint64_t chunk_ns;       /* since when the open chunk is open, host time; 0: it is empty */
    uint64_t synced_ns, synced_len;
    uint32_t sequence;
    struct dx_ring_geometry geometry; /* in force; NULL: none told */
    uint8_t *geometry_bytes;          /* of it */
    uint64_t finished_len;            /* of all files before this one */
    uint64_t lost_before;             /* blocks, when the last outage ended */

    /* written by the thread, read by status */
    _Atomic int error;
    _Atomic uint64_t n_blocks, n_bytes, n_files;
    _Atomic uint64_t n_without_file; /* blocks that waited for one until they were stopped */
    atomic_bool writing;
    pthread_mutex_t path_lock; /* held to copy the path */
    char path[256];
    bool path_is_made; /* else the file of this path cannot be created */
};

static inline bool dx_recorder_is_wanted(struct dx_recorder *r)
{
    return atomic_load_explicit(&r->wanted, memory_order_relaxed);
}

/* Blocks, by whatever cause. */
static inline uint64_t dx_recorder_n_lost(struct dx_recorder *r)
{
    return dx_get(&r->n_dropped) + dx_get(&r->n_without_file);
}

/* Of a host stamp. */
static inline uint64_t dx_recorder_log_time(const struct dx_recorder *r, uint64_t host_ns)
{
    return host_ns + r->unix_offset_ns;
}

/* The end of it, where it is too long; "": there is none. */
void dx_recorder_set_path(struct dx_recorder *r, const char *path);

/*
 * Steps of the thread: 0, or the store's error, and then all is as before and the step is to be
 * done again.
 */
int dx_recorder_declare(struct dx_recorder *r); /* the channel, once */
int dx_recorder_take(struct dx_recorder *r, const struct dx_ring_entry *e);
int dx_recorder_put_gap(struct dx_recorder *r, const struct dx_ring_gap *gap);
int dx_recorder_finish_file(struct dx_recorder *r);

#endif
