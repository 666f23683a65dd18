/*
 * Connections of the mesh socket, byte by byte: what the client said in one file, what the server
 * said in another (tests/protocol, protocol.sh).
 *
 *   recorded say OUT MAJOR MINOR STREAM ENCODING MODE WANT STRIDE BOUND ROW COL ROWS COLS N
 *                                   what a client says: HELLO, SUBSCRIBE and N times NEXT
 *   recorded take SOCKET SAID OUT   says it to a service, and writes what that answers until it
 *                                   closes; when the stream has ended it is told to quit
 *   recorded meshes SAID HEARD      what libdexel makes of it, a line for each commit; and libdexel
 *                                   must say what that client said
 *   recorded same HEARD HEARD       the same messages, but for tiles, stamps, and texts for people
 */
#include <errno.h>
#include <sys/socket.h>
#include <unistd.h>

#include "core/wire/wire.h"
#include "tests/system/held_meshes.h"
#include "tests/system/raw_socket.h"

#define MAX_LEN  (1u << 20)
#define MAX_SAID 4096

/* ---- files ---------------------------------------------------------------------------------- */

struct bytes {
    size_t len;
    uint8_t at[MAX_LEN];
};

static void load(struct bytes *b, const char *path)
{
    FILE *f = fopen(path, "rb");

    if (!f)
        die("%s: %s", path, strerror(errno));
    b->len = fread(b->at, 1, sizeof(b->at), f);
    fclose(f);
    if (b->len == sizeof(b->at))
        die("%s: expected less than %zu bytes", path, sizeof(b->at));
}

static void store(const struct bytes *b, const char *path)
{
    FILE *f = fopen(path, "wb");

    if (!f || fwrite(b->at, 1, b->len, f) != b->len || fclose(f) != 0)
        die("%s: %s", path, strerror(errno));
}

/* The message at `at`, which is then behind it; false at the end. */
static bool next_message(const struct bytes *b, size_t *at, struct dx_wire_header *h,
                         const uint8_t **body)
{
    if (*at == b->len)
        return false;
    if (b->len - *at < DX_WIRE_HEADER_LEN)
        die("a header is cut at byte %zu", *at);
    dx_wire_get_header(h, b->at + *at);
    *at += DX_WIRE_HEADER_LEN;
    if (b->len - *at < h->length)
        die("a body is cut at byte %zu", *at);
    *body = b->at + *at;
    *at += h->length;
    return true;
}

/* ---- what a client says --------------------------------------------------------------------- */

static void put_message(struct bytes *b, enum dx_message type, uint32_t seq, struct dx_writer *w)
{
    uint8_t *head = b->at + b->len;
    size_t len = (size_t)(w->p - head) - DX_WIRE_HEADER_LEN;
    struct dx_wire_header h = {(uint32_t)len, (uint16_t)type, 0, DX_WIRE_NO_STREAM, seq, 0};

    if (w->failed)
        die("a message that is too long");
    dx_wire_put_header(head, &h);
    b->len += DX_WIRE_HEADER_LEN + len;
}

static struct dx_writer begin(struct bytes *b)
{
    return dx_writer_init(b->at + b->len + DX_WIRE_HEADER_LEN, 256);
}

static uint32_t number(const char *word)
{
    char *end;
    unsigned long n = strtoul(word, &end, 10);

    if (*end || !*word || n > UINT16_MAX)
        die("found '%s', expected a number", word);
    return (uint32_t)n;
}

static void say(char **word)
{
    static struct bytes b;
    const struct dx_msg_hello hello = {(uint16_t)number(word[1]), (uint16_t)number(word[2]), 0, 7};
    struct dx_msg_subscribe m = {.encoding = (uint8_t)number(word[4]),
                                 .mode = (uint8_t)number(word[5]),
                                 .want = (uint8_t)number(word[6]),
                                 .lod.stride = (uint8_t)number(word[7]),
                                 .lod.bound = (uint16_t)number(word[8]),
                                 .tile_row0 = (uint16_t)number(word[9]),
                                 .tile_col0 = (uint16_t)number(word[10]),
                                 .n_tile_rows = (uint16_t)number(word[11]),
                                 .n_tile_cols = (uint16_t)number(word[12])};
    struct dx_writer w = begin(&b);

    snprintf(m.stream, sizeof(m.stream), "%s", word[3]);
    dx_msg_hello_put(&w, &hello);
    put_message(&b, DX_MSG_HELLO, 0, &w);
    w = begin(&b);
    dx_msg_subscribe_put(&w, &m);
    put_message(&b, DX_MSG_SUBSCRIBE, 1, &w);
    for (uint32_t n = 0; n < number(word[13]); n++) {
        w = begin(&b);
        put_message(&b, DX_MSG_NEXT, 2 + n, &w);
    }
    store(&b, word[0]);
}

/* ---- what a service answers ----------------------------------------------------------------- */

static bool has_ended(const struct bytes *b)
{
    struct dx_wire_header h;

    for (size_t at = 0; b->len - at >= DX_WIRE_HEADER_LEN;) {
        dx_wire_get_header(&h, b->at + at);
        at += DX_WIRE_HEADER_LEN;
        if (b->len - at < h.length)
            break;
        if (h.type == DX_MSG_STREAM_STATE && h.length && b->at[at] == DX_STREAM_ENDED)
            return true;
        at += h.length;
    }
    return false;
}

static void quit(const char *mesh_socket)
{
    static const char request[] = "{\"request\":\"quit\"}\n";
    char path[100], answer[64];
    int fd;

    snprintf(path, sizeof(path), "%s.control", mesh_socket);
    fd = connect_to(path);
    if (send(fd, request, strlen(request), MSG_NOSIGNAL) < 0 ||
        read(fd, answer, sizeof(answer)) < 0)
        die("%s: %s", path, strerror(errno));
    close(fd);
}

static void take(char **word)
{
    static struct bytes said, heard;
    bool told = false;
    int fd = connect_to(word[0]);
    ssize_t n;

    load(&said, word[1]);
    if (send(fd, said.at, said.len, MSG_NOSIGNAL) != (ssize_t)said.len)
        die("%s: %s", word[0], strerror(errno));
    do {
        struct pollfd p = {fd, POLLIN, 0};

        if (poll(&p, 1, FOLLOWER_SILENCE_MS) != 1)
            die("the service is silent after %zu bytes", heard.len);
        n = read(fd, heard.at + heard.len, sizeof(heard.at) - heard.len);
        heard.len += n > 0 ? (size_t)n : 0;
        if (!told && has_ended(&heard)) {
            quit(word[0]);
            told = true;
        }
    } while (n > 0);
    close(fd);
    store(&heard, word[2]);
}

/* ---- what libdexel makes of it -------------------------------------------------------------- */

/* What the client asked for, as libdexel is asked for it. */
static void read_wish(struct dexel_options *o, struct dx_msg_subscribe *m, const struct bytes *said)
{
    struct dx_wire_header h;
    const uint8_t *body;
    size_t at = 0;

    next_message(said, &at, &h, &body); /* HELLO */
    if (!next_message(said, &at, &h, &body) || dx_msg_subscribe_get(m, body, h.length) < 0)
        die("the recorded client says no SUBSCRIBE");
    *o = (struct dexel_options){
        .stream = m->stream,
        .encoding = (enum dexel_encoding)m->encoding,
        .mode = (enum dexel_mode)m->mode,
        .want_attr = m->want & DX_WANT_ATTR,
        .want_normals = m->want & DX_WANT_NORMALS,
        .tile_row0 = m->tile_row0,
        .tile_col0 = m->tile_col0,
        .n_tile_rows = m->n_tile_rows,
        .n_tile_cols = m->n_tile_cols,
        .lod_sigma = (double)m->lod.bound / DX_LOD_PER_SIGMA,
        .stride = m->lod.stride,
    };
}

static int listen_at(char *path, size_t len)
{
    struct sockaddr_un addr = {.sun_family = AF_UNIX};
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);

    snprintf(path, len, "recorded-%d.sock", (int)getpid());
    snprintf(addr.sun_path, sizeof(addr.sun_path), "%s", path);
    if (fd < 0 || bind(fd, (const struct sockaddr *)&addr, sizeof(addr)) < 0 || listen(fd, 1) < 0)
        die("%s: %s", path, strerror(errno));
    return fd;
}

/* HELLO's minor alone may be a later one. */
static void check_said(int server, const struct bytes *said)
{
    static uint8_t now[MAX_SAID];
    const size_t minor = DX_WIRE_HEADER_LEN + 6;
    ssize_t n = recv(server, now, sizeof(now), MSG_DONTWAIT);

    if (n < 0 || (size_t)n > said->len)
        die("libdexel says %zd bytes, the recorded client said %zu", n, said->len);
    for (size_t k = 0; k < (size_t)n; k++)
        if (now[k] != said->at[k] && k != minor && k != minor + 1)
            die("byte %zu that libdexel says is %02x, the recorded client said %02x", k, now[k],
                said->at[k]);
}

static void meshes(char **word)
{
    static struct bytes said, heard;
    struct dx_msg_subscribe asked;
    struct dexel_options options;
    struct dexel *d;
    const char *code;
    char path[64];
    int listening = listen_at(path, sizeof(path)), server, room = 4 << 20, r;

    load(&said, word[0]);
    load(&heard, word[1]);
    read_wish(&options, &asked, &said);
    options.socket = path;
    if (dexel_open(&d, &options, &callbacks, NULL) < 0)
        die("%s", dexel_error(d));
    unlink(path);
    server = accept(listening, NULL, NULL);
    setsockopt(server, SOL_SOCKET, SO_SNDBUF, &room, sizeof(room));
    if (said.at[DX_WIRE_HEADER_LEN + 4] == DX_WIRE_MAJOR)
        check_said(server, &said);
    /* all of it at once: a recording is smaller than a socket's buffer */
    if (send(server, heard.at, heard.len, MSG_NOSIGNAL | MSG_DONTWAIT) != (ssize_t)heard.len)
        die("%s: %zu bytes do not fit into a socket", word[1], heard.len);
    shutdown(server, SHUT_WR);
    do
        r = dexel_dispatch(d);
    while (r == 0);
    code = strstr(dexel_error(d), "(error ");
    if (!code)
        die("%s: %s", word[1], dexel_error(d));
    printf("error %d\n", atoi(code + strlen("(error ")));
    dexel_close(d);
    close(server);
    close(listening);
    forget();
}

/* ---- two services --------------------------------------------------------------------------- */

/* Which bytes of a message only tell when it was, or are for people. */
static void mask(const struct dx_wire_header *h, uint8_t *body, uint32_t *len)
{
    switch (h->type) {
    case DX_MSG_WELCOME: /* the server's text */
        *len = 24;
        break;
    case DX_MSG_ERROR:
        *len = 2;
        break;
    case DX_MSG_RESET:
        *len = 0;
        break;
    case DX_MSG_STREAM_STATE:
        *len = 1;
        break;
    case DX_MSG_COMMIT: /* host_ns, device_ns */
        memset(body + 8, 0, 16);
        break;
    case DX_MSG_TILE: /* which tile; what is in it, `meshes` tells */
        *len = 5;
        break;
    default:
        break;
    }
}

/* The next message whose place does not depend on time: states on the way may be left out. */
static bool next_that_counts(const struct bytes *b, size_t *at, struct dx_wire_header *h,
                             uint8_t *body, uint32_t *len)
{
    const uint8_t *from;

    do {
        if (!next_message(b, at, h, &from))
            return false;
    } while (h->type == DX_MSG_STREAM_STATE && *from != DX_STREAM_ENDED);
    if (h->length > DX_WIRE_MAX_BODY)
        die("a body of %u bytes", h->length);
    memcpy(body, from, h->length);
    *len = h->length;
    mask(h, body, len);
    return true;
}

static void same(char **word)
{
    static struct bytes a, b;
    static uint8_t body_a[DX_WIRE_MAX_BODY], body_b[DX_WIRE_MAX_BODY];
    size_t at_a = 0, at_b = 0;
    unsigned n = 0;

    load(&a, word[0]);
    load(&b, word[1]);
    for (;; n++) {
        struct dx_wire_header ha, hb;
        uint32_t len_a = 0, len_b = 0;
        bool more_a = next_that_counts(&a, &at_a, &ha, body_a, &len_a);
        bool more_b = next_that_counts(&b, &at_b, &hb, body_b, &len_b);

        if (!more_a && !more_b)
            break;
        if (more_a != more_b)
            die("%s has more messages than %u", word[more_a ? 0 : 1], n);
        if (ha.type != hb.type || ha.flags != hb.flags || ha.stream != hb.stream ||
            ha.epoch != hb.epoch)
            die("message %u: type %u of epoch %llu, and type %u of epoch %llu", n, ha.type,
                (unsigned long long)ha.epoch, hb.type, (unsigned long long)hb.epoch);
        if (len_a != len_b || memcmp(body_a, body_b, len_a))
            die("message %u, of type %u: other bytes", n, ha.type);
    }
    if (n == 0)
        die("%s: no message", word[0]);
}

int main(int argc, char **argv)
{
    static const struct {
        const char *name;
        int n_words;
        void (*run)(char **word);
    } commands[] = {{"say", 14, say}, {"take", 3, take}, {"meshes", 2, meshes}, {"same", 2, same}};

    for (size_t k = 0; argc > 1 && k < sizeof(commands) / sizeof(commands[0]); k++)
        if (!strcmp(argv[1], commands[k].name) && argc == 2 + commands[k].n_words) {
            commands[k].run(argv + 2);
            return 0;
        }
    fputs("usage: recorded say|take|meshes|same ...\n", stderr);
    return 2;
}
