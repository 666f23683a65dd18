/* Limits of the process, and the speed of processors. */
#include "tools/doctor.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define GOVERNORS "/sys/devices/system/cpu/cpu*/cpufreq/scaling_governor"

/* ---- limits of the process --------------------------------------------------------------------
 */

/*
 * A subscriber takes one descriptor, a stream about eight (its device, its thread's wake-ups, a
 * recording), the service itself some. What runs is asked for its own limit; else this shell's is
 * told, which a service that is started from it would have.
 */
void dx_doctor_limits(struct dx_doctor *d)
{
    const unsigned max_clients = d->config.max_clients;
    const unsigned long need = max_clients + 8 * d->config.n_streams + 64;
    char path[64], text[4096], line[128], mend[256];
    unsigned long has;

    snprintf(path, sizeof(path), "/proc/%s/limits", *d->pid ? d->pid : "self");
    if (!dx_doctor_read(d, path, text, sizeof(text)) ||
        !dx_doctor_line(text, "Max open files", line, sizeof(line)))
        return;
    has = strncmp(line, "unlimited", 9) ? strtoul(line, NULL, 10) : need;
    if (*d->pid)
        snprintf(
            mend, sizeof(mend),
            "printf '[Service]\\nLimitNOFILE=%lu\\n' | sudo install -D -m 644 /dev/stdin "
            "/etc/systemd/system/dexeld.service.d/files.conf && sudo systemctl daemon-reload && "
            "sudo systemctl restart dexeld",
            2 * need);
    else
        snprintf(mend, sizeof(mend), "ulimit -n %lu", 2 * need);
    if (has < need)
        dx_doctor_tell(d, DX_DOCTOR_PROBLEM, mend,
                       "%s may have %lu open files, %u subscribers and %u streams need %lu",
                       *d->pid ? "the service" : "a program of this shell", has, max_clients,
                       d->config.n_streams, need);
    else
        dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "%s may have %.*s open files, %lu are needed",
                       *d->pid ? "the service" : "a program of this shell", (int)strcspn(line, " "),
                       line, need);
}

/* ---- processors -------------------------------------------------------------------------------
 */

/* `powersave` of these drivers follows the load, as other governors do. */
static bool is_by_load(const struct dx_doctor *d)
{
    char driver[32];

    return dx_doctor_read(d, "/sys/devices/system/cpu/cpu0/cpufreq/scaling_driver", driver,
                          sizeof(driver)) &&
           (!strcmp(driver, "intel_pstate") || !strcmp(driver, "amd-pstate-epp"));
}

void dx_doctor_processor(struct dx_doctor *d)
{
    unsigned n_slow = 0, n = 0;
    glob_t g;

    dx_doctor_glob(d, GOVERNORS, &g);
    for (size_t k = 0; k < g.gl_pathc; k++) {
        char governor[32];

        n++;
        n_slow += dx_doctor_read(d, dx_doctor_match(d, &g, k), governor, sizeof(governor)) &&
                  !strcmp(governor, "powersave");
    }
    globfree(&g);
    if (n_slow && !is_by_load(d))
        dx_doctor_tell(d, DX_DOCTOR_WARNING, "echo schedutil | sudo tee " GOVERNORS,
                       "%u of %u processors stay at their lowest frequency (powersave): latency "
                       "suffers",
                       n_slow, n);
    else if (n)
        dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "processors follow the load");
    else
        dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "processors have no governor here");
}
