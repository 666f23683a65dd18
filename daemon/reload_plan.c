/* From a file to a plan. Beside the loop: what it looks at does not change until the plan is
 * carried out. */
#include "daemon/reload_plan.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

static void tell(struct dx_reload_report *report, const char *name, enum dx_reload_did did)
{
    snprintf(report->stream[report->n_streams].name, sizeof(report->stream[0].name), "%s", name);
    report->stream[report->n_streams++].did = did;
}

static struct dx_reload_change *add_change(struct dx_reload_plan *plan, const char *name,
                                           struct dx_stream *old)
{
    struct dx_reload_change *c = &plan->change[plan->n++];

    *c = (struct dx_reload_change){.old = old};
    snprintf(c->name, sizeof(c->name), "%s", name);
    return c;
}

/* The stream as the file now has it, not started. */
static int open_fresh(struct dx_reload_change *c, const struct dx_stream_config *config,
                      const struct dx_reload_options *o, struct dx_err *err)
{
    struct dx_server_stream_options shows;
    int r = dx_stream_new(&c->fresh, config, o->pool, err);

    if (r == 0) {
        shows = dx_service_shows(c->fresh);
        r = dx_server_stream_new(&c->shown, &shows);
        if (r < 0)
            dx_err_set(err, r, "%s", strerror(-r));
    }
    if (r == 0)
        return 0;
    dx_service_blame(err, o->file, config);
    return r < 0 ? r : -EIO;
}

static int plan_stream(struct dx_reload_plan *plan, const struct dx_stream_config *config,
                       const struct dx_reload_options *o, struct dx_reload_report *report,
                       struct dx_err *err)
{
    struct dx_stream *old = dx_stream_list_find(o->streams, config->name);

    if (old && dx_config_stream_same(dx_stream_config(old), config) && dx_stream_is_started(old)) {
        tell(report, config->name, DX_RELOAD_UNCHANGED);
        return 0;
    }
    tell(report, config->name, old ? DX_RELOAD_CHANGED : DX_RELOAD_ADDED);
    dx_opening_set(&plan->opening, config);
    return open_fresh(add_change(plan, config->name, old), config, o, err);
}

static bool is_in(const struct dx_config *config, const char *name)
{
    for (uint32_t k = 0; k < config->n_streams; k++)
        if (!strcmp(config->streams[k].name, name))
            return true;
    return false;
}

static void plan_removals(struct dx_reload_plan *plan, const struct dx_reload_options *o,
                          struct dx_reload_report *report)
{
    for (uint32_t k = 0; k < o->streams->n; k++) {
        struct dx_stream *s = o->streams->stream[k];
        const char *name = dx_stream_config(s)->name;

        if (is_in(&plan->next, name))
            continue;
        tell(report, name, DX_RELOAD_REMOVED);
        add_change(plan, name, s);
    }
}

int dx_reload_plan_make(struct dx_reload_plan *plan, const struct dx_reload_options *o,
                        struct dx_reload_report *report, struct dx_err *err)
{
    int r = dx_config_load(&plan->next, o->file, err);

    plan->n = 0;
    for (uint32_t k = 0; k < plan->next.n_streams && r == 0; k++)
        r = plan_stream(plan, &plan->next.streams[k], o, report, err);
    dx_opening_set(&plan->opening, NULL);
    if (r == 0)
        plan_removals(plan, o, report);
    else
        dx_reload_plan_drop(plan);
    return r;
}

void dx_reload_plan_drop(struct dx_reload_plan *plan)
{
    for (uint32_t k = 0; k < plan->n; k++) {
        dx_server_stream_free(plan->change[k].shown);
        dx_stream_free(plan->change[k].fresh);
    }
    plan->n = 0;
    dx_config_fini(&plan->next);
}
