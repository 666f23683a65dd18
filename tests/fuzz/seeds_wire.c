/*
 * Writes the seeds of fuzz_wire: good chunks, messages and sessions, in the form that its first
 * byte chooses. cc -std=gnu17 -I. -D_GNU_SOURCE -o seeds_wire tests/fuzz/seeds_wire.c
 * build/lib/libdexel.a -lm -pthread
 *   ./seeds_wire tests/fuzz/corpus/wire
 */
#include <stdio.h>

#include "tests/unit/tile_fixture.h"

enum target {
    CHUNK = 0,
    RAW,
    FRAMED,
    HELLO,
    WELCOME,
    ERROR,
    SUBSCRIBE,
    SUBSCRIBED,
    GEOMETRY,
    COMMIT,
    RESET,
    STATE
};

static const char *folder;

static void save(const char *name, enum target target, const uint8_t *head, size_t head_len,
                 const uint8_t *bytes, size_t len)
{
    char path[512];
    FILE *f;

    snprintf(path, sizeof(path), "%s/%s", folder, name);
    f = fopen(path, "wb");
    if (!f || fputc((int)target, f) == EOF || (head && fwrite(head, 1, head_len, f) != head_len) ||
        fwrite(bytes, 1, len, f) != len || fclose(f) != 0) {
        perror(path);
        exit(1);
    }
}

static void save_chunks(void)
{
    static struct dx_tile tile;
    static uint8_t chunk[DX_WIRE_MAX_BODY];

    for (uint8_t i = 0; i < 6; i++) {
        const uint8_t wrap = i & 1;
        struct dx_rng rng = dx_rng_init(1, i);
        struct dx_geometry *g = fixture_geometry(71, 90, wrap);
        struct dx_tiling t;

        dx_tiling_init(&t, 71, 90, wrap);
        fixture_tile(&tile, &t, 3, i % 3, i < 3 ? 30 : 250, &rng);
        if (i / 2 & 1)
            fixture_normals(&tile, &rng);
        for (enum dx_encoding e = 0; e < DX_N_ENCODINGS; e++) {
            char name[64];

            snprintf(name, sizeof(name), "chunk-%s-%d", dx_encoding_name(e), i);
            save(name, CHUNK, &wrap, 1, chunk, fixture_chunk(chunk, e, &tile, &t, g));
        }
        dx_geometry_unref(g);
    }
}

/* One of each message a server says, in an order that is right. */
static void make_session(struct script *s, enum dx_encoding e, uint8_t attr_bytes, bool normals)
{
    struct dx_geometry *g = fixture_small_geometry();
    struct dx_tiling t;
    struct dx_tile tile;

    dx_tiling_init(&t, 3, 3, false);
    script_welcome(s);
    for (uint64_t epoch = 1; epoch < 6; epoch += 2) {
        script_state(s, DX_STREAM_LIVE, "");
        script_subscribed_to(s, g, e, attr_bytes, normals);
        script_message(s, DX_MSG_SNAPSHOT_BEGIN, 0, epoch, NULL, 0);
        fixture_small_tile(&tile);
        tile.attr_bytes = attr_bytes;
        tile.has_normals = normals;
        script_tile(s, e, epoch, &tile, &t, g);
        script_commit(s, epoch, 1);
        script_message(s, DX_MSG_SNAPSHOT_END, 0, epoch, NULL, 0);
        script_message(s, 77, DX_WIRE_SKIPPABLE, 0, "new", 3);
        memset(tile.code, 0, sizeof(tile.code));
        script_tile(s, e, epoch + 1, &tile, &t, g);
        script_commit(s, epoch + 1, 1);
        script_reset(s, "again");
    }
    script_state(s, DX_STREAM_ENDED, "end of file");
    script_error(s, DX_WIRE_E_SHUTDOWN, "bye");
    dx_geometry_unref(g);
}

/* The same messages with the short heads of the framed target. */
static size_t shorten(uint8_t *out, const struct script *s)
{
    uint8_t *p = out;

    for (size_t at = 0; at < s->len;) {
        struct dx_wire_header h;

        dx_wire_get_header(&h, s->bytes + at);
        at += DX_WIRE_HEADER_LEN;
        *p++ = (uint8_t)h.type;
        *p++ = (uint8_t)h.flags;
        *p++ = (uint8_t)h.epoch;
        dx_put_u16(p, (uint16_t)h.length);
        memcpy(p + 2, s->bytes + at, h.length);
        p += 2 + h.length;
        at += h.length;
    }
    return (size_t)(p - out);
}

static void save_sessions(void)
{
    static uint8_t framed[1 << 16];

    for (uint8_t i = 0; i < 6; i++) {
        const uint8_t raw_head[2] = {i, i == 1 ? 0 : 255};
        struct script s = {0};
        char name[64];

        make_session(&s, (enum dx_encoding)(i % DX_N_ENCODINGS), i / 3, i % 2);
        snprintf(name, sizeof(name), "session-raw-%d", i);
        save(name, RAW, raw_head, 2, s.bytes, s.len);
        snprintf(name, sizeof(name), "session-framed-%d", i);
        save(name, FRAMED, &i, 1, framed, shorten(framed, &s));
        free(s.bytes);
    }
}

/* The body of each message of a session, and those that a client says. */
static void save_bodies(void)
{
    static const uint8_t target_of[] = {
        [DX_MSG_WELCOME] = WELCOME,   [DX_MSG_ERROR] = ERROR,   [DX_MSG_SUBSCRIBED] = SUBSCRIBED,
        [DX_MSG_GEOMETRY] = GEOMETRY, [DX_MSG_COMMIT] = COMMIT, [DX_MSG_RESET] = RESET,
        [DX_MSG_STREAM_STATE] = STATE};
    const struct dx_msg_subscribe subscribe = {
        .stream = "roof", .encoding = 0, .want = 3, .lod = {64, 32}};
    const struct dx_msg_hello hello = {DX_WIRE_MAJOR, DX_WIRE_MINOR, 0, 7};
    struct script s = {0};
    struct dx_wire_header h;

    make_session(&s, DX_ENCODING_Q16, 1, true);
    SCRIPT_PUT(&s, DX_MSG_HELLO, hello, &hello);
    SCRIPT_PUT(&s, DX_MSG_SUBSCRIBE, subscribe, &subscribe);
    for (size_t at = 0; at < s.len; at += DX_WIRE_HEADER_LEN + h.length) {
        uint8_t target;
        char name[64];

        dx_wire_get_header(&h, s.bytes + at);
        target = h.type < sizeof(target_of) ? target_of[h.type] : 0;
        if (h.type == DX_MSG_HELLO || h.type == DX_MSG_SUBSCRIBE)
            target = h.type == DX_MSG_HELLO ? HELLO : SUBSCRIBE;
        snprintf(name, sizeof(name), "body-%u", h.type);
        if (target)
            save(name, (enum target)target, NULL, 0, s.bytes + at + DX_WIRE_HEADER_LEN, h.length);
    }
    free(s.bytes);
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        fprintf(stderr, "usage: seeds_wire FOLDER\n");
        return 2;
    }
    folder = argv[1];
    save_chunks();
    save_sessions();
    save_bodies();
    return 0;
}
