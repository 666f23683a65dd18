/* The table of modes, and which of them is asked for. */
#include "tools/mesh_mode.h"

#include <string.h>

#define SHORTEST 4 /* of "--mode": "--m" could be --memory too */

static const struct dx_mesh_mode *const modes[] = {
    &dx_mesh_mode_project,
    &dx_mesh_mode_delaunay,
    &dx_mesh_mode_smooth,
};

#define N_MODES (sizeof(modes) / sizeof(modes[0]))

static const struct dx_mesh_mode *find(const char *name)
{
    for (size_t k = 0; k < N_MODES; k++)
        if (strcmp(modes[k]->name, name) == 0)
            return modes[k];
    return NULL;
}

const struct dx_mesh_mode *dx_mesh_mode_asked(int argc, char **argv)
{
    const struct dx_mesh_mode *mode = NULL;

    for (int k = 1; k < argc && !mode; k++) {
        const size_t len = strcspn(argv[k], "=");
        const char *value = argv[k][len] ? argv[k] + len + 1 : k + 1 < argc ? argv[k + 1] : "";

        if (len >= SHORTEST && strncmp(argv[k], "--mode", len) == 0)
            mode = find(value);
    }
    return mode;
}

const char *const *dx_mesh_mode_names(void)
{
    static const char *names[N_MODES + 2] = {"terrain"};

    for (size_t k = 0; k < N_MODES; k++)
        names[k + 1] = modes[k]->name;
    return names;
}
