/* The MCAP writer: its memory, channels, and the taking of messages into the open chunk. */
#include "drivers/file/mcap_write_priv.h"

#include "drivers/file/crc32.h"

#include <errno.h>
#include <stdlib.h>

#define OR(value, otherwise) ((value) ? (value) : (otherwise))

static void set_defaults(struct dx_mcap_writer_config *c)
{
    c->chunk_len = OR(c->chunk_len, (size_t)1 << 20);
    c->chunk_ns = OR(c->chunk_ns, 1000000000);
    c->max_message = OR(c->max_message, (size_t)16 << 20);
    c->max_messages = OR(c->max_messages, 32768);
    c->max_channels = OR(c->max_channels, 256);
    c->max_defs = OR(c->max_defs, (size_t)1 << 20);
    c->index_len = OR(c->index_len, (size_t)4 << 20);
    c->items_len = OR(c->items_len, (size_t)256 << 10);
    c->profile = OR(c->profile, "");
    c->library = OR(c->library, "dexeld " DEXELD_VERSION);
}

static size_t message_len(size_t data_len)
{
    return DX_MCAP_RECORD_HEAD + DX_MCAP_MESSAGE_HEAD + data_len;
}

/* Of the largest chunk: a message on top of one that is nearly full does not happen, but the
 * largest message comes with the definitions it needs. */
static size_t largest_chunk(const struct dx_mcap_writer_config *c)
{
    size_t one = message_len(c->max_message) + c->max_defs;

    return one > c->chunk_len ? one : c->chunk_len;
}

static int check_config(const struct dx_mcap_writer_config *c, struct dx_err *err)
{
    if (c->chunk_len > DX_MCAP_MAX_CHUNK || c->max_message > DX_MCAP_MAX_CHUNK ||
        c->max_defs > DX_MCAP_MAX_DEFS || largest_chunk(c) > DX_MCAP_MAX_CHUNK)
        return dx_err_set(err, -EINVAL, "mcap: chunks of %zu bytes, expected at most %zu",
                          largest_chunk(c), DX_MCAP_MAX_CHUNK);
    if (c->max_channels > 65536 || strlen(c->profile) > DX_MCAP_MAX_NAME ||
        strlen(c->library) > DX_MCAP_MAX_NAME)
        return dx_err_set(err, -EINVAL, "mcap: more than 65536 channels, or names of over %d bytes",
                          DX_MCAP_MAX_NAME);
    return 0;
}

/* The caller's texts need not last. */
static void copy_names(struct dx_mcap_writer *w)
{
    strcpy(w->profile, w->config.profile);
    strcpy(w->library, w->config.library);
    w->config.profile = w->profile;
    w->config.library = w->library;
}

static bool group_init(struct dx_mcap_group *g, size_t cap)
{
    *g = (struct dx_mcap_group){.bytes = malloc(cap), .cap = cap};
    return g->bytes != NULL;
}

static int allocate(struct dx_mcap_writer *w)
{
    const struct dx_mcap_writer_config *c = &w->config;
    int rc;

    dx_mcap_defs_init(&w->defs, c->max_channels, c->max_defs);
    w->chunk_cap = largest_chunk(c);
    rc = dx_mcap_packer_new(&w->packer, c->compression, c->level, w->chunk_cap);
    if (rc)
        return rc;
    w->chunk = malloc(w->chunk_cap);
    w->packed_cap = dx_mcap_packer_bound(w->packer, w->chunk_cap);
    w->packed = c->compression == DX_MCAP_NONE ? NULL : malloc(w->packed_cap);
    w->entries = calloc(c->max_messages, sizeof(*w->entries));
    w->lists = calloc(c->max_channels, sizeof(*w->lists));
    w->schema_in_chunk = calloc(c->max_channels, sizeof(*w->schema_in_chunk));
    return w->chunk && (w->packed || c->compression == DX_MCAP_NONE) && w->entries && w->lists &&
                   w->schema_in_chunk && group_init(&w->chunks, c->index_len) &&
                   group_init(&w->attachments, c->items_len) &&
                   group_init(&w->metadata, c->items_len)
               ? 0
               : -ENOMEM;
}

int dx_mcap_writer_new(struct dx_mcap_writer **out, const struct dx_mcap_writer_config *config,
                       struct dx_err *err)
{
    struct dx_mcap_writer *w = calloc(1, sizeof(*w));
    int rc;

    if (!w)
        return dx_err_set(err, -ENOMEM, "mcap: no memory for a writer");
    w->config = *config;
    set_defaults(&w->config);
    rc = check_config(&w->config, err);
    if (rc == 0) {
        copy_names(w);
        rc = allocate(w);
        if (rc)
            dx_err_set(err, rc, "mcap: no memory for chunks of %zu bytes",
                       largest_chunk(&w->config));
    }
    if (rc) {
        dx_mcap_writer_free(w);
        return rc;
    }
    *out = w;
    return 0;
}

void dx_mcap_writer_free(struct dx_mcap_writer *w)
{
    if (!w)
        return;
    dx_mcap_packer_free(w->packer);
    dx_mcap_defs_fini(&w->defs);
    free(w->chunk);
    free(w->packed);
    free(w->entries);
    free(w->lists);
    free(w->schema_in_chunk);
    free(w->chunks.bytes);
    free(w->attachments.bytes);
    free(w->metadata.bytes);
    free(w);
}

int dx_mcap_writer_schema(struct dx_mcap_writer *w, const struct dx_mcap_schema *s)
{
    return s->id == 0 ? -EINVAL : dx_mcap_defs_schema(&w->defs, s);
}

int dx_mcap_writer_channel(struct dx_mcap_writer *w, const struct dx_mcap_channel *c)
{
    if (c->schema_id != 0 && !dx_mcap_def_find(&w->defs.schemas, c->schema_id))
        return -ENOENT;
    return dx_mcap_defs_channel(&w->defs, c);
}

static void clear_group(struct dx_mcap_group *g)
{
    g->len = 0;
    g->n = 0;
}

int dx_mcap_writer_begin(struct dx_mcap_writer *w, const struct dx_mcap_sink *sink)
{
    uint8_t head[DX_MCAP_RECORD_HEAD + 2 * (4 + DX_MCAP_MAX_NAME)];
    struct dx_writer out = dx_writer_init(head, sizeof(head));
    struct dx_mcap_piece piece;

    w->sink = *sink;
    w->file_len = 0;
    w->file_crc = 0;
    w->stats = (struct dx_mcap_statistics){0};
    clear_group(&w->chunks);
    clear_group(&w->attachments);
    clear_group(&w->metadata);
    dx_mcap_writer_clear_chunk(w);
    for (uint32_t k = 0; k < w->defs.channels.n; k++)
        w->defs.channels.defs[k]->n_messages = 0;
    dx_mcap_put_header(&out, w->config.profile, w->config.library);
    piece = dx_mcap_piece_begin(w);
    dx_mcap_piece_put(&piece, dx_mcap_magic, DX_MCAP_MAGIC_LEN);
    dx_mcap_piece_put(&piece, head, (size_t)(out.p - head));
    return dx_mcap_piece_commit(&piece);
}

/* ---- the open chunk ---------------------------------------------------------------------------
 */

void dx_mcap_writer_clear_chunk(struct dx_mcap_writer *w)
{
    w->chunk_len = 0;
    w->n_entries = 0;
    for (uint32_t k = 0; k < w->defs.channels.n; k++)
        w->lists[k] = (struct dx_mcap_list){DX_MCAP_NONE_LEFT, DX_MCAP_NONE_LEFT, 0};
    for (uint32_t k = 0; k < w->defs.schemas.n; k++)
        w->schema_in_chunk[k] = false;
}

uint32_t dx_mcap_writer_drop(struct dx_mcap_writer *w)
{
    uint32_t n = w->n_entries;

    dx_mcap_writer_clear_chunk(w);
    return n;
}

void dx_mcap_writer_note(struct dx_mcap_writer *w, const struct dx_mcap_def *channel,
                         uint64_t log_time, size_t offset)
{
    struct dx_mcap_list *list = &w->lists[channel->order];
    uint32_t k = w->n_entries++;

    w->entries[k] = (struct dx_mcap_entry){log_time, (uint32_t)offset, DX_MCAP_NONE_LEFT};
    if (list->n++ == 0)
        list->first = k;
    else
        w->entries[list->last].next = k;
    list->last = k;
    w->start = k == 0 || log_time < w->start ? log_time : w->start;
    w->end = k == 0 || log_time > w->end ? log_time : w->end;
}

static void append(struct dx_mcap_writer *w, const struct dx_mcap_def *def)
{
    memcpy(w->chunk + w->chunk_len, def->record, def->len);
    w->chunk_len += def->len;
}

/* The channel's schema, unless it has none or it is in the chunk already. */
static const struct dx_mcap_def *missing_schema(const struct dx_mcap_writer *w,
                                                const struct dx_mcap_def *channel)
{
    const struct dx_mcap_def *schema =
        dx_mcap_def_find(&w->defs.schemas, channel->channel.schema_id);

    return schema && !w->schema_in_chunk[schema->order] ? schema : NULL;
}

/* Bytes that the message and what must be declared before it add to the open chunk. */
static size_t added_len(const struct dx_mcap_writer *w, const struct dx_mcap_def *channel,
                        size_t data_len)
{
    const struct dx_mcap_def *schema;
    size_t len = message_len(data_len);

    if (w->lists[channel->order].n > 0)
        return len;
    schema = missing_schema(w, channel);
    return len + channel->len + (schema ? schema->len : 0);
}

/* The open chunk is to be closed before this message. */
static bool is_due(const struct dx_mcap_writer *w, const struct dx_mcap_def *channel,
                   const struct dx_mcap_message *m)
{
    uint64_t start = m->log_time < w->start ? m->log_time : w->start;
    uint64_t end = m->log_time > w->end ? m->log_time : w->end;

    return w->n_entries > 0 &&
           (w->n_entries == w->config.max_messages || end - start >= w->config.chunk_ns ||
            w->chunk_len + added_len(w, channel, m->data.len) > w->config.chunk_len);
}

static void take(struct dx_mcap_writer *w, const struct dx_mcap_def *channel,
                 const struct dx_mcap_message *m)
{
    const struct dx_mcap_def *schema = missing_schema(w, channel);
    struct dx_writer out;
    size_t offset;

    if (w->lists[channel->order].n == 0) {
        if (schema) {
            append(w, schema);
            w->schema_in_chunk[schema->order] = true;
        }
        append(w, channel);
    }
    offset = w->chunk_len;
    out = dx_writer_init(w->chunk + offset, w->chunk_cap - offset);
    dx_mcap_put_message(&out, m);
    w->chunk_len = (size_t)(out.p - w->chunk);
    dx_mcap_writer_note(w, channel, m->log_time, offset);
}

int dx_mcap_writer_message(struct dx_mcap_writer *w, const struct dx_mcap_message *m)
{
    const struct dx_mcap_def *channel = dx_mcap_def_find(&w->defs.channels, m->channel_id);
    int rc;

    if (!channel)
        return -ENOENT;
    if (m->data.len > w->config.max_message)
        return -EMSGSIZE;
    if (is_due(w, channel, m)) {
        rc = dx_mcap_writer_flush(w);
        if (rc)
            return rc;
    }
    if (w->n_entries == 0 && !dx_mcap_writer_has_room(w))
        return DX_MCAP_E_FULL;
    take(w, channel, m);
    return 0;
}

int dx_mcap_writer_flush(struct dx_mcap_writer *w)
{
    struct dx_mcap_chunk chunk = {
        .start = w->start,
        .end = w->end,
        .uncompressed_len = w->chunk_len,
        .compression = dx_mcap_text(dx_mcap_compression_name(w->config.compression)),
        .records = {w->chunk, w->chunk_len},
    };
    int64_t len;

    if (w->n_entries == 0)
        return 0;
    chunk.crc = dx_crc32(0, w->chunk, w->chunk_len);
    if (w->config.compression != DX_MCAP_NONE) {
        len = dx_mcap_packer_run(w->packer, w->packed, w->packed_cap, w->chunk, w->chunk_len);
        if (len < 0)
            return (int)len;
        chunk.records = (struct dx_mcap_bytes){w->packed, (size_t)len};
    }
    return dx_mcap_writer_put_chunk(w, &chunk);
}

struct dx_mcap_progress dx_mcap_writer_progress(const struct dx_mcap_writer *w)
{
    return (struct dx_mcap_progress){w->file_len, w->stats.n_messages, w->stats.n_chunks,
                                     w->n_entries, w->chunk_len};
}
