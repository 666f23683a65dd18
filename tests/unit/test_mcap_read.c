/* The MCAP reader: the worked file, round trips, order, seek, filters, files of other programs. */
#include "mcap_fixture.h"

#include "core/base/rng.h"

#define S UINT64_C(1000000000)

static void reads_the_worked_file(void **state)
{
    struct mem_file f = mem_copy(worked_file, sizeof(worked_file));

    (void)state;
    for (int scan = 0; scan < 2; scan++) {
        struct dx_mcap_reader *r = open_reader(&f, scan);
        struct dx_mcap_iter *it = new_iter(r, NULL);
        const struct dx_mcap_channel *c = dx_mcap_reader_topic(r, "/a");
        struct dx_mcap_info info;
        struct dx_mcap_message m;

        dx_mcap_reader_info(r, &info);
        assert_int_equal(info.indexed, !scan);
        assert_string_equal(info.library, "dexeld");
        assert_string_equal(info.profile, "");
        assert_int_equal(info.n_messages, 1);
        assert_int_equal(info.start, 1000);
        assert_int_equal(info.end, 1000);
        assert_int_equal(info.n_chunks, 1);
        assert_non_null(c);
        assert_true(dx_mcap_text_is(c->message_encoding, "json"));
        assert_true(dx_mcap_text_is(dx_mcap_reader_find_schema(r, c->schema_id)->name, "t"));
        assert_int_equal(dx_mcap_reader_count(r, c->id), 1);
        assert_int_equal(dx_mcap_iter_next(it, &m), 0);
        assert_int_equal(m.sequence, 7);
        assert_int_equal(m.log_time, 1000);
        assert_memory_equal(m.data.p, "{}", 2);
        assert_int_equal(dx_mcap_iter_next(it, &m), DX_MCAP_E_END);
        assert_int_equal(dx_mcap_iter_next(it, &m), DX_MCAP_E_END);
        expect_sound(r);
        dx_mcap_iter_free(it);
        dx_mcap_reader_free(r);
    }
    mem_free(&f);
}

/* ---- round trips ------------------------------------------------------------------------------
 */

enum { N = 500 };

/* Two channels whose stamps overlap: that of 4 is behind by up to 20 messages. */
static uint64_t time_of(uint32_t k)
{
    return k % 2 ? (uint64_t)k * 1000 : (uint64_t)(k > 20 ? k - 20 : 0) * 1000 + 1;
}

static void write_two_channels(struct mem_file *f, enum dx_mcap_compression compression)
{
    struct dx_mcap_writer_config c = small_config(compression);
    const struct dx_mcap_attachment a = {5, 6, dx_mcap_text("calibration"),
                                         dx_mcap_text("application/json"), bytes_of("{\"a\": 1}")};
    const struct dx_mcap_sink sink = mem_sink(f);
    const struct dx_mcap_pair pairs[] = {{dx_mcap_text("serial"), dx_mcap_text("0042")},
                                         {dx_mcap_text("site"), dx_mcap_text("")}};
    uint8_t map[100];
    struct dx_writer out = dx_writer_init(map, sizeof(map));
    struct dx_mcap_metadata m = {.name = dx_mcap_text("device")};
    struct dx_mcap_writer *w;

    c.index_len = 1 << 16;
    w = new_writer(&c);
    declare(w, 1, true);
    declare(w, 4, true);
    dx_mcap_put_pairs(&out, pairs, 2);
    m.map = (struct dx_mcap_bytes){map, (size_t)(out.p - map)};
    assert_int_equal(dx_mcap_writer_begin(w, &sink), 0);
    assert_int_equal(dx_mcap_writer_metadata(w, &m), 0);
    for (uint32_t k = 0; k < N; k++) {
        assert_int_equal(put(w, k % 2 ? 1 : 4, k, time_of(k)), 0);
        if (k == N / 2)
            assert_int_equal(dx_mcap_writer_attachment(w, &a), 0);
    }
    assert_int_equal(dx_mcap_writer_finish(w), 0);
    dx_mcap_writer_free(w);
}

static void check_items(struct dx_mcap_reader *r)
{
    const struct dx_mcap_item_index *item = dx_mcap_reader_attachment(r, 0);
    struct dx_mcap_attachment a;
    struct dx_mcap_metadata m;
    struct dx_mcap_pair pair;
    struct dx_reader map;
    struct dx_err err;

    assert_non_null(item);
    assert_true(dx_mcap_text_is(item->name, "calibration"));
    assert_int_equal(item->data_len, 8);
    assert_null(dx_mcap_reader_attachment(r, 1));
    assert_int_equal(dx_mcap_reader_read_attachment(r, item, &a, &err), 0);
    assert_int_equal(a.create_time, 6);
    assert_int_equal(a.data.len, 8);
    assert_memory_equal(a.data.p, "{\"a\": 1}", 8);
    item = dx_mcap_reader_metadata(r, 0);
    assert_non_null(item);
    assert_int_equal(dx_mcap_reader_read_metadata(r, item, &m, &err), 0);
    assert_true(dx_mcap_text_is(m.name, "device"));
    map = dx_reader_init(m.map.p, m.map.len);
    assert_int_equal(dx_mcap_next_pair(&pair, &map), 0);
    assert_true(dx_mcap_text_is(pair.key, "serial") && dx_mcap_text_is(pair.value, "0042"));
    assert_int_equal(dx_mcap_next_pair(&pair, &map), 0);
    assert_int_equal(dx_mcap_next_pair(&pair, &map), DX_MCAP_E_END);
}

static void check_order(struct dx_mcap_reader *r)
{
    const struct dx_mcap_query in_file = {.order = DX_MCAP_FILE_ORDER};
    uint32_t got[N], n = read_sequences(r, &in_file, got, N);

    assert_int_equal(n, N);
    for (uint32_t k = 0; k < N; k++)
        assert_int_equal(got[k], k);
    n = read_sequences(r, NULL, got, N);
    assert_int_equal(n, N);
    for (uint32_t k = 1; k < N; k++)
        assert_true(time_of(got[k - 1]) < time_of(got[k]) ||
                    (time_of(got[k - 1]) == time_of(got[k]) && got[k - 1] < got[k]));
}

static void round_trips_in_every_compression(void **state)
{
    (void)state;
    for (enum dx_mcap_compression c = 0; c < DX_MCAP_N_COMPRESSIONS; c++)
        for (int scan = 0; scan < 2; scan++) {
            struct mem_file f = mem_new();
            struct dx_mcap_reader *r;
            struct dx_mcap_info info;

            write_two_channels(&f, c);
            r = open_reader(&f, scan);
            dx_mcap_reader_info(r, &info);
            assert_int_equal(info.indexed, !scan);
            assert_int_equal(info.n_messages, N);
            assert_true(info.n_chunks > 50);
            assert_int_equal(info.n_of[c], info.n_chunks);
            assert_int_equal(dx_mcap_reader_count(r, 1), N / 2);
            assert_int_equal(info.start, 1);
            assert_int_equal(info.end, time_of(N - 1));
            check_order(r);
            check_items(r);
            expect_sound(r);
            dx_mcap_reader_free(r);
            mem_free(&f);
        }
}

/* What a query must give, from all the messages. */
static uint32_t expected(const struct dx_mcap_query *q, uint32_t *out)
{
    uint32_t n = 0;

    for (uint32_t k = 0; k < N; k++) {
        bool wanted = !q->channels;

        for (size_t c = 0; c < q->n_channels; c++)
            wanted = wanted || q->channels[c] == (k % 2 ? 1 : 4);
        if (wanted && time_of(k) >= q->start && (q->end == 0 || time_of(k) < q->end))
            out[n++] = k;
    }
    return n;
}

static int by_number(const void *a, const void *b)
{
    return *(const uint32_t *)a < *(const uint32_t *)b
               ? -1
               : *(const uint32_t *)a > *(const uint32_t *)b;
}

static void filters_by_time_and_channel(void **state)
{
    static const uint16_t first[] = {1}, both[] = {4, 1}, none[] = {77};
    struct mem_file f = mem_new();
    struct dx_rng rng = dx_rng_init(7, 7);
    struct dx_mcap_reader *r;

    (void)state;
    write_two_channels(&f, DX_MCAP_LZ4);
    r = open_reader(&f, false);
    for (int k = 0; k < 200; k++) {
        const uint16_t *channels[] = {NULL, first, both, none};
        struct dx_mcap_query q = {.start = dx_rng_u64(&rng) % (N * 1000),
                                  .channels = channels[k % 4],
                                  .n_channels = k % 4 == 2 ? 2 : 1};
        uint32_t got[N], want[N], n;

        q.end = k % 3 ? q.start + dx_rng_u64(&rng) % (N * 500) : 0;
        n = read_sequences(r, &q, got, N);
        qsort(got, n, sizeof(got[0]), by_number);
        assert_int_equal(n, expected(&q, want));
        if (n)
            assert_memory_equal(got, want, n * sizeof(got[0]));
    }
    expect_sound(r);
    dx_mcap_reader_free(r);
    mem_free(&f);
}

static void seeks_both_ways(void **state)
{
    struct mem_file f = mem_new();
    struct dx_rng rng = dx_rng_init(8, 8);
    struct dx_mcap_reader *r;
    struct dx_mcap_iter *it, *other;

    (void)state;
    write_two_channels(&f, DX_MCAP_ZSTD);
    r = open_reader(&f, false);
    it = new_iter(r, NULL);
    other = new_iter(r, NULL);
    for (int k = 0; k < 200; k++) {
        uint64_t start = dx_rng_u64(&rng) % (N * 1000), first = UINT64_MAX, last = 0;
        struct dx_mcap_message m;

        for (uint32_t i = 0; i < N; i++)
            if (time_of(i) >= start && time_of(i) < first)
                first = time_of(i);
        dx_mcap_iter_seek(it, start);
        for (uint64_t i = dx_rng_u64(&rng) % 30; first != UINT64_MAX && i > 0; i--) {
            if (dx_mcap_iter_next(it, &m) != 0)
                break;
            check_data(&m);
            assert_true(last ? m.log_time >= last : m.log_time == first);
            last = m.log_time;
        }
        if (dx_mcap_iter_next(other, &m) == 0) /* a second iterator is in nobody's way */
            check_data(&m);
    }
    dx_mcap_iter_free(it);
    dx_mcap_iter_free(other);
    dx_mcap_reader_free(r);
    mem_free(&f);
}

/* ---- what other programs write ----------------------------------------------------------------
 */

static void add(struct dx_writer *w, const void *bytes, size_t len)
{
    dx_write_bytes(w, bytes, len);
}

static void add_message(struct dx_writer *w, uint16_t channel, uint32_t sequence, uint64_t time)
{
    uint8_t data[301];
    struct dx_mcap_message m = {
        channel, sequence, time, time / 2, {data, fill_data(data, sequence)}};

    dx_mcap_put_message(w, &m);
}

/* Messages outside of chunks, unknown records, a chunk without a CRC, fields of a later version; no
 * index, no CRCs, and no footer's summary. */
static size_t make_foreign(uint8_t *bytes, size_t room)
{
    const struct dx_mcap_channel c = {.id = 0, .topic = dx_mcap_text("/zero")};
    uint8_t records[2000], *record;
    struct dx_writer w = dx_writer_init(bytes, room),
                     inner = dx_writer_init(records, sizeof(records));
    struct dx_mcap_chunk chunk = {.start = 20, .end = 30};

    add(&w, dx_mcap_magic, DX_MCAP_MAGIC_LEN);
    dx_mcap_put_header(&w, "x-other", "another program");
    record = dx_mcap_record_begin(&w, (enum dx_mcap_op)0x90);
    add(&w, "private", 7);
    dx_mcap_record_end(&w, record);
    dx_mcap_put_channel(&w, &c);
    add_message(&w, 0, 1, 50);
    add_message(&w, 0, 2, 10);
    record = dx_mcap_record_begin(&w, (enum dx_mcap_op)0x10);
    dx_mcap_record_end(&w, record);
    record = dx_mcap_record_begin(&inner, (enum dx_mcap_op)0x11);
    add(&inner, "?", 1);
    dx_mcap_record_end(&inner, record);
    add_message(&inner, 0, 3, 30);
    add_message(&inner, 0, 4, 20);
    chunk.records = (struct dx_mcap_bytes){records, (size_t)(inner.p - records)};
    chunk.uncompressed_len = chunk.records.len;
    dx_mcap_put_chunk_head(&w, &chunk);
    add(&w, records, chunk.records.len);
    add_message(&w, 0, 5, 40);
    record = dx_mcap_record_begin(&w, DX_MCAP_DATA_END);
    dx_write_u32(&w, 0);
    dx_mcap_record_end(&w, record);
    record = dx_mcap_record_begin(&w, DX_MCAP_FOOTER);
    dx_write_u64(&w, 0);
    dx_write_u64(&w, 0);
    dx_write_u32(&w, 0);
    dx_mcap_record_end(&w, record);
    add(&w, dx_mcap_magic, DX_MCAP_MAGIC_LEN);
    assert_false(w.failed || inner.failed);
    return (size_t)(w.p - bytes);
}

static void reads_files_without_index(void **state)
{
    static const uint32_t by_time[] = {2, 4, 3, 5, 1}, in_file[] = {1, 2, 3, 4, 5};
    const struct dx_mcap_query file_order = {.order = DX_MCAP_FILE_ORDER};
    uint8_t bytes[4000];
    struct mem_file f = mem_copy(bytes, make_foreign(bytes, sizeof(bytes)));
    struct dx_mcap_reader *r = open_reader(&f, false);
    struct dx_mcap_info info;
    uint32_t got[5];

    (void)state;
    dx_mcap_reader_info(r, &info);
    assert_false(info.indexed);
    assert_string_equal(info.profile, "x-other");
    assert_int_equal(info.n_messages, 5);
    assert_int_equal(info.n_chunks, 1);
    assert_int_equal(dx_mcap_reader_count(r, 0), 5);
    assert_int_equal(read_sequences(r, NULL, got, 5), 5);
    assert_memory_equal(got, by_time, sizeof(got));
    assert_int_equal(read_sequences(r, &file_order, got, 5), 5);
    assert_memory_equal(got, in_file, sizeof(got));
    expect_sound(r);
    dx_mcap_reader_free(r);
    mem_free(&f);
}

/* More overlapping chunks than the cache has slots: all are merged, each message once. */
static void merges_more_chunks_than_it_keeps(void **state)
{
    enum { CHUNKS = 40, EACH = 10 };
    struct dx_mcap_writer_config c = small_config(DX_MCAP_LZ4);
    struct mem_file f = mem_new();
    const struct dx_mcap_sink sink = mem_sink(&f);
    struct dx_mcap_writer *w;
    struct dx_mcap_reader *r;
    uint32_t got[CHUNKS * EACH];

    (void)state;
    c.index_len = 1 << 16;
    c.chunk_len = 60000;
    w = new_writer(&c);
    declare(w, 1, true);
    assert_int_equal(dx_mcap_writer_begin(w, &sink), 0);
    for (uint32_t chunk = 0; chunk < CHUNKS; chunk++) {
        for (uint32_t k = 0; k < EACH; k++)
            assert_int_equal(put(w, 1, k * CHUNKS + chunk, k * CHUNKS + chunk), 0);
        assert_int_equal(dx_mcap_writer_flush(w), 0);
    }
    assert_int_equal(dx_mcap_writer_finish(w), 0);
    r = open_reader(&f, false);
    assert_int_equal(read_sequences(r, NULL, got, CHUNKS * EACH), CHUNKS * EACH);
    for (uint32_t k = 0; k < CHUNKS * EACH; k++)
        assert_int_equal(got[k], k);
    expect_sound(r);
    dx_mcap_reader_free(r);
    dx_mcap_writer_free(w);
    mem_free(&f);
}

enum { WIDE_CHUNKS = 18, WIDE_EACH = 120, WIDE_LEN = 8000 };

/* Chunks more than the cache has slots, their messages interleaved: each needs another chunk. */
static void write_interleaved(struct mem_file *f)
{
    static const uint8_t zeros[WIDE_LEN];
    struct dx_mcap_writer_config c = small_config(DX_MCAP_LZ4);
    const struct dx_mcap_sink sink = mem_sink(f);
    struct dx_mcap_writer *w;

    c.index_len = 1 << 16;
    c.chunk_len = 1000000;
    c.max_message = WIDE_LEN;
    c.max_messages = 2 * WIDE_EACH;
    w = new_writer(&c);
    declare(w, 1, true);
    assert_int_equal(dx_mcap_writer_begin(w, &sink), 0);
    for (uint32_t k = 0; k < WIDE_CHUNKS * WIDE_EACH; k++) {
        uint32_t at = k % WIDE_EACH * WIDE_CHUNKS + k / WIDE_EACH;
        const struct dx_mcap_message m = {1, at, at, at, {zeros, WIDE_LEN}};

        assert_int_equal(dx_mcap_writer_message(w, &m), 0);
        if ((k + 1) % WIDE_EACH == 0)
            assert_int_equal(dx_mcap_writer_flush(w), 0);
    }
    assert_int_equal(dx_mcap_writer_finish(w), 0);
    dx_mcap_writer_free(w);
}

/* What a small file makes the reader decompress has a bound in order of log time, and in the file's
 * order it is what the file has. */
static void gives_up_chunks_that_overlap_too_much(void **state)
{
    const struct dx_mcap_query in_file = {.order = DX_MCAP_FILE_ORDER};
    struct mem_file f = mem_new();
    struct dx_mcap_message m;
    struct dx_mcap_reader *r;
    struct dx_mcap_iter *it;
    uint32_t n = 0;
    int rc;

    (void)state;
    write_interleaved(&f);
    r = open_reader(&f, false);
    it = new_iter(r, &in_file);
    while ((rc = dx_mcap_iter_next(it, &m)) == 0)
        n++;
    assert_int_equal(rc, DX_MCAP_E_END);
    assert_int_equal(n, WIDE_CHUNKS * WIDE_EACH);
    dx_mcap_iter_free(it);

    it = new_iter(r, NULL);
    for (n = 0; (rc = dx_mcap_iter_next(it, &m)) == 0; n++)
        assert_int_equal(m.sequence, n);
    assert_int_equal(rc, -E2BIG);
    assert_in_range(n, DX_MCAP_MAX_AGAIN / 1000000, WIDE_CHUNKS * WIDE_EACH - 1);
    assert_non_null(strstr(dx_mcap_iter_why(it, rc), "overlap"));
    assert_int_equal(dx_mcap_iter_next(it, &m), -E2BIG);
    expect_sound(r);
    dx_mcap_iter_free(it);
    dx_mcap_reader_free(r);
    mem_free(&f);
}

static void an_empty_recording_is_whole(void **state)
{
    const struct dx_mcap_writer_config c = small_config(DX_MCAP_ZSTD);
    struct mem_file f = mem_new();
    const struct dx_mcap_sink sink = mem_sink(&f);
    struct dx_mcap_writer *w = new_writer(&c);
    uint32_t got[1];

    (void)state;
    assert_int_equal(dx_mcap_writer_begin(w, &sink), 0);
    assert_int_equal(dx_mcap_writer_finish(w), 0);
    for (int scan = 0; scan < 2; scan++) {
        struct dx_mcap_reader *r = open_reader(&f, scan);

        assert_int_equal(read_sequences(r, NULL, got, 1), 0);
        expect_sound(r);
        dx_mcap_reader_free(r);
    }
    dx_mcap_writer_free(w);
    mem_free(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reads_the_worked_file),
        cmocka_unit_test(round_trips_in_every_compression),
        cmocka_unit_test(filters_by_time_and_channel),
        cmocka_unit_test(seeks_both_ways),
        cmocka_unit_test(reads_files_without_index),
        cmocka_unit_test(merges_more_chunks_than_it_keeps),
        cmocka_unit_test(gives_up_chunks_that_overlap_too_much),
        cmocka_unit_test(an_empty_recording_is_whole),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
