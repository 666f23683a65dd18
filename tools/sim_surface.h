/* dexel sim --surface: analytic surfaces as unorganized points. */
#ifndef DX_SIM_SURFACE_H
#define DX_SIM_SURFACE_H

#include <stdbool.h>

/* The command line asks for it: it has options of its own. */
bool dx_sim_surface_asked(int argc, char **argv);

/* The exit status. */
int dx_sim_surface(int argc, char **argv);

#endif
