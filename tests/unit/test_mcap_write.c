/* The MCAP writer: its bytes, when chunks close, bounds, and a sink that fails at any byte. */
#include "mcap_fixture.h"

static void write_worked(struct mem_file *f)
{
    const struct dx_mcap_writer_config config = {.max_message = 1000, .library = "dexeld"};
    const struct dx_mcap_schema schema = {1, dx_mcap_text("t"), dx_mcap_text("jsonschema"),
                                          bytes_of("{}")};
    const struct dx_mcap_channel channel = {.id = 1,
                                            .schema_id = 1,
                                            .topic = dx_mcap_text("/a"),
                                            .message_encoding = dx_mcap_text("json")};
    const struct dx_mcap_message m = {1, 7, 1000, 1000, bytes_of("{}")};
    const struct dx_mcap_sink sink = mem_sink(f);
    struct dx_mcap_writer *w = new_writer(&config);

    assert_int_equal(dx_mcap_writer_schema(w, &schema), 0);
    assert_int_equal(dx_mcap_writer_channel(w, &channel), 0);
    assert_int_equal(dx_mcap_writer_begin(w, &sink), 0);
    assert_int_equal(dx_mcap_writer_message(w, &m), 0);
    assert_int_equal(dx_mcap_writer_finish(w), 0);
    dx_mcap_writer_free(w);
}

static void writes_the_worked_file(void **state)
{
    struct mem_file f = mem_new();

    (void)state;
    write_worked(&f);
    assert_int_equal(f.len, sizeof(worked_file));
    assert_memory_equal(f.bytes, worked_file, sizeof(worked_file));
    mem_free(&f);
}

static uint32_t n_chunks_of(struct mem_file *f)
{
    struct dx_mcap_reader *r = open_reader(f, true);
    struct dx_mcap_info info;

    expect_sound(r);
    dx_mcap_reader_info(r, &info);
    dx_mcap_reader_free(r);
    return info.n_chunks;
}

/* Writes messages at these times, of `len` bytes each, and tells how many chunks they made. */
static uint32_t chunks_made(const struct dx_mcap_writer_config *config, const uint64_t *times,
                            uint32_t n, size_t len)
{
    struct mem_file f = mem_new();
    const struct dx_mcap_sink sink = mem_sink(&f);
    struct dx_mcap_writer *w = new_writer(config);
    uint8_t *data = calloc(1, len);
    uint32_t n_chunks;

    declare(w, 1, false);
    assert_int_equal(dx_mcap_writer_begin(w, &sink), 0);
    for (uint32_t k = 0; k < n; k++) {
        const struct dx_mcap_message m = {1, k, times[k], times[k], {data, len}};

        assert_int_equal(dx_mcap_writer_message(w, &m), 0);
    }
    assert_int_equal(dx_mcap_writer_finish(w), 0);
    n_chunks = n_chunks_of(&f);
    dx_mcap_writer_free(w);
    mem_free(&f);
    free(data);
    return n_chunks;
}

static void chunks_close_by_time_bytes_and_count(void **state)
{
    const uint64_t s = 1000000000, within[] = {5, s / 2, s + 4}, beyond[] = {5, s / 2, s + 5},
                   back[] = {2 * s, s + 1, s}, same[120] = {0};
    struct dx_mcap_writer_config c = small_config(DX_MCAP_NONE);
    /* a message of 100 bytes is 131; its channel is 33 */
    const uint32_t per_chunk = (1000 - 33) / 131;

    (void)state;
    c.chunk_ns = 0;
    assert_int_equal(chunks_made(&c, within, 3, 10), 1);
    assert_int_equal(chunks_made(&c, beyond, 3, 10), 2);
    assert_int_equal(chunks_made(&c, back, 3, 10), 2);
    assert_int_equal(chunks_made(&c, same, per_chunk, 100), 1);
    assert_int_equal(chunks_made(&c, same, per_chunk + 1, 100), 2);
    assert_int_equal(chunks_made(&c, same, 3, 4000), 3); /* larger than the target: one each */
    c.chunk_len = 100000;
    assert_int_equal(chunks_made(&c, same, 100, 1), 1);
    assert_int_equal(chunks_made(&c, same, 101, 1), 2);
}

static void refuses_what_it_has_no_room_for(void **state)
{
    struct mem_file f = mem_new();
    const struct dx_mcap_sink sink = mem_sink(&f);
    struct dx_mcap_writer_config c = small_config(DX_MCAP_LZ4);
    struct dx_mcap_writer *w = new_writer(&c), *none = NULL;
    uint8_t data[4001] = {0};
    char name[2000];
    const struct dx_mcap_message large = {1, 0, 0, 0, {data, 4001}};
    const struct dx_mcap_channel other = {.id = 1, .topic = dx_mcap_text("/other")},
                                 orphan = {.id = 2, .schema_id = 9},
                                 long_one = {.id = 2, .topic = {name, sizeof(name)}};
    const struct dx_mcap_metadata bad_name = {.name = {name, 1025}};
    struct dx_err err;

    (void)state;
    memset(name, 'x', sizeof(name));
    declare(w, 1, false);
    declare(w, 1, false); /* the same again is fine */
    assert_int_equal(dx_mcap_writer_channel(w, &other), -EEXIST);
    assert_int_equal(dx_mcap_writer_channel(w, &orphan), -ENOENT);
    assert_int_equal(dx_mcap_writer_channel(w, &long_one), -E2BIG);
    assert_int_equal(dx_mcap_writer_begin(w, &sink), 0);
    assert_int_equal(dx_mcap_writer_message(w, &large), -EMSGSIZE);
    assert_int_equal(put(w, 3, 0, 0), -ENOENT);
    assert_int_equal(dx_mcap_writer_metadata(w, &bad_name), -EINVAL);
    c.max_message = DX_MCAP_MAX_CHUNK;
    assert_int_equal(dx_mcap_writer_new(&none, &c, &err), -EINVAL);
    dx_mcap_writer_free(w);
    mem_free(&f);
}

/* The index is full: what was taken can be finished, and the next file takes up where it ended. */
static void a_full_index_ends_the_file(void **state)
{
    struct mem_file f[2] = {mem_new(), mem_new()};
    const struct dx_mcap_sink sinks[2] = {mem_sink(&f[0]), mem_sink(&f[1])};
    struct dx_mcap_writer_config c = small_config(DX_MCAP_NONE);
    struct dx_mcap_writer *w = new_writer(&c);
    uint32_t taken = 0, got[200], n = 0;
    int rc;

    (void)state;
    declare(w, 1, true);
    assert_int_equal(dx_mcap_writer_begin(w, &sinks[0]), 0);
    while ((rc = put(w, 1, taken, taken * c.chunk_ns)) == 0 && taken < 150) {
        assert_int_equal(dx_mcap_writer_flush(w), 0);
        taken++;
    }
    assert_int_equal(rc, DX_MCAP_E_FULL);
    assert_in_range(taken, 10, 60);
    assert_int_equal(dx_mcap_writer_finish(w), 0);
    assert_int_equal(dx_mcap_writer_begin(w, &sinks[1]), 0);
    assert_int_equal(put(w, 1, taken, 5), 0);
    assert_int_equal(dx_mcap_writer_finish(w), 0);
    for (int k = 0; k < 2; k++) {
        struct dx_mcap_reader *r = open_reader(&f[k], false);
        struct dx_mcap_info info;

        dx_mcap_reader_info(r, &info);
        assert_true(info.indexed);
        assert_int_equal(info.n_messages, k == 0 ? taken : 1);
        n += read_sequences(r, NULL, got + n, 200 - n);
        expect_sound(r);
        dx_mcap_reader_free(r);
        mem_free(&f[k]);
    }
    assert_int_equal(n, taken + 1);
    for (uint32_t k = 0; k < n; k++)
        assert_int_equal(got[k], k);
    dx_mcap_writer_free(w);
}

/* ---- a sink that fails ------------------------------------------------------------------------
 */

enum { N_MESSAGES = 24 };

/* Writes all, with an attachment in the middle; on an error makes room and tries again, having cut
 * the torn bytes off where `recover`. Returns how many calls failed. */
static unsigned write_stubbornly(struct dx_mcap_writer *w, struct mem_file *f, bool recover)
{
    const struct dx_mcap_sink sink = mem_sink(f);
    const struct dx_mcap_attachment a = {1, 2, dx_mcap_text("config"), dx_mcap_text("text/plain"),
                                         bytes_of("stream: roof\n")};
    unsigned n_failed = 0;

    for (int k = -1; k <= N_MESSAGES + 1;) {
        int rc = k < 0             ? dx_mcap_writer_begin(w, &sink)
                 : k == N_MESSAGES ? dx_mcap_writer_attachment(w, &a)
                 : k > N_MESSAGES  ? dx_mcap_writer_finish(w)
                                   : put(w, k % 2 ? 1 : 4, (uint32_t)k, (uint64_t)k * 1000);

        if (rc == 0) {
            k++;
            continue;
        }
        assert_int_equal(rc, -ENOSPC);
        n_failed++;
        assert_true(dx_mcap_writer_progress(w).len <= f->len);
        if (recover) {
            assert_int_equal(dx_mcap_writer_recover(w), 0);
            assert_int_equal(f->len, dx_mcap_writer_progress(w).len);
        }
        f->budget = UINT64_MAX;
    }
    return n_failed;
}

/* Wherever the disk fills up, the file is in the end the same, byte for byte. */
static void a_full_disk_loses_nothing(void **state)
{
    const struct dx_mcap_writer_config c = small_config(DX_MCAP_ZSTD);
    struct dx_mcap_writer *w = new_writer(&c);
    struct mem_file whole = mem_new();

    (void)state;
    declare(w, 1, true);
    declare(w, 4, false);
    assert_int_equal(write_stubbornly(w, &whole, false), 0);
    assert_true(n_chunks_of(&whole) >= 4);
    for (size_t room = 0; room < whole.len; room++) {
        struct mem_file f = mem_new();

        f.budget = room;
        assert_int_equal(write_stubbornly(w, &f, room % 2), 1);
        assert_int_equal(f.len, whole.len);
        assert_memory_equal(f.bytes, whole.bytes, whole.len);
        mem_free(&f);
    }
    mem_free(&whole);
    dx_mcap_writer_free(w);
}

/* A recorder that gives up the open chunk: the rest is a whole file. */
static void a_dropped_chunk_is_missing_and_nothing_else(void **state)
{
    const struct dx_mcap_writer_config c = small_config(DX_MCAP_NONE);
    struct dx_mcap_writer *w = new_writer(&c);
    struct mem_file f = mem_new();
    const struct dx_mcap_sink sink = mem_sink(&f);
    struct dx_mcap_reader *r;
    uint32_t got[8], n;

    (void)state;
    declare(w, 1, true);
    assert_int_equal(dx_mcap_writer_begin(w, &sink), 0);
    assert_int_equal(put(w, 1, 1, 10), 0);
    assert_int_equal(dx_mcap_writer_flush(w), 0);
    assert_int_equal(put(w, 1, 2, 20), 0);
    assert_int_equal(put(w, 1, 3, 30), 0);
    f.budget = 20;
    assert_int_equal(dx_mcap_writer_flush(w), -ENOSPC);
    assert_int_equal(dx_mcap_writer_recover(w), 0);
    f.budget = UINT64_MAX;
    assert_int_equal(dx_mcap_writer_progress(w).n_open, 2);
    assert_int_equal(dx_mcap_writer_drop(w), 2);
    assert_int_equal(put(w, 1, 4, 40), 0);
    assert_int_equal(dx_mcap_writer_finish(w), 0);
    r = open_reader(&f, true);
    n = read_sequences(r, NULL, got, 8);
    expect_sound(r);
    assert_int_equal(n, 2);
    assert_int_equal(got[0], 1);
    assert_int_equal(got[1], 4);
    dx_mcap_reader_free(r);
    dx_mcap_writer_free(w);
    mem_free(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(writes_the_worked_file),
        cmocka_unit_test(chunks_close_by_time_bytes_and_count),
        cmocka_unit_test(refuses_what_it_has_no_room_for),
        cmocka_unit_test(a_full_index_ends_the_file),
        cmocka_unit_test(a_full_disk_loses_nothing),
        cmocka_unit_test(a_dropped_chunk_is_missing_and_nothing_else),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
