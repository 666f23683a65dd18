/*
 * What anybody may send to the mesh socket. Whatever it is, what the server says keeps to the
 * protocol and holds exactly the mesh (tests/unit/server_client.h), and when the client has gone
 * nothing of it is left behind.
 *
 * Input: a byte of how (enum), then messages with a short head (type, flags, length), whose framing
 * is made right; or, with RAW, bytes as they are, of which the first one says how many a write.
 */
#include "tests/fuzz/server_rig.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len);

enum {
    FRAMES = 1,  /* the mesh changes after each message */
    GRIDS = 2,   /* and so does the geometry */
    MUTE = 4,    /* nothing is read before all is said */
    RAW = 8,     /* see above */
    GRID_AT = 4, /* bits 4 and 5: the grid */
    ENDED = 64,  /* the stream ends before the last message */
};

static const uint32_t grids[] = {0, 2, 101, 200};

/* What was sent, as a server would read it; and what came, as far as it is not a whole message. */
struct talk {
    struct client *client;
    bool has_ended;
    uint8_t sent[1 << 13];
    size_t sent_len;
    bool has_asked; /* its first SUBSCRIBE is known */
    uint8_t came[DX_WIRE_HEADER_LEN + DX_WIRE_MAX_BODY];
    size_t came_len;
};

/* ---- what the server says -----------------------------------------------------------------------
 */

static void take_messages(struct talk *t)
{
    size_t at = 0;

    while (t->came_len - at >= DX_WIRE_HEADER_LEN) {
        struct client *c = t->client;
        struct dx_wire_header h;

        dx_wire_get_header(&h, t->came + at);
        MUST(h.length <= DX_WIRE_MAX_BODY && h.seq == c->seq);
        if (t->came_len - at - DX_WIRE_HEADER_LEN < h.length)
            break;
        MUST(c->error.code == 0); /* which is the last one */
        memcpy(c->body, t->came + at + DX_WIRE_HEADER_LEN, h.length);
        c->seq++;
        client_handle(c, &h);
        at += DX_WIRE_HEADER_LEN + h.length;
    }
    t->came_len -= at;
    memmove(t->came, t->came + at, t->came_len);
}

static bool hear(struct talk *t)
{
    bool any = false;

    while (!t->has_ended) {
        ssize_t n =
            recv(t->client->fd, t->came + t->came_len, sizeof(t->came) - t->came_len, MSG_DONTWAIT);

        if (n < 0 && errno == EAGAIN)
            break;
        any = true;
        t->has_ended = n <= 0;
        t->came_len += n > 0 ? (size_t)n : 0;
        take_messages(t);
    }
    return any;
}

static void turn(struct talk *t, bool listens)
{
    do
        rig_turn();
    while (listens && hear(t));
    MUST(!rig.has_ended);
}

/* ---- what the client says -----------------------------------------------------------------------
 */

/* The first SUBSCRIBE is what counts: the mesh must be that of it. */
static void find_request(struct talk *t)
{
    for (size_t at = 0; !t->has_asked && t->sent_len - at >= DX_WIRE_HEADER_LEN;) {
        struct dx_wire_header h;

        dx_wire_get_header(&h, t->sent + at);
        if (t->sent_len - at - DX_WIRE_HEADER_LEN < h.length)
            break;
        if (h.type == DX_MSG_SUBSCRIBE) {
            (void)dx_msg_subscribe_get(&t->client->asked, t->sent + at + DX_WIRE_HEADER_LEN,
                                       h.length);
            t->has_asked = true;
        }
        at += DX_WIRE_HEADER_LEN + h.length;
    }
}

static void say(struct talk *t, const uint8_t *bytes, size_t len)
{
    if (t->has_ended || len > sizeof(t->sent) - t->sent_len)
        return;
    memcpy(t->sent + t->sent_len, bytes, len);
    t->sent_len += len;
    find_request(t);
    if (send(t->client->fd, bytes, len, MSG_NOSIGNAL | MSG_DONTWAIT) < 0)
        t->has_ended = errno != EAGAIN;
}

static void change(uint8_t how, unsigned step)
{
    struct fixture *fx = &rig.fx;

    if (how & FRAMES)
        fx->target++;
    if (how & GRIDS && rig.mesher.frame == fx->target) {
        fx->grid = grids[(step + (how >> GRID_AT)) % 4];
        mesher_announce(&rig.mesher);
    }
    if (how & ENDED && step == 2)
        dx_feed_state(fx->feed, DX_STREAM_ENDED, "as the input says");
}

static void talk_raw(struct talk *t, uint8_t how, const uint8_t *bytes, size_t len)
{
    size_t step = len ? 1 + 4 * (size_t)bytes[0] : 1;

    for (size_t at = 1; at < len; at += step) {
        say(t, bytes + at, len - at < step ? len - at : step);
        turn(t, !(how & MUTE));
    }
}

static void talk_framed(struct talk *t, uint8_t how, const uint8_t *bytes, size_t len)
{
    struct dx_wire_header h = {.seq = 0};

    for (unsigned step = 0; len >= 3; step++) {
        uint8_t message[DX_WIRE_HEADER_LEN + 255];

        h.type = bytes[0];
        h.flags = bytes[1];
        h.length = bytes[2] < len - 3 ? bytes[2] : (uint32_t)(len - 3);
        dx_wire_put_header(message, &h);
        memcpy(message + DX_WIRE_HEADER_LEN, bytes + 3, h.length);
        say(t, message, DX_WIRE_HEADER_LEN + h.length);
        change(how, step);
        turn(t, !(how & MUTE));
        bytes += 3 + h.length;
        len -= 3 + h.length;
    }
}

/* ---- one client -------------------------------------------------------------------------------
 */

static void set_grid(uint32_t grid)
{
    rig_turn();
    if (rig.mesher.grid == grid)
        return;
    rig.fx.grid = grid;
    mesher_announce(&rig.mesher);
    rig_turn();
}

static void expect_nothing_left(void)
{
    const struct dx_server *s = rig.fx.server;

    MUST(s->n_clients == 0 && !s->subscribers && s->held_len == 0);
    MUST(s->streams->n_subscribers == 0 && !s->streams->loop->views);
    MUST(s->streams->loop->n_pins == 0);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len)
{
    static const struct fixture_options options = {
        .lossless = true, .attr_bytes = 2, .normals = true};
    static struct talk t;

    if (len < 1)
        return 0;
    rig_up(&options);
    set_grid(grids[bytes[0] >> GRID_AT & 3]);
    t.client = client_connect(&rig.fx);
    t.has_ended = t.has_asked = false;
    t.sent_len = t.came_len = 0;
    if (bytes[0] & RAW)
        talk_raw(&t, bytes[0], bytes + 1, len - 1);
    else
        talk_framed(&t, bytes[0], bytes + 1, len - 1);
    turn(&t, true);
    client_close(t.client);
    turn(&t, false);
    expect_nothing_left();
    if (bytes[0] & ENDED)
        dx_feed_state(rig.fx.feed, DX_STREAM_LIVE, "");
    rig_turn();
    return 0;
}
