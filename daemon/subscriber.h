/*
 * A subscriber: one connection on the mesh socket. What it must be told is flags, a cursor and a
 * view of the feed; sender.c turns them into messages when the socket takes them. Loop thread.
 */
#ifndef DX_SUBSCRIBER_H
#define DX_SUBSCRIBER_H

#include <sys/socket.h>
#include <systemd/sd-event.h>

#include "daemon/outbox.h"
#include "daemon/view.h"

struct dx_server;
struct dx_server_stream;

enum dx_subscriber_phase {
    DX_SUBSCRIBER_HELLO,     /* waits for HELLO */
    DX_SUBSCRIBER_SUBSCRIBE, /* waits for SUBSCRIBE */
    DX_SUBSCRIBER_STREAMING,
    DX_SUBSCRIBER_CLOSING, /* only what is in the outbox, then the ERROR */
    DX_SUBSCRIBER_CLOSED,  /* waits to be freed */
};

/* What of its batch was put into the outbox last. */
enum dx_batch_stage {
    DX_BATCH_NONE,
    DX_BATCH_BEGIN,
    DX_BATCH_TILES,
    DX_BATCH_COMMIT,
    DX_BATCH_END,
};

struct dx_subscriber {
    struct dx_server *server;
    struct dx_subscriber *next;
    uint64_t number; /* for the log */
    int fd;
    sd_event_source *io;
    uint32_t io_events;
    struct ucred cred;
    enum dx_subscriber_phase phase;
    uint64_t hello_due_ns;

    uint8_t in[DX_WIRE_HEADER_LEN + DX_WIRE_MAX_CLIENT_BODY];
    size_t in_len;

    uint16_t minor;     /* of the protocol, as spoken here */
    uint32_t encodings; /* of HELLO that we have */
    struct dx_server_stream *stream;
    struct dx_msg_subscribe asked;
    struct dx_view view;

    bool tell_welcome, tell_reset, tell_subscribed, tell_state;
    bool was_subscribed; /* SUBSCRIBED went out, at least in part: changes begin with RESET, until
                            one went out */
    char reset_reason[DX_WIRE_TEXT];
    struct dx_geometry *geometry; /* whose tables it is being sent; a reference */
    uint32_t geometry_at, geometry_len;
    enum dx_batch_stage stage;
    uint32_t next_entry;
    uint32_t credit;   /* NEXTs without their batch */
    uint64_t batch_ns; /* when the last batch was started */
    struct dx_outbox out;
    size_t held_len;      /* limits.h */
    uint64_t progress_ns; /* last byte, or when it began to owe */
    uint32_t n_revoked_in_row;

    bool lingers, said_error; /* while it closes */
    uint16_t doomed; /* enum dx_wire_error: to be closed when nobody walks a list it is in */
    char doom[DX_WIRE_TEXT];

    /* for status */
    uint64_t n_epochs, n_coalesced, n_resets, n_bytes;
    uint64_t last_seq;
    uint64_t behind_ns; /* since then, at most, there is a newer mesh than it has; 0: none is */
};

/* The feed has a mesh that it has not got. */
void dx_subscriber_is_behind(struct dx_subscriber *s);

/* For the log. */
struct dx_log_about dx_subscriber_about(const struct dx_subscriber *s);

/* Takes the descriptor, also when it fails. Errors: -ENOMEM, -errno. */
int dx_subscriber_new(struct dx_subscriber **out, struct dx_server *server, int fd,
                      const struct ucred *who);
void dx_subscriber_free(struct dx_subscriber *s);

/* Says why in an ERROR (if it fits) and in the log, and closes. `linger`: first finishes a message
 * that is half written, and waits for the ERROR to go, as long as something moves. */
void dx_subscriber_shut(struct dx_subscriber *s, enum dx_wire_error code, const char *text,
                        bool linger);

/* Writes what is owed, within the fairness budget of a turn. */
void dx_subscriber_pump(struct dx_subscriber *s);

/* Its stream is another one now, of the same name: it is told RESET with the reason, then what the
 * new one is. What the new stream cannot do for it closes it. Called before the old one lets go of
 * its feed. */
void dx_subscriber_move(struct dx_subscriber *s, struct dx_server_stream *to, const char *reason);

/* It could start a batch now if a pin was free. */
bool dx_subscriber_wants_batch(const struct dx_subscriber *s, uint64_t now_ns);

/* When the next timer concerns it; UINT64_MAX: none. */
uint64_t dx_subscriber_due(const struct dx_subscriber *s);

/* Enforces the deadlines that have passed. */
void dx_subscriber_tick(struct dx_subscriber *s, uint64_t now_ns);

/* ---- between subscriber.c, subscriber_move.c and sender.c
 * ----------------------------------------------------------- */

/* Puts the next messages into the empty outbox. */
void dx_sender_fill(struct dx_subscriber *s, uint64_t now_ns);
void dx_sender_sent(void *subscriber, const struct dx_out_message *m);
/* What it was told holds no more: nothing of a batch goes out after this, and it is told all anew,
 * after RESET if it had been told anything. The view still holds its chunks. */
void dx_sender_begin_anew(struct dx_subscriber *s, const char *reason);
/* The view's `dropped`. */
void dx_sender_dropped(struct dx_view *v, bool slow);

#endif
