/* Symmetric 3x3 matrices: covariances of points and their principal axes. Pure functions. */
#ifndef DX_SYM3_H
#define DX_SYM3_H

/* xx, xy, xz, yy, yz, zz */
struct dx_sym3 {
    double m[6];
};

struct dx_eigen3 {
    double value[3];     /* ascending */
    double vector[3][3]; /* [k]: of value[k], unit length; right-handed */
};

/* Rotations of Jacobi, in a fixed order: the same bits everywhere. */
void dx_sym3_eigen(struct dx_eigen3 *e, const struct dx_sym3 *s);

#endif
