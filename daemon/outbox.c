/* The window of messages of a subscriber. Loop thread. */
#include "daemon/outbox.h"

#include <assert.h>
#include <errno.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/uio.h>

#define MAX_IOV 256 /* blocks of 4 KiB: 1 MiB at most in one call */

struct dx_writer dx_outbox_begin(struct dx_outbox *o)
{
    if (dx_outbox_is_empty(o))
        o->n = o->first = o->heads_len = 0;
    assert(dx_outbox_has_room(o));
    return dx_writer_init(o->heads + o->heads_len + DX_WIRE_HEADER_LEN,
                          DX_OUTBOX_HEADS - o->heads_len - DX_WIRE_HEADER_LEN);
}

struct dx_out_message *dx_outbox_end(struct dx_outbox *o, const struct dx_writer *w,
                                     enum dx_message type, uint32_t stream, uint64_t epoch,
                                     uint32_t body_len)
{
    struct dx_out_message *m = &o->message[o->n++];
    struct dx_wire_header h = {.type = (uint16_t)type, .stream = stream, .epoch = epoch};

    assert(!w->failed);
    *m = (struct dx_out_message){.type = (uint16_t)type,
                                 .head_at = o->heads_len,
                                 .chunk = DX_FEED_NONE,
                                 .body_len = body_len};
    m->head_len = (uint32_t)(w->p - (o->heads + o->heads_len));
    h.length = m->head_len - DX_WIRE_HEADER_LEN + body_len;
    h.seq = o->seq++;
    dx_wire_put_header(o->heads + o->heads_len, &h);
    o->heads_len += m->head_len;
    return m;
}

/* ---- writing
 * ------------------------------------------------------------------------------------- */

struct iov_list {
    struct iovec iov[MAX_IOV];
    size_t n, len;
    bool full; /* something did not fit: nothing may follow it */
};

/* Adds bytes, less the first `*skip` of the whole; joined to what they follow in memory. */
static void add(struct iov_list *l, const uint8_t *bytes, size_t len, size_t *skip)
{
    struct iovec *last = l->n ? &l->iov[l->n - 1] : NULL;

    if (l->full)
        return;
    if (*skip >= len) {
        *skip -= len;
        return;
    }
    bytes += *skip;
    len -= *skip;
    *skip = 0;
    if (last && (const uint8_t *)last->iov_base + last->iov_len == bytes)
        last->iov_len += len;
    else if (l->n < MAX_IOV)
        l->iov[l->n++] = (struct iovec){(void *)(uintptr_t)bytes, len};
    else
        l->full = true;
    l->len += l->full ? 0 : len;
}

static void add_message(const struct dx_outbox *o, const struct dx_out_message *m,
                        struct iov_list *l, size_t skip)
{
    const struct dx_feed *f = o->feed;

    add(l, o->heads + m->head_at, m->head_len, &skip);
    if (m->own) {
        add(l, o->own + m->skip, m->body_len, &skip);
    } else if (m->chunk != DX_FEED_NONE) {
        size_t end = m->skip + m->body_len, at = 0;

        skip += m->skip;
        for (uint32_t b = f->chunk[m->chunk].first; at < end && !l->full; b = f->next_block[b]) {
            size_t left = end - at;

            add(l, dx_feed_block(f, b), left < DX_FEED_BLOCK_LEN ? left : DX_FEED_BLOCK_LEN, &skip);
            at += DX_FEED_BLOCK_LEN;
        }
    }
}

static void advance(struct dx_outbox *o, size_t n,
                    void (*sent)(void *ctx, const struct dx_out_message *m), void *ctx)
{
    o->sent += n;
    while (o->first < o->n) {
        const struct dx_out_message *m = &o->message[o->first];
        size_t len = (size_t)m->head_len + m->body_len;

        if (o->sent < len)
            return;
        o->sent -= len;
        o->first++;
        sent(ctx, m);
    }
}

ssize_t dx_outbox_write(struct dx_outbox *o, int fd, size_t budget,
                        void (*sent)(void *ctx, const struct dx_out_message *m), void *ctx)
{
    struct iov_list l;
    struct msghdr msg = {.msg_iov = l.iov};
    ssize_t n;

    l.n = l.len = 0;
    l.full = false;
    for (uint32_t k = o->first; k < o->n && l.len < budget && !l.full; k++)
        add_message(o, &o->message[k], &l, k == o->first ? o->sent : 0);
    msg.msg_iovlen = l.n;
    do
        n = sendmsg(fd, &msg, MSG_NOSIGNAL | MSG_DONTWAIT);
    while (n < 0 && errno == EINTR);
    if (n < 0)
        return errno == EAGAIN || errno == EWOULDBLOCK ? 0 : -errno;
    advance(o, (size_t)n, sent, ctx);
    return n;
}

/* ---- cutting
 * ------------------------------------------------------------------------------------- */

/* Copies what is left of a chunk's body to `own`; the message refers to it there. */
static void keep_copy(struct dx_outbox *o, struct dx_out_message *m)
{
    const struct dx_feed *f = o->feed;
    size_t end = m->skip + m->body_len, at = 0;

    for (uint32_t b = f->chunk[m->chunk].first; at < end; b = f->next_block[b]) {
        size_t left = end - at;

        memcpy(o->own + at, dx_feed_block(f, b),
               left < DX_FEED_BLOCK_LEN ? left : DX_FEED_BLOCK_LEN);
        at += DX_FEED_BLOCK_LEN;
    }
    m->chunk = DX_FEED_NONE;
    m->own = true;
}

uint16_t dx_outbox_cut(struct dx_outbox *o)
{
    uint32_t keep = o->first;
    uint16_t begun = 0;

    if (!dx_outbox_is_empty(o) && o->sent > 0) {
        struct dx_out_message *m = &o->message[keep++];

        if (m->chunk != DX_FEED_NONE)
            keep_copy(o, m);
        begun = m->type;
    }
    while (keep < o->n && o->message[keep].type == DX_MSG_WELCOME)
        keep++;
    o->seq -= o->n - keep;
    o->n = keep;
    return begun;
}
