/* A server in a thread on a socket of its own, and a scripted mesher in another. */
#ifndef SERVER_FIXTURE_H
#define SERVER_FIXTURE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <semaphore.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "core/base/hash.h"
#include "core/wire/wire.h"
#include "daemon/feed_priv.h"
#include "daemon/log.h"
#include "daemon/server.h"
#include "tests/unit/feed_body.h"

#define MAX_TILES 128

struct fixture {
    char dir[64], mesh[96], control[108];
    struct dx_server *server;
    struct dx_feed *feed;
    struct dx_counters counters;
    pthread_t server_thread, mesher_thread;
    bool server_runs;
    _Atomic uint32_t n_subscribers;

    /* the mesher; `target`, `stop`, `next_*` are the test's, the rest its own */
    sem_t wake;
    _Atomic uint64_t target;
    _Atomic bool stop;
    _Atomic uint64_t done_frame; /* published */
    _Atomic uint32_t grid;       /* number of the geometry wanted */
    _Atomic int state;           /* to be told after the target, -1: none */
    bool lossless;
    uint32_t body_len; /* longest */
    uint8_t attr_bytes;
    bool normals;
};

struct fixture_options {
    struct dx_server_options server;
    bool lossless;
    uint32_t body_len; /* 0: up to 300 bytes */
    uint32_t n_blocks; /* 0: plenty */
    uint32_t grid;
    uint8_t attr_bytes;
    bool normals;
    bool no_mesh; /* until target moves there is no geometry */
};

/* Geometries of 2x3, 3x4 and 10x11 tiles, odd sizes; from 100 on with 32-bit ranges, from 200 on a
 * table. */
static const struct fixture_grid {
    uint32_t height, width, rows, cols;
} fixture_grids[] = {{100, 180, 2, 3}, {190, 250, 3, 4}, {640, 700, 10, 11}};

static inline const struct fixture_grid *fixture_grid(uint32_t grid)
{
    return &fixture_grids[grid % 100];
}

static inline struct dx_geometry *fixture_geometry(uint32_t grid)
{
    const struct fixture_grid *size = fixture_grid(grid);
    struct dx_geometry *g;

    assert_int_equal(dx_geometry_new(&g, grid >= 200 ? DX_MODEL_TABLE : DX_MODEL_PINHOLE,
                                     size->height, size->width),
                     0);
    g->range_bytes = grid >= 100 && grid < 200 ? 4 : 2;
    g->unit_m = 0.001f;
    for (size_t k = 0; k < g->n_table; k++)
        g->table[k] = (float)k * 0.25f;
    return g;
}

static inline uint32_t fixture_n_tiles(uint32_t grid)
{
    return fixture_grid(grid)->rows * fixture_grid(grid)->cols;
}

/* What tile `t` of a frame holds: the last frame that changed it, times 100, and itself; some are
 * empty. */
static inline uint64_t fixture_version(uint64_t frame, uint32_t t)
{
    uint64_t last = frame - frame % (1 + t % 3);

    return last == 0 || (last + t) % 5 == 0 ? 0 : 100 * last + t;
}

/* Section bits of the chunks. */
static inline uint8_t fixture_sections(const struct fixture *fx)
{
    return (uint8_t)(fx->attr_bytes | (fx->normals ? DX_CHUNK_NORMALS : 0));
}

/* TILE body of a version: a chunk's header, the version between the sections, and bytes that follow
 * from it. */
static inline size_t fixture_body(uint8_t *body, uint64_t version, unsigned encoding, uint32_t cols,
                                  uint32_t tile, uint32_t max_len, uint8_t sections)
{
    uint16_t n = (uint16_t)(version ? 1 + dx_hash_u64(9, version) % max_len : 0);
    uint8_t *p = body + DX_CHUNK_HEADER_LEN;

    memset(body, 0, DX_CHUNK_HEADER_LEN);
    dx_put_u16(body, (uint16_t)(tile / cols));
    dx_put_u16(body + 2, (uint16_t)(tile % cols));
    body[4] = (uint8_t)encoding;
    if (!version)
        return DX_CHUNK_HEADER_LEN;
    body[DX_CHUNK_SECTIONS_AT] = sections;
    dx_put_u16(body + 6, n);
    dx_put_u16(body + 8, 1);
    for (uint32_t k = 0; k < n * (sections & 3u); k++)
        *p++ = (uint8_t)(version * 7 + k);
    dx_put_u64(p, version);
    p += 8;
    for (uint32_t k = 0; k < n; k++)
        *p++ = (uint8_t)(version * 31 + k + encoding);
    for (uint32_t k = 0; sections & DX_CHUNK_NORMALS && k < 2u * n; k++)
        *p++ = (uint8_t)(version * 13 + k);
    return (size_t)(p - body);
}

/* ---- the mesher
 * ---------------------------------------------------------------------------------- */

struct mesher {
    struct fixture *fx;
    uint64_t epoch, frame;
    uint32_t grid;
    bool announced;
    uint32_t served[DX_N_FORMS];
};

static inline bool mesher_add(struct mesher *m, uint64_t frame, const uint32_t *generation)
{
    static __thread uint8_t body[DX_WIRE_MAX_BODY];
    struct fixture *fx = m->fx;
    uint32_t n_tiles = fixture_n_tiles(m->grid);

    dx_feed_begin(fx->feed, m->epoch + 1, generation);
    for (uint32_t k = 0; k < DX_N_FORMS * n_tiles; k++) {
        uint32_t e = k / n_tiles, t = k % n_tiles;
        uint64_t version = fixture_version(frame, t);

        if (!generation[e] ||
            (generation[e] == m->served[e] && version == fixture_version(m->frame, t)))
            continue;
        if (!feed_add_body(fx->feed, t, e, body,
                           fixture_body(body, version, dx_form_encoding(e),
                                        fixture_grid(m->grid)->cols, t, fx->body_len,
                                        fixture_sections(fx))))
            return false;
    }
    return true;
}

/* False: nothing to do, or not now. Its stages take 1, 2, 4 and 8 ms. */
static inline bool mesher_publish(struct mesher *m)
{
    const struct dx_passage passage = {1000000, 2000000, 4000000, 8000000, 16000000};
    struct fixture *fx = m->fx;
    uint32_t generation[DX_N_FORMS];
    uint64_t frame = m->frame, target = atomic_load(&fx->target);
    bool unserved = false;

    dx_feed_wanted(fx->feed, generation);
    for (int e = 0; e < DX_N_FORMS; e++)
        unserved |= generation[e] && generation[e] != m->served[e];
    if (frame < target && (!fx->lossless || dx_feed_lossless_epoch(fx->feed) >= m->epoch))
        frame++;
    else if (!unserved || frame == 0)
        return false;
    if (!mesher_add(m, frame, generation)) {
        dx_feed_abort(fx->feed);
        dx_count(&fx->counters.n_short_of_chunks, 1);
        return false;
    }
    dx_feed_commit(fx->feed, &(struct dx_msg_commit){.frame = frame, .host_ns = 1}, &passage);
    memcpy(m->served, generation, sizeof(m->served));
    m->epoch++;
    m->frame = frame;
    dx_count(&fx->counters.n_frames, 1);
    return true;
}

static inline void mesher_announce(struct mesher *m)
{
    struct dx_geometry *g;
    struct dx_terrain_params params;

    m->grid = atomic_load(&m->fx->grid);
    m->announced = true;
    g = fixture_geometry(m->grid);
    dx_terrain_params_default(&params);
    params.normals = m->fx->normals;
    dx_feed_reset(m->fx->feed, g, &params, m->fx->attr_bytes, "another geometry");
    dx_geometry_unref(g);
    memset(m->served, 0, sizeof(m->served));
    m->frame = m->frame ? m->frame - 1 : 0; /* the same frame again, on the new grid */
}

static inline void *mesher_main(void *fixture)
{
    struct fixture *fx = fixture;
    struct mesher m = {.fx = fx};
    int told = -1;

    while (!atomic_load(&fx->stop)) {
        int state = atomic_load(&fx->state);

        if (atomic_load(&fx->target) && (!m.announced || (m.grid != atomic_load(&fx->grid) &&
                                                          m.frame == atomic_load(&fx->target))))
            mesher_announce(&m);
        while (m.announced && mesher_publish(&m))
            ;
        if (state >= 0 && state != told && m.frame == atomic_load(&fx->target)) {
            dx_feed_state(fx->feed, (enum dx_stream_state)state, "as the test says");
            told = state;
        }
        atomic_store(&fx->done_frame, m.frame);
        sem_wait(&fx->wake);
    }
    return NULL;
}

static inline void fixture_kick(void *fx)
{
    sem_post(&((struct fixture *)fx)->wake);
}

/* The mesher publishes up to frame n, each as an epoch of its own. */
static inline void fixture_frames(struct fixture *fx, uint64_t n)
{
    atomic_store(&fx->target, n);
    fixture_kick(fx);
}

static inline void fixture_state(struct fixture *fx, enum dx_stream_state state)
{
    atomic_store(&fx->state, state);
    fixture_kick(fx);
}

/* ---- start and end
 * ------------------------------------------------------------------------------- */

static inline void fixture_count(void *fx, uint32_t n)
{
    atomic_store(&((struct fixture *)fx)->n_subscribers, n);
}

static inline void *server_main(void *fixture)
{
    struct fixture *fx = fixture;
    int r = dx_server_run(fx->server);

    return (void *)(intptr_t)r;
}

static inline struct fixture *fixture_start(const struct fixture_options *options)
{
    static const struct fixture_options defaults;
    struct fixture *fx = calloc(1, sizeof(*fx));
    struct dx_server_options o;
    struct dx_err err;
    uint32_t n_blocks;

    options = options ? options : &defaults;
    fx->body_len = options->body_len ? options->body_len : 300;
    fx->lossless = options->lossless;
    fx->attr_bytes = options->attr_bytes;
    fx->normals = options->normals;
    atomic_store(&fx->state, -1);
    atomic_store(&fx->grid, options->grid);
    dx_log_set_level(LOG_ERR);
    strcpy(fx->dir, "/tmp/dexeld-test-XXXXXX");
    assert_non_null(mkdtemp(fx->dir));
    snprintf(fx->mesh, sizeof(fx->mesh), "%s/mesh.sock", fx->dir);
    snprintf(fx->control, sizeof(fx->control), "%s/control.sock", fx->dir);
    o = options->server;
    o.mesh_path = fx->mesh;
    o.control_path = fx->control;
    sem_init(&fx->wake, 0, 0);
    if (dx_server_new(&fx->server, &o, &err) < 0)
        fail_msg("%s", err.text);
    n_blocks = options->n_blocks ? options->n_blocks : 16384;
    assert_int_equal(
        dx_feed_new_sized(&fx->feed, MAX_TILES, n_blocks, 2048, 64, -1, fixture_kick, fx), 0);
    assert_int_equal(
        dx_server_add_stream(fx->server,
                             &(struct dx_server_stream_options){.name = "test",
                                                                .feed = fx->feed,
                                                                .counters = &fx->counters,
                                                                .lossless = options->lossless,
                                                                .subscribers = fixture_count,
                                                                .ctx = fx}),
        0);
    assert_int_equal(pthread_create(&fx->server_thread, NULL, server_main, fx), 0);
    fx->server_runs = true;
    assert_int_equal(pthread_create(&fx->mesher_thread, NULL, mesher_main, fx), 0);
    if (!options->no_mesh)
        fixture_frames(fx, 3);
    while (!options->no_mesh && atomic_load(&fx->done_frame) < 3)
        sched_yield();
    return fx;
}

static inline void fixture_join_server(struct fixture *fx)
{
    void *r;

    pthread_join(fx->server_thread, &r);
    fx->server_runs = false;
    assert_int_equal((intptr_t)r, 0);
}

static inline void fixture_stop(struct fixture *fx)
{
    atomic_store(&fx->stop, true);
    fixture_kick(fx);
    pthread_join(fx->mesher_thread, NULL);
    if (fx->server_runs) {
        dx_server_stop(fx->server);
        fixture_join_server(fx);
    }
    dx_server_free(fx->server);
    assert_int_equal(access(fx->mesh, F_OK), -1); /* unlinked */
    dx_feed_free(fx->feed);
    sem_destroy(&fx->wake);
    assert_int_equal(rmdir(fx->dir), 0);
    free(fx);
}

#endif
