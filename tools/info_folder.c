/* dexel info of a directory or pattern of MCAP files: each checked, times and gaps over all. */
#include "tools/info.h"

#include "drivers/file/file_list.h"
#include "drivers/file/format.h"
#include "drivers/file/mcap_read.h"
#include "drivers/file/open_regular.h"
#include "tools/source.h"

#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

struct sum {
    const struct dx_info_options *o;
    struct dx_file_list list;
    const struct dx_driver *driver; /* of the first file that has one */
    uint64_t bytes, n_messages, start, end, n_damaged;
    json_t *channels;   /* by topic, in the order of their coming */
    json_t *recordings; /* each file: times and damage */
    json_t *damage;     /* the first one of each file */
};

/* Its first file decides. */
static bool folder_probe(const char *path, const uint8_t *bytes, size_t len)
{
    uint8_t magic[DX_MCAP_MAGIC_LEN];
    struct dx_file_list list;
    struct stat st;
    ssize_t n = 0;
    bool is = false;
    int fd;

    (void)bytes;
    if (len > 0 || (stat(path, &st) == 0 && !S_ISDIR(st.st_mode)) ||
        dx_file_list_init(&list, path, NULL) != 0)
        return false;
    fd = dx_open_regular(list.paths[0], NULL);
    if (fd >= 0) {
        n = read(fd, magic, sizeof(magic));
        close(fd);
    }
    is = dx_format_has_ext(list.paths[0], ".mcap") || (n > 0 && dx_mcap_probe(magic, (size_t)n));
    dx_file_list_fini(&list);
    return is;
}

static uint64_t get(const json_t *o, const char *key)
{
    return (uint64_t)json_integer_value(json_object_get(o, key));
}

static void set(json_t *o, const char *key, uint64_t v)
{
    json_object_set_new(o, key, json_integer((json_int_t)v));
}

static void copy(json_t *to, const json_t *from, const char *key)
{
    json_t *v = json_object_get(from, key);

    if (v)
        json_object_set(to, key, v);
}

/* ---- channels ---------------------------------------------------------------------------------
 */

static json_t *find_topic(json_t *channels, const json_t *topic)
{
    json_t *c;
    size_t k;

    json_array_foreach(channels, k, c)
    {
        if (json_equal(json_object_get(c, "topic"), topic))
            return c;
    }
    return NULL;
}

static void set_longest(json_t *o, double seconds, uint64_t at)
{
    json_object_set_new(o, "longest_gap_s", json_real(seconds));
    set(o, "longest_gap_at_ns", at);
}

static double longest_of(const json_t *o)
{
    return json_real_value(json_object_get(o, "longest_gap_s"));
}

/* Adds a channel of the next file to that of the files before, and the gap between the two. */
static void merge_channel(const struct sum *s, json_t *all, const json_t *c)
{
    uint64_t end = get(all, "end_ns"), start = get(c, "start_ns");
    uint64_t between = start > end ? start - end : 0;
    double between_s = (double)between * 1e-9;

    set(all, "messages", get(all, "messages") + get(c, "messages"));
    if (!json_object_get(c, "start_ns"))
        return;
    if (!json_object_get(all, "start_ns")) {
        static const char *const keys[] = {"bytes", "start_ns",      "end_ns",
                                           "gaps",  "longest_gap_s", "longest_gap_at_ns"};

        for (size_t k = 0; k < sizeof(keys) / sizeof(keys[0]); k++)
            copy(all, c, keys[k]);
        return;
    }
    set(all, "bytes", get(all, "bytes") + get(c, "bytes"));
    set(all, "gaps", get(all, "gaps") + get(c, "gaps") + (between > s->o->gap_ns));
    if (between_s > longest_of(all))
        set_longest(all, between_s, end);
    if (longest_of(c) > longest_of(all))
        set_longest(all, longest_of(c), get(c, "longest_gap_at_ns"));
    if (start < get(all, "start_ns"))
        set(all, "start_ns", start);
    if (get(c, "end_ns") > end)
        set(all, "end_ns", get(c, "end_ns"));
}

static void merge_channels(const struct sum *s, const json_t *file)
{
    json_t *c;
    size_t k;

    json_array_foreach(json_object_get(file, "channel"), k, c)
    {
        const json_t *topic = json_object_get(c, "topic");
        json_t *all = find_topic(s->channels, topic);

        if (!all) {
            all = json_object();
            copy(all, c, "topic");
            copy(all, c, "schema");
            json_array_append_new(s->channels, all);
        }
        merge_channel(s, all, c);
    }
}

/* ---- files ------------------------------------------------------------------------------------
 */

static void add_damage(struct sum *s, const char *path, uint64_t n, const json_t *first)
{
    json_t *d = json_object();

    json_object_set_new(d, "file", json_string(path));
    set(d, "damaged", n);
    copy(d, first, "offset");
    copy(d, first, "bytes");
    copy(d, first, "text");
    json_array_append_new(s->damage, d);
    s->n_damaged += n;
}

static void merge_times(struct sum *s, const json_t *file)
{
    uint64_t n = get(file, "messages"), start = get(file, "start_ns"), end = get(file, "end_ns");

    s->bytes += get(file, "bytes");
    if (n == 0)
        return;
    s->start = s->n_messages == 0 || start < s->start ? start : s->start;
    s->end = s->n_messages == 0 || end > s->end ? end : s->end;
    s->n_messages += n;
}

/* A file that is not even MCAP is damage of its own; the others are told all the same. */
static void tell_bad_file(json_t *file, const char *path, const struct sum *s,
                          const struct dx_err *err)
{
    const bool is_scan = dx_format_knows_name(path) && !dx_format_has_ext(path, ".mcap");
    const char *text = is_scan ? "a scan among recordings, expected either in a folder" : err->text;

    dx_info_sound(file, 1, json_pack("[o]", dx_info_damage(0, 0, text)), s->o);
}

static void add_file(struct sum *s, const char *path)
{
    static const char *const keys[] = {"bytes",   "messages", "start_ns", "end_ns",
                                       "seconds", "sound",    "damaged"};
    const struct dx_driver *driver;
    json_t *file = json_object(), *told = json_object();
    struct dx_err err = {""};

    if (dx_info_mcap_file(file, &driver, path, s->o, &err) < 0)
        tell_bad_file(file, path, s, &err);
    if (!s->driver)
        s->driver = driver;
    merge_times(s, file);
    merge_channels(s, file);
    json_object_set_new(told, "file", json_string(path));
    for (size_t k = 0; k < sizeof(keys) / sizeof(keys[0]); k++)
        copy(told, file, keys[k]);
    json_array_append_new(s->recordings, told);
    if (get(file, "damaged") > 0)
        add_damage(s, path, get(file, "damaged"),
                   json_array_get(json_object_get(file, "damage"), 0));
    json_decref(file);
}

/* One file that cannot be replayed keeps all of them from it; the frames of the others are told. */
static void decode_each(json_t *out, const struct sum *s)
{
    uint64_t n = 0;
    json_t *told;
    size_t k;

    json_array_foreach(s->recordings, k, told)
    {
        json_t *alone = json_object();

        dx_info_decode(alone, s->driver, s->list.paths[k]); /* "file" is none where not UTF-8 */
        copy(told, alone, "frames");
        n += get(alone, "frames");
        json_decref(alone);
    }
    set(out, "frames", n);
}

static void tell_frames(json_t *out, struct sum *s, const char *path)
{
    json_t *d;

    if (dx_info_decode(out, s->driver, path))
        return;
    decode_each(out, s);
    if (s->n_damaged > 0)
        return;
    d = dx_info_damage(0, 0, json_string_value(json_object_get(out, "not_decoded")));
    add_damage(s, path, 1, d);
    json_decref(d);
}

static void tell_sum(json_t *out, struct sum *s)
{
    set(out, "bytes", s->bytes);
    set(out, "messages", s->n_messages);
    if (s->n_messages > 0) {
        set(out, "start_ns", s->start);
        set(out, "end_ns", s->end);
        json_object_set_new(out, "seconds", json_real((double)(s->end - s->start) * 1e-9));
    }
    json_object_set_new(out, "checked", json_boolean(!s->o->quick));
    json_object_set_new(out, "channel", s->channels);
    json_object_set_new(out, "recording", s->recordings);
}

static int folder_tell(json_t *out, const char *path, const struct dx_info_options *o,
                       struct dx_err *err)
{
    struct sum s = {.o = o};
    int rc = dx_file_list_init(&s.list, path, err);

    if (rc)
        return rc;
    s.channels = json_array();
    s.recordings = json_array();
    s.damage = json_array();
    json_object_set_new(out, "format", json_string("MCAP"));
    set(out, "files", s.list.n);
    for (size_t k = 0; k < s.list.n; k++)
        add_file(&s, s.list.paths[k]);
    tell_sum(out, &s);
    if (!o->quick)
        tell_frames(out, &s, path);
    dx_info_sound(out, s.n_damaged, s.damage, o);
    dx_file_list_fini(&s.list);
    return 0;
}

const struct dx_info_kind dx_info_folder = {folder_probe, folder_tell};
