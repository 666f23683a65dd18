/* Normal deviates. */
#include "core/base/rng.h"

#include "core/base/trig.h"

#include <math.h>

double dx_rng_normal(struct dx_rng *g)
{
    double u = dx_rng_unit(g) + 0x1p-54;
    double v = dx_rng_unit(g);

    return sqrt(-2 * dx_log(u)) * dx_cos(2 * DX_PI * v);
}
