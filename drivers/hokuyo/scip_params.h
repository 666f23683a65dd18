/*
 * What a scanner says of itself: PP (its constants), VV (who it is), II (how it is). Lines are
 * taken by their key, in any order; unknown keys do not matter. Pure functions.
 */
#ifndef DX_SCIP_PARAMS_H
#define DX_SCIP_PARAMS_H

#include "drivers/hokuyo/scip_lines.h"

/* By which the reasons for a missing range are read (DEVICES 1.5). */
enum dx_scip_class { DX_SCIP_CLASS_URG = 0, DX_SCIP_CLASS_UTM = 1 };

struct dx_scip_params {
    uint32_t ares;       /* steps in a turn */
    uint32_t amin, amax; /* first and last step that can be measured */
    uint32_t afrt;       /* the step straight ahead */
    uint32_t dmin, dmax; /* millimetres */
    uint32_t scan_rpm;   /* of its mirror */
    enum dx_scip_class class;
    char model[32]; /* "UTM-30LX" */
};

struct dx_scip_identity {
    char serial[32], firmware[32];
};

/* Each takes the lines behind the status. False: a line is damaged, or (PP) a constant is missing
 * or makes no sense. */
bool dx_scip_read_params(struct dx_scip_params *p, struct dx_scip_cursor lines);
bool dx_scip_read_identity(struct dx_scip_identity *id, struct dx_scip_cursor lines);
/* STAT of II; "" when the scanner says that it is well. */
bool dx_scip_read_trouble(char *text, size_t len, struct dx_scip_cursor lines);

/* Whether the constants are those of a scanner: what comes from outside is checked by it. */
bool dx_scip_params_good(const struct dx_scip_params *p);

/* Nanoseconds of a turn of the mirror. */
static inline double dx_scip_period_ns(const struct dx_scip_params *p)
{
    return 60e9 / p->scan_rpm;
}

#endif
