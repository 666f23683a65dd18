/* Repair of MCAP files: what the reader's scan found, through the writer. */
#include "drivers/file/mcap_repair.h"

#include "drivers/file/mcap_read_priv.h"
#include "drivers/file/mcap_write_priv.h"

#include <errno.h>
#include <stdio.h>

struct repair {
    struct dx_mcap_reader *r;
    struct dx_mcap_writer *w;
    struct dx_mcap_repaired *out;
};

/* The two tables' sizes and the largest part: what the writer must be able to hold. */
static struct dx_mcap_writer_config needed(const struct dx_mcap_reader *r)
{
    uint32_t n_defs =
        r->defs.channels.n > r->defs.schemas.n ? r->defs.channels.n : r->defs.schemas.n;
    size_t largest = 0, most = DX_MCAP_MAX_CHUNK - r->defs.len - 100;
    struct dx_mcap_writer_config c = {
        .compression = DX_MCAP_ZSTD,
        .chunk_ns = UINT64_MAX,
        .max_channels = n_defs ? n_defs : 1,
        .max_defs = r->defs.len + 1,
        .profile = r->profile,
    };

    for (uint32_t k = 0; k < r->parts.n; k++)
        largest = r->parts.p[k].records_len > largest ? r->parts.p[k].records_len : largest;
    c.max_messages = (uint32_t)(largest / (DX_MCAP_RECORD_HEAD + DX_MCAP_MESSAGE_HEAD)) + 1;
    c.max_message = (largest < most ? largest : most) + 1;
    c.chunk_len =
        largest + c.max_defs < DX_MCAP_MAX_CHUNK ? largest + c.max_defs : DX_MCAP_MAX_CHUNK;
    c.index_len = (2 * (size_t)r->parts.n + 16) * (96 + 10 * (size_t)c.max_channels);
    c.items_len = 96 * ((size_t)r->attachments.n + r->metadata.n + 1) + r->attachments.names_len +
                  r->metadata.names_len;
    return c;
}

/* A writer that takes all the reader can hold; the messages of a part go into one chunk. */
static int open_writer(struct repair *p, struct dx_err *err)
{
    struct dx_mcap_writer_config c = needed(p->r);
    char library[256];

    snprintf(library, sizeof(library), "dexeld " DEXELD_VERSION ", repaired; was: %s",
             p->r->library);
    c.library = library;
    return dx_mcap_writer_new(&p->w, &c, err);
}

static int declare(struct repair *p)
{
    const struct dx_mcap_schema *s;
    const struct dx_mcap_channel *c;
    int rc = 0;

    for (uint32_t k = 0; rc == 0 && (s = dx_mcap_reader_schema(p->r, k)); k++)
        rc = dx_mcap_writer_schema(p->w, s);
    for (uint32_t k = 0; rc == 0 && (c = dx_mcap_reader_channel(p->r, k)); k++) {
        rc = dx_mcap_writer_channel(p->w, c);
        if (rc == -ENOENT) { /* its schema is lost, its messages are not */
            struct dx_mcap_channel bare = *c;

            bare.schema_id = 0;
            rc = dx_mcap_writer_channel(p->w, &bare);
        }
    }
    return rc;
}

/* The chunk as it is, with new message indexes. */
static int copy_chunk(struct repair *p, struct dx_mcap_part *part, struct dx_mcap_bytes records)
{
    struct dx_mcap_part_walk walk = dx_mcap_part_walk(p->r, records);
    struct dx_mcap_chunk chunk;
    struct dx_mcap_message m;
    size_t offset;
    int rc;

    while ((rc = dx_mcap_part_next(&walk, &m, &offset)) == 0)
        dx_mcap_writer_note(p->w, dx_mcap_def_find(&p->w->defs.channels, m.channel_id), m.log_time,
                            offset);
    if (rc < 0)
        return rc;
    rc = dx_mcap_view_chunk(p->r, part, &chunk);
    if (rc)
        return rc;
    chunk.start = part->start; /* as found; 0 without messages */
    chunk.end = part->end;
    return dx_mcap_writer_put_chunk(p->w, &chunk);
}

/* What can be read of it, into a chunk of its own. */
static int move_messages(struct repair *p, struct dx_mcap_bytes records)
{
    struct dx_mcap_part_walk walk = dx_mcap_part_walk(p->r, records);
    struct dx_mcap_message m;
    size_t offset;
    int rc;

    while ((rc = dx_mcap_part_next(&walk, &m, &offset)) == 0) {
        rc = dx_mcap_writer_message(p->w, &m);
        if (rc == -EMSGSIZE)
            p->out->n_lost++;
        else if (rc)
            return rc;
        else
            p->out->n_moved++;
    }
    return rc == -ENOMEM ? rc : dx_mcap_writer_flush(p->w);
}

/* The declarations of a chunk whose channels lost their schema would contradict those of the file;
 * so would those of ids that are taken, which is_odd tells. */
static bool has_lost_schema(const struct repair *p)
{
    const struct dx_mcap_channel *c;

    for (uint32_t k = 0; (c = dx_mcap_reader_channel(p->r, k)); k++)
        if (c->schema_id != 0 && !dx_mcap_reader_find_schema(p->r, c->schema_id))
            return true;
    return false;
}

static int copy_part(struct repair *p, struct dx_mcap_part *part, bool as_it_is)
{
    struct dx_mcap_bytes records;
    int rc = dx_mcap_load(p->r, part, &records);

    if (rc)
        return rc;
    rc = part->is_run || part->is_odd || !as_it_is ? move_messages(p, records)
                                                   : copy_chunk(p, part, records);
    dx_mcap_unload(p->r, part);
    return rc;
}

static int copy_item(struct repair *p, const struct dx_mcap_item_index *item, bool is_attachment)
{
    struct dx_mcap_attachment a;
    struct dx_mcap_metadata m;
    int rc;

    if (is_attachment) {
        rc = dx_mcap_reader_read_attachment(p->r, item, &a, NULL);
        p->out->n_lost_items += rc != 0;
        rc = rc ? 0 : dx_mcap_writer_attachment(p->w, &a);
    } else {
        rc = dx_mcap_reader_read_metadata(p->r, item, &m, NULL);
        p->out->n_lost_items += rc != 0;
        rc = rc ? 0 : dx_mcap_writer_metadata(p->w, &m);
    }
    if (rc == -EINVAL) { /* a name longer than we write */
        p->out->n_lost_items++;
        rc = 0;
    }
    return rc;
}

static uint64_t offset_of(const struct dx_mcap_item_index *item)
{
    return item ? item->record.offset : UINT64_MAX;
}

/* Everything in the order of the file. */
static int copy_all(struct repair *p)
{
    bool as_it_is = !has_lost_schema(p);
    uint32_t part = 0, attachment = 0, metadata = 0;
    int rc = 0;

    while (rc == 0) {
        const struct dx_mcap_item_index *a = dx_mcap_reader_attachment(p->r, attachment);
        const struct dx_mcap_item_index *m = dx_mcap_reader_metadata(p->r, metadata);
        uint64_t at = part < p->r->parts.n ? p->r->parts.p[part].at.offset : UINT64_MAX;

        if (at == UINT64_MAX && !a && !m)
            break;
        if (at < offset_of(a) && at < offset_of(m)) {
            rc = copy_part(p, &p->r->parts.p[part++], as_it_is);
        } else if (offset_of(a) < offset_of(m)) {
            rc = copy_item(p, a, true);
            attachment++;
        } else {
            rc = copy_item(p, m, false);
            metadata++;
        }
    }
    p->out->n_items = attachment + metadata - p->out->n_lost_items;
    return rc;
}

int dx_mcap_repair(struct dx_mcap_reader *r, const struct dx_mcap_sink *sink,
                   struct dx_mcap_repaired *out, struct dx_err *err)
{
    struct repair p = {.r = r, .out = out};
    int rc = open_writer(&p, err);

    *out = (struct dx_mcap_repaired){0};
    if (rc)
        return rc;
    rc = declare(&p);
    if (rc == 0)
        rc = dx_mcap_writer_begin(p.w, sink);
    if (rc == 0)
        rc = copy_all(&p);
    if (rc == 0)
        rc = dx_mcap_writer_finish(p.w);
    out->n_messages = dx_mcap_writer_progress(p.w).n_messages;
    dx_mcap_writer_free(p.w);
    if (rc > 0)
        rc = -E2BIG;
    return rc ? dx_err_set(err, rc, "cannot be repaired: %s", strerror(-rc)) : 0;
}
