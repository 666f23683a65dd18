/*
 * Points of a plane in order of angle around the origin, as Gopi and Krishnan (2002, section 4.1)
 * do it: by quadrant, then by sin^2, without trigonometry. Where sin^2 does not tell, the cross
 * product does, exactly; on one ray the nearer comes first, then the lower number.
 */
#ifndef DX_FLAT_ORDER_H
#define DX_FLAT_ORDER_H

#include "core/cloud/predicates.h"

/* One point to be ordered; `key` is set by dx_angle_key. */
struct dx_angle {
    double key;
    struct dx_flat at; /* not the origin */
    uint32_t number;
};

/* Quadrant + sin^2 within it (from its first axis), 0 to below 4 but for rounding; monotone in the
 * angle from the x axis but for rounding. */
double dx_angle_key(struct dx_flat at);

/* Sorts v[n]: few points, insertion. */
void dx_angle_sort(struct dx_angle *v, uint32_t n);

#endif
