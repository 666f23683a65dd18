/*
 * One datagram a line: NAME=VALUE, each ended by a newline, which no value may have in it (those
 * would have to be sent with their length). Any thread; the socket is made by the first line and
 * kept.
 */
#include "daemon/journal.h"

#include <errno.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#define DATAGRAM_LEN 2048
#define FACILITY     3 /* a daemon's, as the journal gives what it reads from standard error */

struct datagram {
    char bytes[DATAGRAM_LEN];
    size_t len;
};

/* Left out when it does not fit whole: a cut field would be damage. */
static void add(struct datagram *d, const char *name, const char *value)
{
    size_t len = strlen(name) + 1 + strlen(value) + 1;

    if (len >= sizeof(d->bytes) - d->len)
        return;
    snprintf(d->bytes + d->len, sizeof(d->bytes) - d->len, "%s=%s\n", name, value);
    for (size_t k = 0; k + 1 < len; k++)
        if (d->bytes[d->len + k] == '\n')
            d->bytes[d->len + k] = ' ';
    d->len += len;
}

static void add_number(struct datagram *d, const char *name, long long value)
{
    char text[24];

    snprintf(text, sizeof(text), "%lld", value);
    add(d, name, text);
}

static void build(struct datagram *d, const struct dx_journal_line *line)
{
    const struct dx_log_about *about = line->about;

    add(d, "SYSLOG_IDENTIFIER", "dexeld");
    add_number(d, "SYSLOG_FACILITY", FACILITY);
    add_number(d, "PRIORITY", line->level);
    add(d, "SUBSYSTEM", line->subsystem);
    if (about->stream)
        add(d, "STREAM", about->stream);
    if (about->device)
        add(d, "DEVICE", about->device);
    if (about->client_pid) {
        add_number(d, "CLIENT_PID", about->client_pid);
        add_number(d, "CLIENT_UID", about->client_uid);
    }
    add(d, "MESSAGE", line->text);
}

/* Released with its number: a socket is used by no thread that has not seen it made. */
static int journal_socket(void)
{
    static _Atomic int kept = -1;
    int fd = atomic_load_explicit(&kept, memory_order_acquire), none = -1;

    if (fd >= 0)
        return fd;
    fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd >= 0 && !atomic_compare_exchange_strong_explicit(&kept, &none, fd, memory_order_release,
                                                            memory_order_acquire)) {
        close(fd); /* another thread was first */
        fd = none;
    }
    return fd;
}

/* By address, each of them: a journal that was started anew has another socket there. */
bool dx_journal_send(const char *path, const struct dx_journal_line *line)
{
    struct sockaddr_un to = {.sun_family = AF_UNIX};
    struct datagram d = {.len = 0};
    ssize_t n;

    if (strlen(path) >= sizeof(to.sun_path))
        return false;
    memcpy(to.sun_path, path, strlen(path));
    build(&d, line);
    n = sendto(journal_socket(), d.bytes, d.len, MSG_NOSIGNAL | MSG_DONTWAIT,
               (struct sockaddr *)&to, sizeof(to));
    return n >= 0 || errno == EAGAIN || errno == ENOBUFS;
}
