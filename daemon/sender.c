/*
 * What a subscriber is told, and in which order: WELCOME; RESET when it had been told something
 * else before; SUBSCRIBED, GEOMETRY; then batches, SNAPSHOT_BEGIN TILE* COMMIT SNAPSHOT_END for the
 * first and TILE* COMMIT for the others, with STREAM_STATE between them. Loop thread.
 */
#include "daemon/server_priv.h"

#include <stdio.h>
#include <string.h>

#include "daemon/clock.h"

static void end(struct dx_subscriber *s, const struct dx_writer *w, enum dx_message type)
{
    bool of_batch =
        type == DX_MSG_SNAPSHOT_BEGIN || type == DX_MSG_SNAPSHOT_END || type == DX_MSG_COMMIT;
    uint32_t stream = type == DX_MSG_WELCOME ? DX_WIRE_NO_STREAM : s->stream->number;

    dx_outbox_end(&s->out, w, type, stream, of_batch ? s->view.batch_epoch : 0, 0);
}

static void put_welcome(struct dx_subscriber *s)
{
    struct dx_msg_welcome m = {.major = DX_WIRE_MAJOR,
                               .minor = s->minor,
                               .encodings = s->encodings,
                               .max_body = DX_WIRE_MAX_BODY,
                               .n_streams = s->server->n_streams,
                               .server = "dexeld " DEXELD_VERSION};
    struct dx_writer w = dx_outbox_begin(&s->out);

    dx_msg_welcome_put(&w, &m);
    end(s, &w, DX_MSG_WELCOME);
    s->tell_welcome = false;
}

static void put_reset(struct dx_subscriber *s)
{
    struct dx_msg_reset m;
    struct dx_writer w = dx_outbox_begin(&s->out);

    memcpy(m.reason, s->reset_reason, sizeof(m.reason));
    dx_msg_reset_put(&w, &m);
    end(s, &w, DX_MSG_RESET);
    s->tell_reset = false;
    s->n_resets++;
}

static void begin_geometry(struct dx_subscriber *s, struct dx_geometry *g)
{
    dx_geometry_unref(s->geometry);
    s->geometry = NULL;
    s->geometry_at = s->geometry_len = 0;
    if (!dx_encoding_has_ranges(s->asked.encoding))
        return;
    s->geometry = dx_geometry_ref(g);
    s->geometry_len = (uint32_t)(g->n_table * sizeof(float));
}

/* NULL, or why this stream cannot be told in the encoding asked for. */
static const char *unfit_encoding(const struct dx_subscriber *s)
{
    const struct dx_geometry *g = s->stream->loop->geometry;

    if (g->exact && dx_encoding_has_ranges(s->asked.encoding))
        return "q16 and delta carry ranges, this stream has exact points; take f32";
    if (s->asked.encoding == DX_ENCODING_Q16 && g->range_bytes != 2)
        return "q16 needs 16-bit ranges, this stream has 32-bit ones; take delta or f32";
    return NULL;
}

static void put_subscribed(struct dx_subscriber *s)
{
    const struct dx_feed_loop *l = s->stream->loop;
    const struct dx_geometry *g = l->geometry;
    const struct dx_terrain_params *p = &l->params;
    struct dx_msg_subscribed m = {
        .encoding = s->asked.encoding,
        .mode = s->asked.mode,
        .attr_bytes = s->asked.want & DX_WANT_ATTR ? l->attr_bytes : 0,
        .model = (uint8_t)g->model,
        .wrap = g->wrap,
        .flip = g->flip,
        .range_bytes = g->range_bytes,
        .height = g->height,
        .width = g->width,
        .tile_rows = (uint16_t)l->tiling.rows,
        .tile_cols = (uint16_t)l->tiling.cols,
        .unit_m = g->unit_m,
        .sigma = {p->sigma[0], p->sigma[1], p->sigma[2]},
        .tilt_deg = p->tilt_deg,
        .noise_k = p->noise_k,
        .cap_m = p->cap_m,
        .diag = (uint8_t)p->diag,
        .paper = p->paper,
        .normals = p->normals && s->asked.want & DX_WANT_NORMALS,
        .smooth = p->smooth,
        .lod = s->asked.lod,
    };
    struct dx_writer w;

    begin_geometry(s, l->geometry);
    m.table_bytes = s->geometry_len;
    memcpy(m.pose, g->pose, sizeof(m.pose));
    snprintf(m.stream, sizeof(m.stream), "%s", s->stream->options.name);
    w = dx_outbox_begin(&s->out);
    dx_msg_subscribed_put(&w, &m);
    end(s, &w, DX_MSG_SUBSCRIBED);
    s->tell_subscribed = false;
}

/* One piece, through `own`: put as little-endian bits whatever the host is. */
static void put_geometry(struct dx_subscriber *s)
{
    uint32_t left = s->geometry_len - s->geometry_at;
    uint32_t len = left < DX_WIRE_GEOMETRY_PIECE ? left : DX_WIRE_GEOMETRY_PIECE;
    const float *from = s->geometry->table + s->geometry_at / sizeof(float);
    struct dx_msg_geometry m = {.offset = s->geometry_at, .total = s->geometry_len};
    struct dx_writer w = dx_outbox_begin(&s->out);
    struct dx_out_message *out;

    for (uint32_t k = 0; k < len / sizeof(float); k++)
        dx_put_u32(s->out.own + k * sizeof(float), dx_f32_bits(from[k]));
    dx_msg_geometry_put(&w, &m); /* offset and total; the bytes follow from `own` */
    out = dx_outbox_end(&s->out, &w, DX_MSG_GEOMETRY, s->stream->number, 0, len);
    out->own = true;
    s->geometry_at += len;
    if (s->geometry_at == s->geometry_len) {
        dx_geometry_unref(s->geometry);
        s->geometry = NULL;
    }
}

static void put_state(struct dx_subscriber *s)
{
    struct dx_msg_stream_state m = {.state = (uint8_t)s->stream->loop->state};
    struct dx_writer w = dx_outbox_begin(&s->out);

    memcpy(m.reason, s->stream->loop->state_reason, sizeof(m.reason));
    dx_msg_stream_state_put(&w, &m);
    end(s, &w, DX_MSG_STREAM_STATE);
    s->tell_state = false;
}

static void put_empty(struct dx_subscriber *s, enum dx_message type)
{
    struct dx_writer w = dx_outbox_begin(&s->out);

    end(s, &w, type);
}

/* The sections that a client asked for. */
static uint8_t wanted_sections(const struct dx_subscriber *s)
{
    unsigned attr = s->asked.want & DX_WANT_ATTR ? DX_CHUNK_ATTR8 | DX_CHUNK_ATTR16 : 0;

    return (uint8_t)(attr | (s->asked.want & DX_WANT_NORMALS ? DX_CHUNK_NORMALS : 0) |
                     DX_CHUNK_SMOOTHED);
}

/*
 * TILE: the chunk as it is, or without the sections that were not asked for; the header of an empty
 * tile when there is no chunk.
 */
static void put_tile(struct dx_subscriber *s, uint32_t number)
{
    const struct dx_view_entry *e = &s->view.entry[number];
    const struct dx_tiling *t = &s->stream->loop->tiling;
    struct dx_chunk_cut cut = {.skip = 0};
    struct dx_writer w = dx_outbox_begin(&s->out);
    struct dx_out_message *out;

    if (e->chunk == DX_FEED_NONE) {
        dx_chunk_put_empty(dx_write_room(&w, DX_CHUNK_HEADER_LEN), dx_form_encoding(s->view.form),
                           e->tile / t->cols, e->tile % t->cols);
    } else {
        const struct dx_feed_chunk *c = &s->out.feed->chunk[e->chunk];
        const uint8_t *body = dx_feed_block(s->out.feed, c->first);

        cut.len = c->len;
        if (body[DX_CHUNK_SECTIONS_AT] & ~wanted_sections(s)) {
            dx_chunk_cut(&cut, body, c->len, wanted_sections(s));
            dx_write_bytes(&w, cut.head, sizeof(cut.head));
        }
    }
    out = dx_outbox_end(&s->out, &w, DX_MSG_TILE, s->stream->number, s->view.batch_epoch, cut.len);
    out->chunk = e->chunk;
    out->skip = cut.skip;
    out->entry = number;
}

static void put_commit(struct dx_subscriber *s)
{
    struct dx_writer w = dx_outbox_begin(&s->out);

    dx_msg_commit_put(&w, &s->view.commit);
    end(s, &w, DX_MSG_COMMIT);
}

/* ---- order
 * --------------------------------------------------------------------------------------- */

/* The next message of the open batch. */
static void put_batch(struct dx_subscriber *s)
{
    switch (s->stage) {
    case DX_BATCH_NONE:
        break;
    case DX_BATCH_BEGIN:
        if (s->view.batch_is_snapshot)
            put_empty(s, DX_MSG_SNAPSHOT_BEGIN);
        s->stage = DX_BATCH_TILES;
        break;
    case DX_BATCH_TILES:
        if (s->next_entry < s->view.n_entries)
            put_tile(s, s->next_entry++);
        else
            s->stage = DX_BATCH_COMMIT;
        break;
    case DX_BATCH_COMMIT:
        put_commit(s);
        s->stage = s->view.batch_is_snapshot ? DX_BATCH_END : DX_BATCH_NONE;
        break;
    case DX_BATCH_END:
        put_empty(s, DX_MSG_SNAPSHOT_END);
        s->stage = DX_BATCH_NONE;
        break;
    }
}

/* `ended` comes after the last epoch; a stream that never had one has nothing to wait for. */
static bool may_tell_state(const struct dx_subscriber *s)
{
    const struct dx_feed_loop *l = s->stream->loop;

    if (s->view.in_batch)
        return false;
    if (l->state != DX_STREAM_ENDED || !l->has_epoch)
        return true;
    return !s->view.snapshot && s->view.done_seq == l->seq;
}

static bool begin_batch(struct dx_subscriber *s, uint64_t now_ns)
{
    if (!dx_subscriber_wants_batch(s, now_ns) || !dx_view_begin(&s->view, now_ns))
        return false;
    s->stage = DX_BATCH_BEGIN;
    s->next_entry = 0;
    s->batch_ns = now_ns;
    if (s->credit)
        s->credit--;
    return true;
}

/* Puts one message or moves one step on; false: nothing is owed now. */
static bool step(struct dx_subscriber *s, uint64_t now_ns)
{
    if (s->tell_welcome) {
        put_welcome(s);
    } else if (s->phase != DX_SUBSCRIBER_STREAMING) {
        return false;
    } else if (s->tell_reset) {
        put_reset(s);
    } else if (s->tell_subscribed && s->stream->loop->geometry) {
        const char *unfit = unfit_encoding(s);

        if (unfit) {
            s->doomed = DX_WIRE_E_ENCODING;
            snprintf(s->doom, sizeof(s->doom), "%s", unfit);
            return false;
        }
        put_subscribed(s);
    } else if (s->geometry) {
        put_geometry(s);
    } else if (s->stage != DX_BATCH_NONE) {
        put_batch(s);
    } else if (s->tell_state && may_tell_state(s)) {
        put_state(s);
    } else {
        return begin_batch(s, now_ns);
    }
    return true;
}

void dx_sender_fill(struct dx_subscriber *s, uint64_t now_ns)
{
    bool used_own = false; /* one piece of GEOMETRY at a time */

    while (!used_own && (dx_outbox_is_empty(&s->out) || dx_outbox_has_room(&s->out)) &&
           step(s, now_ns))
        used_own = s->out.n > s->out.first && s->out.message[s->out.n - 1].own;
    if (!dx_outbox_is_empty(&s->out))
        s->progress_ns = now_ns;
}

/* ---- what has gone, what is lost
 * ----------------------------------------------------------------- */

static void commit_sent(struct dx_subscriber *s)
{
    struct dx_view *v = &s->view;
    uint64_t now = dx_clock_ns();

    if (!v->batch_is_snapshot && v->commit.host_ns && v->commit.host_ns <= now)
        dx_latency_add(&s->stream->latency, now - v->commit.host_ns);
    if (!v->batch_is_snapshot && v->published_ns)
        dx_latency_add(&s->stream->stage[DX_STAGE_SEND], now - v->published_ns);
    if (s->last_seq)
        s->n_coalesced += v->batch_seq - s->last_seq - 1;
    s->last_seq = v->batch_seq;
    s->n_epochs++;
    s->n_revoked_in_row = 0;
    /* what it lacks now was published after this batch was begun */
    s->behind_ns = v->batch_seq < s->stream->loop->seq ? s->batch_ns : 0;
    dx_view_end(v);
}

void dx_sender_sent(void *subscriber, const struct dx_out_message *m)
{
    struct dx_subscriber *s = subscriber;

    if (m->type == DX_MSG_SUBSCRIBED || m->type == DX_MSG_RESET)
        s->was_subscribed = m->type == DX_MSG_SUBSCRIBED;
    if (m->chunk != DX_FEED_NONE) /* else empty, or a copy: the view has let go of it already */
        dx_view_release(&s->view, m->entry);
    if (m->type == DX_MSG_TILE && s->stream)
        dx_count(&s->stream->options.counters->n_tiles_sent, 1);
    if (m->type == DX_MSG_COMMIT && s->view.in_batch)
        commit_sent(s);
}

void dx_sender_begin_anew(struct dx_subscriber *s, const char *reason)
{
    uint16_t begun = dx_outbox_cut(&s->out);
    bool owed = s->tell_reset;

    s->was_subscribed = begun != DX_MSG_RESET && (s->was_subscribed || begun == DX_MSG_SUBSCRIBED);
    s->tell_reset = s->was_subscribed;
    s->tell_subscribed = true;
    s->tell_state = true;
    dx_geometry_unref(s->geometry);
    s->geometry = NULL;
    if (s->view.in_batch && s->asked.mode == DX_MODE_PULL)
        s->credit++; /* its batch did not come */
    s->stage = DX_BATCH_NONE;
    s->last_seq = 0;
    if (!owed && *reason) /* the first one counts; of a new stream's own beginning there is none */
        snprintf(s->reset_reason, sizeof(s->reset_reason), "%s", reason);
}

void dx_sender_dropped(struct dx_view *v, bool slow)
{
    struct dx_subscriber *s =
        (struct dx_subscriber *)((char *)v - offsetof(struct dx_subscriber, view));

    dx_sender_begin_anew(s, slow ? "too slow" : s->stream->loop->reset_reason);
    if (!slow)
        return;
    dx_count(&s->stream->options.counters->n_slow, 1);
    dx_log_client(LOG_INFO, s, "too slow for %s, begins anew", s->stream->options.name);
    if (++s->n_revoked_in_row >= 2) {
        s->doomed = DX_WIRE_E_SLOW;
        snprintf(s->doom, sizeof(s->doom), "too slow: twice in a row no batch was taken whole");
    }
}
