/*
 * The MCAP reader: a single record in a scan, checked and taken in. Damage is noted where its
 * record is.
 */
#include "drivers/file/mcap_scan.h"

#include <errno.h>

#define RUN_LEN   ((uint64_t)1 << 20) /* messages outside of chunks are read in such runs */
#define MAX_NAMES ((size_t)512 << 10) /* of an attachment */

static const uint8_t *body_of(struct dx_mcap_scan *s, size_t len, int *rc)
{
    const uint8_t *p = NULL;

    *rc = dx_mcap_view_get(s->r, s->at + DX_MCAP_RECORD_HEAD, len, &p);
    return *rc ? NULL : p;
}

static uint64_t body_len(const struct dx_mcap_scan *s)
{
    return s->len - DX_MCAP_RECORD_HEAD;
}

/* Passes -ENOMEM up; anything else is damage of this record. */
static int damaged(struct dx_mcap_scan *s, int rc, const char *what)
{
    if (rc == -ENOMEM)
        return rc;
    dx_mcap_note(s->r, s->at, s->len, "%s", what);
    return 0;
}

/* A message whose data have `len` bytes. */
static void count(struct dx_mcap_scan *s, struct dx_mcap_part *part,
                  const struct dx_mcap_message *m, size_t len)
{
    bool is_first = !part->has_messages;
    struct dx_mcap_message told = *m;

    part->has_messages = true;
    part->start = is_first || m->log_time < part->start ? m->log_time : part->start;
    part->end = is_first || m->log_time > part->end ? m->log_time : part->end;
    s->start = s->n_messages == 0 || m->log_time < s->start ? m->log_time : s->start;
    s->end = s->n_messages == 0 || m->log_time > s->end ? m->log_time : s->end;
    s->n_messages++;
    dx_mcap_def_find(&s->r->defs.channels, m->channel_id)->n_messages++;
    told.data = (struct dx_mcap_bytes){NULL, len};
    if (s->r->on_message)
        s->r->on_message(s->r->on_message_ctx, &told);
}

/* ---- messages outside of chunks ---------------------------------------------------------------
 */

int dx_mcap_scan_close_run(struct dx_mcap_scan *s)
{
    int rc = s->run.at.len ? dx_mcap_parts_add(&s->r->parts, &s->run) : 0;

    s->run = (struct dx_mcap_part){0};
    return rc;
}

static int scan_message(struct dx_mcap_scan *s)
{
    struct dx_mcap_message m;
    const uint8_t *p;
    int rc;

    if (s->len > s->r->max_chunk || body_len(s) < DX_MCAP_MESSAGE_HEAD)
        return damaged(s, 0, "message shorter or longer than expected");
    p = body_of(s, DX_MCAP_MESSAGE_HEAD, &rc);
    if (!p)
        return damaged(s, rc, "message cannot be read");
    dx_mcap_get_message(&m, p, DX_MCAP_MESSAGE_HEAD);
    if (!dx_mcap_def_find(&s->r->defs.channels, m.channel_id))
        return damaged(s, 0, "message of an unknown channel");
    if (s->run.at.len &&
        (s->run.at.offset + s->run.at.len != s->at || s->run.at.len + s->len > RUN_LEN)) {
        rc = dx_mcap_scan_close_run(s);
        if (rc)
            return rc;
    }
    if (s->run.at.len == 0)
        s->run = (struct dx_mcap_part){.at.offset = s->at, .is_run = true};
    count(s, &s->run, &m, (size_t)body_len(s) - DX_MCAP_MESSAGE_HEAD);
    s->run.at.len += s->len;
    s->run.records_len = (uint32_t)s->run.at.len;
    return 0;
}

/* ---- chunks -----------------------------------------------------------------------------------
 */

/* Takes in what the chunk declares and counts its messages. */
static int scan_records(struct dx_mcap_scan *s, struct dx_mcap_part *part,
                        struct dx_mcap_bytes records)
{
    struct dx_mcap_part_walk walk = dx_mcap_part_walk(s->r, records);
    struct dx_mcap_message m;
    size_t offset;
    int rc;

    while ((rc = dx_mcap_part_next(&walk, &m, &offset)) == 0)
        count(s, part, &m, m.data.len);
    if (rc == -ENOMEM)
        return rc;
    part->is_odd = rc < 0 || walk.n_strange > 0;
    if (rc < 0)
        dx_mcap_note(s->r, s->at, s->len, "chunk: damaged record at byte %zu of its %zu",
                     (size_t)(walk.records.p - walk.start), records.len);
    if (walk.n_strange > 0)
        dx_mcap_note(s->r, s->at, s->len,
                     "chunk: %llu records of unknown channels or of ids that are taken",
                     (unsigned long long)walk.n_strange);
    return 0;
}

/* The lengths inside the record agree with its own. */
static bool is_sound(struct dx_mcap_scan *s)
{
    struct dx_mcap_chunk c;
    const uint8_t *p;

    return dx_mcap_view_get(s->r, s->at, (size_t)s->len, &p) == 0 &&
           dx_mcap_get_chunk(&c, p + DX_MCAP_RECORD_HEAD, (size_t)body_len(s)) == 0 &&
           dx_mcap_chunk_is_sound(&c, s->len);
}

static void check_length(struct dx_mcap_scan *s, const struct dx_mcap_part *part)
{
    uint64_t known;
    struct dx_mcap_chunk c;

    if (dx_mcap_view_chunk(s->r, part, &c) < 0)
        return;
    known = (uint64_t)(c.records.p - s->r->view.bytes) + s->r->view.offset + c.records.len - s->at;
    s->len = dx_mcap_true_len(s->r, s->at, s->len, known);
}

static int scan_chunk(struct dx_mcap_scan *s)
{
    struct dx_mcap_part part = {.at = {s->at, s->len}};
    struct dx_mcap_bytes records;
    int rc = dx_mcap_load(s->r, &part, &records);

    if (rc == -ENOMEM)
        return rc;
    if (rc) {
        dx_mcap_note(s->r, s->at, s->len, "%s", s->r->why.text);
        return rc != -EBADMSG || (s->len <= 2 * s->r->max_chunk && is_sound(s)) ? 0
                                                                                : DX_MCAP_E_RESYNC;
    }
    part.records_len = (uint32_t)records.len;
    rc = scan_records(s, &part, records);
    dx_mcap_unload(s->r, &part);
    if (rc == 0)
        check_length(s, &part);
    return rc ? rc : dx_mcap_parts_add(&s->r->parts, &part);
}

/* ---- other records ----------------------------------------------------------------------------
 */

static int scan_def(struct dx_mcap_scan *s)
{
    const uint8_t *p;
    int rc;

    if (body_len(s) > DX_MCAP_MAX_DEFS)
        return damaged(s, 0, "schema or channel larger than this reader takes");
    p = body_of(s, (size_t)body_len(s), &rc);
    if (p)
        rc = dx_mcap_take_def(s->r, s->op, p, (size_t)body_len(s));
    return rc ? damaged(s, rc, "schema or channel that is damaged, or of an id that is taken") : 0;
}

/* The CRC is the last of the record, over all before it. */
static int check_attachment_crc(struct dx_mcap_scan *s, uint64_t len)
{
    uint32_t found, crc;
    const uint8_t *p;
    int rc = dx_mcap_view_get(s->r, s->at + DX_MCAP_RECORD_HEAD + len, 4, &p);

    if (rc)
        return rc;
    crc = dx_get_u32(p);
    if (crc == 0)
        return 0;
    rc = dx_mcap_view_crc(s->r, s->at + DX_MCAP_RECORD_HEAD, len, &found);
    return rc ? rc : found == crc ? 0 : -EBADMSG;
}

static int scan_attachment(struct dx_mcap_scan *s)
{
    size_t head_len = body_len(s) < MAX_NAMES ? (size_t)body_len(s) : MAX_NAMES;
    struct dx_mcap_item_index item;
    struct dx_mcap_attachment a;
    struct dx_mcap_extent data;
    const uint8_t *p;
    int rc;

    p = body_of(s, head_len, &rc);
    if (!p)
        return damaged(s, rc, "attachment cannot be read");
    if (dx_mcap_get_attachment_head(&a, &data, p, head_len) < 0 || body_len(s) < 4 ||
        data.offset > body_len(s) - 4 || data.len != body_len(s) - 4 - data.offset) {
        dx_mcap_note(s->r, s->at, s->len, "attachment: its lengths do not agree");
        return DX_MCAP_E_RESYNC;
    }
    rc = check_attachment_crc(s, body_len(s) - 4);
    if (rc)
        return damaged(s, rc, "attachment: wrong CRC");
    p = body_of(s, head_len, &rc); /* the CRC has moved the view on */
    if (!p)
        return damaged(s, rc, "attachment cannot be read");
    dx_mcap_get_attachment_head(&a, &data, p, head_len);
    item = (struct dx_mcap_item_index){{s->at, s->len}, a.log_time, a.create_time,
                                       data.len,        a.name,     a.media_type};
    rc = dx_mcap_items_add(&s->r->attachments, &item);
    return rc ? damaged(s, rc, "attachment: more than this reader takes") : 0;
}

/* Not used (the chunk itself tells more), but its lengths tell whether the record is one. */
static int scan_message_index(struct dx_mcap_scan *s)
{
    const uint8_t *p;
    int rc;

    p = body_len(s) >= 6 ? body_of(s, 6, &rc) : NULL;
    if (p && (uint64_t)dx_get_u32(p + 2) + 6 == body_len(s))
        return 0;
    dx_mcap_note(s->r, s->at, s->len, "message index: its lengths do not agree");
    return DX_MCAP_E_RESYNC;
}

static int scan_metadata(struct dx_mcap_scan *s)
{
    struct dx_mcap_item_index item = {.record = {s->at, s->len}};
    struct dx_mcap_metadata m;
    const uint8_t *p;
    int rc;

    if (s->len > DX_MCAP_MAX_METADATA)
        return damaged(s, 0, "metadata: more than this reader takes");
    p = body_of(s, (size_t)body_len(s), &rc);
    if (p)
        rc = dx_mcap_get_metadata(&m, p, (size_t)body_len(s));
    if (rc == -EBADMSG) {
        dx_mcap_note(s->r, s->at, s->len, "metadata: its lengths do not agree");
        return DX_MCAP_E_RESYNC;
    }
    if (rc == 0) {
        item.name = m.name;
        rc = dx_mcap_items_add(&s->r->metadata, &item);
    }
    return rc ? damaged(s, rc, "metadata: cannot be read, or more than this reader takes") : 0;
}

static int scan_data_end(struct dx_mcap_scan *s)
{
    uint32_t found, crc;
    const uint8_t *p;
    int rc;

    s->ended = true;
    p = body_len(s) == 4 ? body_of(s, 4, &rc) : NULL;
    if (!p) {
        dx_mcap_note(s->r, s->at, s->len, "no whole DataEnd record");
        return 0;
    }
    crc = dx_get_u32(p);
    if (crc == 0)
        return 0;
    rc = dx_mcap_view_crc(s->r, 0, s->at, &found);
    if (rc)
        return damaged(s, rc, "data cannot be read again for their CRC");
    if (found != crc)
        dx_mcap_note(s->r, 0, s->at, "data: CRC is %08x, expected %08x", found, crc);
    return 0;
}

int dx_mcap_scan_record(struct dx_mcap_scan *s)
{
    int rc;

    switch (s->op) {
    case DX_MCAP_SCHEMA:
    case DX_MCAP_CHANNEL:
        return scan_def(s);
    case DX_MCAP_MESSAGE:
        return scan_message(s);
    case DX_MCAP_CHUNK:
        rc = dx_mcap_scan_close_run(s);
        return rc ? rc : scan_chunk(s);
    case DX_MCAP_MESSAGE_INDEX:
        return scan_message_index(s);
    case DX_MCAP_ATTACHMENT:
        return scan_attachment(s);
    case DX_MCAP_METADATA:
        return scan_metadata(s);
    case DX_MCAP_DATA_END:
        return scan_data_end(s);
    case DX_MCAP_FOOTER:
        dx_mcap_note(s->r, s->at, s->len, "footer without the end of data before it");
        s->ended = true;
        return 0;
    default: /* of a later version, or private; an index does not belong here and is not used */
        return 0;
    }
}
