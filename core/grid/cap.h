/*
 * The cap: the longest edge, in 3-D. The rule is in integers (docs/terrain.md); f32 points decide
 * all but the few edges that are as long as the cap to the last bits.
 */
#ifndef DX_CAP_H
#define DX_CAP_H

#include "core/grid/area.h"

/* Fills an area's points, from its ranges. */
void dx_cap_gather(struct dx_area *a, const struct dx_geometry *g, const struct dx_gates *gates);

/* Of the row joined[e][p], takes away the edges that are too long. */
void dx_cap_row(struct dx_area *a, const struct dx_gates *gates, enum dx_edge e, uint32_t p);

#endif
