/* The mailbox. All of struct slot is guarded by the lock, save the dexels of its plane (mailbox.h).
 */
#include "daemon/mailbox.h"

#include "daemon/clock.h"

#include <errno.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#define SLOTS 3

struct slot {
    bool used;             /* holds a frame that has not been taken whole */
    bool complete;         /* its last part has been delivered */
    bool taken;            /* the mesher reads it */
    uint64_t frame, order; /* order: slots in the sequence of their frames */
    bool fresh;            /* some column is new */
    uint64_t *columns;
    struct dx_stamp stamp;
    uint64_t delivered_ns;
    struct dx_plane plane;
};

struct dx_mailbox {
    pthread_mutex_t lock;
    pthread_cond_t room; /* a slot became free, or everything was taken */
    bool lossless, closed;
    void (*wake)(void *);
    void *wake_ctx;
    atomic_uint_fast64_t n_skipped;

    struct slot slot[SLOTS];
    struct slot *filling; /* the reader's; NULL between frames */
    uint64_t n_frames;
    uint64_t *taken_columns;
    size_t n_words;

    struct dx_geometry *geometry; /* told, not taken; the slots are empty then */
    uint8_t attr_bytes;
    bool state_waits;
    enum dx_stream_state state;
    uint64_t state_order; /* frames before it */
    char reason[DX_WIRE_TEXT];
};

int dx_mailbox_new(struct dx_mailbox **out, bool lossless, void (*wake)(void *), void *ctx)
{
    struct dx_mailbox *m = calloc(1, sizeof(*m));

    if (!m)
        return -ENOMEM;
    pthread_mutex_init(&m->lock, NULL);
    pthread_cond_init(&m->room, NULL);
    m->lossless = lossless;
    m->wake = wake;
    m->wake_ctx = ctx;
    *out = m;
    return 0;
}

static void free_slots(struct dx_mailbox *m)
{
    for (int k = 0; k < SLOTS; k++) {
        dx_plane_fini(&m->slot[k].plane);
        free(m->slot[k].columns);
        m->slot[k] = (struct slot){0};
    }
    free(m->taken_columns);
    m->taken_columns = NULL;
}

void dx_mailbox_free(struct dx_mailbox *m)
{
    if (!m)
        return;
    free_slots(m);
    dx_geometry_unref(m->geometry);
    pthread_cond_destroy(&m->room);
    pthread_mutex_destroy(&m->lock);
    free(m);
}

void dx_mailbox_close(struct dx_mailbox *m)
{
    pthread_mutex_lock(&m->lock);
    m->closed = true;
    pthread_cond_broadcast(&m->room);
    pthread_mutex_unlock(&m->lock);
}

uint64_t dx_mailbox_n_skipped(struct dx_mailbox *m)
{
    return atomic_load_explicit(&m->n_skipped, memory_order_relaxed); /* a statistic */
}

/* ---- the reader's half ---------------------------------------------------------------------- */

static bool is_empty(const struct dx_mailbox *m)
{
    for (int k = 0; k < SLOTS; k++)
        if (m->slot[k].used || m->slot[k].taken)
            return false;
    return !m->geometry && !m->state_waits;
}

/* A frame that the driver left without a last part ends when the next begins. */
static void finish_filling(struct dx_mailbox *m)
{
    if (!m->filling)
        return;
    m->filling->complete = true;
    if (!m->filling->fresh && !m->filling->taken)
        m->filling->used = false;
    m->filling = NULL;
}

static int allocate_slots(struct dx_mailbox *m, const struct dx_geometry *g, uint8_t attr_bytes)
{
    free_slots(m);
    m->n_words = (g->width + 63) / 64;
    m->taken_columns = calloc(m->n_words, sizeof(uint64_t));
    if (!m->taken_columns)
        return -ENOMEM;
    for (int k = 0; k < SLOTS; k++) {
        int r = dx_plane_init_for(&m->slot[k].plane, g, attr_bytes);

        m->slot[k].columns = calloc(m->n_words, sizeof(uint64_t));
        if (r < 0 || !m->slot[k].columns)
            return r < 0 ? r : -ENOMEM;
    }
    return 0;
}

/* Waits until the mesher has taken everything of the old geometry: it never waits for a client,
 * save in a lossless replay, which may wait here as anywhere. */
static int put_geometry(void *ctx, struct dx_geometry *g, uint8_t attr_bytes)
{
    struct dx_mailbox *m = ctx;
    int r = -ECANCELED;

    pthread_mutex_lock(&m->lock);
    finish_filling(m);
    while (!m->closed && !is_empty(m))
        pthread_cond_wait(&m->room, &m->lock);
    if (!m->closed)
        r = allocate_slots(m, g, attr_bytes);
    if (r == 0) {
        m->geometry = dx_geometry_ref(g);
        m->attr_bytes = attr_bytes;
    }
    pthread_mutex_unlock(&m->lock);
    m->wake(m->wake_ctx);
    return r;
}

/* A slot for a new frame: a free one, else (live) the oldest that waits; NULL: none yet. */
static struct slot *find_slot(struct dx_mailbox *m)
{
    struct slot *oldest = NULL;

    for (int k = 0; k < SLOTS; k++) {
        struct slot *s = &m->slot[k];

        if (!s->used && !s->taken)
            return s;
        if (!s->taken && (!oldest || s->order < oldest->order))
            oldest = s;
    }
    if (m->lossless)
        return NULL;
    if (oldest)
        atomic_fetch_add_explicit(&m->n_skipped, 1, memory_order_relaxed);
    return oldest;
}

static void begin_frame(struct dx_mailbox *m, struct slot *s, uint64_t number)
{
    s->used = true;
    s->complete = s->fresh = false;
    s->frame = number;
    s->order = m->n_frames++;
    memset(s->columns, 0, m->n_words * sizeof(uint64_t));
    m->filling = s;
}

static struct dx_plane *get_plane(void *ctx, uint64_t number)
{
    struct dx_mailbox *m = ctx;
    struct slot *s = NULL;
    bool is_new = false;

    pthread_mutex_lock(&m->lock);
    if (m->filling && m->filling->frame == number) {
        s = m->filling;
    } else {
        finish_filling(m);
        while (!m->closed && !(s = find_slot(m)))
            pthread_cond_wait(&m->room, &m->lock);
        is_new = s != NULL;
        if (is_new)
            begin_frame(m, s, number);
    }
    if (m->closed)
        s = NULL;
    pthread_mutex_unlock(&m->lock);
    if (!s)
        return NULL;
    if (is_new)
        dx_plane_clear(&s->plane); /* ours alone until its first part is delivered */
    return &s->plane;
}

static void deliver(void *ctx, const struct dx_frame_part *part)
{
    struct dx_mailbox *m = ctx;
    uint64_t now = dx_clock_ns();
    struct slot *s;

    pthread_mutex_lock(&m->lock);
    s = m->filling;
    if (s && s->frame == part->frame) {
        for (uint32_t j = part->col0; j < part->col0 + part->n_cols; j++)
            s->columns[j / 64] |= 1ull << (j % 64);
        s->fresh = true;
        s->stamp = part->stamp;
        s->delivered_ns = now;
        if (part->last) {
            s->complete = true;
            m->filling = NULL;
        }
    }
    pthread_mutex_unlock(&m->lock);
    m->wake(m->wake_ctx);
}

struct dx_frame_sink dx_mailbox_sink(struct dx_mailbox *m)
{
    return (struct dx_frame_sink){m, put_geometry, get_plane, deliver};
}

void dx_mailbox_put_state(struct dx_mailbox *m, enum dx_stream_state state, const char *reason)
{
    pthread_mutex_lock(&m->lock);
    if (state == DX_STREAM_ENDED || state == DX_STREAM_GONE || state == DX_STREAM_FAULTED)
        finish_filling(m);
    m->state_waits = true;
    m->state_order = m->n_frames;
    m->state = state;
    strncpy(m->reason, reason, sizeof(m->reason) - 1);
    pthread_mutex_unlock(&m->lock);
    m->wake(m->wake_ctx);
}

/* ---- the mesher's half ---------------------------------------------------------------------- */

/* The oldest slot with something new; live, older ones are dropped once a later frame is complete.
 */
static struct slot *next_slot(struct dx_mailbox *m)
{
    struct slot *first = NULL, *complete = NULL;

    for (int k = 0; k < SLOTS; k++) {
        struct slot *s = &m->slot[k];

        if (!s->used || !s->fresh)
            continue;
        if (!first || s->order < first->order)
            first = s;
        if (s->complete && (!complete || s->order > complete->order))
            complete = s;
    }
    if (m->lossless || !complete)
        return first;
    for (int k = 0; k < SLOTS; k++) {
        struct slot *s = &m->slot[k];

        if (s->used && s->fresh && s->order < complete->order) {
            s->used = s->fresh = false;
            atomic_fetch_add_explicit(&m->n_skipped, 1, memory_order_relaxed);
        }
    }
    return complete;
}

static void take_columns(struct dx_mailbox *m, struct slot *s, struct dx_mail_item *item)
{
    memcpy(m->taken_columns, s->columns, m->n_words * sizeof(uint64_t));
    memset(s->columns, 0, m->n_words * sizeof(uint64_t));
    s->fresh = false;
    s->taken = true;
    item->plane = &s->plane;
    item->columns = m->taken_columns;
    item->frame = s->frame;
    item->complete = s->complete;
    item->stamp = s->stamp;
    item->delivered_ns = s->delivered_ns;
}

/* Has nothing stayed of the frames before it? Those after it may come without end. */
static bool state_is_next(const struct dx_mailbox *m)
{
    for (int k = 0; k < SLOTS; k++)
        if (m->slot[k].used && m->slot[k].fresh && m->slot[k].order < m->state_order)
            return false;
    return m->state_waits;
}

enum dx_mail dx_mailbox_take(struct dx_mailbox *m, struct dx_mail_item *item)
{
    struct slot *s;

    *item = (struct dx_mail_item){.kind = DX_MAIL_NONE};
    pthread_mutex_lock(&m->lock);
    if (m->geometry) {
        item->kind = DX_MAIL_GEOMETRY;
        item->geometry = m->geometry;
        item->attr_bytes = m->attr_bytes;
        m->geometry = NULL;
    } else if (state_is_next(m)) {
        item->kind = DX_MAIL_STATE;
        item->state = m->state;
        memcpy(item->reason, m->reason, sizeof(item->reason));
        m->state_waits = false;
    } else if ((s = next_slot(m)) != NULL) {
        item->kind = DX_MAIL_COLUMNS;
        take_columns(m, s, item);
    }
    if (item->kind != DX_MAIL_NONE && item->kind != DX_MAIL_COLUMNS)
        pthread_cond_broadcast(&m->room);
    pthread_mutex_unlock(&m->lock);
    return item->kind;
}

void dx_mailbox_release(struct dx_mailbox *m)
{
    pthread_mutex_lock(&m->lock);
    for (int k = 0; k < SLOTS; k++) {
        struct slot *s = &m->slot[k];

        if (!s->taken)
            continue;
        s->taken = false;
        if (s->complete && !s->fresh)
            s->used = false;
    }
    pthread_cond_broadcast(&m->room);
    pthread_mutex_unlock(&m->lock);
}
