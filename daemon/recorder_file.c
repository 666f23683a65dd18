/*
 * What the recorder writes: files from their beginning to their end, and the entries of the ring
 * into them. A step that fails leaves all as it was before it.
 */
#include "daemon/recorder_priv.h"

#include "daemon/clock.h"
#include "daemon/log.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int dx_recorder_declare(struct dx_recorder *r)
{
    return dx_recording_declare(r->writer, r->config.driver, r->config.name);
}

/* ---- the beginning and the end of a file -----------------------------------------------------
 */

static int attach_geometry(struct dx_recorder *r)
{
    const struct dx_geometry *g = r->geometry.geometry;

    if (!g)
        return 0;
    return dx_recording_attach_geometry(r->writer, dx_recorder_log_time(r, r->geometry.host_ns),
                                        r->geometry_bytes, dx_recording_geometry_len(g));
}

void dx_recorder_set_path(struct dx_recorder *r, const char *path)
{
    const size_t len = strlen(path), most = sizeof(r->path) - 1;

    pthread_mutex_lock(&r->path_lock);
    snprintf(r->path, sizeof(r->path), "%s", len > most ? &path[len - most] : path);
    pthread_mutex_unlock(&r->path_lock);
}

/* The path is kept also when there is no file: it is the one that fails. */
static int create_file(struct dx_recorder *r, uint64_t time)
{
    const char *path = "";
    int rc = r->config.store.create(r->config.store.ctx, &r->sink, &path, time);

    dx_recorder_set_path(r, path);
    r->path_is_made = rc == 0;
    if (rc)
        return rc;
    r->file_start_ns = time;
    r->synced_len = 0;
    dx_count(&r->n_files, 1);
    dx_log_info("recorder", "%s: recording to %s", r->config.name, r->path);
    return 0;
}

/* The next step of a file's beginning. */
static int open_step(struct dx_recorder *r, uint64_t time)
{
    switch (r->opening) {
    case DX_OPEN_NOT:
        return create_file(r, time);
    case DX_OPEN_CREATED:
        return dx_mcap_writer_begin(r->writer, &r->sink);
    case DX_OPEN_BEGUN:
        return dx_recording_attach_config(r->writer, r->file_start_ns, r->yaml, r->config.yaml_len);
    case DX_OPEN_CONFIG:
        return attach_geometry(r);
    case DX_OPEN_DONE:
        break;
    }
    return 0;
}

/* From where the last attempt has left off. */
static int open_file(struct dx_recorder *r, uint64_t time)
{
    while (r->opening != DX_OPEN_DONE) {
        int rc = open_step(r, time);

        if (rc)
            return rc;
        r->opening++;
    }
    r->goes_on = false;
    atomic_store_explicit(&r->writing, true, memory_order_relaxed);
    return 0;
}

int dx_recorder_finish_file(struct dx_recorder *r)
{
    int rc;

    if (r->opening == DX_OPEN_NOT)
        return 0;
    rc = r->opening == DX_OPEN_CREATED ? dx_mcap_writer_begin(r->writer, &r->sink) : 0;
    if (rc == 0)
        rc = dx_mcap_writer_finish(r->writer);
    if (rc)
        return rc;
    (void)r->config.store.sync(r->config.store.ctx); /* it is written; this may come later */
    r->finished_len += dx_mcap_writer_progress(r->writer).len;
    r->config.store.close(r->config.store.ctx);
    r->opening = DX_OPEN_NOT;
    r->chunk_ns = 0;
    atomic_store_explicit(&r->writing, false, memory_order_relaxed);
    return 0;
}

/* ---- entries of the ring ---------------------------------------------------------------------
 */

static bool is_split_due(const struct dx_recorder *r, const struct dx_ring_entry *e)
{
    struct dx_mcap_progress p = dx_mcap_writer_progress(r->writer);
    uint64_t len = p.len + p.open_len, ns = dx_recorder_log_time(r, e->host_ns) - r->file_start_ns;
    bool due = (r->config.split_len && len >= r->config.split_len) ||
               (r->config.split_ns && ns >= r->config.split_ns);
    /* better at a frame's start, but not for ever */
    bool overdue = (r->config.split_len && len >= 2 * r->config.split_len) ||
                   (r->config.split_ns && ns >= 2 * r->config.split_ns);

    return r->opening == DX_OPEN_DONE && e->starts_block && due && (e->starts_frame || overdue);
}

static int put_message(struct dx_recorder *r, const struct dx_ring_entry *e)
{
    uint32_t n_chunks = dx_mcap_writer_progress(r->writer).n_chunks;
    int rc = dx_recording_put_message(r->writer, r->sequence, dx_recorder_log_time(r, e->host_ns),
                                      e->bytes, e->len);

    if (rc)
        return rc;
    r->sequence++;
    if (e->starts_block)
        dx_count(&r->n_blocks, 1);
    if (r->chunk_ns == 0 || dx_mcap_writer_progress(r->writer).n_chunks != n_chunks)
        r->chunk_ns = dx_clock_ns();
    return 0;
}

/* The file is over; the next one follows it without a gap. */
static int end_for_next(struct dx_recorder *r)
{
    int rc = dx_recorder_finish_file(r);

    r->goes_on = rc == 0;
    return rc;
}

static bool is_failing(struct dx_recorder *r)
{
    return atomic_load_explicit(&r->error, memory_order_relaxed) != 0;
}

/* Is there no file, and will there be none for what comes next? One that is to follow another
 * without a gap is given up when it cannot be made and nobody wants it any more. */
static bool has_no_file(struct dx_recorder *r)
{
    if (r->opening != DX_OPEN_NOT)
        return false;
    return !r->goes_on || (!dx_recorder_is_wanted(r) && is_failing(r));
}

/* It goes into no file: the recording was stopped and it had been put just before, or it was
 * started in the middle of a frame. Only where there should have been a file it is lost. */
static void pass_over(struct dx_recorder *r, const struct dx_ring_entry *e)
{
    if (e->starts_block && is_failing(r))
        dx_count(&r->n_without_file, 1);
}

static int take_piece(struct dx_recorder *r, const struct dx_ring_entry *e)
{
    bool begins = e->starts_block && e->starts_frame;
    int rc = 0;

    if (is_split_due(r, e))
        rc = end_for_next(r);
    if (rc == 0 && r->opening != DX_OPEN_DONE) {
        if (has_no_file(r) && !(begins && dx_recorder_is_wanted(r))) {
            pass_over(r, e);
            return 0;
        }
        rc = open_file(r, dx_recorder_log_time(r, e->host_ns));
    }
    if (rc == 0)
        rc = put_message(r, e);
    if (rc == DX_MCAP_E_FULL)
        rc = end_for_next(r);
    return rc == 0 && r->goes_on ? take_piece(r, e) : rc;
}

int dx_recorder_put_gap(struct dx_recorder *r, const struct dx_ring_gap *gap)
{
    const struct dx_recording_gap told = {.n = gap->n,
                                          .first = gap->first,
                                          .start = dx_recorder_log_time(r, gap->from_ns),
                                          .end = dx_recorder_log_time(r, gap->to_ns)};
    int rc;

    if (has_no_file(r))
        return 0; /* nothing before it either: no gap */
    rc = open_file(r, dx_recorder_log_time(r, gap->to_ns));
    if (rc)
        return rc;
    rc = dx_recording_put_gap(r->writer, &told);
    if (rc == DX_MCAP_E_FULL)
        rc = end_for_next(r);
    return rc == 0 && r->goes_on ? dx_recorder_put_gap(r, gap) : rc;
}

/* The taker of the entry gets its reference. */
static int take_geometry(struct dx_recorder *r, const struct dx_ring_geometry *told)
{
    size_t len = dx_recording_geometry_len(told->geometry);
    int rc;

    if (r->geometry.host_ns != told->host_ns) { /* else this is another attempt */
        uint8_t *bytes = malloc(len);

        if (!bytes)
            return -ENOMEM;
        dx_recording_put_geometry(bytes, told->geometry, told->attr_bytes);
        free(r->geometry_bytes);
        dx_geometry_unref(r->geometry.geometry);
        r->geometry = *told;
        r->geometry_bytes = bytes;
    }
    rc = r->opening == DX_OPEN_DONE ? attach_geometry(r) : 0;
    return rc == DX_MCAP_E_FULL ? end_for_next(r) : rc;
}

int dx_recorder_take(struct dx_recorder *r, const struct dx_ring_entry *e)
{
    struct dx_ring_geometry geometry;
    struct dx_ring_gap gap;

    switch (e->kind) {
    case DX_RING_GEOMETRY:
        memcpy(&geometry, e->bytes, sizeof(geometry));
        return take_geometry(r, &geometry);
    case DX_RING_GAP:
        memcpy(&gap, e->bytes, sizeof(gap));
        return dx_recorder_put_gap(r, &gap);
    case DX_RING_PIECE:
        break;
    }
    return take_piece(r, e);
}
