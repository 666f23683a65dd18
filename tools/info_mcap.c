/* dexel info of MCAP recordings: by reading every message, or by the index. */
#include "tools/info.h"

#include "drivers/file/cloud_bag.h"
#include "drivers/file/recording.h"
#include "tools/mcap_open.h"
#include "tools/source.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* What the messages of a channel tell. */
struct count {
    uint64_t n, bytes, first, last;
    uint64_t n_gaps, longest, longest_at; /* ns; since when */
};

struct tally {
    struct count *of[65536]; /* by channel */
    uint64_t gap_ns;
    bool failed; /* no memory */
};

static bool mcap_probe(const char *path, const uint8_t *bytes, size_t len)
{
    (void)path;
    return dx_mcap_probe(bytes, len);
}

/* ---- texts of a file --------------------------------------------------------------------------
 */

/* Of a file one cannot know that it is UTF-8. */
static json_t *text_json(struct dx_mcap_text t)
{
    json_t *v = json_stringn(t.p ? t.p : "", t.len);
    char text[256];

    if (v)
        return v;
    dx_mcap_text_copy(text, sizeof(text), t);
    return json_string(text);
}

static json_t *map_json(struct dx_mcap_bytes map)
{
    struct dx_reader r = dx_reader_init(map.p, map.len);
    json_t *object = json_object();
    struct dx_mcap_pair pair;
    char key[256];

    while (dx_mcap_next_pair(&pair, &r) == 0) {
        dx_mcap_text_copy(key, sizeof(key), pair.key);
        json_object_set_new(object, key, text_json(pair.value));
    }
    return object;
}

static void set(json_t *o, const char *key, uint64_t v)
{
    json_object_set_new(o, key, json_integer((json_int_t)v));
}

static double seconds(uint64_t from, uint64_t to)
{
    return (double)(to - from) * 1e-9;
}

/* ---- channels ---------------------------------------------------------------------------------
 */

/* Within a channel the file's order is that of time, or nearly. */
static void on_message(void *ctx, const struct dx_mcap_message *m)
{
    struct tally *t = ctx;
    struct count *c = t->of[m->channel_id];
    uint64_t gap;

    if (!c)
        c = t->of[m->channel_id] = calloc(1, sizeof(*c));
    if (!c) {
        t->failed = true;
        return;
    }
    gap = c->n && m->log_time > c->last ? m->log_time - c->last : 0;
    c->n_gaps += gap > t->gap_ns;
    if (gap > c->longest) {
        c->longest = gap;
        c->longest_at = c->last;
    }
    c->first = c->n == 0 || m->log_time < c->first ? m->log_time : c->first;
    c->last = c->n == 0 || m->log_time > c->last ? m->log_time : c->last;
    c->n++;
    c->bytes += m->data.len;
}

static void tell_count(json_t *o, const struct count *c)
{
    set(o, "bytes", c->bytes);
    set(o, "start_ns", c->first);
    set(o, "end_ns", c->last);
    if (c->n > 1 && c->last > c->first)
        json_object_set_new(o, "rate_hz",
                            json_real((double)(c->n - 1) / seconds(c->first, c->last)));
    set(o, "gaps", c->n_gaps);
    json_object_set_new(o, "longest_gap_s", json_real((double)c->longest * 1e-9));
    set(o, "longest_gap_at_ns", c->longest_at);
}

static json_t *channel_json(const struct dx_mcap_reader *r, const struct dx_mcap_channel *c,
                            const struct tally *t)
{
    const struct dx_mcap_schema *schema = dx_mcap_reader_find_schema(r, c->schema_id);
    const struct count *count = t ? t->of[c->id] : NULL;
    json_t *o = json_object();

    json_object_set_new(o, "topic", text_json(c->topic));
    json_object_set_new(o, "encoding", text_json(c->message_encoding));
    if (schema) {
        json_object_set_new(o, "schema", text_json(schema->name));
        json_object_set_new(o, "schema_encoding", text_json(schema->encoding));
    }
    set(o, "messages", dx_mcap_reader_count(r, c->id));
    if (count)
        tell_count(o, count);
    json_object_set_new(o, "metadata", map_json(c->metadata));
    return o;
}

static json_t *channels_json(const struct dx_mcap_reader *r, const struct tally *t)
{
    const struct dx_mcap_channel *c;
    json_t *list = json_array();

    for (uint32_t k = 0; (c = dx_mcap_reader_channel(r, k)); k++)
        json_array_append_new(list, channel_json(r, c, t));
    return list;
}

/* ---- the rest ---------------------------------------------------------------------------------
 */

static json_t *attachments_json(const struct dx_mcap_reader *r)
{
    const struct dx_mcap_item_index *a;
    json_t *list = json_array();

    for (uint32_t k = 0; (a = dx_mcap_reader_attachment(r, k)); k++) {
        json_t *o = json_object();

        json_object_set_new(o, "name", text_json(a->name));
        json_object_set_new(o, "media_type", text_json(a->media_type));
        set(o, "bytes", a->data_len);
        set(o, "log_time_ns", a->log_time);
        json_array_append_new(list, o);
    }
    return list;
}

static json_t *metadata_json(struct dx_mcap_reader *r)
{
    const struct dx_mcap_item_index *item;
    json_t *list = json_array();

    for (uint32_t k = 0; (item = dx_mcap_reader_metadata(r, k)); k++) {
        struct dx_mcap_metadata m;
        json_t *o = json_object();

        json_object_set_new(o, "name", text_json(item->name));
        if (dx_mcap_reader_read_metadata(r, item, &m, NULL) == 0)
            json_object_set_new(o, "values", map_json(m.map));
        json_array_append_new(list, o);
    }
    return list;
}

static void tell_file(json_t *out, const struct dx_mcap_reader *r)
{
    struct dx_mcap_info info;

    dx_mcap_reader_info(r, &info);
    json_object_set_new(out, "format", json_string("MCAP"));
    json_object_set_new(out, "profile", json_string(info.profile));
    json_object_set_new(out, "library", json_string(info.library));
    set(out, "bytes", info.len);
    set(out, "messages", info.n_messages);
    if (info.n_messages > 0) {
        set(out, "start_ns", info.start);
        set(out, "end_ns", info.end);
        json_object_set_new(out, "seconds", json_real(seconds(info.start, info.end)));
    }
    set(out, "chunks", info.n_chunks);
    for (int c = 0; c < DX_MCAP_N_COMPRESSIONS; c++)
        if (info.n_of[c] > 0)
            set(out,
                c == DX_MCAP_NONE  ? "chunks_plain"
                : c == DX_MCAP_LZ4 ? "chunks_lz4"
                                   : "chunks_zstd",
                info.n_of[c]);
}

static void tell_damage(json_t *out, const struct dx_mcap_reader *r,
                        const struct dx_info_options *o)
{
    const struct dx_mcap_damage *d;
    json_t *list = json_array();

    for (uint64_t k = 0; (d = dx_mcap_reader_damage(r, k)); k++)
        json_array_append_new(list, dx_info_damage(d->offset, d->len, d->text));
    dx_info_sound(out, dx_mcap_reader_damages(r), list, o);
}

static const struct dx_driver *driver_of(const struct dx_mcap_reader *r)
{
    return dx_mcap_reader_topic(r, DX_RECORDING_TOPIC) ? &dx_recorded_driver
           : dx_cloud_bag_has_clouds(r)                ? &dx_file_driver
                                                       : NULL;
}

static int tell_all(json_t *out, struct tally *tally, const struct dx_driver **driver,
                    const char *path, const struct dx_info_options *o, struct dx_err *err)
{
    const struct dx_mcap_read_options options = {
        .scan = !o->quick, .on_message = o->quick ? NULL : on_message, .ctx = tally};
    struct dx_mcap_file file;
    int rc = dx_mcap_file_open(&file, path, &options, err);

    if (rc)
        return rc;
    *driver = driver_of(file.reader);
    tell_file(out, file.reader);
    json_object_set_new(out, "checked", json_boolean(!o->quick));
    json_object_set_new(out, "channel", channels_json(file.reader, tally));
    json_object_set_new(out, "attachment", attachments_json(file.reader));
    json_object_set_new(out, "metadata", metadata_json(file.reader));
    tell_damage(out, file.reader, o);
    dx_mcap_file_close(&file);
    return tally->failed ? dx_err_set(err, -ENOMEM, "%s: no memory", path) : 0;
}

int dx_info_mcap_file(json_t *out, const struct dx_driver **driver, const char *path,
                      const struct dx_info_options *o, struct dx_err *err)
{
    struct tally *tally = calloc(1, sizeof(*tally));
    int rc;

    *driver = NULL;
    if (!tally)
        return dx_err_set(err, -ENOMEM, "%s: no memory", path);
    tally->gap_ns = o->gap_ns;
    rc = tell_all(out, tally, driver, path, o, err);
    for (size_t k = 0; k < 65536; k++)
        free(tally->of[k]);
    free(tally);
    return rc;
}

static int mcap_tell(json_t *out, const char *path, const struct dx_info_options *o,
                     struct dx_err *err)
{
    const struct dx_driver *driver;
    json_t *damage;
    uint64_t n;
    int rc = dx_info_mcap_file(out, &driver, path, o, err);

    if (rc || o->quick)
        return rc;
    n = (uint64_t)json_integer_value(json_object_get(out, "damaged"));
    damage = json_incref(json_object_get(out, "damage"));
    json_object_del(out, "sound"); /* the verdict is the last that is told */
    json_object_del(out, "damaged");
    json_object_del(out, "damage");
    if (!dx_info_decode(out, driver, path) && n == 0) {
        const json_t *why = json_object_get(out, "not_decoded");

        json_array_append_new(damage, dx_info_damage(0, 0, json_string_value(why)));
        n = 1;
    }
    dx_info_sound(out, n, damage, o);
    return 0;
}

const struct dx_info_kind dx_info_mcap = {mcap_probe, mcap_tell};
