/* Surfaces given by an equation, sampled by points that keep a distance: a part of surfaces.c. */
#ifndef DX_SURFACES_IMPLICIT_H
#define DX_SURFACES_IMPLICIT_H

#include "core/base/rng.h"
#include "drivers/synth/surfaces.h"

/* At most `max` points into xyz[max][3], about as many. Errors: -ENOMEM. */
int dx_implicit_sample(double *xyz, uint32_t *n, double *spacing, uint32_t max,
                       enum dx_surface surface, struct dx_rng *rng);

#endif
