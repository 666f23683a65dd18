/* Room and speed: disk of recordings, descriptors, processors. */
#include "tools/doctor.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/statvfs.h>

#define MIB       (1ull << 20)
#define ROOM_MIB  2048u /* less is told of a recording that has no bound of its own */
#define GOVERNORS "/sys/devices/system/cpu/cpu*/cpufreq/scaling_governor"

/* ---- disk -------------------------------------------------------------------------------------
 */

/* Bytes that may still be written there. False: nobody knows. */
static bool find_room(const struct dx_doctor *d, const char *folder, unsigned long long *bytes)
{
    char whole[PATH_MAX], key[PATH_MAX], text[32];
    struct statvfs s;

    snprintf(key, sizeof(key), "free %.300s", folder);
    if (dx_doctor_fact(d, key, text, sizeof(text))) {
        *bytes = strtoull(text, NULL, 10);
        return true;
    }
    dx_doctor_path(d, whole, sizeof(whole), folder);
    if (statvfs(whole, &s) < 0)
        return false;
    *bytes = (unsigned long long)s.f_bavail * s.f_frsize;
    return true;
}

static void look_at_folder(struct dx_doctor *d, const struct dx_stream_config *s)
{
    const struct dx_doctor_user *user = dx_doctor_runs_as(d);
    char folder[1024], mend[1280];
    const char *slash = strrchr(s->record.path, '/');
    const unsigned need_mib = s->record.keep_mib ? s->record.split_mib : ROOM_MIB;
    unsigned long long room;
    struct stat st;

    snprintf(folder, sizeof(folder), "%.*s", slash ? (int)(slash - s->record.path) : 1,
             slash ? s->record.path : ".");
    if (!dx_doctor_stat(d, folder, &st)) {
        snprintf(mend, sizeof(mend), "sudo install -d -o %s -g dexel -m 750 %s", user->name,
                 folder);
        dx_doctor_tell(d, DX_DOCTOR_PROBLEM, mend, "%s: there is no folder %s for its recordings",
                       s->name, folder);
    } else if (!dx_doctor_may_open(user, &st)) {
        snprintf(mend, sizeof(mend), "sudo chown %s %s", user->name, folder);
        dx_doctor_tell(d, DX_DOCTOR_PROBLEM, mend, "%s: %s may not write to %s", s->name,
                       user->name, folder);
    } else if (find_room(d, folder, &room) && room / MIB < need_mib) {
        snprintf(mend, sizeof(mend), "ls -t %.300s/*.mcap | tail -n 1 | xargs -d '\\n' sudo rm --",
                 folder);
        dx_doctor_tell(d, room / MIB < 64 ? DX_DOCTOR_PROBLEM : DX_DOCTOR_WARNING, mend,
                       "%s: %llu MB are free in %s%s; the oldest recording can go", s->name,
                       room / MIB, folder,
                       s->record.keep_mib ? "" : ", and nothing bounds it (record.keep_mib)");
    } else {
        dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "%s: there is room in %s", s->name, folder);
    }
}

void dx_doctor_disk(struct dx_doctor *d)
{
    unsigned n = 0;

    for (uint32_t k = 0; k < d->config.n_streams; k++) {
        if (!*d->config.streams[k].record.path)
            continue;
        look_at_folder(d, &d->config.streams[k]);
        n++;
    }
    if (n == 0)
        dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "nothing is configured to be recorded");
}

/* ---- limits of the process --------------------------------------------------------------------
 */

/*
 * A subscriber takes one descriptor, a stream about eight (its device, its thread's wake-ups, a
 * recording), the service itself some. What runs is asked for its own limit; else this shell's is
 * told, which a service that is started from it would have.
 */
void dx_doctor_limits(struct dx_doctor *d)
{
    const unsigned max_clients = d->has_config ? d->config.max_clients : 256;
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
