/*
 * Elementary functions with a fixed order of operations (built with -ffp-contract=off). Range
 * reduction in two or three parts (Cody and Waite), then Taylor or odd series on a short interval.
 */
#include "core/base/trig.h"

#include "core/base/bytes.h"

#include <math.h>

/* pi/2 in three parts; the first two have trailing zero bits, so that k * part is exact for small
 * k. */
#define PIO2_HI  0x1.921fb544p+0
#define PIO2_MID 0x1.0b4611a6p-34
#define PIO2_LO  0x1.3198a2e037073p-69

static double sin_poly(double x)
{
    double z = x * x;
    double p = -1.0 / 1307674368000.0;

    p = p * z + 1.0 / 6227020800.0;
    p = p * z - 1.0 / 39916800.0;
    p = p * z + 1.0 / 362880.0;
    p = p * z - 1.0 / 5040.0;
    p = p * z + 1.0 / 120.0;
    p = p * z - 1.0 / 6.0;
    return x + x * z * p;
}

static double cos_poly(double x)
{
    double z = x * x;
    double p = 1.0 / 20922789888000.0;

    p = p * z - 1.0 / 87178291200.0;
    p = p * z + 1.0 / 479001600.0;
    p = p * z - 1.0 / 3628800.0;
    p = p * z + 1.0 / 40320.0;
    p = p * z - 1.0 / 720.0;
    p = p * z + 1.0 / 24.0;
    p = p * z - 1.0 / 2.0;
    return 1.0 + z * p;
}

void dx_sincos(double x, double *s, double *c)
{
    double k = rint(x * (2 / DX_PI));
    double y = ((x - k * PIO2_HI) - k * PIO2_MID) - k * PIO2_LO;
    double sy = sin_poly(y), cy = cos_poly(y);

    switch ((long)k & 3) {
    case 0:
        *s = sy, *c = cy;
        break;
    case 1:
        *s = cy, *c = -sy;
        break;
    case 2:
        *s = -sy, *c = -cy;
        break;
    default:
        *s = -cy, *c = sy;
    }
}

double dx_sin(double x)
{
    double s, c;

    dx_sincos(x, &s, &c);
    return s;
}

double dx_cos(double x)
{
    double s, c;

    dx_sincos(x, &s, &c);
    return c;
}

double dx_tan(double x)
{
    double s, c;

    dx_sincos(x, &s, &c);
    return s / c;
}

/* atan on [0, 1]: two halvings atan(x) = 2 atan(x / (1 + sqrt(1 + x^2))) bring x below 0.2. */
static double atan_unit(double x)
{
    double p = 0, z;

    for (int k = 0; k < 2; k++)
        x = x / (1 + sqrt(1 + x * x));
    z = x * x;
    for (int n = 23; n >= 1; n -= 2)
        p = 1.0 / n - z * p;
    return 4 * (x * p);
}

double dx_atan2(double y, double x)
{
    double ax = fabs(x), ay = fabs(y), a;

    if (ax == 0 && ay == 0)
        return 0;
    a = ay <= ax ? atan_unit(ay / ax) : DX_PI / 2 - atan_unit(ax / ay);
    if (x < 0)
        a = DX_PI - a;
    return y < 0 ? -a : a;
}

double dx_acos(double x)
{
    if (x > 1)
        x = 1;
    if (x < -1)
        x = -1;
    return dx_atan2(sqrt((1 - x) * (1 + x)), x);
}

#define LN2_HI 0x1.62e42feep-1
#define LN2_LO 0x1.a39ef35793c76p-33

double dx_exp(double x)
{
    double k = rint(x / 0.69314718055994530942);
    double y = (x - k * LN2_HI) - k * LN2_LO;
    double p = 1;

    for (int n = 14; n >= 1; n--)
        p = 1 + y * p / n;
    return p * dx_f64_from_bits((uint64_t)(1023 + (int64_t)k) << 52);
}

double dx_log(double x)
{
    uint64_t bits = dx_f64_bits(x);
    int64_t e = (int64_t)(bits >> 52) - 1023;
    double m = dx_f64_from_bits((bits & 0xfffffffffffffu) | (uint64_t)1023 << 52);
    double p = 0, s, z;

    if (m > 1.41421356237309504880) {
        m /= 2;
        e++;
    }
    s = (m - 1) / (m + 1);
    z = s * s;
    for (int n = 23; n >= 1; n -= 2)
        p = 1.0 / n + z * p;
    return (double)e * LN2_LO + (2 * s * p + (double)e * LN2_HI);
}
