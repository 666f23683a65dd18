/*
 * Where a turning stage stands: samples of its angle, with host times. A source is one of several
 * kinds behind a small table; the driver of a line scanner asks it for the samples that belong to a
 * scan and puts them into the scan's block, so that a recording replays. Reader thread.
 */
#ifndef DX_ANGLE_H
#define DX_ANGLE_H

#include "core/base/err.h"
#include "drivers/stage_encoder.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Between samples the angle runs evenly; outside of them as between the nearest two. */
struct dx_angle_sample {
    uint64_t host_ns; /* CLOCK_MONOTONIC; samples of a list ascend */
    double angle_rad; /* counter-clockwise from above; counted on over turns, without jumps */
    bool uncertain;   /* what lies next to it may be wrong (missed edges, no index yet) */
};

struct dx_angle_source;

struct dx_angle_ops {
    /* Takes in what has come; called between scans, at the latest every pump_ms. 0, or negative:
     * the source has failed for good. */
    int (*pump)(struct dx_angle_source *source, struct dx_err *err);
    /* The samples that tell the angle from `from_ns` to `until_ns`: one at or before, those within,
     * one at or behind, as far as it has them. At most `max` (2 at the least), evenly thinned out.
     * Returns how many; 0: it does not know. */
    size_t (*samples)(struct dx_angle_source *source, uint64_t from_ns, uint64_t until_ns,
                      struct dx_angle_sample *out, size_t max);
    /* Why its angles are doubtful; "": they are not. */
    void (*trouble)(const struct dx_angle_source *source, char *text, size_t len);
    void (*close)(struct dx_angle_source *source);
};

struct dx_angle_source {
    const struct dx_angle_ops *ops;
    uint32_t pump_ms; /* 0: pump() has nothing to do */
};

struct dx_angle_config {
    struct dx_encoder_config encoder; /* with lines, it tells the angle; else: */
    /* constant: the stage turns by itself, evenly. The angle is `start_deg` when the host's clock
     * is 0, so that it is the same for every stay of the scanner. */
    double rpm;       /* > 0; of a stage with an encoder about so, or 0 */
    double start_deg; /* of the stage */
    bool clockwise;
    double swing_deg; /* > 0: from the start so far and back, at even speed; 0: on and on */
};

/* NULL, or why there is no such source, and *key is the key at fault ("stage.rpm"). */
const char *dx_angle_check(const struct dx_angle_config *config, const char **key);

/* -EINVAL, -ENOMEM, or what the encoder gives. */
int dx_angle_open(struct dx_angle_source **out, const struct dx_angle_config *config,
                  struct dx_err *err);
void dx_angle_close(struct dx_angle_source *source); /* NULL is fine */

/* The constant source's angle at a host time. */
double dx_angle_constant(const struct dx_angle_config *config, uint64_t host_ns);

#endif
