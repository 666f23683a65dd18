/*
 * libdexel against a scripted server that behaves: sessions in all encodings, bytes one at a time,
 * RESET, raw tiles, pull mode, and what the client itself says.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "core/grid/octahedral.h"
#include "tests/unit/client_fixture.h"

/* A snapshot of all tiles, one later batch of one tile; returns the hash that the callbacks should
 * see. */
static uint64_t script_mesh(struct script *s, enum dexel_encoding encoding, uint8_t attr_bytes,
                            bool normals, const struct dx_geometry *g, uint64_t h)
{
    static struct dx_tile tile;
    static struct dx_tile_mesh mesh;
    static uint32_t ids[DX_TILE_MAX_VERTICES];
    static float normal[3 * DX_TILE_MAX_VERTICES];
    struct dx_rng rng = dx_rng_init(9, attr_bytes);
    struct dx_tiling t;
    uint32_t n_tiles;

    dx_tiling_init(&t, g->height, g->width, g->wrap);
    n_tiles = dx_tiling_n_tiles(&t);
    script_message(s, DX_MSG_SNAPSHOT_BEGIN, 0, 7, NULL, 0);
    for (uint32_t i = 0; i < n_tiles + 1; i++) {
        uint32_t n = 0;

        fixture_tile(&tile, &t, i % n_tiles, attr_bytes, i == 1 ? 0 : 200, &rng);
        if (normals)
            fixture_normals(&tile, &rng);
        script_tile(s, (enum dx_encoding)encoding, i < n_tiles ? 7 : 8, &tile, &t, g);
        if (i == n_tiles - 1) {
            script_commit(s, 7, n_tiles);
            script_message(s, DX_MSG_SNAPSHOT_END, 0, 7, NULL, 0);
        }
        dx_tile_mesh_build(&mesh, &tile, &t, g);
        for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++)
            if (mesh.mask[k / 8] >> (k % 8) & 1)
                ids[n++] = (uint32_t)dx_tile_vertex_id(&t, tile.row, tile.col, k);
        for (uint32_t v = 0; normals && v < n; v++)
            dx_octahedral_decode(normal + 3 * v, mesh.normal + 2 * v);
        h = hash_mesh(h, &(struct dexel_tile){tile.row, tile.col, n, mesh.n_triangles, mesh.xyz,
                                              mesh.index, ids, attr_bytes && n ? mesh.attr : NULL,
                                              normals && n ? normal : NULL});
    }
    script_commit(s, 8, 1);
    return h;
}

static void good_session(enum dexel_encoding encoding, uint8_t attr_bytes, bool normals, bool wrap,
                         size_t step)
{
    struct dx_geometry *g = fixture_geometry(90, 150, wrap);
    struct session s;
    uint64_t want;

    open_session(&s, (struct dexel_options){.encoding = encoding}, &callbacks);
    script_welcome(&s.script);
    script_state(&s.script, DX_STREAM_OPENING, "waiting for a frame");
    script_subscribed_to(&s.script, g, (enum dx_encoding)encoding, attr_bytes, normals);
    want = script_mesh(&s.script, encoding, attr_bytes, normals, g, 0);
    script_state(&s.script, DX_STREAM_ENDED, "end of file");
    assert_int_equal(play(&s, step), 0);

    assert_int_equal(s.seen.n_stream, 1);
    assert_int_equal(s.seen.stream.height, 90);
    assert_int_equal(s.seen.stream.wrap, wrap);
    assert_int_equal(s.seen.stream.flip, g->flip);
    assert_int_equal(s.seen.stream.normals, normals);
    assert_string_equal(s.seen.stream.name, "test");
    assert_int_equal(s.seen.n_tile, 2 * 3 + 1);
    assert_int_equal(s.seen.n_commit, 2);
    assert_true(s.seen.commit.epoch == 8 && s.seen.commit.frame == 108);
    assert_true(s.seen.commit.partial && !s.seen.commit.snapshot && s.seen.commit.n_tiles == 1);
    assert_true(!s.seen.commit.cap_first && s.seen.commit.cap_last);
    assert_true(s.seen.hash == want);
    assert_int_equal(s.seen.n_state, 2);
    assert_int_equal(s.seen.state, DEXEL_ENDED);
    assert_string_equal(s.seen.text, "end of file");
    assert_int_equal(dexel_run(s.client, 0), 0); /* the stream has ended */
    hang_up(&s);
    assert_int_equal(dexel_dispatch(s.client), -ECONNRESET);
    assert_int_equal(dexel_dispatch(s.client), -ECONNRESET); /* and stays so */
    close_session(&s);
    dx_geometry_unref(g);
}

static void test_good_sessions(void **state)
{
    (void)state;
    for (int e = 0; e <= DEXEL_DELTA; e++)
        for (uint8_t attr_bytes = 0; attr_bytes <= 2; attr_bytes++) {
            good_session((enum dexel_encoding)e, attr_bytes, attr_bytes == 1, true, SIZE_MAX);
            good_session((enum dexel_encoding)e, attr_bytes, attr_bytes == 0, false, 5000);
        }
}

/* A stream that smooths its ranges says so once, and each chunk says it again. */
static void test_smoothed(void **state)
{
    struct dx_geometry *g = fixture_small_geometry();

    (void)state;
    for (int e = 0; e <= DEXEL_DELTA; e++) {
        struct dx_msg_subscribed m;
        struct session s;
        size_t at;

        open_session(&s, (struct dexel_options){.encoding = (enum dexel_encoding)e}, &callbacks);
        script_welcome(&s.script);
        fixture_subscribed(&m, g, (enum dx_encoding)e, 0);
        m.smooth = 1;
        SCRIPT_PUT(&s.script, DX_MSG_SUBSCRIBED, subscribed, &m);
        if (m.table_bytes)
            script_geometry(&s.script, g, 1000);
        script_message(&s.script, DX_MSG_SNAPSHOT_BEGIN, 0, 1, NULL, 0);
        at = s.script.len;
        small_tile(&s.script, g, (enum dx_encoding)e, 1, 0);
        dx_chunk_set_smoothed(s.script.bytes + at + DX_WIRE_HEADER_LEN);
        script_commit(&s.script, 1, 1);
        assert_int_equal(play(&s, SIZE_MAX), 0);
        assert_int_equal(s.seen.stream.smoothed, 1);
        assert_int_equal(s.seen.n_tile, 1);
        assert_int_equal(s.seen.n_commit, 1);
        close_session(&s);
    }
    dx_geometry_unref(g);
}

static void test_dribbled_bytes(void **state)
{
    struct dx_geometry *g = fixture_small_geometry();

    (void)state;
    for (int e = 0; e <= DEXEL_DELTA; e++) {
        struct session s;
        uint64_t want;

        open_session(&s, (struct dexel_options){.encoding = (enum dexel_encoding)e}, &callbacks);
        script_welcome(&s.script);
        script_subscribed(&s.script, g, (enum dx_encoding)e, 0);
        want = script_mesh(&s.script, (enum dexel_encoding)e, 0, false, g, 0);
        assert_int_equal(play(&s, 1), 0);
        assert_int_equal(s.seen.n_commit, 2);
        assert_true(s.seen.hash == want);
        close_session(&s);
    }
    dx_geometry_unref(g);
}

/* HELLO and SUBSCRIBE leave at once, NEXT when asked. */
static void test_what_the_client_says(void **state)
{
    struct dexel_options options = {.stream = "roof",
                                    .encoding = DEXEL_Q16,
                                    .mode = DEXEL_PULL,
                                    .want_attr = 7,
                                    .want_normals = 1,
                                    .min_interval_ms = 40,
                                    .tile_row0 = 1,
                                    .tile_col0 = 2,
                                    .n_tile_rows = 3,
                                    .n_tile_cols = 4};
    struct dx_msg_subscribe m;
    struct dx_msg_hello hello;
    struct dx_wire_header h;
    struct session s;
    uint8_t bytes[512];
    ssize_t n;

    (void)state;
    open_session(&s, options, &callbacks);
    n = recv(s.server, bytes, sizeof(bytes), 0);
    assert_int_equal(n, 24 + 16 + 24 + 24);
    dx_wire_get_header(&h, bytes);
    assert_true(h.type == DX_MSG_HELLO && h.seq == 0 && h.stream == DX_WIRE_NO_STREAM);
    assert_int_equal(dx_msg_hello_get(&hello, bytes + 24, 16), 0);
    assert_int_equal(hello.encodings, 7);
    dx_wire_get_header(&h, bytes + 40);
    assert_true(h.type == DX_MSG_SUBSCRIBE && h.seq == 1 && h.length == 24);
    assert_int_equal(dx_msg_subscribe_get(&m, bytes + 64, 24), 0);
    assert_string_equal(m.stream, "roof");
    assert_true(m.encoding == 1 && m.mode == 1 && m.want == 3 && m.min_interval_ms == 40);
    assert_true(m.tile_row0 == 1 && m.tile_col0 == 2 && m.n_tile_rows == 3 && m.n_tile_cols == 4);

    assert_int_equal(dexel_next(s.client), 0);
    assert_int_equal(dexel_next(s.client), 0);
    assert_int_equal(dexel_events(s.client), POLLIN);
    assert_int_equal(recv(s.server, bytes, sizeof(bytes), 0), 48);
    dx_wire_get_header(&h, bytes + 24);
    assert_true(h.type == DX_MSG_NEXT && h.seq == 3 && h.length == 0);
    close_session(&s);

    open_session(&s, (struct dexel_options){0}, &callbacks);
    assert_int_equal(dexel_next(s.client), -EINVAL);
    close_session(&s);
}

/* NEXT that a full socket does not take waits, up to a bound, and leaves later. */
static void test_next_to_a_deaf_server(void **state)
{
    struct session s;
    uint8_t bytes[4096];
    size_t n_bytes = 0, n_next = 0;
    int r;

    (void)state;
    open_session(&s, (struct dexel_options){.mode = DEXEL_PULL}, &callbacks);
    while ((r = dexel_next(s.client)) == 0)
        n_next++;
    assert_int_equal(r, -ENOBUFS);
    assert_int_equal(dexel_events(s.client), POLLIN | POLLOUT);
    while (n_bytes < 24 + 16 + 24 + 18 + 24 * n_next) {
        ssize_t n = recv(s.server, bytes, sizeof(bytes), 0);

        assert_true(n > 0 || errno == EAGAIN);
        n_bytes += n > 0 ? (size_t)n : 0;
        assert_int_equal(dexel_dispatch(s.client), 0);
    }
    assert_int_equal(dexel_events(s.client), POLLIN);
    assert_int_equal(dexel_next(s.client), 0);
    close_session(&s);
}

static void test_reset_with_another_geometry(void **state)
{
    struct dx_geometry *g = fixture_geometry(70, 80, true), *other = fixture_small_geometry();
    struct dx_tiling t;
    struct dx_tile tile;
    struct session s;
    uint64_t want;

    (void)state;
    open_session(&s, (struct dexel_options){.encoding = DEXEL_Q16}, &callbacks);
    script_welcome(&s.script);
    script_subscribed(&s.script, g, DX_ENCODING_Q16, 1);
    want = script_mesh(&s.script, DEXEL_Q16, 1, false, g, 0);
    /* a batch without its COMMIT: the server took it back */
    dx_tiling_init(&t, 70, 80, true);
    fixture_tile(&tile, &t, 0, 1, 0, &(struct dx_rng){1});
    script_tile(&s.script, DX_ENCODING_Q16, 9, &tile, &t, g);
    script_reset(&s.script, "the camera moved");
    script_subscribed(&s.script, other, DX_ENCODING_Q16, 0);
    script_mesh(&s.script, DEXEL_Q16, 0, false, other, want);
    assert_int_equal(play(&s, SIZE_MAX), 0);
    assert_int_equal(s.seen.n_reset, 1);
    assert_string_equal(s.seen.text, "the camera moved");
    assert_int_equal(s.seen.n_stream, 2);
    assert_int_equal(s.seen.stream.height, 3);
    assert_int_equal(s.seen.n_commit, 4);
    close_session(&s);
    dx_geometry_unref(g);
    dx_geometry_unref(other);
}

static void test_raw_tiles(void **state)
{
    static const struct dexel_callbacks raw = {.raw_tile = on_raw_tile, .commit = on_commit};
    static uint8_t chunk[DX_WIRE_MAX_BODY];
    struct dx_geometry *g = fixture_small_geometry();
    struct dx_tiling t;
    struct dx_tile tile;
    struct session s;

    (void)state;
    dx_tiling_init(&t, 3, 3, false);
    fixture_small_tile(&tile);
    open_session(&s, (struct dexel_options){.encoding = DEXEL_Q16}, &raw);
    script_welcome(&s.script);
    script_subscribed(&s.script, g, DX_ENCODING_Q16, 0);
    script_message(&s.script, DX_MSG_SNAPSHOT_BEGIN, 0, 1, NULL, 0);
    script_tile(&s.script, DX_ENCODING_Q16, 1, &tile, &t, g);
    script_commit(&s.script, 1, 1);
    assert_int_equal(play(&s, SIZE_MAX), 0);
    assert_int_equal(s.seen.n_raw, 1);
    assert_true(s.seen.hash == dx_hash(0, chunk, dx_chunk_put_q16(chunk, &tile)));
    assert_true(s.seen.commit.snapshot);
    close_session(&s);
    dx_geometry_unref(g);
}

static void test_callback_stops(void **state)
{
    struct dx_geometry *g = fixture_geometry(70, 80, true);
    struct session s;
    uint64_t want;

    (void)state;
    open_session(&s, (struct dexel_options){0}, &callbacks);
    script_welcome(&s.script);
    script_subscribed(&s.script, g, DX_ENCODING_F32, 0);
    want = script_mesh(&s.script, DEXEL_F32, 0, false, g, 0);
    assert_true(send(s.server, s.script.bytes, s.script.len, 0) == (ssize_t)s.script.len);
    s.seen.stop_at_tile = 42;
    for (int i = 1; i <= 5; i++) {
        assert_int_equal(dexel_run(s.client, 1000), 42);
        assert_int_equal(s.seen.n_tile, i);
    }
    assert_int_equal(dexel_run(s.client, 0), -ETIMEDOUT);
    assert_true(s.seen.hash == want);
    assert_int_equal(s.seen.n_commit, 2);
    close_session(&s);
    dx_geometry_unref(g);
}

static void test_skippable(void **state)
{
    struct dx_geometry *g = fixture_small_geometry();
    struct session s;

    (void)state;
    open_session(&s, (struct dexel_options){.encoding = DEXEL_Q16}, &callbacks);
    start(&s.script, g);
    script_message(&s.script, 999, DX_WIRE_SKIPPABLE, 0, "abc", 3);
    script_commit(&s.script, 1, 0);
    assert_int_equal(play(&s, SIZE_MAX), 0);
    assert_int_equal(s.seen.n_commit, 1);
    close_session(&s);
    dx_geometry_unref(g);
}

static void test_open_errors(void **state)
{
    struct dexel_options options = {.socket = "/tmp/dexel-test-none/s"};
    char long_path[200];
    struct dexel *d;

    (void)state;
    assert_int_equal(dexel_open(&d, &options, &callbacks, NULL), -ENOENT);
    assert_non_null(strstr(dexel_error(d), "/tmp/dexel-test-none/s"));
    assert_int_equal(dexel_dispatch(d), -ENOENT);
    assert_int_equal(dexel_run(d, -1), -ENOENT);
    assert_int_equal(dexel_next(d), -ENOENT);
    dexel_close(d);

    memset(long_path, 'x', sizeof(long_path));
    long_path[sizeof(long_path) - 1] = 0;
    options.socket = long_path;
    assert_int_equal(dexel_open(&d, &options, &callbacks, NULL), -ENAMETOOLONG);
    dexel_close(d);
    options.stream = long_path;
    assert_int_equal(dexel_open(&d, &options, &callbacks, NULL), -EINVAL);
    dexel_close(d);
    options = (struct dexel_options){.n_tile_rows = 1};
    assert_int_equal(dexel_open(&d, &options, &callbacks, NULL), -EINVAL);
    dexel_close(d);

    setenv("DEXELD_SOCKET", "/tmp/dexel-test-none/env", 1);
    assert_int_equal(dexel_open(&d, NULL, &callbacks, NULL), -ENOENT);
    assert_non_null(strstr(dexel_error(d), "/tmp/dexel-test-none/env"));
    dexel_close(d);
    dexel_close(NULL);
    assert_non_null(dexel_error(NULL));
    assert_string_equal(dexel_version(), DEXELD_VERSION);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_good_sessions),
        cmocka_unit_test(test_dribbled_bytes),
        cmocka_unit_test(test_smoothed),
        cmocka_unit_test(test_what_the_client_says),
        cmocka_unit_test(test_next_to_a_deaf_server),
        cmocka_unit_test(test_reset_with_another_geometry),
        cmocka_unit_test(test_raw_tiles),
        cmocka_unit_test(test_callback_stops),
        cmocka_unit_test(test_skippable),
        cmocka_unit_test(test_open_errors),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
