/* Recordings one after the other, and the pieces of their blocks. */
#include "drivers/file/playlist.h"

#include "drivers/file/cloud_bag.h"
#include "drivers/file/file_list.h"
#include "drivers/file/open_regular.h"
#include "drivers/file/recording_join.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct span {
    uint64_t start, end; /* log times */
    bool is_empty;
    bool damage_told, geometry_told;
};

struct dx_playlist {
    void (*tell)(const char *text); /* NULL: nobody listens */
    struct dx_file_list list;
    struct span *spans; /* of each file */
    char *config;
    size_t config_len;

    /* the open file */
    size_t file; /* list.n: at the end */
    int fd;
    struct dx_mcap_reader *reader; /* NULL: none is open */
    struct dx_mcap_iter *iter;
    bool seeking; /* blocks are passed over up to the start of a frame */

    struct dx_recording_join join;
};

/* The first bytes of a file, as many as there are; negative: it cannot be read. */
static ssize_t read_magic(uint8_t magic[DX_MCAP_MAGIC_LEN], const char *path)
{
    int fd = dx_open_regular(path, NULL);
    ssize_t n;

    if (fd < 0)
        return -1;
    n = read(fd, magic, DX_MCAP_MAGIC_LEN);
    close(fd);
    return n;
}

/* Of dexeld: also when nothing can be said, so that the playlist tells what it misses. */
static bool is_recording(const char *path)
{
    struct dx_mcap_reader *reader;
    struct dx_mcap_source source;
    int fd = dx_open_regular(path, NULL);
    bool is_ours = true;

    if (fd < 0)
        return true;
    if (dx_mcap_source_fd(&source, fd) == 0 &&
        dx_mcap_reader_open(&reader, &source, NULL, NULL) == 0) {
        is_ours = dx_mcap_reader_topic(reader, DX_RECORDING_TOPIC) != NULL ||
                  !dx_cloud_bag_has_clouds(reader);
        dx_mcap_reader_free(reader);
    }
    close(fd);
    return is_ours;
}

bool dx_playlist_wants(const char *path)
{
    uint8_t magic[DX_MCAP_MAGIC_LEN];
    struct dx_file_list list;
    bool wants = false;
    ssize_t n = 0;

    if (dx_file_list_init(&list, path, NULL) != 0)
        return false;
    /* what a kill has left of a file's first bytes tells nothing, nor what cannot be read */
    for (size_t k = 0; k < list.n && n < DX_MCAP_MAGIC_LEN; k++) {
        n = read_magic(magic, list.paths[k]);
        wants = n == DX_MCAP_MAGIC_LEN && dx_mcap_probe(magic, DX_MCAP_MAGIC_LEN) &&
                is_recording(list.paths[k]);
    }
    dx_file_list_fini(&list);
    return wants;
}

__attribute__((format(printf, 2, 3))) static void report(const struct dx_playlist *p,
                                                         const char *format, ...)
{
    char text[512];
    va_list args;

    if (!p->tell)
        return;
    va_start(args, format);
    vsnprintf(text, sizeof(text), format, args);
    va_end(args);
    p->tell(text);
}

/* ---- files -----------------------------------------------------------------------------------
 */

static void close_file(struct dx_playlist *p)
{
    dx_mcap_iter_free(p->iter);
    dx_mcap_reader_free(p->reader);
    if (p->fd >= 0)
        close(p->fd);
    p->iter = NULL;
    p->reader = NULL;
    p->fd = -1;
}

static int start_iter(struct dx_playlist *p)
{
    const struct dx_mcap_channel *c = dx_mcap_reader_topic(p->reader, DX_RECORDING_TOPIC);
    const uint16_t none = 0;
    const struct dx_mcap_query query = {
        .order = DX_MCAP_FILE_ORDER, .channels = c ? &c->id : &none, .n_channels = 1};

    return dx_mcap_iter_new(&p->iter, p->reader, &query);
}

static int open_file(struct dx_playlist *p, size_t k, struct dx_err *err)
{
    const char *path = p->list.paths[k];
    struct dx_mcap_source source;
    int rc;

    close_file(p);
    p->file = k;
    p->fd = dx_open_regular(path, err);
    if (p->fd < 0)
        return p->fd;
    rc = dx_mcap_source_fd(&source, p->fd);
    if (rc)
        return dx_err_set(err, rc, "%s: %s", path, strerror(-rc));
    rc = dx_mcap_reader_open(&p->reader, &source, NULL, err);
    if (rc) {
        dx_err_prefix(err, path);
        return rc;
    }
    rc = start_iter(p);
    return rc ? dx_err_set(err, rc, "%s: %s", path, strerror(-rc)) : 0;
}

/* The newest attachment of a name that was made at `time` or before; NULL: none. */
static const struct dx_mcap_item_index *find(const struct dx_playlist *p, const char *name,
                                             uint64_t time)
{
    const struct dx_mcap_item_index *item, *best = NULL;

    for (uint32_t k = 0; (item = dx_mcap_reader_attachment(p->reader, k)) != NULL; k++)
        if (dx_mcap_text_is(item->name, name) && item->log_time <= time &&
            (!best || item->log_time >= best->log_time))
            best = item;
    return best;
}

/* All files of a replay are of one stream: one decoder serves them. */
static int take_config(struct dx_playlist *p, struct dx_err *err)
{
    const struct dx_mcap_item_index *item = find(p, DX_RECORDING_CONFIG, UINT64_MAX);
    const char *path = p->list.paths[p->file];
    struct dx_mcap_attachment a;
    int rc;

    if (!item)
        return dx_err_set(err, -EBADMSG, "%s: no attachment '%s', expected a recording of dexeld",
                          path, DX_RECORDING_CONFIG);
    rc = dx_mcap_reader_read_attachment(p->reader, item, &a, err);
    if (rc) {
        dx_err_prefix(err, path);
        return rc;
    }
    if (p->config)
        return a.data.len == p->config_len && !memcmp(a.data.p, p->config, a.data.len)
                   ? 0
                   : dx_err_set(err, -EBADMSG,
                                "%s: recorded with another configuration than %s, expected files "
                                "of one stream",
                                path, p->list.paths[0]);
    p->config = malloc(a.data.len + 1);
    if (!p->config)
        return dx_err_set(err, -ENOMEM, "%s: no memory", path);
    memcpy(p->config, a.data.p, a.data.len);
    p->config_len = a.data.len;
    return 0;
}

/* Was the recorder killed before the file had anything in it, its configuration included? */
static bool is_stillborn(const struct dx_playlist *p, const struct dx_mcap_info *info)
{
    return info->n_messages == 0 && dx_mcap_reader_damages(p->reader) > 0 &&
           !find(p, DX_RECORDING_CONFIG, UINT64_MAX);
}

/* 0; 1: there is nothing in it. */
static int look_at(struct dx_playlist *p, size_t k, struct dx_err *err)
{
    uint8_t magic[DX_MCAP_MAGIC_LEN];
    struct dx_mcap_info info;
    ssize_t n = read_magic(magic, p->list.paths[k]);
    int rc;

    if (n >= 0 && n < DX_MCAP_MAGIC_LEN)
        return 1;
    rc = open_file(p, k, err);
    if (rc)
        return rc;
    dx_mcap_reader_info(p->reader, &info);
    if (is_stillborn(p, &info))
        return 1;
    p->spans[k] =
        (struct span){.start = info.start, .end = info.end, .is_empty = info.n_messages == 0};
    return take_config(p, err);
}

/* Looks at all files, and leaves out those with nothing in them: a kill -9 or a power cut at the
 * beginning of a file must not cost the others. */
static int look_at_all(struct dx_playlist *p, struct dx_err *err)
{
    size_t k = 0;

    while (k < p->list.n) {
        int rc = look_at(p, k, err);

        if (rc < 0)
            return rc;
        if (rc == 0) {
            k++;
            continue;
        }
        if (p->list.n == 1)
            return dx_err_set(err, -EBADMSG, "%s: ends before its configuration, nothing is in it",
                              p->list.paths[0]);
        report(p, "%s: ends before its configuration, passed over", p->list.paths[k]);
        dx_file_list_remove(&p->list, k);
    }
    return 0;
}

/* By the times in them, whatever their names: names need not sort as times do. An empty file goes
 * with the one before it. */
static void sort_by_time(struct dx_playlist *p)
{
    for (size_t k = 1; k < p->list.n; k++)
        if (p->spans[k].is_empty)
            p->spans[k].start = p->spans[k].end = p->spans[k - 1].end;
    for (size_t k = 1; k < p->list.n; k++) {
        struct span span = p->spans[k];
        char *path = p->list.paths[k];
        size_t i = k;

        for (; i > 0 && p->spans[i - 1].start > span.start; i--) {
            p->spans[i] = p->spans[i - 1];
            p->list.paths[i] = p->list.paths[i - 1];
        }
        p->spans[i] = span;
        p->list.paths[i] = path;
    }
}

int dx_playlist_new(struct dx_playlist **out, const char *path, void (*tell)(const char *text),
                    struct dx_err *err)
{
    struct dx_playlist *p = calloc(1, sizeof(*p));
    int rc;

    if (!p)
        return dx_err_set(err, -ENOMEM, "%s: no memory", path);
    p->fd = -1;
    p->tell = tell;
    rc = dx_file_list_init(&p->list, path, err);
    if (rc == 0) {
        p->spans = calloc(p->list.n, sizeof(*p->spans));
        if (!p->spans)
            rc = dx_err_set(err, -ENOMEM, "%s: no memory", path);
    }
    if (rc == 0)
        rc = look_at_all(p, err);
    if (rc == 0)
        sort_by_time(p);
    if (rc == 0)
        rc = open_file(p, 0, err);
    if (rc) {
        dx_playlist_free(p);
        return rc;
    }
    *out = p;
    return 0;
}

void dx_playlist_free(struct dx_playlist *p)
{
    if (!p)
        return;
    close_file(p);
    dx_file_list_fini(&p->list);
    free(p->spans);
    free(p->config);
    dx_recording_join_fini(&p->join);
    free(p);
}

const char *dx_playlist_config(const struct dx_playlist *p, size_t *len)
{
    *len = p->config_len;
    return p->config;
}

size_t dx_playlist_n_files(const struct dx_playlist *p)
{
    return p->list.n;
}

uint64_t dx_playlist_start(const struct dx_playlist *p)
{
    for (size_t k = 0; k < p->list.n; k++)
        if (!p->spans[k].is_empty)
            return p->spans[k].start;
    return 0;
}

uint64_t dx_playlist_end(const struct dx_playlist *p)
{
    uint64_t end = 0;

    for (size_t k = 0; k < p->list.n; k++)
        if (!p->spans[k].is_empty && p->spans[k].end > end)
            end = p->spans[k].end;
    return end;
}

/* ---- blocks ----------------------------------------------------------------------------------
 */

static void give(struct dx_playlist *p, struct dx_playlist_block *out, uint64_t time)
{
    p->seeking = false;
    *out = (struct dx_playlist_block){
        .block = dx_recording_joined(&p->join),
        .log_time = time,
        .starts_frame = p->join.first.flags & DX_RECORDING_STARTS_FRAME,
    };
}

/* Of the open file; once, however often it is played. */
static void tell_damage(struct dx_playlist *p)
{
    uint64_t n = dx_mcap_reader_damages(p->reader);
    const struct dx_mcap_damage *first = dx_mcap_reader_damage(p->reader, 0);

    if (n && first && !p->spans[p->file].damage_told)
        report(p, "%s: damaged in %llu places, first at byte %llu: %s", p->list.paths[p->file],
               (unsigned long long)n, (unsigned long long)first->offset, first->text);
    p->spans[p->file].damage_told |= n > 0;
}

/* The file has no more messages. 0: the next one is open. */
static int next_file(struct dx_playlist *p, struct dx_err *err)
{
    tell_damage(p);
    if (p->file + 1 < p->list.n)
        return open_file(p, p->file + 1, err);
    return DX_DRIVER_E_EOF;
}

int dx_playlist_next(struct dx_playlist *p, struct dx_playlist_block *out, struct dx_err *err)
{
    for (;;) {
        struct dx_recording_piece piece;
        struct dx_mcap_message m;
        int rc = dx_mcap_iter_next(p->iter, &m);

        if (rc == DX_MCAP_E_END) {
            rc = next_file(p, err);
            if (rc)
                return rc;
            continue;
        }
        if (rc)
            return dx_err_set(err, rc, "%s: %s", p->list.paths[p->file], strerror(-rc));
        if (dx_recording_get_piece(&piece, m.data.p, m.data.len) != 0) {
            report(p, "%s: message %u is no block", p->list.paths[p->file], m.sequence);
            continue;
        }
        rc = dx_recording_join_take(&p->join, &piece, p->seeking);
        if (rc < 0)
            return dx_err_set(err, rc, "%s: no memory for a block of %llu bytes",
                              p->list.paths[p->file], (unsigned long long)piece.block_len);
        if (rc == 1) {
            give(p, out, m.log_time);
            return 0;
        }
    }
}

int dx_playlist_seek(struct dx_playlist *p, uint64_t time, struct dx_err *err)
{
    size_t k = 0;
    int rc;

    while (k + 1 < p->list.n && (p->spans[k].is_empty || p->spans[k].end < time))
        k++;
    rc = open_file(p, k, err);
    if (rc)
        return rc;
    if (time > p->spans[k].start)
        dx_mcap_iter_seek(p->iter, time);
    dx_recording_join_drop(&p->join);
    p->seeking = true;
    return 0;
}

/* Of the open file; once, however often it is played. */
static void tell_geometry(struct dx_playlist *p, const char *text)
{
    struct span *span = &p->spans[p->file];

    if (!span->geometry_told)
        report(p,
               "%s: the geometry of its frames cannot be used, what the configuration says is "
               "taken: %s",
               p->list.paths[p->file], text);
    span->geometry_told = true;
}

bool dx_playlist_geometry(struct dx_playlist *p, uint64_t time, struct dx_geometry **g,
                          uint8_t *attr_bytes)
{
    const struct dx_mcap_item_index *item = find(p, DX_RECORDING_GEOMETRY, time);
    struct dx_mcap_attachment a;
    struct dx_err err = {""};
    int rc;

    if (!item)
        return false;
    rc = dx_mcap_reader_read_attachment(p->reader, item, &a, &err);
    if (rc == 0) {
        rc = dx_recording_get_geometry(g, attr_bytes, a.data.p, a.data.len);
        if (rc)
            dx_err_set(&err, rc, "byte %llu: %s", (unsigned long long)item->record.offset,
                       rc == -ENOMEM ? "no memory" : "no geometry");
    }
    if (rc)
        tell_geometry(p, err.text);
    return rc == 0;
}
