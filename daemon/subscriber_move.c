/*
 * A subscriber whose stream is replaced while it is on it: the connection stays, and so does what
 * it asked for. Loop thread.
 */
#include "daemon/server_priv.h"

#include "daemon/clock.h"

/* What it asked for, in the new feed. There nobody has asked for anything but those who came the
 * same way, so a level of detail finds a form as it did before. */
static unsigned form_of(struct dx_feed_loop *l, const struct dx_msg_subscribe *m)
{
    return dx_lod_is_whole(m->lod) ? m->encoding : dx_feed_loop_form(l, m->lod);
}

static const char *unfit(const struct dx_msg_subscribe *m, const struct dx_server_stream *to)
{
    if (m->mode == DX_MODE_LOSSLESS && !to->options.lossless)
        return "the stream was configured anew, and is no replay at rate max any more";
    return NULL;
}

void dx_subscriber_move(struct dx_subscriber *s, struct dx_server_stream *to, const char *reason)
{
    const char *why = unfit(&s->asked, to);

    if (why) {
        dx_subscriber_shut(s, DX_WIRE_E_MODE, why, true);
        return;
    }
    dx_sender_begin_anew(s, reason); /* the outbox refers to no chunk of the old feed after this */
    dx_view_leave(&s->view, dx_clock_ns());
    dx_server_count_subscriber(s->stream, -1);
    s->stream = to;
    dx_server_count_subscriber(to, 1);
    s->out.feed = to->options.feed;
    s->view.loop = to->loop;
    s->view.form = form_of(to->loop, &s->asked);
    s->view.done_seq = s->view.done_epoch = 0;
    s->behind_ns = 0; /* until the new stream has a mesh */
    if (s->view.form == DX_N_FORMS || dx_view_join(&s->view) < 0)
        dx_subscriber_shut(s, DX_WIRE_E_LIMIT, "no memory for another subscriber", true);
}
