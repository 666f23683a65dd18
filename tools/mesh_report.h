/* dexel mesh --report: what a mesh file is, in numbers. */
#ifndef DX_MESH_REPORT_H
#define DX_MESH_REPORT_H

#include <stdbool.h>

/* The command line asks for it: it has options of its own. */
bool dx_mesh_report_asked(int argc, char **argv);

/* The exit status. */
int dx_mesh_report(int argc, char **argv);

#endif
