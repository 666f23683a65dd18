/* What a reload has done, for the log and the control socket. */
#ifndef DX_RELOAD_REPORT_H
#define DX_RELOAD_REPORT_H

#include "daemon/config.h"

enum dx_reload_did {
    DX_RELOAD_ADDED,
    DX_RELOAD_CHANGED,
    DX_RELOAD_REMOVED,
    DX_RELOAD_UNCHANGED,
};
#define DX_RELOAD_N_DID 4

struct dx_reload_report {
    const char *file;
    bool is_refused;    /* nothing was changed */
    struct dx_err err;  /* why it was refused, or what went wrong; "": nothing did */
    uint32_t n_streams; /* those of before, and those of now */
    struct {
        char name[64];
        enum dx_reload_did did;
    } stream[2 * DX_CONFIG_MAX_STREAMS];
    unsigned n_fixed; /* keys whose new values count from the next start on */
    const char *fixed[DX_CONFIG_MAX_FIXED];
};

static inline uint32_t dx_reload_count(const struct dx_reload_report *report,
                                       enum dx_reload_did did)
{
    uint32_t n = 0;

    for (uint32_t k = 0; k < report->n_streams; k++)
        n += report->stream[k].did == did;
    return n;
}

#endif
