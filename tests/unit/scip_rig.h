/* A session and a simulated scanner, joined; time is counted, not waited for. */
#ifndef SCIP_RIG_H
#define SCIP_RIG_H

#include "drivers/hokuyo/scip_session.h"
#include "tests/hil/scip_device.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#define MS 1000000ull
#define S  (1000 * MS)

struct rig {
    struct dx_scip_session session;
    struct scip_sim sim;
    uint64_t now;
    size_t piece;    /* bytes at a time to the session; 0: all */
    char said[4096]; /* what the session sent */
    size_t said_len;
    uint64_t n_scans, n_degraded;
    int64_t worst_ns; /* between a scan's host time and the truth */
    uint64_t last_device_ns;
    bool backwards; /* device time ran */
};

static inline void rig_init(struct rig *r, const char *model, struct dx_scip_want want)
{
    memset(r, 0, sizeof(*r));
    r->now = 1000 * S;
    for (size_t k = 0; k < sizeof(scip_models) / sizeof(scip_models[0]); k++)
        if (!strcmp(scip_models[k].name, model))
            scip_sim_init(&r->sim, &scip_models[k], r->now);
    assert_non_null(r->sim.model.name);
    assert_int_equal(dx_scip_session_init(&r->session, &want, 0, r->now), 0);
}

#define ALL_STEPS                                                                                  \
    (struct dx_scip_want)                                                                          \
    {                                                                                              \
        .first_step = -1, .last_step = -1, .cluster = 1                                            \
    }

static inline void rig_fini(struct rig *r)
{
    dx_scip_session_fini(&r->session);
}

static inline void rig_take(struct rig *r)
{
    const struct dx_scip_scan *scan = &r->session.scan;
    /* in steady state the scan that is sent is the one before next_ns */
    int64_t truth =
        (int64_t)(r->sim.next_ns - (uint64_t)(scip_sim_period_ns(&r->sim) * (r->sim.skip + 1)));
    int64_t off = (int64_t)scan->host_ns - truth;

    off = off < 0 ? -off : off;
    r->worst_ns = off > r->worst_ns ? off : r->worst_ns;
    r->n_scans++;
    r->n_degraded += scan->degraded;
    r->backwards |= scan->device_ns < r->last_device_ns;
    r->last_device_ns = scan->device_ns;
}

static inline void rig_to_session(struct rig *r)
{
    size_t at = 0;

    while (at < r->sim.out_len) {
        size_t n = r->sim.out_len - at;

        n = r->piece && n > r->piece ? r->piece : n;
        for (size_t used = 0; used < n;) {
            used += dx_scip_session_feed(&r->session, r->sim.out + at + used, n - used, r->now);
            if (r->session.scan_ready)
                rig_take(r);
        }
        at += n;
    }
    r->sim.out_len = 0;
}

static inline void rig_to_sim(struct rig *r)
{
    size_t len = r->session.out_len;

    if (len == 0)
        return;
    if (r->said_len + len < sizeof(r->said)) {
        memcpy(r->said + r->said_len, r->session.out, len);
        r->said_len += len;
    }
    scip_sim_feed(&r->sim, r->session.out, len, r->now);
    dx_scip_session_sent(&r->session, len, r->now);
}

/* On for so long; what happens first happens first. */
static inline void rig_run(struct rig *r, uint64_t ns)
{
    uint64_t until = r->now + ns;

    while (r->now < until) {
        uint64_t next;

        rig_to_sim(r);
        if (r->sim.out_len) {
            r->now += MS / 5; /* on the way */
            rig_to_session(r);
            continue;
        }
        next = scip_sim_next_ns(&r->sim);
        next = r->session.deadline_ns < next ? r->session.deadline_ns : next;
        next = until < next ? until : next;
        r->now = next > r->now ? next : r->now + MS;
        scip_sim_tick(&r->sim, r->now);
        rig_to_session(r);
        dx_scip_session_tick(&r->session, r->now);
    }
}

/* How often the session sent this line. */
static inline unsigned rig_said(const struct rig *r, const char *line)
{
    size_t len = strlen(line);
    unsigned n = 0;

    for (const char *p = r->said; (p = strstr(p, line)); p += len)
        n += (p == r->said || p[-1] == '\n') && p[len] == '\n';
    return n;
}

static inline void rig_forget(struct rig *r)
{
    memset(r->said, 0, sizeof(r->said));
    r->said_len = 0;
    r->n_scans = r->n_degraded = 0;
    r->worst_ns = 0;
}

#endif
