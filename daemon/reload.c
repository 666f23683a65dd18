/* The steps of a reload, and who has what in hand between them. */
#include "daemon/reload.h"

#include "daemon/aside.h"
#include "daemon/clock.h"
#include "daemon/control_config.h"
#include "daemon/log.h"
#include "daemon/notify.h"
#include "daemon/reload_plan.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define JOIN_NS   700000000u /* for readers to come back from a decode, or from stopping a device */
#define SETTLE_NS 2000000000u /* more, for a recorder to end its file */

enum phase {
    IDLE,
    PLANNING, /* beside the loop: the plan is the helper's, and so is the report */
    SETTLING, /* beside the loop: the streams of the plan are the helper's, and so is `left` */
    TELLING,  /* whoever is answered may ask for the next one at once: it has to wait */
};

struct dx_reload {
    struct dx_reload_options o;
    struct dx_aside aside;
    enum phase phase;
    uint64_t number; /* of the one that runs, or ran last */
    bool again;      /* another was asked for meanwhile */
    int result;      /* of planning */
    bool is_late;    /* planning has taken long */
    sd_event_source *late;
    struct dx_reload_plan plan;
    struct dx_reload_report report;
    struct dx_config before;    /* what was in force, to be freed beside the loop */
    struct dx_stream_list left; /* stopped, but not back in time */
};

static void begin(struct dx_reload *r);

/* Once for a reload: whoever waits for it learns what it waits for. */
static int on_late(sd_event_source *source, uint64_t usec, void *reload)
{
    struct dx_reload *r = reload;
    struct dx_opening_now now = dx_opening_get(&r->plan.opening);

    (void)source;
    (void)usec;
    if (r->phase != PLANNING)
        return 0;
    r->is_late = true;
    if (*now.stream)
        dx_log_warning("reload", "still opening stream %s", now.text);
    else
        dx_log_warning("reload", "still reading %s", r->o.file);
    return 0;
}

static int add_events(struct dx_reload *r)
{
    sd_event *event = dx_server_event(r->o.server);
    int result = sd_event_add_time(event, &r->late, CLOCK_MONOTONIC, 0, 0, on_late, r);

    if (result < 0)
        return result;
    sd_event_source_set_enabled(r->late, SD_EVENT_OFF);
    return dx_aside_init(&r->aside, event, r);
}

int dx_reload_new(struct dx_reload **out, const struct dx_reload_options *options)
{
    struct dx_reload *r = calloc(1, sizeof(*r));
    int result;

    if (!r)
        return -ENOMEM;
    r->o = *options;
    dx_opening_init(&r->plan.opening);
    result = add_events(r);
    if (result < 0) {
        sd_event_source_disable_unref(r->late);
        dx_opening_fini(&r->plan.opening);
        free(r);
        return result;
    }
    *out = r;
    return 0;
}

/* ---- told --------------------------------------------------------------------------------------
 */

static void log_report(const struct dx_reload_report *report)
{
    for (unsigned k = 0; k < report->n_fixed; k++)
        dx_log_warning("reload", "%s: the value in %s counts from the next start on",
                       report->fixed[k], report->file);
    if (report->err.text[0])
        dx_log_error("reload", "%s%s", report->is_refused ? "refused, nothing was changed: " : "",
                     report->err.text);
    if (!report->is_refused)
        dx_log_info("reload", "%s: %u streams added, %u changed, %u removed, %u unchanged",
                    report->file, dx_reload_count(report, DX_RELOAD_ADDED),
                    dx_reload_count(report, DX_RELOAD_CHANGED),
                    dx_reload_count(report, DX_RELOAD_REMOVED),
                    dx_reload_count(report, DX_RELOAD_UNCHANGED));
}

static void finish(struct dx_reload *r)
{
    r->phase = TELLING;
    log_report(&r->report);
    dx_notify_reloaded(r->o.server, r->report.is_refused ? &r->report.err : NULL);
    dx_control_reloaded(r->o.server, r->number, &r->report);
    r->phase = IDLE;
    if (r->again)
        begin(r);
}

static void refuse(struct dx_reload *r)
{
    r->report.is_refused = true;
    r->report.n_streams = r->report.n_fixed = 0;
    finish(r);
}

/* ---- beside the loop: the old streams end, the new ones start ----------------------------------
 */

/* Its mesher has ended by then, whether its reader has or not: nobody needs what the server had of
 * it. */
static void end_old(struct dx_reload *r, struct dx_reload_change *c, uint64_t due_ns)
{
    bool joined = dx_stream_join(c->old, due_ns);

    dx_server_stream_free(c->shown);
    c->shown = NULL;
    if (joined) {
        dx_stream_free(c->old);
    } else {
        dx_log_warning("reload", "%s: its reader is still in a decode, or waits for its device",
                       c->name);
        dx_stream_list_add(&r->left, c->old);
    }
    c->old = NULL;
}

/* All have ended before any starts: a device may go from one to another. */
static void settle(void *reload)
{
    struct dx_reload *r = reload;
    uint64_t due_ns = dx_clock_ns() + JOIN_NS;

    dx_config_fini(&r->before);
    for (uint32_t k = 0; k < r->plan.n; k++)
        if (r->plan.change[k].old)
            end_old(r, &r->plan.change[k], due_ns);
    for (uint32_t k = 0; k < r->plan.n; k++)
        if (r->plan.change[k].fresh)
            dx_stream_start(r->plan.change[k].fresh, &r->report.err);
}

/* ---- loop --------------------------------------------------------------------------------------
 */

static void take_fresh(struct dx_reload *r)
{
    for (uint32_t k = 0; k < r->plan.n; k++)
        if (r->plan.change[k].fresh)
            dx_stream_list_add(r->o.streams, r->plan.change[k].fresh);
    r->plan.n = 0;
}

static void on_settled(void *reload)
{
    struct dx_reload *r = reload;

    take_fresh(r);
    finish(r);
}

/* The new streams are watched, though not yet served: the last thing that can fail. */
static int attach_all(struct dx_reload *r)
{
    for (uint32_t k = 0; k < r->plan.n; k++) {
        int result = r->plan.change[k].shown
                         ? dx_server_attach_stream(r->o.server, r->plan.change[k].shown)
                         : 0;

        if (result == 0)
            continue;
        while (k--)
            if (r->plan.change[k].shown)
                dx_server_detach_stream(r->plan.change[k].shown);
        return dx_err_set(&r->report.err, result, "event loop: %s", strerror(-result));
    }
    return 0;
}

/* Those who subscribed to the old stream are on the new one after this, or gone. */
static void swap(struct dx_reload *r, struct dx_reload_change *c)
{
    char reason[128];

    snprintf(reason, sizeof(reason), "the configuration has no stream '%s' any more", c->name);
    if (c->fresh)
        c->shown = dx_server_put_stream(r->o.server, c->shown, "configuration changed");
    else
        c->shown = dx_server_take_stream(r->o.server, c->name, reason);
    if (!c->old)
        return;
    dx_stream_list_remove(r->o.streams, c->old);
    dx_stream_stop(c->old);
}

static void apply_config(struct dx_reload *r)
{
    struct dx_config *now = r->o.config;
    struct dx_server_limits limits;
    bool level_changed = r->plan.next.log_level != now->log_level;

    r->report.n_fixed = dx_config_keep_fixed(&r->plan.next, now, r->report.fixed);
    r->before = *now;
    *now = r->plan.next;
    r->plan.next = (struct dx_config){0};
    if (level_changed)
        dx_log_set_level(now->log_level);
    limits = dx_service_limits(now);
    dx_server_set_limits(r->o.server, &limits);
}

static void on_planned(void *reload)
{
    struct dx_reload *r = reload;

    if (r->result == 0 && attach_all(r) < 0) {
        dx_reload_plan_drop(&r->plan);
        r->result = -EAGAIN;
    }
    if (r->result) {
        refuse(r);
        return;
    }
    r->report.err.text[0] = '\0';
    for (uint32_t k = 0; k < r->plan.n; k++)
        swap(r, &r->plan.change[k]);
    apply_config(r);
    r->phase = SETTLING;
    dx_aside_start(&r->aside, "reload", settle, on_settled);
}

/* ---- beside the loop: reading and opening ------------------------------------------------------
 */

static void plan(void *reload)
{
    struct dx_reload *r = reload;

    dx_stream_list_end(&r->left, dx_clock_ns());
    if (r->left.n + r->o.streams->n > DX_CONFIG_MAX_STREAMS)
        r->result = dx_err_set(&r->report.err, -EBUSY, "%u streams of before have not ended yet",
                               r->left.n);
    else
        r->result = dx_reload_plan_make(&r->plan, &r->o, &r->report, &r->report.err);
}

static void begin(struct dx_reload *r)
{
    r->number++;
    r->again = r->is_late = false;
    r->phase = PLANNING;
    r->report = (struct dx_reload_report){.file = r->o.file};
    dx_notify_reloading();
    sd_event_source_set_time(r->late, (dx_clock_ns() + DX_OPENING_LATE_NS) / 1000);
    sd_event_source_set_enabled(r->late, SD_EVENT_ONESHOT);
    dx_aside_start(&r->aside, "reload", plan, on_planned);
}

uint64_t dx_reload_ask(void *reload)
{
    struct dx_reload *r = reload;

    if (r->phase != IDLE) {
        r->again = true;
        return r->number + 1;
    }
    begin(r);
    return r->number;
}

bool dx_reload_waits(struct dx_reload *r, char stream[64])
{
    struct dx_opening_now now = dx_opening_get(&r->plan.opening);

    if (r->phase != PLANNING || !r->is_late || !*now.stream)
        return false;
    memcpy(stream, now.stream, sizeof(now.stream));
    return true;
}

/* ---- the end -----------------------------------------------------------------------------------
 */

bool dx_reload_end(struct dx_reload *r, uint64_t due_ns)
{
    if (!r)
        return true;
    if (!dx_aside_wait(&r->aside, due_ns + SETTLE_NS))
        return false;
    if (r->phase == PLANNING)
        dx_reload_plan_drop(&r->plan);
    for (uint32_t k = 0; k < r->plan.n; k++)
        if (r->plan.change[k].fresh)
            dx_stream_stop(r->plan.change[k].fresh);
    take_fresh(r);
    r->phase = IDLE;
    return dx_stream_list_end(&r->left, due_ns);
}

void dx_reload_free(struct dx_reload *r)
{
    if (!r)
        return;
    dx_aside_fini(&r->aside);
    sd_event_source_disable_unref(r->late);
    dx_opening_fini(&r->plan.opening);
    free(r);
}
