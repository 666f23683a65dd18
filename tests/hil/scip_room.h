/*
 * What a simulated line scanner on a turning stage sees: a box-shaped room, cast ray by ray, so
 * that the truth is known. Pure functions, in the terms of drivers/stage.h, but not of its code.
 */
#ifndef SCIP_ROOM_H
#define SCIP_ROOM_H

#include "core/base/trig.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* The scanner's mount and stage, as drivers/stage.h has them. */
struct scip_pose {
    double rpm, start_deg, swing_deg;
    bool clockwise;
    double offset[3], angles_deg[3];
};

static inline void scip_sim_mount(double r[9], const double deg[3])
{
    double sr, cr, sp, cp, sy, cy;

    dx_sincos(dx_rad(deg[0]), &sr, &cr);
    dx_sincos(dx_rad(deg[1]), &sp, &cp);
    dx_sincos(dx_rad(deg[2]), &sy, &cy);
    /* Rz(yaw) Ry(-pitch) Rx(roll), written out */
    r[0] = cy * cp;
    r[1] = -cy * sp * sr - sy * cr;
    r[2] = -cy * sp * cr + sy * sr;
    r[3] = sy * cp;
    r[4] = -sy * sp * sr + cy * cr;
    r[5] = -sy * sp * cr - cy * sr;
    r[6] = sp;
    r[7] = cp * sr;
    r[8] = cp * cr;
}

static inline double scip_sim_stage(const struct scip_pose *p, uint64_t host_ns)
{
    double turns = (double)host_ns / 60e9 * p->rpm, swing = p->swing_deg / 360;

    if (swing > 0) {
        double at = fmod(turns, 2 * swing);

        turns = at > swing ? 2 * swing - at : at;
    }
    return dx_rad(p->start_deg) + 2 * DX_PI * (p->clockwise ? -turns : turns);
}

/* Distance from a point inside the room to its wall; d of length 1. */
static inline double scip_sim_cast(const double room[6], const double o[3], const double d[3])
{
    double best = INFINITY;

    for (int k = 0; k < 3; k++) {
        double to = d[k] > 0 ? room[3 + k] - o[k] : room[k] - o[k];
        double t = d[k] == 0 ? INFINITY : to / d[k];

        best = t < best ? t : best;
    }
    return best;
}

/* Metres along the beam at the scanner's angle, when the stage is at psi. */
static inline double scip_room_range(const double room[6], const struct scip_pose *pose,
                                     double angle, double psi)
{
    const double beam[3] = {dx_cos(angle), 0, dx_sin(angle)};
    double r[9], o[3], d[3], c = dx_cos(psi), n = dx_sin(psi), v[3];

    scip_sim_mount(r, pose->angles_deg);
    for (int k = 0; k < 3; k++)
        v[k] = r[3 * k] * beam[0] + r[3 * k + 1] * beam[1] + r[3 * k + 2] * beam[2];
    d[0] = v[0] * c - v[1] * n;
    d[1] = v[0] * n + v[1] * c;
    d[2] = v[2];
    o[0] = pose->offset[0] * c - pose->offset[1] * n;
    o[1] = pose->offset[0] * n + pose->offset[1] * c;
    o[2] = pose->offset[2];
    return scip_sim_cast(room, o, d);
}

#endif
