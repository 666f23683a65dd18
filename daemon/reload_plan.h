/*
 * What a reload is going to do to each stream, worked out and made ready before anything is
 * touched. Inside reload.c, beside the loop.
 */
#ifndef DX_RELOAD_PLAN_H
#define DX_RELOAD_PLAN_H

#include "daemon/opening.h"
#include "daemon/reload.h"
#include "daemon/reload_report.h"

struct dx_reload_change {
    char name[64];
    struct dx_stream *old;   /* NULL: the stream is added */
    struct dx_stream *fresh; /* NULL: it is removed */
    /* what the server has of it: of `fresh` until it takes its place, then of `old` */
    struct dx_server_stream *shown;
};

struct dx_reload_plan {
    struct dx_config next;
    struct dx_reload_change change[2 * DX_CONFIG_MAX_STREAMS];
    uint32_t n;
    struct dx_opening opening; /* for the loop, while the plan is made */
};

/* Reads the file and opens what it newly asks for; the report says what becomes of each stream. On
 * error there is no plan. Errors, with a text that names the file and mostly the line: those of
 * dx_config_load and dx_stream_new, -ENOMEM. */
int dx_reload_plan_make(struct dx_reload_plan *plan, const struct dx_reload_options *o,
                        struct dx_reload_report *report, struct dx_err *err);

/* Frees what it opened. Nothing of it was put into its place. */
void dx_reload_plan_drop(struct dx_reload_plan *plan);

#endif
