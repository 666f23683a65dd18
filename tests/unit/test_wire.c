/*
 * Messages: round trips, the golden bytes of docs/protocol.md, bodies of every wrong length, fields
 * out of their range.
 */
#include <errno.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "tests/unit/tile_fixture.h"

/* Every message through one pair of functions, so that the tests below can go over all. */
union any {
    struct dx_msg_hello hello;
    struct dx_msg_welcome welcome;
    struct dx_msg_error error;
    struct dx_msg_subscribe subscribe;
    struct dx_msg_subscribed subscribed;
    struct dx_msg_geometry geometry;
    struct dx_msg_commit commit;
    struct dx_msg_reset reset;
    struct dx_msg_stream_state stream_state;
};

#define ADAPT(name)                                                                                \
    static void put_##name(struct dx_writer *w, const union any *m)                                \
    {                                                                                              \
        dx_msg_##name##_put(w, &m->name);                                                          \
    }                                                                                              \
    static int get_##name(union any *m, const uint8_t *body, size_t len)                           \
    {                                                                                              \
        return dx_msg_##name##_get(&m->name, body, len);                                           \
    }

ADAPT(hello)
ADAPT(welcome)
ADAPT(error)
ADAPT(subscribe)
ADAPT(subscribed)
ADAPT(geometry)
ADAPT(commit)
ADAPT(reset)
ADAPT(stream_state)

static const uint8_t piece[12] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};

static const struct kind {
    const char *name;
    void (*put)(struct dx_writer *w, const union any *m);
    int (*get)(union any *m, const uint8_t *body, size_t len);
    size_t len; /* of the body of the example */
    union any example;
} kinds[] = {
    {"HELLO", put_hello, get_hello, 16, {.hello = {1, 0, 3, 4}}},
    {"WELCOME",
     put_welcome,
     get_welcome,
     26 + 3,
     {.welcome = {0, 1, 2, 3, DX_WIRE_MAX_BODY, 5, "abc"}}},
    {"ERROR", put_error, get_error, 4 + 2, {.error = {7, "no"}}},
    {"SUBSCRIBE",
     put_subscribe,
     get_subscribe,
     20 + 4,
     {.subscribe = {"roof", 2, 2, 3, 40, 1, 2, 3, 4, {64, 16}}}},
    {"SUBSCRIBED",
     put_subscribed,
     get_subscribed,
     180 + 4,
     {.subscribed = {.stream = "roof",
                     .encoding = 1,
                     .mode = 2,
                     .attr_bytes = 2,
                     .model = DX_MODEL_SPINNING,
                     .wrap = 1,
                     .flip = 1,
                     .range_bytes = 2,
                     .height = 128,
                     .width = 2048,
                     .tile_rows = 2,
                     .tile_cols = 32,
                     .unit_m = 0.002f,
                     .pose = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12},
                     .table_bytes = 4 * (2 * 2048 + 6 * 128),
                     .sigma = {0.1, 0.2, 0.3},
                     .tilt_deg = 78,
                     .noise_k = 4,
                     .cap_m = 9,
                     .diag = 2,
                     .paper = 1,
                     .normals = 1,
                     .smooth = 1}}},
    {"GEOMETRY", put_geometry, get_geometry, 8 + 12, {.geometry = {8, 20, 12, piece}}},
    {"COMMIT",
     put_commit,
     get_commit,
     44,
     {.commit = {1, UINT64_MAX, 3, 2, 5, 6,
                 DX_COMMIT_PARTIAL | DX_COMMIT_CAP_FIRST | DX_COMMIT_CAP_LAST}}},
    {"RESET", put_reset, get_reset, 2 + 3, {.reset = {"why"}}},
    {"STREAM_STATE", put_stream_state, get_stream_state, 3 + 3, {.stream_state = {4, "end"}}},
};

#define N_KINDS (sizeof(kinds) / sizeof(kinds[0]))

static size_t put(const struct kind *k, const union any *m, uint8_t *body, size_t room)
{
    struct dx_writer w = dx_writer_init(body, room);

    k->put(&w, m);
    return w.failed ? 0 : (size_t)(w.p - body);
}

static void test_round_trip(void **state)
{
    (void)state;
    for (size_t i = 0; i < N_KINDS; i++) {
        uint8_t body[512], again[512];
        union any m;
        size_t len = put(&kinds[i], &kinds[i].example, body, sizeof(body));

        memset(&m, 0xaa, sizeof(m));
        assert_int_equal(len, kinds[i].len);
        assert_int_equal(kinds[i].get(&m, body, len), 0);
        assert_int_equal(put(&kinds[i], &m, again, sizeof(again)), len);
        assert_memory_equal(body, again, len);
    }
}

static void test_fields(void **state)
{
    uint8_t body[512];
    union any m;
    const struct kind *k = &kinds[4];

    (void)state;
    assert_int_equal(k->get(&m, body, put(k, &k->example, body, sizeof(body))), 0);
    assert_string_equal(m.subscribed.stream, "roof");
    assert_int_equal(m.subscribed.width, 2048);
    assert_int_equal(m.subscribed.flip, 1);
    assert_true(m.subscribed.diag == 2 && m.subscribed.normals == 1 && m.subscribed.smooth == 1);
    assert_true(m.subscribed.unit_m == 0.002f && m.subscribed.pose[11] == 12);
    assert_true(m.subscribed.sigma[2] == 0.3 && m.subscribed.cap_m == 9);
    k = &kinds[6];
    assert_int_equal(k->get(&m, body, put(k, &k->example, body, sizeof(body))), 0);
    assert_int_equal(m.commit.flags, 7);
    assert_true(m.commit.host_ns == UINT64_MAX && m.commit.n_dropped == 5);
    assert_int_equal(m.commit.clock_id, 2);
}

/* The bodies sit in blocks of their own size, so that a read past the end shows under ASan. */
static int get_at_length(const struct kind *k, const uint8_t *body, size_t body_len, size_t len)
{
    uint8_t *p = calloc(1, len ? len : 1);
    union any m;
    int r;

    assert_non_null(p);
    memcpy(p, body, len < body_len ? len : body_len);
    r = k->get(&m, p, len);
    free(p);
    return r;
}

static void test_wrong_lengths(void **state)
{
    (void)state;
    for (size_t i = 0; i < N_KINDS; i++) {
        uint8_t body[512];
        size_t len = put(&kinds[i], &kinds[i].example, body, sizeof(body));

        for (size_t n = 0; n <= len + 9; n++) {
            /* a piece of geometry is as long as its message says */
            bool shorter_piece = kinds[i].put == put_geometry && n > 8 && n < len && n % 4 == 0;

            assert_int_equal(get_at_length(&kinds[i], body, len, n),
                             n == len || shorter_piece ? 0 : -EBADMSG);
        }
    }
}

/* A later version may say more in its HELLO; that of ours may not. */
static void test_hello_of_another_version(void **state)
{
    static const struct {
        uint16_t major, minor;
        int longer;
    } cases[] = {{1, 0, -EBADMSG}, {1, 1, 0}, {2, 0, 0}, {0, 3, 0}};

    (void)state;
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        const union any m = {.hello = {cases[i].major, cases[i].minor, 0, 7}};
        uint8_t body[32] = {0};
        size_t len = put(&kinds[0], &m, body, sizeof(body));

        assert_int_equal(get_at_length(&kinds[0], body, len, len), 0);
        assert_int_equal(get_at_length(&kinds[0], body, len, len + 5), cases[i].longer);
        assert_int_equal(get_at_length(&kinds[0], body, len, len - 1), -EBADMSG);
    }
    assert_int_equal(dx_wire_minor(0), 0);
    assert_int_equal(dx_wire_minor(7), DX_WIRE_MINOR);
}

static void test_writer_short_of_room(void **state)
{
    (void)state;
    for (size_t i = 0; i < N_KINDS; i++)
        for (size_t room = 0; room < kinds[i].len; room++) {
            uint8_t *p = malloc(room + 1);

            assert_non_null(p);
            assert_int_equal(put(&kinds[i], &kinds[i].example, p, room), 0);
            free(p);
        }
}

static void test_fields_out_of_range(void **state)
{
    static const struct {
        int kind;
        size_t at;
        uint8_t value;
    } bad[] = {
        {0, 0, 'X'},   {1, 3, 'X'},    {1, 18, 0x05},  {3, 0, 3},    {3, 1, 3},     {3, 2, 4},
        {3, 12, 0},    {3, 14, 0},     {3, 18, 31},    {3, 19, 127}, {4, 0, 3},     {4, 1, 3},
        {4, 2, 3},     {4, 3, 0},      {4, 3, 4},      {4, 4, 2},    {4, 5, 2},     {4, 6, 3},
        {4, 6, 4},     {4, 7, 3},      {4, 9, 2},      {4, 8, 2},    {4, 12, 0},    {4, 14, 1},
        {4, 17, 0},    {4, 18, 1},     {4, 20, 1},     {4, 22, 31},  {4, 27, 0xff}, {4, 28, 1},
        {4, 39, 0x7f}, {4, 135, 0x7f}, {4, 159, 0xff}, {4, 180, 0},  {5, 0, 9},     {5, 0, 12},
        {5, 4, 19},    {6, 32, 4},     {7, 3, 10},     {8, 0, 6},
    };

    (void)state;
    for (size_t i = 0; i < sizeof(bad) / sizeof(bad[0]); i++) {
        const struct kind *k = &kinds[bad[i].kind];
        uint8_t body[512];
        union any m;
        size_t len = put(k, &k->example, body, sizeof(body));

        body[bad[i].at] = bad[i].value;
        /* an all-ones exponent needs its other byte: 0x7ff0, 0xff80 */
        if (bad[i].value == 0x7f || bad[i].value == 0xff)
            body[bad[i].at - 1] |= 0xf0;
        if (k->get(&m, body, len) != -EBADMSG)
            fail_msg("%s took %#x at %zu", k->name, bad[i].value, bad[i].at);
    }
}

static void test_texts(void **state)
{
    uint8_t body[1024] = {0}, *p = body + 4;
    struct dx_msg_error e;
    struct dx_msg_subscribe s;
    struct dx_writer w;

    (void)state;
    memset(e.text, 'x', sizeof(e.text)); /* no NUL in its room */
    w = dx_writer_init(body, sizeof(body));
    dx_msg_error_put(&w, &e);
    assert_int_equal(w.p - body, 4 + DX_WIRE_TEXT - 1);

    memset(p, 'y', 300); /* longer than the room: cut */
    dx_put_u16(body + 2, 300);
    assert_int_equal(dx_msg_error_get(&e, body, 304), 0);
    assert_int_equal(strlen(e.text), DX_WIRE_TEXT - 1);

    e = (struct dx_msg_error){.code = 1, .text = "two\nlines\x7f"};
    w = dx_writer_init(body, sizeof(body));
    dx_msg_error_put(&w, &e);
    assert_int_equal(dx_msg_error_get(&e, body, (size_t)(w.p - body)), 0);
    assert_string_equal(e.text, "two lines ");

    s = (struct dx_msg_subscribe){.mode = DX_MODE_LIVE};
    w = dx_writer_init(body, sizeof(body));
    dx_msg_subscribe_put(&w, &s);
    memset(body + 20, 'z', DX_WIRE_NAME);
    dx_put_u16(body + 18, DX_WIRE_NAME - 1);
    assert_int_equal(dx_msg_subscribe_get(&s, body, 20 + DX_WIRE_NAME - 1), 0);
    dx_put_u16(body + 18, DX_WIRE_NAME); /* a name is never cut */
    assert_int_equal(dx_msg_subscribe_get(&s, body, 20 + DX_WIRE_NAME), -EBADMSG);
}

/* SUBSCRIBED with a level of detail: of f32 alone, and of the strides there are. */
static void test_levels(void **state)
{
    static const struct {
        uint8_t encoding;
        struct dx_lod_level lod;
        int want;
    } cases[] = {
        {DX_ENCODING_F32, {0, 0}, 0},          {DX_ENCODING_F32, {65534, 0}, 0},
        {DX_ENCODING_F32, {1, 64}, 0},         {DX_ENCODING_F32, {65535, 0}, -EBADMSG},
        {DX_ENCODING_F32, {64, 3}, -EBADMSG},  {DX_ENCODING_F32, {0, 128}, -EBADMSG},
        {DX_ENCODING_Q16, {0, 0}, 0},          {DX_ENCODING_Q16, {64, 0}, -EBADMSG},
        {DX_ENCODING_DELTA, {0, 8}, -EBADMSG},
    };

    (void)state;
    for (size_t k = 0; k < sizeof(cases) / sizeof(cases[0]); k++) {
        union any m = kinds[4].example;
        uint8_t body[512];
        size_t len;

        m.subscribed.encoding = cases[k].encoding;
        m.subscribed.lod = cases[k].lod;
        if (cases[k].encoding == DX_ENCODING_F32)
            m.subscribed.table_bytes = 0;
        len = put(&kinds[4], &m, body, sizeof(body));
        assert_int_equal(kinds[4].get(&m, body, len), cases[k].want);
        if (cases[k].want == 0)
            assert_true(dx_lod_same(m.subscribed.lod, cases[k].lod));
    }
}

/* As printed in docs/protocol.md. */
static void test_golden_bytes(void **state)
{
    static const uint8_t hello[] = {
        0x10, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0xff, 0xff, 0xff, 0xff, 0x00, 0x00,
        0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x44, 0x45, 0x58, 0x4c,
        0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x07, 0x00, 0x00, 0x00,
    };
    static const uint8_t subscribe[] = {
        0x18, 0x00, 0x00, 0x00, 0x04, 0x00, 0x00, 0x00, 0xff, 0xff, 0xff, 0xff,
        0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
        0x00, 0x00, 0x03, 0x20, 0x28, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
        0x00, 0x00, 0x00, 0x00, 0x40, 0x00, 0x04, 0x00, 0x72, 0x6f, 0x6f, 0x66,
    };
    const struct dx_msg_hello h = {.major = 1, .minor = 0, .encodings = 7};
    const struct dx_msg_subscribe s = {.stream = "roof",
                                       .lod = {.bound = 64, .stride = 32},
                                       .want = DX_WANT_ATTR | DX_WANT_NORMALS,
                                       .min_interval_ms = 40};
    struct dx_wire_header header = {
        .length = 16, .type = DX_MSG_HELLO, .stream = DX_WIRE_NO_STREAM};
    uint8_t bytes[128];
    struct dx_writer w = dx_writer_init(bytes + DX_WIRE_HEADER_LEN, 100);

    (void)state;
    dx_wire_put_header(bytes, &header);
    dx_msg_hello_put(&w, &h);
    assert_int_equal(w.p - bytes, sizeof(hello));
    assert_memory_equal(bytes, hello, sizeof(hello));

    header = (struct dx_wire_header){
        .length = 24, .type = DX_MSG_SUBSCRIBE, .stream = DX_WIRE_NO_STREAM, .seq = 1};
    w = dx_writer_init(bytes + DX_WIRE_HEADER_LEN, 100);
    dx_wire_put_header(bytes, &header);
    dx_msg_subscribe_put(&w, &s);
    assert_int_equal(w.p - bytes, sizeof(subscribe));
    assert_memory_equal(bytes, subscribe, sizeof(subscribe));
}

static void test_header(void **state)
{
    const struct dx_wire_header h = {0x01020304, 0x0506,     0x0708,
                                     0x090a0b0c, 0x0d0e0f10, 0x1112131415161718};
    struct dx_wire_header again;
    uint8_t bytes[DX_WIRE_HEADER_LEN];

    (void)state;
    dx_wire_put_header(bytes, &h);
    assert_int_equal(bytes[0], 4);
    assert_int_equal(bytes[23], 0x11);
    dx_wire_get_header(&again, bytes);
    assert_memory_equal(&again, &h, sizeof(h));
}

static void test_names(void **state)
{
    (void)state;
    for (unsigned e = 0; e < DX_N_ENCODINGS; e++)
        assert_int_equal(dx_encoding_from_name(dx_encoding_name(e)), e);
    assert_int_equal(dx_encoding_from_name("f64"), -1);
    assert_string_equal(dx_encoding_name(9), "unknown");
    assert_string_equal(dx_stream_state_name(DX_STREAM_ENDED), "ended");
    assert_string_equal(dx_stream_state_name(DX_STREAM_FAULTED), "faulted");
    assert_string_equal(dx_stream_state_name(6), "unknown");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_round_trip),
        cmocka_unit_test(test_fields),
        cmocka_unit_test(test_wrong_lengths),
        cmocka_unit_test(test_hello_of_another_version),
        cmocka_unit_test(test_writer_short_of_room),
        cmocka_unit_test(test_fields_out_of_range),
        cmocka_unit_test(test_texts),
        cmocka_unit_test(test_levels),
        cmocka_unit_test(test_golden_bytes),
        cmocka_unit_test(test_header),
        cmocka_unit_test(test_names),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
