/* dexel convert --normals: unorganized points to the same with normals. One thread. */
#ifndef DX_CONVERT_NORMALS_H
#define DX_CONVERT_NORMALS_H

#include <stdbool.h>

/* The command line asks for it: it has options of its own. */
bool dx_convert_normals_asked(int argc, char **argv);

/* The exit status. */
int dx_convert_normals(int argc, char **argv);

#endif
