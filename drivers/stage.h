/*
 * A turning stage: joins a line source (the scans of a line scanner) and an angle source (angle.h)
 * into organized frames. Each value of a scan goes to the row of its beam and to the column of the
 * angle that the stage had when it was measured; columns are delivered as the stage leaves them,
 * and a frame ends with a sweep. Reader thread.
 *
 * p = Rz(psi) (offset + R r (cos a, 0, sin a)): a is the scanner's angle (0 forward, counted up),
 * psi the stage's, R = Rz(yaw) Ry(-pitch) Rx(roll) the mount's.
 */
#ifndef DX_STAGE_H
#define DX_STAGE_H

#include "drivers/angle.h"
#include "drivers/driver.h"

enum dx_stage_sweep {
    DX_STAGE_FULL,  /* a frame is a turn */
    DX_STAGE_HALF,  /* half a turn */
    DX_STAGE_SWING, /* from one end of angle.swing_deg to the other, and back the next */
};

enum dx_stage_halves {
    DX_STAGE_HALVES_AUTO,  /* both, unless the front half sees all in a sweep of a turn */
    DX_STAGE_HALVES_FRONT, /* that which looks forward */
    DX_STAGE_HALVES_BOTH,
};

struct dx_stage_config {
    struct dx_angle_config angle;
    enum dx_stage_sweep sweep;
    enum dx_stage_halves halves;
    uint32_t columns;     /* of a turn; 0: as many as there are scans in one, within reason */
    double offset_m[3];   /* where the scanner is, from the axis; x forward, y left, z up */
    double angles_deg[3]; /* roll, pitch, yaw of its forward direction and plane */
    bool mean;            /* of several values in a dexel, else the last */
    bool exact;           /* vertices are the points themselves, not those of columns' centres */
};

/* The line source: what every scan has in common. */
struct dx_line_shape {
    uint32_t n;                  /* values */
    double angle0_rad, step_rad; /* of the values; step > 0 */
    double max_m;                /* the farthest */
    double lines_s;              /* scans in a second */
    uint8_t attr_bytes;
};

/* A scan. */
struct dx_line {
    uint64_t host_ns;      /* when value 0 was measured */
    double step_ns;        /* from value to value */
    const uint32_t *range; /* [n] millimetres; 0: no return */
    const uint16_t *attr;  /* [n] or NULL */
    const struct dx_angle_sample *angle;
    size_t n_angles;
    struct dx_stamp stamp;
};

struct dx_stage_counts {
    uint64_t n_late;      /* values for a column that the stage had left */
    uint64_t n_outside;   /* of the swing; or back over the beginning of a sweep */
    uint64_t n_uncertain; /* left out: the angle was in doubt */
};

struct dx_turning_stage;

/* Columns that the stage goes on from one scan to the next at a speed, in radians a second; above
 * two most columns stay empty, and no mesh comes of it. `*turn`: columns of a whole turn. */
double dx_stage_stride(const struct dx_stage_config *config, const struct dx_line_shape *shape,
                       double rad_s, uint32_t *turn);

/* NULL, or why there is no such stage, and *key is the key at fault ("stage.angles"). */
const char *dx_stage_check(const struct dx_stage_config *config, const char **key);

int dx_stage_new(struct dx_turning_stage **out, const struct dx_stage_config *config,
                 struct dx_err *err);
void dx_stage_free(struct dx_turning_stage *stage); /* NULL is fine */

/* Makes the grid when the shape is a new one; tells the sink. -EINVAL, -ENOMEM, or the sink's. */
int dx_stage_shape(struct dx_turning_stage *stage, const struct dx_line_shape *shape,
                   const struct dx_frame_sink *sink, struct dx_err *err);
/* One scan. 0, or DX_DRIVER_E_AGAIN (the sink is closing). */
int dx_stage_put(struct dx_turning_stage *stage, const struct dx_line *line,
                 const struct dx_frame_sink *sink);
/* What is half assembled is void: the next scan begins a frame. */
void dx_stage_restart(struct dx_turning_stage *stage);

/* NULL before the first shape. */
const struct dx_geometry *dx_stage_geometry(const struct dx_turning_stage *stage);
const char *dx_stage_layout_text(const struct dx_turning_stage *stage);
struct dx_stage_counts dx_stage_counts(const struct dx_turning_stage *stage);

#endif
