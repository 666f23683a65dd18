/*
 * libdexel: subscribe to the meshes of a dexeld.
 *
 * A connection belongs to one thread at a time. Two ways to drive it: dexel_run() blocks and calls
 * back; or poll dexel_fd() for dexel_events() and call dexel_dispatch() when it is ready. Callbacks
 * run inside those calls; a callback that returns non-zero stops them, and they return that value.
 *
 * The mesh is state, not a log: each tile replaces the tile of the same row and column; after a
 * commit, the tiles held together are exactly the mesh of that epoch. reset means: forget all
 * tiles; stream is called again before the next one.
 *
 * With `reconnect` a subscription outlives its service: see dexel_options.
 *
 * Functions that can fail return 0 or -errno (-EPROTO: the server broke the protocol or refused us;
 * -ECONNRESET: it went away); dexel_error() then says more. After such an error a connection only
 * repeats it: close it and open another.
 */
#ifndef DEXEL_H
#define DEXEL_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define DEXEL_API __attribute__((visibility("default")))

/* How the mesh travels; what arrives is the same, bit for bit. A vertex takes about 24, 2.4 and 1
 * bytes. Q16 needs a stream with ranges of 16 bits; DELTA costs both sides the most work. */
enum dexel_encoding { DEXEL_F32 = 0, DEXEL_Q16 = 1, DEXEL_DELTA = 2 };
enum dexel_mode { DEXEL_LIVE = 0, DEXEL_PULL = 1, DEXEL_LOSSLESS = 2 };
enum dexel_model { DEXEL_SPINNING = 1, DEXEL_PINHOLE = 2, DEXEL_TABLE = 3 };
enum dexel_state {
    DEXEL_OPENING = 0,
    DEXEL_LIVE_STATE = 1,
    DEXEL_STALLED = 2,
    DEXEL_GONE = 3,
    DEXEL_ENDED = 4,
    DEXEL_FAULTED = 5,
};

struct dexel; /* a connection */

/* What a stream is; told before any data, and again after each reset. Holds until the next time. */
struct dexel_stream {
    const char *name;
    enum dexel_model model;
    uint32_t height, width;        /* dexels: rows, columns */
    uint32_t tile_rows, tile_cols; /* tiles are 64x64 cells */
    int wrap;                      /* column 0 follows the last */
    int flip;                      /* the rows and columns run so that triangles are turned round:
                                      see dexel_commit's caps */
    unsigned attr_bytes;           /* 0, 1 or 2: bytes of a vertex's attribute */
    int normals;                   /* tiles come with normals */
    int smoothed;                  /* vertices are no samples: the stream smooths its ranges */
    double unit_m;                 /* metres per range unit */
    double pose[12];               /* rows of [R|t], scanner to world; not applied to vertices */
    double sigma[3], tilt_deg, noise_k, cap_m; /* mesh parameters in force */
    double lod_sigma;                          /* level of detail, as asked for; 0: none */
    unsigned stride;
};

/* The mesh of one tile. Pointers hold until the callback returns. */
struct dexel_tile {
    uint32_t row, col;                /* of the tile */
    uint32_t n_vertices, n_triangles; /* both 0: the tile is empty now */
    const float *xyz;                 /* [n_vertices][3], metres, scanner frame */
    const uint16_t *index; /* [n_triangles][3] into this tile's vertices; faces see the scanner */
    const uint32_t
        *dexel;           /* [n_vertices] row * width + column: the same in all tiles, to weld by */
    const uint16_t *attr; /* [n_vertices], or NULL */
    const float *normal;  /* [n_vertices][3], unit length, towards the scanner; or NULL */
};

struct dexel_commit {
    uint64_t epoch, frame;
    uint64_t host_ns,
        device_ns;     /* stamps of the newest frame; host is CLOCK_MONOTONIC of the server */
    uint32_t clock_id; /* of device_ns: 0 none, 1 realtime, 2 monotonic, 3 device */
    uint64_t n_dropped;
    uint32_t n_tiles; /* in this batch */
    int partial;      /* more columns of this frame will come */
    int snapshot;     /* the first commit after a subscribe or a reset */
    /*
     * Polar caps: until the next commit the mesh has besides, in no tile, a fan over all dexels of
     * its first or last row, whose triangles are for j = 1 .. width - 2
     *   first row  (0, j + 1, j)        last row  (0, j, j + 1)
     * in columns of that row; the last two are exchanged when the stream's flip is set.
     */
    int cap_first, cap_last;
};

/* Any member may be NULL. */
struct dexel_callbacks {
    int (*stream)(void *user, const struct dexel_stream *stream);
    int (*reset)(void *user, const char *reason);
    int (*tile)(void *user, const struct dexel_tile *tile);
    int (*raw_tile)(void *user, const uint8_t *chunk, size_t len); /* the TILE body, undecoded */
    int (*commit)(void *user, const struct dexel_commit *commit);
    int (*state)(void *user, enum dexel_state state, const char *reason);
};

struct dexel_options {
    const char *socket; /* NULL: $DEXELD_SOCKET, else /run/dexeld/mesh.sock */
    const char *stream; /* NULL: the only stream */
    enum dexel_encoding encoding;
    enum dexel_mode mode;
    int want_attr, want_normals; /* where the stream has them */
    uint32_t min_interval_ms;
    uint16_t tile_row0, tile_col0, n_tile_rows, n_tile_cols; /* region; 0 rows and cols: all */
    /*
     * Level of detail, F32 only; both 0: the whole mesh. Samples within lod_sigma (1/16 to 4095,
     * rounded to 1/16) of what is left may be left out, in steps of `stride` (2, 4 .. 64) at most;
     * without lod_sigma all of them are.
     */
    double lod_sigma;
    unsigned stride;
    /*
     * Not 0: where no service answers, or it goes away, turns us out because it stops, is full or
     * we were too slow, it is tried again: at once, then after 0.1 s, twice that, to 2 s. What is
     * held stays: state tells DEXEL_GONE and why, reset comes when a service has answered, and then
     * all as at the start. dexel_open() does not wait for it. Other errors end the subscription.
     */
    int reconnect;
};

/* Connects and sends HELLO and SUBSCRIBE; what the server answers comes in dispatch. `options` may
 * be NULL. After an error *out is there for dexel_error() and dexel_close() alone (NULL for
 * -ENOMEM). */
DEXEL_API int dexel_open(struct dexel **out, const struct dexel_options *options,
                         const struct dexel_callbacks *callbacks, void *user);
DEXEL_API void dexel_close(struct dexel *d); /* NULL is fine */

DEXEL_API int dexel_fd(const struct dexel *d);
DEXEL_API short dexel_events(
    const struct dexel *d); /* POLLIN, and POLLOUT while bytes wait to go */

/* Handles what was received, reads once what is there, handles that; never waits. 0; a callback's
 * value (messages after it wait for the next call); or negative. Made for level-triggered polling.
 */
DEXEL_API int dexel_dispatch(struct dexel *d);

/* Dispatches until a callback stops it, an error, or the stream ended (then 0). timeout_ms without
 * a byte from the server gives -ETIMEDOUT (-1 waits for ever), a signal -EINTR: call again to go
 * on. */
DEXEL_API int dexel_run(struct dexel *d, int timeout_ms);

/* Pull mode: ask for the next batch; the snapshot is the first. What was asked for and has not come
 * is asked of the next connection (`reconnect`). May be called in a callback. */
DEXEL_API int dexel_next(struct dexel *d);

/* What went wrong last, for people; never NULL, also for a NULL connection. */
DEXEL_API const char *dexel_error(const struct dexel *d);

DEXEL_API const char *dexel_version(void);

#ifdef __cplusplus
}
#endif

#endif
