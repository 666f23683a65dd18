/*
 * For tests of the recorder: a disk in memory that can be full, absent or short of room, blocks
 * that tell who they are, and a look at all that was recorded.
 */
#ifndef DX_RECORDER_FIXTURE_H
#define DX_RECORDER_FIXTURE_H

#include "mcap_fixture.h"

#include "daemon/clock.h"
#include "daemon/log.h"
#include "daemon/recorder.h"

#define MAX_FILES 64

struct disk {
    struct mem_file files[MAX_FILES];
    unsigned n_files;
    int create_error; /* 0: files can be made */
    bool is_open;
    char path[32];
};

static inline int disk_create(void *ctx, struct dx_mcap_sink *sink, const char **path,
                              uint64_t unix_ns)
{
    struct disk *d = ctx;

    (void)unix_ns;
    snprintf(d->path, sizeof(d->path), "file %u", d->n_files);
    *path = d->path;
    if (d->create_error)
        return d->create_error;
    assert_false(d->is_open);
    assert_true(d->n_files < MAX_FILES);
    d->files[d->n_files] = mem_new();
    *sink = mem_sink(&d->files[d->n_files++]);
    d->is_open = true;
    return 0;
}

static inline int disk_sync(void *ctx)
{
    const struct disk *d = ctx;

    assert_true(d->is_open);
    return 0;
}

static inline void disk_close(void *ctx)
{
    struct disk *d = ctx;

    d->is_open = false;
}

static inline struct mem_file *newest(struct disk *d)
{
    assert_true(d->n_files > 0);
    return &d->files[d->n_files - 1];
}

static inline void disk_free(struct disk *d)
{
    for (unsigned k = 0; k < d->n_files; k++)
        mem_free(&d->files[k]);
}

#define YAML "streams: [{name: t, synthetic: {}}]\n"

static inline struct dx_recorder_config recorder_config(struct disk *d)
{
    return (struct dx_recorder_config){.name = "t",
                                       .driver = "synthetic",
                                       .yaml = YAML,
                                       .yaml_len = strlen(YAML),
                                       .store = {d, disk_create, disk_sync, disk_close},
                                       .ring_len = 1 << 16,
                                       .compression = DX_MCAP_NONE,
                                       .start = true};
}

static inline struct dx_recorder *new_recorder(const struct dx_recorder_config *config)
{
    struct dx_recorder *r = NULL;
    struct dx_err err = {""};

    dx_log_set_level(-1); /* nothing */
    if (dx_recorder_new(&r, config, &err) < 0)
        fail_msg("%s", err.text);
    return r;
}

/* The bytes of block `number`. */
static inline uint8_t byte_of(uint64_t number, size_t k)
{
    return (uint8_t)(number * 31 + k + k / 251);
}

#define HOST_NS(number) (1000000000u + (number)*1000000u)

/* Block `number` of `len` bytes. */
static inline void feed(struct dx_recorder *r, uint64_t number, size_t len, bool starts_frame)
{
    static uint8_t bytes[1 << 20];
    const struct dx_block block = {.bytes = len ? bytes : NULL,
                                   .len = len,
                                   .stamp = {HOST_NS(number), number * 7, DX_CLOCK_DEVICE},
                                   .number = number,
                                   .source = "the device"};

    assert_true(len <= sizeof(bytes));
    for (size_t k = 0; k < len; k++)
        bytes[k] = byte_of(number, k);
    dx_recorder_feed(r, &block, starts_frame);
}

static inline uint64_t dropped(struct dx_recorder *r)
{
    struct dx_recorder_status s;

    dx_recorder_status(r, &s);
    return s.n_dropped;
}

/* ---- what was recorded -----------------------------------------------------------------------
 */

struct seen {
    uint64_t n_blocks, first, next; /* numbers */
    uint64_t n_missing, n_told;     /* between blocks; by gaps */
    uint64_t offset;                /* in the block under way */
    uint64_t n_starts;              /* blocks that start a frame */
    bool first_starts_frame;        /* of the file looked at last */
    uint64_t last_len;              /* of the last block */
};

static inline void see_message(struct seen *s, const struct dx_mcap_message *m, bool first_of_file)
{
    struct dx_recording_piece p;

    assert_int_equal(dx_recording_get_piece(&p, m->data.p, m->data.len), 0);
    assert_int_equal(p.offset, s->offset);
    assert_int_equal(p.device_ns, p.number * 7);
    assert_int_equal(p.clock_id, DX_CLOCK_DEVICE);
    if (p.offset == 0) {
        assert_int_equal(p.source_len, strlen("the device"));
        assert_memory_equal(p.source, "the device", p.source_len);
    }
    for (size_t k = 0; k < p.len; k++)
        if (p.bytes[k] != byte_of(p.number, p.offset + k))
            fail_msg("block %u is altered", (unsigned)p.number);
    if (first_of_file)
        s->first_starts_frame = p.offset == 0 && (p.flags & DX_RECORDING_STARTS_FRAME);
    if (s->n_blocks == 0)
        s->first = s->next = p.number;
    assert_true(p.number >= s->next);
    s->n_missing += p.number - s->next;
    s->next = p.number;
    s->offset = p.offset + p.len;
    if (s->offset < p.block_len)
        return;
    s->n_starts += p.flags & DX_RECORDING_STARTS_FRAME;
    s->last_len = p.block_len;
    s->offset = 0;
    s->next++;
    s->n_blocks++;
}

static inline void see_gaps(struct seen *s, struct dx_mcap_reader *r)
{
    const struct dx_mcap_item_index *item;
    struct dx_mcap_metadata m;
    struct dx_mcap_pair pair;

    for (uint32_t k = 0; (item = dx_mcap_reader_metadata(r, k)) != NULL; k++) {
        struct dx_reader map;
        char text[24];

        assert_true(dx_mcap_text_is(item->name, DX_RECORDING_GAP));
        assert_int_equal(dx_mcap_reader_read_metadata(r, item, &m, NULL), 0);
        map = dx_reader_init(m.map.p, m.map.len);
        assert_int_equal(dx_mcap_next_pair(&pair, &map), 0);
        assert_true(dx_mcap_text_is(pair.key, "blocks"));
        dx_mcap_text_copy(text, sizeof(text), pair.value);
        s->n_told += strtoull(text, NULL, 10);
    }
}

/* Adds a file, which is `whole` with its index, or not finished. Returns its attachments. */
static inline uint32_t see_file(struct seen *s, struct mem_file *f, bool whole)
{
    const struct dx_mcap_query query = {.order = DX_MCAP_FILE_ORDER};
    struct dx_mcap_reader *r = open_reader(f, false);
    struct dx_mcap_iter *it = new_iter(r, &query);
    struct dx_mcap_attachment a;
    struct dx_mcap_message m;
    struct dx_mcap_info info;
    bool first = true;
    uint32_t n = 0;
    int rc;

    dx_mcap_reader_info(r, &info);
    assert_int_equal(info.indexed, whole);
    while ((rc = dx_mcap_iter_next(it, &m)) == 0) {
        see_message(s, &m, first);
        first = false;
    }
    assert_int_equal(rc, DX_MCAP_E_END);
    if (whole)
        assert_int_equal(dx_mcap_reader_damages(r), 0);
    see_gaps(s, r);
    while (dx_mcap_reader_attachment(r, n))
        n++;
    assert_true(n > 0);
    assert_int_equal(dx_mcap_reader_read_attachment(r, dx_mcap_reader_attachment(r, 0), &a, NULL),
                     0);
    assert_true(dx_mcap_text_is(a.name, DX_RECORDING_CONFIG));
    assert_int_equal(a.data.len, strlen(YAML));
    assert_memory_equal(a.data.p, YAML, a.data.len);
    dx_mcap_iter_free(it);
    dx_mcap_reader_free(r);
    return n;
}

/* All files, finished. */
static inline struct seen see(struct disk *d)
{
    struct seen s = {0};

    assert_false(d->is_open);
    for (unsigned k = 0; k < d->n_files; k++)
        see_file(&s, &d->files[k], true);
    return s;
}

/* Its thread, in this one: all that was fed is written, the file finished. */
static inline void finish(struct dx_recorder *r)
{
    dx_recorder_stop(r, true);
    dx_recorder_run(r);
}

#endif
