/*
 * Which neighbours are joined: the first-order rule (docs/terrain.md), a row of edges at a time,
 * the rescue of those that it cuts wrongly, and the cap on their length.
 */
#ifndef DX_EDGES_H
#define DX_EDGES_H

#include "core/grid/area.h"

/* Fills joined[e][p][q] for the rows that the rules in force read. */
void dx_edges_join(struct dx_area *a, const struct dx_gates *gates, const struct dx_geometry *g);

#endif
