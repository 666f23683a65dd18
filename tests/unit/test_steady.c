/*
 * A stream that runs allocates nothing: driver, mailbox, mesher, feed, server and a subscriber on a
 * real socket, all in this process, whose own calls of malloc and its kin are counted (linked with
 * -Wl,--wrap; Makefile). Bounded by epochs, not by time.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include "core/wire/wire.h"
#include "daemon/clock.h"
#include "daemon/config.h"
#include "daemon/log.h"
#include "daemon/server.h"
#include "daemon/stream.h"
#include "tools/alloc_count.h"

#define WARM_EPOCHS     20
#define MEASURED_EPOCHS 100

struct service {
    char dir[64], socket[96];
    struct dx_config config;
    struct dx_pool *pool;
    struct dx_stream *stream;
    struct dx_server *server;
    pthread_t loop;
};

static void *run_loop(void *server)
{
    dx_server_run(server);
    return NULL;
}

static void add_stream(struct service *s)
{
    struct dx_server_stream_options options = {.name = dx_stream_config(s->stream)->name,
                                               .feed = dx_stream_feed(s->stream),
                                               .counters = dx_stream_counters(s->stream),
                                               .subscribers = dx_stream_subscribers,
                                               .ctx = s->stream};

    assert_int_equal(dx_server_add_stream(s->server, &options), 0);
}

/* A recording goes into our folder. */
static void place_recording(struct service *s)
{
    char *path = NULL;

    if (!*s->config.streams[0].record.path)
        return;
    assert_true(asprintf(&path, "%s/rec.mcap", s->dir) > 0);
    free(s->config.streams[0].record.path);
    s->config.streams[0].record.path = path;
}

static void service_init(struct service *s, const char *yaml)
{
    struct dx_server_options options = {.mesh_path = s->socket};
    struct dx_err err = {0};

    memset(s, 0, sizeof(*s));
    dx_log_set_level(3);
    strcpy(s->dir, "/tmp/test_steady.XXXXXX");
    assert_non_null(mkdtemp(s->dir));
    snprintf(s->socket, sizeof(s->socket), "%s/mesh.sock", s->dir);
    if (dx_config_parse(&s->config, "steady", yaml, strlen(yaml), &err) < 0)
        fail_msg("%s", err.text);
    place_recording(s);
    assert_int_equal(dx_pool_new(&s->pool, 2), 0);
    assert_int_equal(dx_stream_new(&s->stream, &s->config.streams[0], s->pool, &err), 0);
    assert_int_equal(dx_server_new(&s->server, &options, &err), 0);
    add_stream(s);
    assert_int_equal(pthread_create(&s->loop, NULL, run_loop, s->server), 0);
    assert_int_equal(dx_stream_start(s->stream, &err), 0);
}

static void service_fini(struct service *s)
{
    dx_stream_stop(s->stream);
    assert_true(dx_stream_join(s->stream, dx_clock_ns() + 300000000000u));
    dx_server_stop(s->server);
    pthread_join(s->loop, NULL);
    dx_server_free(s->server);
    dx_stream_free(s->stream);
    if (*s->config.streams[0].record.path)
        assert_int_equal(unlink(s->config.streams[0].record.path), 0);
    dx_pool_free(s->pool);
    dx_config_fini(&s->config);
    assert_int_equal(rmdir(s->dir), 0);
}

/* ---- a subscriber that allocates nothing ---------------------------------------------------- */

static void send_message(int fd, uint16_t type, const uint8_t *body, size_t len)
{
    struct dx_wire_header h = {.length = (uint32_t)len, .type = type};
    uint8_t bytes[DX_WIRE_HEADER_LEN + 512];

    assert_true(len <= 512);
    dx_wire_put_header(bytes, &h);
    memcpy(bytes + DX_WIRE_HEADER_LEN, body, len);
    assert_int_equal(send(fd, bytes, DX_WIRE_HEADER_LEN + len, MSG_NOSIGNAL),
                     DX_WIRE_HEADER_LEN + len);
}

static int subscribe(const char *path, enum dx_encoding encoding, struct dx_lod_level lod)
{
    struct dx_msg_hello hello = {DX_WIRE_MAJOR, DX_WIRE_MINOR, 0, 1u << encoding};
    struct dx_msg_subscribe ask = {.encoding = (uint8_t)encoding, .want = DX_WANT_ATTR, .lod = lod};
    struct sockaddr_un addr = {.sun_family = AF_UNIX};
    struct timeval silence = {.tv_sec = 300};
    uint8_t body[512];
    struct dx_writer w = dx_writer_init(body, sizeof(body));
    int fd = socket(AF_UNIX, SOCK_STREAM, 0);

    snprintf(addr.sun_path, sizeof(addr.sun_path), "%s", path);
    setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &silence, sizeof(silence));
    assert_int_equal(connect(fd, (struct sockaddr *)&addr, sizeof(addr)), 0);
    dx_msg_hello_put(&w, &hello);
    send_message(fd, DX_MSG_HELLO, body, (size_t)(w.p - body));
    w = dx_writer_init(body, sizeof(body));
    dx_msg_subscribe_put(&w, &ask);
    send_message(fd, DX_MSG_SUBSCRIBE, body, (size_t)(w.p - body));
    return fd;
}

static void receive(int fd, void *to, size_t len)
{
    assert_int_equal(recv(fd, to, len, MSG_WAITALL), len);
}

/* Reads until `n` epochs with tiles in them are closed; returns how many tiles came. */
static uint64_t take_epochs(int fd, uint32_t n)
{
    static uint8_t body[DX_WIRE_MAX_BODY];
    uint64_t n_tiles = 0;

    while (n) {
        uint8_t head[DX_WIRE_HEADER_LEN];
        struct dx_wire_header h;
        struct dx_msg_commit commit;

        receive(fd, head, sizeof(head));
        dx_wire_get_header(&h, head);
        assert_true(h.length <= sizeof(body) && h.type != DX_MSG_ERROR);
        if (h.length)
            receive(fd, body, h.length);
        if (h.type != DX_MSG_COMMIT)
            continue;
        assert_int_equal(dx_msg_commit_get(&commit, body, h.length), 0);
        n_tiles += commit.n_tiles;
        n -= commit.n_tiles != 0;
    }
    return n_tiles;
}

/* Whether the recorder, whose thread may come late, has put blocks into its file. */
static bool records(const struct service *s)
{
    const char *path = s->config.streams[0].record.path;
    struct stat st;

    return !*path || (stat(path, &st) == 0 && st.st_size > 0);
}

static void runs_without_allocating(const char *yaml, enum dx_encoding encoding,
                                    struct dx_lod_level lod)
{
    struct service s;
    uint64_t before, after, n_tiles;
    int fd;

    service_init(&s, yaml);
    fd = subscribe(s.socket, encoding, lod);
    take_epochs(fd, WARM_EPOCHS);
    while (!records(&s))
        take_epochs(fd, 1);
    before = dx_alloc_count();
    n_tiles = take_epochs(fd, MEASURED_EPOCHS);
    after = dx_alloc_count();
    close(fd);
    service_fini(&s);
    assert_true(before > 0); /* the counter is linked in */
    assert_true(n_tiles >= MEASURED_EPOCHS);
    assert_int_equal(after - before, 0);
}

/* ---- tests ---------------------------------------------------------------------------------- */

static void whole_frames(enum dx_encoding encoding, struct dx_lod_level lod)
{
    runs_without_allocating("streams:\n"
                            "  - name: hall\n"
                            "    synthetic: {scene: hall, size: 300x200, noise: 0.005,\n"
                            "                dropouts: 0.02, rate: max}\n",
                            encoding, lod);
}

static void whole_frames_to_a_level(void **state)
{
    (void)state;
    whole_frames(DX_ENCODING_F32, (struct dx_lod_level){.bound = 64});
}

static void whole_frames_to_q16(void **state)
{
    (void)state;
    whole_frames(DX_ENCODING_Q16, (struct dx_lod_level){0});
}

static void whole_frames_to_delta(void **state)
{
    (void)state;
    whole_frames(DX_ENCODING_DELTA, (struct dx_lod_level){0});
}

static void parts_of_frames_to_f32(void **state)
{
    (void)state;
    runs_without_allocating("streams:\n"
                            "  - name: hall\n"
                            "    commit_ms: 1\n"
                            "    synthetic: {scene: hall, size: 300x200, noise: 0.005,\n"
                            "                dropouts: 0.02, rate: max, parts: 20}\n",
                            DX_ENCODING_F32, (struct dx_lod_level){0});
}

static void averaged_parts_to_q16(void **state)
{
    (void)state;
    runs_without_allocating("streams:\n"
                            "  - name: box\n"
                            "    commit_ms: 1\n"
                            "    ingest: {filter: mean, keyframe: 5}\n"
                            "    synthetic: {scene: moving-box, size: 300x200, noise: 0.005,\n"
                            "                dropouts: 0.02, rate: max, parts: 20}\n",
                            DX_ENCODING_Q16, (struct dx_lod_level){0});
}

static void medians_to_f32(void **state)
{
    (void)state;
    runs_without_allocating("streams:\n"
                            "  - name: hall\n"
                            "    ingest: {filter: median3}\n"
                            "    synthetic: {scene: hall, size: 300x200, noise: 0.005,\n"
                            "                dropouts: 0.02, rate: max}\n",
                            DX_ENCODING_F32, (struct dx_lod_level){0});
}

/* The recorder's thread as well. */
static void recorded_parts_to_q16(void **state)
{
    (void)state;
    runs_without_allocating("streams:\n"
                            "  - name: hall\n"
                            "    commit_ms: 1\n"
                            "    synthetic: {scene: hall, size: 300x200, noise: 0.005,\n"
                            "                dropouts: 0.02, rate: max, parts: 1}\n"
                            "    record: {path: x.mcap}\n",
                            DX_ENCODING_Q16, (struct dx_lod_level){0});
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(whole_frames_to_a_level), cmocka_unit_test(whole_frames_to_q16),
        cmocka_unit_test(whole_frames_to_delta),   cmocka_unit_test(parts_of_frames_to_f32),
        cmocka_unit_test(averaged_parts_to_q16),   cmocka_unit_test(medians_to_f32),
        cmocka_unit_test(recorded_parts_to_q16),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
