/* dexel convert --smooth: a cloud of points, smoothed, with normals. One thread and its pool. */
#ifndef DX_CONVERT_SMOOTH_H
#define DX_CONVERT_SMOOTH_H

#include <stdbool.h>

bool dx_convert_smooth_asked(int argc, char **argv);

/* The exit status. */
int dx_convert_smooth(int argc, char **argv);

#endif
