/*
 * The recorder: its memory, what the reader calls, and the turns of its thread. What a turn writes
 * is in recorder_file.c.
 */
#include "daemon/recorder_priv.h"

#include "daemon/clock.h"
#include "daemon/fault.h"
#include "daemon/log.h"

#include <errno.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SECOND_NS 1000000000u
#define RETRY_NS  250000000u

/* Host stamps to Unix time, fixed for as long as the recorder lives: its log times never jump. */
static uint64_t unix_offset(void)
{
    struct timespec t;

    clock_gettime(CLOCK_REALTIME, &t);
    return (uint64_t)t.tv_sec * SECOND_NS + (uint64_t)t.tv_nsec - dx_clock_ns();
}

static int make(struct dx_recorder *r, struct dx_err *err)
{
    const struct dx_mcap_writer_config writer = {
        .compression = r->config.compression,
        .max_message = DX_RECORDING_HEAD + DX_RECORDING_MAX_SOURCE + DX_RECORDING_PIECE,
        .max_channels = 4,
        .max_defs = 4096,
    };
    int rc = dx_mcap_writer_new(&r->writer, &writer, err);

    if (rc)
        return rc;
    rc = dx_block_ring_init(&r->ring, r->config.ring_len);
    r->yaml = rc ? NULL : malloc(r->config.yaml_len + 1);
    if (rc || !r->yaml)
        return dx_err_set(err, -ENOMEM, "no memory for %zu bytes of blocks", r->config.ring_len);
    memcpy(r->yaml, r->config.yaml, r->config.yaml_len);
    rc = dx_recorder_declare(r);
    return rc ? dx_err_set(err, rc, "the recording's channel: %s", strerror(-rc)) : 0;
}

int dx_recorder_new(struct dx_recorder **out, const struct dx_recorder_config *config,
                    struct dx_err *err)
{
    struct dx_recorder *r = calloc(1, sizeof(*r));
    int rc;

    if (!r)
        return dx_err_set(err, -ENOMEM, "no memory");
    r->config = *config;
    r->config.retry_ns = config->retry_ns ? config->retry_ns : RETRY_NS;
    r->unix_offset_ns = unix_offset();
    sem_init(&r->wake, 0, 0);
    pthread_mutex_init(&r->path_lock, NULL);
    atomic_init(&r->wanted, config->start);
    rc = make(r, err);
    if (rc) {
        dx_recorder_free(r);
        return rc;
    }
    *out = r;
    return 0;
}

void dx_recorder_free(struct dx_recorder *r)
{
    if (!r)
        return;
    dx_block_ring_fini(&r->ring);
    dx_mcap_writer_free(r->writer);
    dx_geometry_unref(r->geometry.geometry);
    free(r->geometry_bytes);
    free(r->yaml);
    pthread_mutex_destroy(&r->path_lock);
    sem_destroy(&r->wake);
    free(r);
}

/* ---- reader ----------------------------------------------------------------------------------
 */

void dx_recorder_feed(struct dx_recorder *r, const struct dx_block *block, bool starts_frame)
{
    if (!dx_recorder_is_wanted(r))
        return;
    if (dx_block_ring_put(&r->ring, block, starts_frame)) {
        sem_post(&r->wake);
        return;
    }
    dx_count(&r->n_dropped, 1);
    if (atomic_exchange_explicit(&r->told, true, memory_order_relaxed))
        return;
    if (block->len > r->config.ring_len)
        dx_log_warning("recorder",
                       "%s: a block of %zu bytes is lost, and all like it: longer than "
                       "buffer_mib",
                       r->config.name, block->len);
    else
        dx_log_warning("recorder", "%s: blocks are lost: the disk takes them too slowly",
                       r->config.name);
}

void dx_recorder_geometry(struct dx_recorder *r, struct dx_geometry *g, uint8_t attr_bytes)
{
    const struct dx_ring_geometry told = {g, attr_bytes, dx_clock_ns()};

    dx_block_ring_put_geometry(&r->ring, &told);
    sem_post(&r->wake);
}

/* ---- thread: turns ---------------------------------------------------------------------------
 */

/* The chunk is closed after a second, also when nothing comes. */
static int close_chunk(struct dx_recorder *r, uint64_t now_ns)
{
    int rc;

    if (r->chunk_ns == 0 || now_ns < r->chunk_ns + SECOND_NS)
        return 0;
    rc = dx_mcap_writer_flush(r->writer);
    if (rc == DX_MCAP_E_FULL)
        return dx_recorder_finish_file(r);
    if (rc == 0)
        r->chunk_ns = 0;
    return rc;
}

static int end_recording(struct dx_recorder *r)
{
    int rc = dx_recorder_finish_file(r);

    if (rc == 0)
        r->goes_on = false;
    return rc;
}

static int sync_file(struct dx_recorder *r, uint64_t now_ns)
{
    uint64_t len = r->opening == DX_OPEN_NOT ? 0 : dx_mcap_writer_progress(r->writer).len;

    atomic_store_explicit(&r->n_bytes, r->finished_len + len, memory_order_relaxed);
    if (len == 0 || len == r->synced_len || now_ns < r->synced_ns + SECOND_NS)
        return 0;
    r->synced_len = len;
    r->synced_ns = now_ns;
    return r->config.store.sync(r->config.store.ctx);
}

static void tell_trouble(struct dx_recorder *r, int rc)
{
    if (atomic_exchange_explicit(&r->error, rc, memory_order_relaxed) != 0)
        return;
    atomic_store_explicit(&r->told, true, memory_order_relaxed);
    dx_log_error("recorder", "%s: %s: %s; it is tried again", r->config.name,
                 r->path[0] ? r->path : "no file", strerror(-rc));
}

/* All that waited is written, or was given up as the recording was stopped. */
static void tell_recovery(struct dx_recorder *r)
{
    uint64_t n = dx_recorder_n_lost(r), lost = n - r->lost_before;
    int error = atomic_exchange_explicit(&r->error, 0, memory_order_relaxed);

    if (!atomic_load_explicit(&r->told, memory_order_relaxed) && !error)
        return;
    if (r->opening != DX_OPEN_NOT)
        dx_log_info("recorder", "%s: recording goes on, %llu blocks were lost", r->config.name,
                    (unsigned long long)lost);
    else if (lost)
        dx_log_warning("recorder", "%s: recording was stopped, %llu blocks were lost",
                       r->config.name, (unsigned long long)lost);
    if (!r->path_is_made) /* there is no such file, and nobody waits for it now */
        dx_recorder_set_path(r, "");
    r->lost_before = n;
    atomic_store_explicit(&r->told, false, memory_order_relaxed);
}

int dx_recorder_turn(struct dx_recorder *r, uint64_t now_ns)
{
    struct dx_ring_entry e;
    int rc = 0;

    while (rc == 0 && dx_block_ring_peek(&r->ring, &e)) {
        dx_heartbeat_beat(r->config.beat, dx_clock_ns());
        dx_fault_point(DX_FAULT_RECORDER);
        rc = dx_recorder_take(r, &e);
        if (rc == 0)
            dx_block_ring_pop(&r->ring);
    }
    if (rc == 0)
        rc = dx_recorder_is_wanted(r) ? close_chunk(r, now_ns) : end_recording(r);
    if (rc == 0)
        rc = sync_file(r, now_ns);
    if (rc == 0) {
        tell_recovery(r);
        return 0;
    }
    if (r->opening != DX_OPEN_NOT)
        (void)dx_mcap_writer_recover(r->writer); /* the file is whole while it waits */
    tell_trouble(r, rc);
    return rc;
}

/* When the thread must look again though nobody posts; 0: never. */
static uint64_t due(const struct dx_recorder *r, int rc)
{
    if (rc)
        return dx_clock_ns() + r->config.retry_ns;
    if (r->chunk_ns)
        return r->chunk_ns + SECOND_NS;
    return r->opening != DX_OPEN_NOT && dx_mcap_writer_progress(r->writer).len != r->synced_len
               ? r->synced_ns + SECOND_NS
               : 0;
}

/* The reader has come back: its gap, if the last blocks were lost, is ours. */
static void wind_up(struct dx_recorder *r)
{
    int rc = dx_recorder_turn(r, dx_clock_ns());

    if (rc == 0 && r->reader_is_back && r->ring.gap.n)
        rc = dx_recorder_put_gap(r, &r->ring.gap);
    if (rc == 0)
        rc = dx_recorder_finish_file(r);
    if (rc == 0)
        return;
    if (r->opening == DX_OPEN_NOT) {
        dx_log_error("recorder", "%s: what waited for a file is lost: %s", r->config.name,
                     strerror(-rc));
        return;
    }
    dx_log_error("recorder", "%s: %s is left without its end: %s", r->config.name, r->path,
                 strerror(-rc));
    (void)dx_mcap_writer_recover(r->writer);
    r->config.store.close(r->config.store.ctx);
}

/* The ring has seconds of room, and a frame is late at once: a post does not interrupt the reader
 * (nor whoever else runs). Where it is refused, it is not so. */
static void give_way(void)
{
    const struct sched_param none = {0};

    (void)sched_setscheduler(0, SCHED_BATCH, &none);
}

void dx_recorder_run(struct dx_recorder *r)
{
    int rc = 0;

    give_way();
    if (dx_recorder_is_wanted(r))
        dx_block_ring_populate(&r->ring);
    while (!atomic_load_explicit(&r->stop, memory_order_acquire)) {
        dx_heartbeat_rest(r->config.beat);
        dx_clock_sem_wait(&r->wake, due(r, rc));
        dx_heartbeat_beat(r->config.beat, dx_clock_ns());
        while (sem_trywait(&r->wake) == 0) /* one turn takes all that was posted for */
            ;
        rc = dx_recorder_turn(r, dx_clock_ns());
    }
    wind_up(r);
    dx_heartbeat_rest(r->config.beat);
}

/* ---- any thread ------------------------------------------------------------------------------
 */

void dx_recorder_stop(struct dx_recorder *r, bool reader_is_back)
{
    r->reader_is_back = reader_is_back;
    atomic_store_explicit(&r->stop, true, memory_order_release);
    sem_post(&r->wake);
}

static void want(struct dx_recorder *r, bool wanted)
{
    atomic_store_explicit(&r->wanted, wanted, memory_order_relaxed);
    sem_post(&r->wake);
}

void dx_recorder_start_file(struct dx_recorder *r)
{
    want(r, true);
}

void dx_recorder_stop_file(struct dx_recorder *r)
{
    want(r, false);
}

void dx_recorder_status(struct dx_recorder *r, struct dx_recorder_status *out)
{
    *out = (struct dx_recorder_status){
        .wanted = dx_recorder_is_wanted(r),
        .writing = atomic_load_explicit(&r->writing, memory_order_relaxed),
        .error = atomic_load_explicit(&r->error, memory_order_relaxed),
        .n_blocks = dx_get(&r->n_blocks),
        .n_dropped = dx_recorder_n_lost(r),
        .n_bytes = dx_get(&r->n_bytes),
        .n_files = dx_get(&r->n_files),
        .waiting = dx_block_ring_used(&r->ring),
    };
    pthread_mutex_lock(&r->path_lock);
    memcpy(out->path, r->path, sizeof(out->path));
    pthread_mutex_unlock(&r->path_lock);
}
