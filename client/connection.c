/*
 * Socket, buffers and framing of a subscriber. One thread at a time.
 */
#include "client/connection.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#define FIRST_MAX_BODY    1024u /* WELCOME and ERROR are shorter */
#define CONNECT_TIMEOUT_S 10

int dx_connection_init(struct dx_connection *c)
{
    memset(c, 0, sizeof(*c));
    c->fd = -1;
    return dx_connection_set_max_body(c, FIRST_MAX_BODY);
}

void dx_connection_fini(struct dx_connection *c)
{
    if (c->fd >= 0)
        close(c->fd);
    free(c->in);
}

static int set_nonblocking(int fd)
{
    int flags = fcntl(fd, F_GETFL);

    return flags < 0 || fcntl(fd, F_SETFL, flags | O_NONBLOCK) < 0 ? -errno : 0;
}

int dx_connection_open(struct dx_connection *c, const char *path, enum dx_connection_wait wait,
                       struct dx_err *err)
{
    const struct timeval timeout = {.tv_sec = CONNECT_TIMEOUT_S};
    struct sockaddr_un addr = {.sun_family = AF_UNIX};
    int r;

    if (strlen(path) >= sizeof(addr.sun_path))
        return dx_err_set(err, -ENAMETOOLONG, "%s: a socket path has at most %zu bytes", path,
                          sizeof(addr.sun_path) - 1);
    memcpy(addr.sun_path, path, strlen(path) + 1);
    c->fd = socket(AF_UNIX,
                   SOCK_STREAM | SOCK_CLOEXEC | (wait == DX_CONNECTION_TRY ? SOCK_NONBLOCK : 0), 0);
    if (c->fd < 0)
        return dx_err_set(err, -errno, "socket: %s", strerror(errno));
    setsockopt(c->fd, SOL_SOCKET, SO_SNDTIMEO, &timeout, sizeof(timeout));
    if (connect(c->fd, (const struct sockaddr *)&addr, sizeof(addr)) < 0)
        return dx_err_set(err, -errno, "%s: %s", path, strerror(errno));
    r = set_nonblocking(c->fd);
    return r < 0 ? dx_err_set(err, r, "%s: %s", path, strerror(-r)) : 0;
}

int dx_connection_set_max_body(struct dx_connection *c, uint32_t max_body)
{
    const size_t unread = c->in_len - c->in_pos;
    size_t cap = DX_WIRE_HEADER_LEN + (size_t)max_body;
    uint8_t *in;

    if (cap < unread)
        cap = unread;
    in = malloc(cap);
    if (!in)
        return -ENOMEM;
    if (unread)
        memcpy(in, c->in + c->in_pos, unread);
    free(c->in);
    c->in = in;
    c->in_cap = cap;
    c->in_pos = 0;
    c->in_len = unread;
    c->max_body = max_body;
    return 0;
}

int dx_connection_send(struct dx_connection *c, enum dx_message type, const uint8_t *body,
                       size_t len)
{
    const struct dx_wire_header h = {.length = (uint32_t)len,
                                     .type = (uint16_t)type,
                                     .stream = DX_WIRE_NO_STREAM,
                                     .seq = c->seq_out};

    if (len + DX_WIRE_HEADER_LEN > sizeof(c->out) - c->out_len)
        return -ENOBUFS;
    dx_wire_put_header(c->out + c->out_len, &h);
    if (len)
        memcpy(c->out + c->out_len + DX_WIRE_HEADER_LEN, body, len);
    c->out_len += DX_WIRE_HEADER_LEN + len;
    c->seq_out++;
    return dx_connection_flush(c);
}

int dx_connection_flush(struct dx_connection *c)
{
    while (c->out_len) {
        ssize_t n = send(c->fd, c->out, c->out_len, MSG_NOSIGNAL | MSG_DONTWAIT);

        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0 && errno == EAGAIN)
            return 0;
        if (n < 0 && errno != EPIPE && errno != ECONNRESET)
            return -errno;
        if (n < 0)
            n = (ssize_t)c->out_len;
        c->out_len -= (size_t)n;
        memmove(c->out, c->out + n, c->out_len);
    }
    return 0;
}

int dx_connection_fill(struct dx_connection *c, struct dx_err *err)
{
    ssize_t n;

    if (c->in_pos) {
        c->in_len -= c->in_pos;
        memmove(c->in, c->in + c->in_pos, c->in_len);
        c->in_pos = 0;
    }
    do
        n = recv(c->fd, c->in + c->in_len, c->in_cap - c->in_len, MSG_DONTWAIT);
    while (n < 0 && errno == EINTR);
    if (n < 0 && errno == EAGAIN)
        return 0;
    /* a peer that left without reading all we said resets the connection: closed, too */
    if (n < 0 && errno != ECONNRESET)
        return dx_err_set(err, -errno, "reading from the server: %s", strerror(errno));
    if (n <= 0)
        return dx_err_set(err, -ECONNRESET, "the server closed the connection%s",
                          c->in_len ? " in the middle of a message" : "");
    c->in_len += (size_t)n;
    return DX_CONNECTION_BYTES;
}

int dx_connection_next(struct dx_connection *c, struct dx_wire_header *h, const uint8_t **body,
                       struct dx_err *err)
{
    const size_t unread = c->in_len - c->in_pos;

    if (unread < DX_WIRE_HEADER_LEN)
        return 0;
    dx_wire_get_header(h, c->in + c->in_pos);
    if (h->length > c->max_body && c->seq_in == 0 && c->in[c->in_pos] == '{')
        return dx_err_set(err, -EPROTO,
                          "found a line of JSON in answer, expected WELCOME; this seems to be the "
                          "control socket, but this needs the mesh socket (socket in the "
                          "configuration)");
    if (h->length > c->max_body)
        return dx_err_set(err, -EPROTO,
                          "message %u of the server: a body of %u bytes, at most %u expected",
                          c->seq_in, h->length, c->max_body);
    if (h->seq != c->seq_in)
        return dx_err_set(err, -EPROTO, "message %u of the server: numbered %u", c->seq_in, h->seq);
    if (unread < DX_WIRE_HEADER_LEN + (size_t)h->length)
        return 0;
    *body = c->in + c->in_pos + DX_WIRE_HEADER_LEN;
    c->in_pos += DX_WIRE_HEADER_LEN + (size_t)h->length;
    c->seq_in++;
    return DX_CONNECTION_MESSAGE;
}
