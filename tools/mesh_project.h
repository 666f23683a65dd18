/* dexel mesh --mode project: files of unorganized points to a mesh. */
#ifndef DX_MESH_PROJECT_H
#define DX_MESH_PROJECT_H

#include <stdbool.h>

/* The command line asks for this mode: it has options of its own. */
bool dx_mesh_project_asked(int argc, char **argv);

/* The exit status. */
int dx_mesh_project(int argc, char **argv);

#endif
