/*
 * Damaged MCAP files: cut anywhere, any byte changed, bytes that cannot be read, lengths that lie.
 * What is delivered is true, what is missing is told, and the repaired file is whole.
 */
#include "mcap_fixture.h"

#include "core/base/bytes.h"

enum { N = 12 };

struct file {
    struct mem_file f;
    uint64_t ends[N];  /* where the chunk of each message ends */
    uint64_t data_len; /* up to DataEnd */
    uint64_t attachment_end;
};

/* A message a chunk, an attachment after the sixth. */
static struct file make_file(enum dx_mcap_compression compression)
{
    const struct dx_mcap_writer_config c = small_config(compression);
    const struct dx_mcap_attachment a = {1, 2, dx_mcap_text("note"), dx_mcap_text("text/plain"),
                                         bytes_of("some words")};
    struct dx_mcap_writer *w = new_writer(&c);
    struct file out = {.f = mem_new()};
    const struct dx_mcap_sink sink = mem_sink(&out.f);

    declare(w, 1, true);
    declare(w, 4, false);
    assert_int_equal(dx_mcap_writer_begin(w, &sink), 0);
    for (uint32_t k = 0; k < N; k++) {
        assert_int_equal(put(w, k % 2 ? 1 : 4, k, k), 0);
        if (k == 6)
            assert_int_equal(dx_mcap_writer_attachment(w, &a), 0);
        out.attachment_end = k == 6 ? dx_mcap_writer_progress(w).len : out.attachment_end;
        /* the chunk ends before its message index (9 + 6 + 16 bytes) */
        assert_int_equal(dx_mcap_writer_flush(w), 0);
        out.ends[k] = dx_mcap_writer_progress(w).len - 31;
    }
    out.data_len = dx_mcap_writer_progress(w).len;
    assert_int_equal(dx_mcap_writer_finish(w), 0);
    dx_mcap_writer_free(w);
    out.f.bytes = realloc(out.f.bytes, out.f.len + 1);
    assert_non_null(out.f.bytes);
    return out;
}

/* Writes what the reader could save; tells that the result is whole, with the same messages. */
static void check_repair(struct mem_file *f, const uint32_t *sequences, uint32_t n)
{
    struct dx_mcap_reader *r = open_reader(f, true);
    struct mem_file fixed = mem_new();
    const struct dx_mcap_sink sink = mem_sink(&fixed);
    struct dx_mcap_repaired report;
    struct dx_mcap_info info;
    struct dx_err err = {""};
    uint32_t got[N];

    if (dx_mcap_repair(r, &sink, &report, &err) < 0)
        fail_msg("%s", err.text);
    dx_mcap_reader_free(r);
    for (int scan = 0; scan < 2; scan++) {
        r = open_reader(&fixed, scan);
        dx_mcap_reader_info(r, &info);
        assert_int_equal(info.indexed, !scan);
        assert_int_equal(info.n_messages, report.n_messages);
        assert_int_equal(read_sequences(r, NULL, got, N), n);
        if (n)
            assert_memory_equal(got, sequences, n * sizeof(got[0]));
        expect_sound(r);
        dx_mcap_reader_free(r);
    }
    mem_free(&fixed);
}

/* ---- cut --------------------------------------------------------------------------------------
 */

static void reads_up_to_the_last_whole_chunk(void **state)
{
    struct file whole = make_file(DX_MCAP_LZ4);

    (void)state;
    for (size_t len = DX_MCAP_MAGIC_LEN; len < whole.f.len; len++) {
        struct mem_file cut = mem_copy(whole.f.bytes, len);
        struct dx_mcap_reader *r = open_reader(&cut, false);
        uint32_t got[N], n = 0;

        while (n < N && whole.ends[n] <= len)
            n++;
        assert_true(dx_mcap_reader_damages(r) > 0);
        assert_int_equal(read_sequences(r, NULL, got, N), n);
        for (uint32_t k = 0; k < n; k++)
            assert_int_equal(got[k], k);
        assert_int_equal(dx_mcap_reader_attachment(r, 0) != NULL, len >= whole.attachment_end);
        dx_mcap_reader_free(r);
        if (len % 7 == 0)
            check_repair(&cut, got, n);
        mem_free(&cut);
    }
    mem_free(&whole.f);
}

static void the_place_of_a_cut_is_told(void **state)
{
    struct file whole = make_file(DX_MCAP_NONE);
    uint64_t last = whole.ends[N - 1];
    struct mem_file cut = mem_copy(whole.f.bytes, last - 3);
    struct dx_mcap_reader *r = open_reader(&cut, false);
    const struct dx_mcap_damage *d = dx_mcap_reader_damage(r, 0);

    (void)state;
    assert_int_equal(dx_mcap_reader_damages(r), 1);
    assert_int_equal(d->offset, whole.ends[N - 2] + 31);
    assert_int_equal(d->offset + d->len, last - 3);
    assert_non_null(strstr(d->text, "cut"));
    dx_mcap_reader_free(r);
    mem_free(&cut);
    mem_free(&whole.f);
}

static void what_is_no_mcap_file_is_refused(void **state)
{
    struct mem_file f = mem_copy(worked_file, sizeof(worked_file));
    struct dx_mcap_source source = mem_source(&f);
    struct dx_mcap_reader *r = NULL;
    struct dx_err err;

    (void)state;
    f.bytes[3] = 'X';
    assert_int_equal(dx_mcap_reader_open(&r, &source, NULL, &err), -EBADMSG);
    assert_non_null(strstr(err.text, "no MCAP file"));
    for (source.len = 0; source.len < DX_MCAP_MAGIC_LEN; source.len++)
        assert_int_equal(dx_mcap_reader_open(&r, &source, NULL, &err), -EBADMSG);
    mem_free(&f);
}

/* ---- changed ----------------------------------------------------------------------------------
 */

/* Whatever the reader delivers is a message of the file, in its order; either nothing is missing or
 * something was told. With a scan, something is told in any case: every byte is under a CRC. */
static void check_changed(struct mem_file *f, bool scan, size_t at, bool and_repair)
{
    struct dx_mcap_reader *r = open_reader(f, scan);
    uint32_t got[N], n = read_sequences(r, NULL, got, N);

    for (uint32_t k = 1; k < n; k++)
        assert_true(got[k - 1] < got[k]);
    if (n < N && dx_mcap_reader_damages(r) == 0)
        fail_msg("byte %zu: %u messages are missing, and nothing is said", at, N - n);
    if (n + 1 < N)
        fail_msg("byte %zu: %u messages of %u", at, n, N);
    if (scan && dx_mcap_reader_damages(r) == 0)
        fail_msg("byte %zu: not noticed", at);
    dx_mcap_reader_free(r);
    if (and_repair)
        check_repair(f, got, n);
}

static void any_byte_may_be_wrong(void **state)
{
    static const uint8_t changes[] = {0x01, 0x80, 0xff};

    (void)state;
    for (enum dx_mcap_compression c = 0; c < DX_MCAP_N_COMPRESSIONS; c++) {
        struct file whole = make_file(c);

        /* without compression every byte */
        for (size_t at = DX_MCAP_MAGIC_LEN; at < whole.f.len; at += c == DX_MCAP_NONE ? 1 : 5) {
            uint8_t change = changes[(at + c) % 3];

            whole.f.bytes[at] ^= change;
            check_changed(&whole.f, false, at, false);
            check_changed(&whole.f, true, at, at % 11 == 0);
            whole.f.bytes[at] ^= change;
        }
        mem_free(&whole.f);
    }
}

static void a_hole_in_the_middle_costs_what_is_in_it(void **state)
{
    struct file whole = make_file(DX_MCAP_ZSTD);
    uint32_t got[N], n;

    (void)state;
    /* from within the third message's chunk into the fifth's; and no index, which would know */
    memset(whole.f.bytes + whole.ends[2] - 20, 0, whole.ends[4] - whole.ends[2]);
    for (int index = 0; index < 2; index++) {
        struct mem_file f = mem_copy(whole.f.bytes, index ? whole.f.len : whole.data_len);
        struct dx_mcap_reader *r = open_reader(&f, false);

        n = read_sequences(r, NULL, got, N);
        assert_int_equal(n, N - 3);
        assert_int_equal(got[1], 1);
        assert_int_equal(got[2], 5);
        assert_true(dx_mcap_reader_damages(r) > 0);
        dx_mcap_reader_free(r);
        check_repair(&f, got, n);
        mem_free(&f);
    }
    mem_free(&whole.f);
}

static void bytes_that_cannot_be_read_are_passed_over(void **state)
{
    struct file whole = make_file(DX_MCAP_NONE);

    (void)state;
    whole.f.bad_from = whole.ends[3] - 8;
    whole.f.bad_to = whole.ends[3];
    for (int scan = 0; scan < 2; scan++) {
        struct dx_mcap_reader *r = open_reader(&whole.f, scan);
        uint32_t got[N];

        assert_int_equal(read_sequences(r, NULL, got, N), N - 1);
        assert_int_equal(got[2], 2);
        assert_int_equal(got[3], 4);
        assert_int_equal(dx_mcap_reader_damage(r, 0)->offset, whole.ends[2] + 31);
        assert_non_null(strstr(dx_mcap_reader_damage(r, 0)->text, strerror(EIO)));
        dx_mcap_reader_free(r);
    }
    mem_free(&whole.f);
}

/* ---- lies -------------------------------------------------------------------------------------
 */

static int refuse_big(void *ctx, uint64_t offset, void *bytes, size_t len)
{
    /* the bound that open_reader sets is 1 MiB; what is read at a time stays near it */
    assert_in_range(len, 0, 3 << 20);
    return mem_read(ctx, offset, bytes, len);
}

/* A file of this one record after the header, of which only the head is there or little more. */
static void check_lie(uint8_t op, uint64_t claimed, const uint8_t *body, size_t len)
{
    struct mem_file f = mem_copy(worked_file, 31);
    struct dx_mcap_source source;
    const struct dx_mcap_read_options o = {.max_chunk = 1 << 20};
    struct dx_mcap_reader *r = NULL;
    uint8_t head[9] = {op};
    struct dx_err err;
    uint32_t got[1];

    dx_put_u64(head + 1, claimed);
    assert_int_equal(mem_write(&f, f.len, head, sizeof(head)), 0);
    assert_int_equal(mem_write(&f, f.len, body, len), 0);
    source = mem_source(&f);
    source.read = refuse_big;
    assert_int_equal(dx_mcap_reader_open(&r, &source, &o, &err), 0);
    assert_int_equal(read_sequences(r, NULL, got, 1), 0);
    assert_true(dx_mcap_reader_damages(r) > 0);
    dx_mcap_reader_free(r);
    mem_free(&f);
}

static void lengths_that_lie_are_not_believed(void **state)
{
    static const uint64_t lies[] = {UINT64_MAX, UINT64_MAX - 8, INT64_MAX, UINT32_MAX, 1 << 20};
    uint8_t body[100] = {0};

    (void)state;
    for (uint8_t op = 0; op < 0x14; op++)
        for (size_t k = 0; k < sizeof(lies) / sizeof(lies[0]); k++)
            check_lie(op, lies[k], body, sizeof(body));
    /* right outside, wrong inside: a chunk of 2^40 bytes uncompressed, or of 2^63 stored */
    for (int k = 0; k < 2; k++) {
        memset(body, 0, sizeof(body));
        dx_put_u64(body + 16, k == 0 ? UINT64_C(1) << 40 : 60);
        dx_put_u64(body + 32, k == 0 ? 60 : UINT64_C(1) << 63);
        check_lie(DX_MCAP_CHUNK, sizeof(body), body, sizeof(body));
    }
    /* an attachment of 2^63 bytes, texts of 2^32 - 1 */
    memset(body, 0, sizeof(body));
    dx_put_u64(body + 24, UINT64_C(1) << 63);
    check_lie(DX_MCAP_ATTACHMENT, sizeof(body), body, sizeof(body));
    memset(body, 0xff, sizeof(body));
    for (int op = DX_MCAP_SCHEMA; op <= DX_MCAP_METADATA; op++)
        check_lie((uint8_t)op, sizeof(body), body, sizeof(body));
}

/* A zstd frame of little that becomes much: not more than the chunk says, and it says too much. */
static void a_bomb_does_not_go_off(void **state)
{
    const size_t much = (size_t)8 << 20;
    struct dx_mcap_packer *packer;
    uint8_t *zeros = calloc(1, much), *packed, *body;
    int64_t len;
    size_t room;

    (void)state;
    assert_int_equal(dx_mcap_packer_new(&packer, DX_MCAP_ZSTD, 1, much), 0);
    room = dx_mcap_packer_bound(packer, much);
    packed = malloc(room);
    len = dx_mcap_packer_run(packer, packed, room, zeros, much);
    assert_in_range(len, 1, 10000);
    body = calloc(1, (size_t)len + 44);
    memcpy(body + 28, "\4\0\0\0zstd", 8);
    dx_put_u64(body + 36, (uint64_t)len);
    memcpy(body + 44, packed, (size_t)len);
    dx_put_u64(body + 16, much); /* above the bound */
    check_lie(DX_MCAP_CHUNK, (uint64_t)len + 44, body, (size_t)len + 44);
    dx_put_u64(body + 16, 1000); /* less than it has */
    check_lie(DX_MCAP_CHUNK, (uint64_t)len + 44, body, (size_t)len + 44);
    dx_mcap_packer_free(packer);
    free(zeros);
    free(packed);
    free(body);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reads_up_to_the_last_whole_chunk),
        cmocka_unit_test(the_place_of_a_cut_is_told),
        cmocka_unit_test(what_is_no_mcap_file_is_refused),
        cmocka_unit_test(any_byte_may_be_wrong),
        cmocka_unit_test(a_hole_in_the_middle_costs_what_is_in_it),
        cmocka_unit_test(bytes_that_cannot_be_read_are_passed_over),
        cmocka_unit_test(lengths_that_lie_are_not_believed),
        cmocka_unit_test(a_bomb_does_not_go_off),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
