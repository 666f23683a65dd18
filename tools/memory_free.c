/* /proc/meminfo, and the limits of the control groups (version 2) that this process is in. */
#include "tools/memory_free.h"

#include <inttypes.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>

#define CGROUPS "/sys/fs/cgroup"

static uint64_t machine_free(void)
{
    FILE *f = fopen("/proc/meminfo", "re");
    uint64_t kb, sum = 0;
    char line[128];
    int n = 0;

    while (f && fgets(line, sizeof(line), f))
        if (sscanf(line, "MemAvailable: %" SCNu64, &kb) == 1 ||
            sscanf(line, "SwapFree: %" SCNu64, &kb) == 1) {
            sum += kb * 1024;
            n++;
        }
    if (f)
        fclose(f);
    return n ? sum : UINT64_MAX;
}

/* A number that stands alone in a file of the group; UINT64_MAX: there is none, or "max". */
static uint64_t group_number(const char *group, const char *file)
{
    uint64_t value = UINT64_MAX;
    char path[512];
    FILE *f;

    snprintf(path, sizeof(path), CGROUPS "%s/%s", group, file);
    f = fopen(path, "re");
    if (f && fscanf(f, "%" SCNu64, &value) != 1)
        value = UINT64_MAX;
    if (f)
        fclose(f);
    return value;
}

/* The path of the group in the one hierarchy of version 2; false: there is none. */
static bool own_group(char group[256])
{
    FILE *f = fopen("/proc/self/cgroup", "re");
    bool found = false;

    while (f && !found && fgets(group, 256, f))
        if (strncmp(group, "0::/", 4) == 0) {
            memmove(group, group + 3, strlen(group + 3) + 1);
            group[strcspn(group, "\n")] = '\0';
            found = true;
        }
    if (f)
        fclose(f);
    return found;
}

uint64_t dx_memory_free(void)
{
    uint64_t least = machine_free();
    char group[256], *slash;

    if (!own_group(group))
        return least;
    /* Each group above may have a limit of its own. */
    do {
        const uint64_t max = group_number(group, "memory.max"),
                       used = group_number(group, "memory.current");
        const uint64_t left = max > used ? max - used : 0;

        if (max != UINT64_MAX && used != UINT64_MAX && left < least)
            least = left;
        slash = strrchr(group, '/');
        if (slash)
            *slash = '\0';
    } while (slash);
    return least;
}

uint64_t dx_memory_peak(void)
{
    struct rusage use;

    return getrusage(RUSAGE_SELF, &use) == 0 ? (uint64_t)use.ru_maxrss * 1024 : 0;
}
