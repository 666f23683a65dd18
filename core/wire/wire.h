/*
 * The socket protocol: framing and the bodies of all messages, both directions, little-endian. One
 * struct a message, one put and one get each; docs/protocol.md is the reference and says what each
 * field means. Pure functions on bytes; any thread.
 */
#ifndef DX_WIRE_H
#define DX_WIRE_H

#include "core/base/bytes.h"
#include "core/grid/geometry.h"
#include "core/grid/lod_level.h"

#define DX_WIRE_MAGIC 0x4c584544u /* "DEXL" */
#define DX_WIRE_MAJOR 1
#define DX_WIRE_MINOR 0

/* u32 length (of the body) | u16 type | u16 flags | u32 stream | u32 seq | u64 epoch */
#define DX_WIRE_HEADER_LEN      24
#define DX_WIRE_MAX_BODY        (256u << 10) /* server to client */
#define DX_WIRE_MAX_CLIENT_BODY 1024u        /* client to server */
#define DX_WIRE_GEOMETRY_PIECE  (64u << 10)  /* table bytes in one GEOMETRY message */

#define DX_WIRE_SKIPPABLE       0x0001u /* header flag: who does not know the type skips the message */

#define DX_WIRE_NO_STREAM       0xffffffffu /* header.stream of messages that are not about a stream */

enum dx_message {
    DX_MSG_HELLO = 1, /* client */
    DX_MSG_WELCOME = 2,
    DX_MSG_ERROR = 3,
    DX_MSG_SUBSCRIBE = 4, /* client */
    DX_MSG_SUBSCRIBED = 5,
    DX_MSG_GEOMETRY = 6,
    DX_MSG_TILE = 7,
    DX_MSG_COMMIT = 8,
    DX_MSG_RESET = 9,
    DX_MSG_SNAPSHOT_BEGIN = 10,
    DX_MSG_SNAPSHOT_END = 11,
    DX_MSG_STREAM_STATE = 12,
    DX_MSG_NEXT = 13, /* client, pull mode */
};

enum dx_encoding {
    DX_ENCODING_F32 = 0,
    DX_ENCODING_Q16 = 1,
    DX_ENCODING_DELTA = 2,
    DX_N_ENCODINGS = 3,
};

/* Ranges travel, and the geometry with them: the client makes the points. */
static inline bool dx_encoding_has_ranges(unsigned encoding)
{
    return encoding != DX_ENCODING_F32;
}

enum dx_mode {
    DX_MODE_LIVE =
        0, /* batches as fast as the client takes them, at most one per min_interval_ms */
    DX_MODE_PULL = 1,     /* one batch for each NEXT */
    DX_MODE_LOSSLESS = 2, /* every epoch; only from a replay at rate max */
};

enum dx_wire_error { /* code of an ERROR message */
                     DX_WIRE_E_PROTOCOL = 1,
                     DX_WIRE_E_VERSION = 2,
                     DX_WIRE_E_NO_STREAM = 3,
                     DX_WIRE_E_ENCODING = 4,
                     DX_WIRE_E_MODE = 5,
                     DX_WIRE_E_LIMIT = 6,
                     DX_WIRE_E_SLOW = 7,
                     DX_WIRE_E_SHUTDOWN = 8,
                     DX_WIRE_E_DISMISSED = 9, /* an operator has ended the connection */
};

enum dx_stream_state {
    DX_STREAM_OPENING = 0,
    DX_STREAM_LIVE = 1,
    DX_STREAM_STALLED = 2,
    DX_STREAM_GONE = 3,
    DX_STREAM_ENDED = 4,
    DX_STREAM_FAULTED = 5,
};

#define DX_WIRE_TEXT 160 /* room for a text and its NUL; on the wire u16 length + bytes */
#define DX_WIRE_NAME 64

struct dx_wire_header {
    uint32_t length;
    uint16_t type, flags;
    uint32_t stream, seq;
    uint64_t epoch;
};

struct dx_msg_hello {
    uint16_t major, minor;
    uint32_t features;  /* none defined yet */
    uint32_t encodings; /* bit per enum dx_encoding that the client can read */
};

struct dx_msg_welcome {
    uint16_t major, minor;
    uint32_t features, encodings;
    uint32_t max_body; /* no message of this server has a longer body */
    uint32_t n_streams;
    char server[DX_WIRE_TEXT]; /* "dexeld 0.1.0" */
};

struct dx_msg_error {
    uint16_t code;
    char text[DX_WIRE_TEXT];
};

#define DX_WANT_ATTR    0x1u
#define DX_WANT_NORMALS 0x2u

struct dx_msg_subscribe {
    char stream[DX_WIRE_NAME]; /* "" takes the only stream */
    uint8_t encoding, mode;
    uint8_t want; /* DX_WANT_*: sections, where the stream has them */
    uint32_t min_interval_ms;
    uint16_t tile_row0, tile_col0, n_tile_rows, n_tile_cols; /* region; 0 rows and cols = all */
    struct dx_lod_level lod; /* not checked by get: what is wrong is told in words */
};

struct dx_msg_subscribed {
    char stream[DX_WIRE_NAME];
    uint8_t encoding, mode;
    uint8_t attr_bytes; /* 0: TILEs carry no attribute */
    uint8_t model, wrap, flip, range_bytes;
    uint8_t normals; /* 1: TILEs carry normals */
    uint8_t smooth;  /* 1: vertices are no samples: ranges are smoothed */
    uint32_t height, width;
    uint16_t tile_rows, tile_cols;
    float unit_m;
    double pose[12];
    uint32_t table_bytes; /* GEOMETRY follows in pieces when not 0 (q16, delta) */
    double sigma[3], tilt_deg, noise_k, cap_m;
    uint8_t diag, paper;
    struct dx_lod_level lod;
};

struct dx_msg_geometry {    /* a piece of the tables, f32 bits */
    uint32_t offset, total; /* bytes */
    uint32_t len;
    const uint8_t *bytes; /* into the body */
};

struct dx_msg_commit {
    uint64_t frame; /* number of the newest frame in this epoch, from 0 */
    uint64_t host_ns, device_ns;
    uint32_t
        clock_id; /* of device_ns: 0 none, 1 CLOCK_REALTIME, 2 CLOCK_MONOTONIC, 3 device's own */
    uint64_t n_dropped; /* frames the mailbox skipped since the stream began */
    uint32_t n_tiles;   /* TILE messages in this batch */
    uint32_t flags;     /* DX_COMMIT_* */
};

#define DX_COMMIT_PARTIAL   0x1u /* more columns of this frame will come */
#define DX_COMMIT_CAP_FIRST 0x2u /* a fan over the first row belongs to the mesh */
#define DX_COMMIT_CAP_LAST  0x4u

struct dx_msg_reset {
    char reason[DX_WIRE_TEXT];
};

struct dx_msg_stream_state {
    uint8_t state;
    char reason[DX_WIRE_TEXT];
};

/* The minor that a server speaks to a client of the same major: the smaller one. */
static inline uint16_t dx_wire_minor(uint16_t of_client)
{
    const unsigned ours = DX_WIRE_MINOR;

    return of_client < ours ? of_client : (uint16_t)ours;
}

void dx_wire_put_header(uint8_t out[DX_WIRE_HEADER_LEN], const struct dx_wire_header *h);
void dx_wire_get_header(struct dx_wire_header *h, const uint8_t in[DX_WIRE_HEADER_LEN]);

/*
 * put: appends the body to the writer (check w->failed). get: 0, or -EBADMSG when the body is too
 * short, too long, or a field is out of its range; a HELLO of a version that is not ours may be
 * longer. Texts are cut to their room, never left without NUL.
 */
void dx_msg_hello_put(struct dx_writer *w, const struct dx_msg_hello *m);
int dx_msg_hello_get(struct dx_msg_hello *m, const uint8_t *body, size_t len);
void dx_msg_welcome_put(struct dx_writer *w, const struct dx_msg_welcome *m);
int dx_msg_welcome_get(struct dx_msg_welcome *m, const uint8_t *body, size_t len);
void dx_msg_error_put(struct dx_writer *w, const struct dx_msg_error *m);
int dx_msg_error_get(struct dx_msg_error *m, const uint8_t *body, size_t len);
void dx_msg_subscribe_put(struct dx_writer *w, const struct dx_msg_subscribe *m);
int dx_msg_subscribe_get(struct dx_msg_subscribe *m, const uint8_t *body, size_t len);
void dx_msg_subscribed_put(struct dx_writer *w, const struct dx_msg_subscribed *m);
int dx_msg_subscribed_get(struct dx_msg_subscribed *m, const uint8_t *body, size_t len);
void dx_msg_geometry_put(struct dx_writer *w, const struct dx_msg_geometry *m);
int dx_msg_geometry_get(struct dx_msg_geometry *m, const uint8_t *body, size_t len);
void dx_msg_commit_put(struct dx_writer *w, const struct dx_msg_commit *m);
int dx_msg_commit_get(struct dx_msg_commit *m, const uint8_t *body, size_t len);
void dx_msg_reset_put(struct dx_writer *w, const struct dx_msg_reset *m);
int dx_msg_reset_get(struct dx_msg_reset *m, const uint8_t *body, size_t len);
void dx_msg_stream_state_put(struct dx_writer *w, const struct dx_msg_stream_state *m);
int dx_msg_stream_state_get(struct dx_msg_stream_state *m, const uint8_t *body, size_t len);

const char *dx_encoding_name(unsigned encoding); /* "f32", "q16", "delta" */
const char *dx_mode_name(unsigned mode);         /* "live", "pull", "lossless" */
int dx_encoding_from_name(const char *name);     /* or -1 */
const char *dx_stream_state_name(unsigned state);

#endif
