/* Octahedral unit vectors: see octahedral.h. */
#include "core/grid/octahedral.h"

#include <math.h>

/* Between the lower half of the octahedron and the corners of the square; its own inverse. */
static void fold(float *u, float *v)
{
    float x = *u, y = *v;

    *u = (1 - fabsf(y)) * (x >= 0 ? 1.0f : -1.0f);
    *v = (1 - fabsf(x)) * (y >= 0 ? 1.0f : -1.0f);
}

void dx_octahedral_encode(int8_t out[2], const float n[3])
{
    float sum = (fabsf(n[0]) + fabsf(n[1])) + fabsf(n[2]);
    float u, v;

    out[0] = out[1] = 0;
    if (!(sum > 0 && sum < INFINITY))
        return;
    u = n[0] / sum;
    v = n[1] / sum;
    if (n[2] < 0)
        fold(&u, &v);
    out[0] = (int8_t)rint((double)(u * DX_OCTAHEDRAL_MAX));
    out[1] = (int8_t)rint((double)(v * DX_OCTAHEDRAL_MAX));
}

void dx_octahedral_decode(float n[3], const int8_t in[2])
{
    float u = (float)in[0] / DX_OCTAHEDRAL_MAX, v = (float)in[1] / DX_OCTAHEDRAL_MAX;
    float w = (1 - fabsf(u)) - fabsf(v), len;

    if (w < 0)
        fold(&u, &v);
    /* rounded once: the square root of a binary32 number in binary64 rounds to the same as its own
     */
    len = (float)sqrt((double)((u * u + v * v) + w * w));
    n[0] = u / len;
    n[1] = v / len;
    n[2] = w / len;
}
