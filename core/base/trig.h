/*
 * sin, cos, atan2, exp and log as fixed polynomials in double: glibc's differ in the last bits
 * between machines (with and without FMA), and what we compute must not. Absolute error below 1e-14
 * (sin, cos, atan2), relative below 1e-14 (exp, log). Pure functions, any thread.
 */
#ifndef DX_TRIG_H
#define DX_TRIG_H

#define DX_PI 3.14159265358979323846

/* |x| up to 1e6 rad. */
void dx_sincos(double x, double *s, double *c);
double dx_sin(double x);
double dx_cos(double x);
double dx_tan(double x);

/* In [-pi, pi]; 0 for (0, 0); the sign of a zero y does not count. */
double dx_atan2(double y, double x);

/* x in [-1, 1], clamped. */
double dx_acos(double x);

/* x in [-700, 700]; log for x > 0 (normal numbers). */
double dx_exp(double x);
double dx_log(double x);

static inline double dx_rad(double deg)
{
    return deg * (DX_PI / 180);
}

static inline double dx_deg(double rad)
{
    return rad * (180 / DX_PI);
}

#endif
