/*
 * The mesher. What is committed and not yet sent is kept as a bitset of tiles for each form, so
 * that a shortage of chunks costs nothing but time: the tiles go out with a later epoch.
 */
#include "daemon/mesher.h"

#include "daemon/clock.h"
#include "daemon/encoder.h"
#include "daemon/fault.h"
#include "daemon/log.h"

#include <errno.h>
#include <semaphore.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

struct dx_mesher {
    struct dx_mesher_config config;
    struct dx_mailbox *mailbox;
    struct dx_feed *feed;
    struct dx_counters *counters;
    struct dx_pool *pool;
    sem_t wake;
    atomic_bool stop;

    struct dx_geometry *geometry;
    struct dx_terrain *terrain; /* NULL until there is a geometry */
    bool have_noise;            /* given, or a whole frame has been seen */
    uint64_t epoch;
    uint64_t commit_ns;          /* when the last commit was made, or a new grid begun */
    struct dx_msg_commit commit; /* what the array holds now */
    struct dx_passage passage;   /* of that, so far */
    bool has_mesh, uncommitted, unsent;
    bool announced; /* subscribers have been told this geometry, and the noise in force */
    const char *why_reset;
    uint64_t step_ns; /* what a step may take: by the size of the grid */

    uint32_t served[DX_N_FORMS];   /* generation that has been sent whole */
    uint64_t *pending[DX_N_FORMS]; /* tiles that changed since they were sent */
    struct dx_encoder *encoder;
    struct dx_lod *lod; /* of the terrain, while somebody wants a level of detail */
    struct dx_lod_level level[DX_LOD_SLOTS];
};

static void free_pending(struct dx_mesher *m)
{
    for (int e = 0; e < DX_N_FORMS; e++) {
        free(m->pending[e]);
        m->pending[e] = NULL;
    }
}

int dx_mesher_new(struct dx_mesher **out, const struct dx_mesher_config *config,
                  struct dx_mailbox *mailbox, struct dx_feed *feed, struct dx_counters *counters,
                  struct dx_pool *pool)
{
    struct dx_mesher *m = calloc(1, sizeof(*m));

    if (!m)
        return -ENOMEM;
    m->config = *config;
    m->mailbox = mailbox;
    m->feed = feed;
    m->counters = counters;
    m->pool = pool;
    sem_init(&m->wake, 0, 0);
    if (dx_encoder_new(&m->encoder, pool) < 0) {
        dx_mesher_free(m);
        return -ENOMEM;
    }
    *out = m;
    return 0;
}

void dx_mesher_free(struct dx_mesher *m)
{
    if (!m)
        return;
    free_pending(m);
    dx_lod_free(m->lod);
    dx_terrain_free(m->terrain);
    dx_geometry_unref(m->geometry);
    dx_encoder_free(m->encoder);
    sem_destroy(&m->wake);
    free(m);
}

void dx_mesher_kick(void *mesher)
{
    struct dx_mesher *m = mesher;

    sem_post(&m->wake);
}

void dx_mesher_stop(struct dx_mesher *m)
{
    atomic_store_explicit(&m->stop, true, memory_order_relaxed); /* ordered by the semaphore */
    dx_mesher_kick(m);
}

/* A step begins. */
static void beat(struct dx_mesher *m)
{
    dx_heartbeat_allow(m->config.beat, dx_clock_ns(), m->step_ns);
}

/* ---- committing ------------------------------------------------------------------------------ */

/* Dexels with a return, for the status. */
static uint64_t count_valid(const struct dx_plane *plane)
{
    size_t n = dx_plane_n_dexels(plane), n_valid = 0;

    if (plane->range_bytes == 2)
        for (size_t k = 0; k < n; k++)
            n_valid += ((const uint16_t *)plane->range)[k] != 0;
    else
        for (size_t k = 0; k < n; k++)
            n_valid += ((const uint32_t *)plane->range)[k] != 0;
    return n_valid;
}

static uint32_t commit_caps(const struct dx_terrain *t)
{
    uint32_t caps = dx_terrain_caps(t);

    return (caps & DX_CAP_FIRST ? DX_COMMIT_CAP_FIRST : 0) |
           (caps & DX_CAP_LAST ? DX_COMMIT_CAP_LAST : 0);
}

static void commit_mesh(struct dx_mesher *m)
{
    uint64_t start = dx_clock_ns(), n_words;
    uint32_t n_tiles, n_changed;
    const uint64_t *changed;

    if (!m->uncommitted)
        return;
    beat(m);
    n_tiles = dx_tiling_n_tiles(dx_terrain_tiling(m->terrain));
    n_changed = dx_terrain_commit(m->terrain, m->pool);
    dx_count(&m->counters->n_tiles_changed, n_changed);
    dx_count(&m->counters->n_tiles_same, n_tiles - n_changed);
    changed = dx_terrain_changed(m->terrain);
    n_words = n_tiles / 64 + 1;
    for (int e = 0; e < DX_N_ENCODINGS; e++)
        for (uint64_t k = 0; k < n_words; k++)
            m->pending[e][k] |= changed[k];
    if (m->lod)
        dx_lod_note(m->lod, changed);
    m->commit.n_dropped = dx_mailbox_n_skipped(m->mailbox);
    m->commit.flags = (m->commit.flags & DX_COMMIT_PARTIAL) | commit_caps(m->terrain);
    m->uncommitted = false;
    m->unsent = true;
    m->has_mesh = true;
    m->commit_ns = dx_clock_ns();
    m->passage.meshed_ns = m->commit_ns;
    dx_count(&m->counters->mesh_ns, m->commit_ns - start);
    dx_set(&m->counters->mesh_ns_last, m->commit_ns - start);
    dx_set(&m->counters->n_valid, count_valid(dx_terrain_published(m->terrain)));
}

/* ---- sending -------------------------------------------------------------------------------- */

static bool is_newly_wanted(const struct dx_mesher *m, const uint32_t wanted[DX_N_FORMS])
{
    for (int e = 0; e < DX_N_FORMS; e++)
        if (wanted[e] != 0 && wanted[e] != m->served[e])
            return true;
    return false;
}

static void drop_lod(struct dx_mesher *m)
{
    dx_lod_free(m->lod);
    m->lod = NULL;
}

/* The levels wanted, as the array is now: all their tiles that are cut otherwise are owed. The
 * first subscriber who wants one makes room for errors, the last one gives it up. Without memory
 * for them nobody gets any, until there is some. */
static void update_lod(struct dx_mesher *m, uint32_t wanted[DX_N_FORMS])
{
    const size_t n_words = dx_tiling_n_tiles(dx_terrain_tiling(m->terrain)) / 64 + 1;
    uint32_t *of_levels = wanted + DX_N_ENCODINGS;
    bool any = false;

    for (unsigned s = 0; s < DX_LOD_SLOTS; s++) {
        m->level[s] = of_levels[s] ? dx_feed_level(m->feed, s) : (struct dx_lod_level){0};
        any |= of_levels[s] != 0;
    }
    if (!any) {
        drop_lod(m);
        return;
    }
    if (!m->lod && dx_lod_new(&m->lod, m->terrain, m->pool) < 0) {
        dx_log_error("mesher", "%s: no memory for levels of detail", m->config.name);
        memset(of_levels, 0, DX_LOD_SLOTS * sizeof(*of_levels));
        return;
    }
    dx_lod_update(m->lod, m->level, m->pool);
    for (unsigned s = 0; s < DX_LOD_SLOTS; s++)
        for (size_t k = 0; k < n_words; k++)
            m->pending[DX_N_ENCODINGS + s][k] |= dx_lod_changed(m->lod, s)[k];
}

/* What each form owes: nothing when nobody wants it, everything when somebody newly does. */
static void update_pending(struct dx_mesher *m, const uint32_t wanted[DX_N_FORMS])
{
    size_t bytes = ((size_t)dx_tiling_n_tiles(dx_terrain_tiling(m->terrain)) / 64 + 1) * 8;

    for (int e = 0; e < DX_N_FORMS; e++)
        if (wanted[e] == 0)
            memset(m->pending[e], 0, bytes);
        else if (wanted[e] != m->served[e])
            memset(m->pending[e], 0xff, bytes);
}

static void epoch_sent(struct dx_mesher *m, const uint32_t wanted[DX_N_FORMS])
{
    size_t bytes = ((size_t)dx_tiling_n_tiles(dx_terrain_tiling(m->terrain)) / 64 + 1) * 8;

    m->epoch++;
    m->unsent = false;
    for (int e = 0; e < DX_N_FORMS; e++) {
        memset(m->pending[e], 0, bytes);
        m->served[e] = wanted[e];
    }
    dx_count(&m->counters->n_epochs, 1);
}

/* Publishes an epoch when there is something to say: a commit that has not been sent, or a form
 * that somebody newly wants. */
static void send_epoch(struct dx_mesher *m)
{
    uint32_t wanted[DX_N_FORMS];
    struct dx_encoder_source source;

    dx_feed_wanted(m->feed, wanted);
    if (!m->has_mesh || (!m->unsent && !is_newly_wanted(m, wanted)))
        return;
    beat(m);
    commit_mesh(m); /* columns may have come since: codes and samples must be of one array */
    update_lod(m, wanted);
    update_pending(m, wanted);
    dx_feed_begin(m->feed, m->epoch + 1, wanted);
    source = (struct dx_encoder_source){.terrain = m->terrain, .lod = m->lod};
    memcpy(source.level, m->level, sizeof(source.level));
    if (!dx_encoder_add(m->encoder, m->feed, &source, m->pending)) {
        dx_feed_abort(m->feed);
        dx_count(&m->counters->n_short_of_chunks, 1);
        m->unsent = true;
        return;
    }
    m->passage.published_ns = dx_clock_ns();
    dx_feed_commit(m->feed, &m->commit, m->unsent ? &m->passage : NULL);
    epoch_sent(m, wanted);
}

/* ---- taking --------------------------------------------------------------------------------- */

static int set_geometry(struct dx_mesher *m, struct dx_geometry *g, uint8_t attr_bytes)
{
    const struct dx_tiling *tiling;
    size_t n_words;
    int r;

    free_pending(m);
    r = dx_terrain_new(&m->terrain, g, &m->config.terrain, attr_bytes);
    if (r < 0)
        return r;
    tiling = dx_terrain_tiling(m->terrain);
    n_words = dx_tiling_n_tiles(tiling) / 64 + 1;
    for (int e = 0; e < DX_N_FORMS; e++) {
        m->pending[e] = calloc(n_words, sizeof(uint64_t));
        if (!m->pending[e]) {
            dx_terrain_free(m->terrain);
            m->terrain = NULL;
            return -ENOMEM;
        }
        m->served[e] = 0;
    }
    m->have_noise = m->config.terrain.sigma_given;
    return 0;
}

/* Why there will be no mesh of this geometry: told to subscribers, and to the log. */
static void refuse(struct dx_mesher *m, const struct dx_geometry *g, const char *why)
{
    dx_log_error("mesher", "%s: a grid of %u rows and %u columns: %s", m->config.name, g->height,
                 g->width, why);
    dx_feed_state(m->feed, DX_STREAM_GONE, why);
}

static void reset(struct dx_mesher *m, const struct dx_mail_item *mail)
{
    const struct dx_geometry *g = mail->geometry;
    struct dx_tiling tiling;

    m->step_ns = (uint64_t)g->height * g->width * DX_HEARTBEAT_DEXEL_NS;
    beat(m);
    dx_tiling_init(&tiling, g->height, g->width, g->wrap);
    drop_lod(m);
    dx_terrain_free(m->terrain);
    m->terrain = NULL;
    if (dx_tiling_n_tiles(&tiling) > m->config.max_tiles)
        refuse(m, g, "more tiles than a stream can have");
    else if (set_geometry(m, mail->geometry, mail->attr_bytes) < 0)
        refuse(m, g, "no mesh: too small, or no memory");
    m->announced = false;
    m->has_mesh = m->uncommitted = m->unsent = false;
    m->commit_ns = dx_clock_ns(); /* else its first part would be a commit of its own, or not */
    m->why_reset = m->epoch ? "the geometry changed" : "";
    dx_geometry_unref(m->geometry);
    m->geometry = mail->geometry;
}

/* Tells subscribers what the stream is, once the noise is known: the parameters in force are part
 * of it. */
static void announce(struct dx_mesher *m)
{
    dx_feed_reset(m->feed, m->geometry, dx_terrain_params(m->terrain),
                  dx_terrain_published(m->terrain)->attr_bytes, m->why_reset);
    drop_lod(m);                             /* its errors are in sigmas */
    memset(m->served, 0, sizeof(m->served)); /* a reset takes all tiles from everybody */
    m->announced = true;
}

/* The noise, once a frame has told it, is the stream's: for a later geometry too. Subscribers who
 * have been told the floor instead are told anew. */
static void keep_noise(struct dx_mesher *m)
{
    const struct dx_terrain_params *p = dx_terrain_params(m->terrain);

    if (m->have_noise || !p->sigma_given)
        return;
    m->config.terrain = *p;
    m->have_noise = true;
    if (m->announced)
        m->why_reset = "the noise is known now";
    m->announced = false;
}

/* Publishes runs of columns to the array. */
static void publish_columns(struct dx_mesher *m, const struct dx_plane *plane,
                            const uint64_t *columns)
{
    for (uint32_t j = 0; j < plane->width;) {
        uint32_t end = j;

        while (end < plane->width && (columns[end / 64] >> (end % 64) & 1))
            end++;
        if (end > j)
            dx_terrain_publish(m->terrain, plane, j, end - j, m->pool);
        j = end + 1;
    }
}

static void take_columns(struct dx_mesher *m, const struct dx_mail_item *mail)
{
    const uint64_t now = dx_clock_ns();

    if (!m->terrain)
        return;
    if (!m->have_noise && !mail->complete) /* the estimate wants a whole frame: all its columns */
        return;                            /* are published together, when it is complete */
    if (m->have_noise)
        publish_columns(m, mail->plane, mail->columns);
    else
        dx_terrain_publish(m->terrain, mail->plane, 0, mail->plane->width, m->pool);
    keep_noise(m);
    m->uncommitted = true;
    m->commit = (struct dx_msg_commit){
        .frame = mail->frame,
        .host_ns = mail->stamp.host_ns,
        .device_ns = mail->stamp.device_ns,
        .clock_id = mail->stamp.clock_id,
        .flags = mail->complete ? 0 : DX_COMMIT_PARTIAL,
    };
    m->passage = (struct dx_passage){
        .read_ns = mail->stamp.host_ns, .delivered_ns = mail->delivered_ns, .taken_ns = now};
    dx_count(&m->counters->n_parts, 1);
    if (mail->complete)
        dx_count(&m->counters->n_frames, 1);
    if (!m->announced)
        announce(m);
}

/* One item of mail; false when there is none. */
static bool take_mail(struct dx_mesher *m)
{
    struct dx_mail_item mail;

    beat(m);
    switch (dx_mailbox_take(m->mailbox, &mail)) {
    case DX_MAIL_NONE:
        return false;
    case DX_MAIL_GEOMETRY:
        reset(m, &mail);
        break;
    case DX_MAIL_COLUMNS:
        dx_fault_point(DX_FAULT_MESHER);
        take_columns(m, &mail);
        dx_mailbox_release(m->mailbox);
        if (mail.complete)
            commit_mesh(m);
        break;
    case DX_MAIL_STATE:
        if (mail.state != DX_STREAM_LIVE) { /* that one comes in the middle of a frame */
            if (m->terrain)
                dx_terrain_forget(m->terrain); /* what comes after the interruption is seen anew */
            commit_mesh(m);
            send_epoch(m);
        }
        if (m->terrain || mail.state != DX_STREAM_LIVE) /* nothing is live without a mesh */
            dx_feed_state(m->feed, mail.state, mail.reason);
        break;
    }
    return true;
}

/* A lossless replay takes the next frame when every lossless subscriber has the last epoch. */
static bool may_take(const struct dx_mesher *m)
{
    return !m->config.lossless || (!m->unsent && dx_feed_lossless_epoch(m->feed) >= m->epoch);
}

/* Sleeps until kicked, or until a commit of parts is due. */
static void wait_for_kick(struct dx_mesher *m)
{
    uint64_t due = m->commit_ns + (uint64_t)m->config.commit_ms * 1000000;

    dx_heartbeat_rest(m->config.beat);
    if (m->uncommitted)
        dx_clock_sem_wait(&m->wake, due);
    else
        dx_clock_sem_wait(&m->wake, 0);
    while (sem_trywait(&m->wake) == 0)
        ; /* kicks that came together are one */
    beat(m);
}

void dx_mesher_run(struct dx_mesher *m)
{
    while (!atomic_load_explicit(&m->stop, memory_order_relaxed)) {
        while (may_take(m) && take_mail(m))
            send_epoch(m);
        if (m->uncommitted &&
            dx_clock_ns() >= m->commit_ns + (uint64_t)m->config.commit_ms * 1000000)
            commit_mesh(m);
        send_epoch(m);
        wait_for_kick(m); /* whatever came in the meantime has raised the semaphore */
    }
    dx_heartbeat_rest(m->config.beat);
}
