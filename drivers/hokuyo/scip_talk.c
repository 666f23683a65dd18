/* A session on a link. */
#include "drivers/hokuyo/scip_talk.h"

#include "drivers/monotonic.h"

#include <errno.h>

#define MS 1000000u

void dx_scip_talk_init(struct dx_scip_talk *t)
{
    *t = (struct dx_scip_talk){.link = NULL};
    pthread_mutex_init(&t->mutex, NULL);
}

void dx_scip_talk_fini(struct dx_scip_talk *t)
{
    dx_scip_link_close(t->link);
    dx_scip_session_fini(&t->session);
    pthread_mutex_destroy(&t->mutex);
}

void dx_scip_talk_set_link(struct dx_scip_talk *t, struct dx_scip_link *link)
{
    struct dx_scip_link *before = t->link;

    pthread_mutex_lock(&t->mutex);
    t->link = link;
    pthread_mutex_unlock(&t->mutex);
    dx_scip_link_close(before); /* nobody wakes it any more */
}

void dx_scip_talk_wake(struct dx_scip_talk *t)
{
    pthread_mutex_lock(&t->mutex);
    if (t->link)
        t->link->ops->wake(t->link);
    else
        t->is_woken = true;
    pthread_mutex_unlock(&t->mutex);
}

bool dx_scip_talk_take_wake(struct dx_scip_talk *t)
{
    bool is_woken;

    pthread_mutex_lock(&t->mutex);
    is_woken = t->is_woken;
    t->is_woken = false;
    pthread_mutex_unlock(&t->mutex);
    return is_woken;
}

int dx_scip_talk_begin(struct dx_scip_talk *t, const struct dx_scip_want *want, size_t headroom,
                       struct dx_err *err)
{
    struct dx_scip_counts counts = t->session.counts;
    int r;

    dx_scip_session_fini(&t->session);
    r = dx_scip_session_init(&t->session, want, headroom, dx_clock_ns());
    if (r)
        return dx_err_set(err, r, "%s: no memory", t->link->place);
    t->session.counts = counts;
    t->in_at = t->in_len = 0;
    return 0;
}

int dx_scip_talk_feed(struct dx_scip_talk *t)
{
    while (t->in_at < t->in_len) {
        t->in_at +=
            dx_scip_session_feed(&t->session, t->in + t->in_at, t->in_len - t->in_at, t->in_ns);
        if (t->session.scan_ready)
            return 0;
    }
    return DX_DRIVER_E_AGAIN;
}

static int send_waiting(struct dx_scip_talk *t, struct dx_err *err)
{
    size_t len = t->session.out_len;
    int r;

    if (len == 0)
        return 0;
    r = t->link->ops->write(t->link, t->session.out, len, err);
    if (r == 0)
        dx_scip_session_sent(&t->session, len, dx_clock_ns());
    return r;
}

/* Milliseconds until the session or the caller wants to be heard. */
static int wait_ms(const struct dx_scip_talk *t, uint64_t until_ns, uint64_t now_ns)
{
    uint64_t next = t->session.deadline_ns < until_ns ? t->session.deadline_ns : until_ns;

    return next > now_ns ? (int)((next - now_ns + MS - 1) / MS) : 0;
}

int dx_scip_talk_step(struct dx_scip_talk *t, uint64_t until_ns, struct dx_err *err)
{
    uint64_t now = dx_clock_ns();
    int r;

    dx_scip_session_tick(&t->session, now);
    if (t->session.dead)
        return dx_err_set(err, -ETIMEDOUT, "%s: %s", t->link->place, t->session.trouble);
    r = send_waiting(t, err);
    t->in_at = t->in_len = 0;
    if (r == 0)
        r = t->link->ops->read(t->link, t->in, sizeof(t->in), &t->in_len, wait_ms(t, until_ns, now),
                               err);
    if (r)
        t->in_len = 0;
    else
        t->in_ns = dx_clock_ns();
    return r;
}
