/*
 * Mixed pixels: samples between two surfaces, of a beam that met both. One that is cut off on both
 * sides is left out. A missing neighbour cuts nothing off, so that dead scan lines do not eat their
 * neighbours; and what is joined is not decided again after, which keeps the rule local.
 */
#ifndef DX_MIXED_H
#define DX_MIXED_H

#include "core/grid/area.h"

/* Fills alive from valid and joined, and so the final edges. */
void dx_mixed_find(struct dx_area *a, const struct dx_gates *gates);

#endif
