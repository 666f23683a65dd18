/*
 * hostile SOCKET CONTROL PID: all that clients can do wrong, beside a subscriber that must not
 * notice. Twice: the service's descriptors and memory after the second time are those after the
 * first.
 */
#include <dirent.h>
#include <errno.h>
#include <pthread.h>
#include <semaphore.h>
#include <stdatomic.h>
#include <sys/socket.h>
#include <unistd.h>

#include "core/wire/wire.h"
#include "tests/system/follower.h"
#include "tests/system/raw_socket.h"

#define N_RANDOM     200
#define N_CONNECTS   1000
#define N_SUBSCRIBE  1000
#define N_TORN       50
#define N_EPOCHS     100 /* in which what was closed must be gone from the service */
#define RSS_MORE_KIB 1024

/* ---- beside them ---------------------------------------------------------------------------- */

static struct follower good = {.name = "good"};
static sem_t epochs; /* one for each */
static atomic_bool stop;

static void *follow(void *socket)
{
    struct follower *one = &good;
    unsigned n = 0;

    follower_open(&good, socket, NULL, DEXEL_Q16);
    while (!stop) {
        followers_turn(&one, 1, -1);
        for (; n < good.n_commits; n++)
            sem_post(&epochs);
    }
    follower_close(&good);
    return NULL;
}

static void await_epoch(void)
{
    while (sem_wait(&epochs) < 0)
        ;
}

/* ---- connections ---------------------------------------------------------------------------- */

/* It may be hung up on in the middle: that is not for the client to mind. */
static void say(int fd, const uint8_t *bytes, size_t len)
{
    while (len) {
        ssize_t n = send(fd, bytes, len, MSG_NOSIGNAL);

        if (n < 0)
            return;
        bytes += n;
        len -= (size_t)n;
    }
}

/* Reads to the end of the connection, and closes; -> the code of the ERROR, the last message; 0:
 * none. */
static unsigned hear_end(int fd)
{
    static uint8_t bytes[1 << 20];
    struct pollfd p = {fd, POLLIN, 0};
    size_t len = 0, at = 0;
    unsigned code = 0;
    ssize_t n;

    do {
        if (poll(&p, 1, FOLLOWER_SILENCE_MS) != 1)
            die("the service does not end a connection that broke the protocol");
        n = read(fd, bytes + len, sizeof(bytes) - len);
        len += n > 0 ? (size_t)n : 0;
    } while (n > 0);
    close(fd);
    while (len - at >= DX_WIRE_HEADER_LEN + 2) {
        struct dx_wire_header h;

        dx_wire_get_header(&h, bytes + at);
        code = h.type == DX_MSG_ERROR ? dx_get_u16(bytes + at + DX_WIRE_HEADER_LEN) : 0;
        at += DX_WIRE_HEADER_LEN + h.length;
        if (at > len)
            break;
    }
    return code;
}

/* ---- messages ------------------------------------------------------------------------------- */

static size_t put_message(uint8_t *out, enum dx_message type, uint32_t seq, struct dx_writer *w)
{
    size_t len = (size_t)(w->p - (out + DX_WIRE_HEADER_LEN));
    struct dx_wire_header h = {(uint32_t)len, (uint16_t)type, 0, DX_WIRE_NO_STREAM, seq, 0};

    dx_wire_put_header(out, &h);
    return DX_WIRE_HEADER_LEN + len;
}

static size_t put_hello(uint8_t *out)
{
    struct dx_writer w = dx_writer_init(out + DX_WIRE_HEADER_LEN, 1024);

    dx_msg_hello_put(&w, &(struct dx_msg_hello){DX_WIRE_MAJOR, DX_WIRE_MINOR, 0, 3});
    return put_message(out, DX_MSG_HELLO, 0, &w);
}

static size_t put_subscribe(uint8_t *out, uint32_t seq, const struct dx_msg_subscribe *m)
{
    struct dx_writer w = dx_writer_init(out + DX_WIRE_HEADER_LEN, 1024);

    dx_msg_subscribe_put(&w, m);
    return put_message(out, DX_MSG_SUBSCRIBE, seq, &w);
}

/* ---- what clients do wrong ------------------------------------------------------------------ */

static void random_bytes(const char *socket)
{
    uint64_t word;

    for (uint64_t k = 0; k < N_RANDOM; k++) {
        uint8_t bytes[2048];
        int fd = connect_to(socket);

        for (size_t at = 0; at < sizeof(bytes); at += 8) {
            word = dx_hash_u64(k, at);
            memcpy(bytes + at, &word, 8);
        }
        say(fd, bytes, 64 + k * 7);
        hear_end(fd);
    }
}

static void absurd_lengths(const char *socket)
{
    static const uint32_t lengths[] = {0xffffffff, 0x80000000, 0x7fffffff, 0x00040001,
                                       1025,       0,          15,         17};

    for (size_t k = 0; k < sizeof(lengths) / sizeof(lengths[0]); k++) {
        uint8_t bytes[2048] = {0};
        size_t len = put_hello(bytes);
        int fd = connect_to(socket);
        unsigned code;

        dx_put_u32(bytes, lengths[k]);
        say(fd, bytes, len + 1);
        code = hear_end(fd);
        if (code != DX_WIRE_E_PROTOCOL)
            die("a body of %u bytes: error %u, expected %d", lengths[k], code, DX_WIRE_E_PROTOCOL);
    }
}

static void thousand_connects(const char *socket)
{
    for (unsigned k = 0; k < N_CONNECTS; k++)
        close(connect_to(socket));
}

static void thousand_subscribes(const char *socket)
{
    uint8_t bytes[2048];
    size_t len = put_hello(bytes);
    int fd = connect_to(socket);

    for (uint32_t k = 1; k <= N_SUBSCRIBE; k++) {
        len += put_subscribe(bytes + len, k, &(struct dx_msg_subscribe){.encoding = 1});
        say(fd, bytes, len);
        len = 0;
    }
    hear_end(fd);
}

/* One bad SUBSCRIBE each; the ERROR says what was wrong. */
static void bad_subscribes(const char *socket)
{
    static const struct {
        struct dx_msg_subscribe m;
        unsigned code;
    } bad[] = {
        {{.stream = "nowhere"}, DX_WIRE_E_NO_STREAM}, {{.encoding = 7}, DX_WIRE_E_PROTOCOL},
        {{.mode = DX_MODE_LOSSLESS}, DX_WIRE_E_MODE}, {{.mode = 9}, DX_WIRE_E_PROTOCOL},
        {{.n_tile_rows = 3}, DX_WIRE_E_PROTOCOL},
    };

    for (size_t k = 0; k < sizeof(bad) / sizeof(bad[0]); k++) {
        uint8_t bytes[2048];
        size_t len = put_hello(bytes);
        int fd = connect_to(socket);
        unsigned code;

        len += put_subscribe(bytes + len, 1, &bad[k].m);
        say(fd, bytes, len);
        code = hear_end(fd);
        if (code != bad[k].code)
            die("bad SUBSCRIBE %zu: error %u, expected %u", k, code, bad[k].code);
    }
}

/* Closes in the middle of what it says, and in the middle of what it is told. */
static void torn(const char *socket)
{
    for (unsigned k = 0; k < N_TORN; k++) {
        uint8_t bytes[2048], some[1000];
        size_t len = put_hello(bytes);
        int fd = connect_to(socket);

        len += put_subscribe(bytes + len, 1, &(struct dx_msg_subscribe){.encoding = k % 2});
        say(fd, bytes, k % 3 ? len : len - 1 - k % 16);
        for (unsigned n = 0; k % 3 && n < k; n++)
            if (read(fd, some, sizeof(some)) <= 0)
                die("torn: %s", strerror(errno));
        close(fd);
    }
}

static void control_socket(const char *control)
{
    static char long_line[5000];
    int fd[40];

    memset(long_line, '{', sizeof(long_line));
    for (unsigned k = 0; k < 40; k++) {
        fd[k] = connect_to(control);
        say(fd[k], (const uint8_t *)long_line, k % 2 ? sizeof(long_line) : 100);
    }
    for (unsigned k = 0; k < 40; k++)
        close(fd[k]);
}

/* Asks without end, and reads nothing: what the service answers has no room after a while. */
static void control_flood(const char *control)
{
    static const char line[] = "{\"request\":\"status\"}\n";
    int fd = connect_to(control);

    for (unsigned k = 0; k < N_SUBSCRIBE; k++)
        if (send(fd, line, sizeof(line) - 1, MSG_NOSIGNAL | MSG_DONTWAIT) < 0)
            break;
    close(fd);
}

/* Half a HELLO, and silence: the service ends it in its own time. */
static void begin_silence(const char *socket, int fd[DX_WIRE_HEADER_LEN])
{
    uint8_t bytes[2048];

    put_hello(bytes);
    for (unsigned k = 0; k < DX_WIRE_HEADER_LEN; k++) {
        fd[k] = connect_to(socket);
        say(fd[k], bytes, k + 1);
    }
}

/* ---- what is left of it --------------------------------------------------------------------- */

static unsigned n_descriptors(long pid)
{
    char path[64];
    unsigned n = 0;
    DIR *d;

    snprintf(path, sizeof(path), "/proc/%ld/fd", pid);
    d = opendir(path);
    if (!d)
        die("%s cannot be read: the service is gone", path);
    while (readdir(d))
        n++;
    closedir(d);
    return n;
}

static void attack(const char *socket, const char *control)
{
    random_bytes(socket);
    absurd_lengths(socket);
    thousand_connects(socket);
    thousand_subscribes(socket);
    bad_subscribes(socket);
    torn(socket);
    control_socket(control);
    control_flood(control);
}

static void await_descriptors(long pid, unsigned n)
{
    while (sem_trywait(&epochs) == 0)
        ; /* those of before */
    for (unsigned k = 0; n_descriptors(pid) != n; k++) {
        if (k == N_EPOCHS)
            die("the service has %u descriptors, had %u", n_descriptors(pid), n);
        await_epoch();
    }
}

int main(int argc, char **argv)
{
    long pid = argc == 4 ? strtol(argv[3], NULL, 10) : 0, rss;
    int silent[DX_WIRE_HEADER_LEN];
    unsigned n_fd;
    pthread_t thread;

    if (pid <= 0)
        die("usage: hostile SOCKET CONTROL PID");
    sem_init(&epochs, 0, 0);
    if (pthread_create(&thread, NULL, follow, argv[1]) != 0)
        die("no thread");
    await_epoch();
    n_fd = n_descriptors(pid);
    begin_silence(argv[1], silent);
    attack(argv[1], argv[2]);
    for (unsigned k = 0; k < DX_WIRE_HEADER_LEN; k++)
        if (hear_end(silent[k]) != DX_WIRE_E_PROTOCOL)
            die("silence after %u bytes of HELLO: not the error expected", k + 1);
    await_descriptors(pid, n_fd);
    rss = rss_kib(pid);
    attack(argv[1], argv[2]);
    await_descriptors(pid, n_fd);
    printf("memory: %ld KiB, after another round %ld KiB; %u descriptors\n", rss, rss_kib(pid),
           n_fd);
    if (!SANITIZED && rss_kib(pid) > rss + RSS_MORE_KIB)
        die("the service's memory grew");
    stop = true;
    pthread_join(thread, NULL);
    printf("beside them: %u epochs, %u missed, %u resets\n", good.n_commits, good.n_missed,
           good.n_resets);
    return good.n_resets || (good.n_missed && !SANITIZED);
}
