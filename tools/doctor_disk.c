/* The folders that the service writes to: are they there, may it, and is there room? */
#include "tools/doctor.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/statvfs.h>

#define MIB      (1ull << 20)
#define ROOM_MIB 2048u             /* less is told of a recording that has no bound of its own */
#define RECORDS  "/var/lib/dexeld" /* the service's own: its unit makes it once, */
#define METRICS  "/run/dexeld-metrics" /* and this one at each start */

/* ---- a folder ---------------------------------------------------------------------------------
 */

/* Is it that folder, or below it, as the paths are spelt? */
static bool is_in(const char *path, const char *folder)
{
    const size_t len = strlen(folder);

    return !strncmp(path, folder, len) && (!path[len] || path[len] == '/');
}

/* The same wherever the folder really is: it may have another name than it seems. */
static bool is_own(const struct dx_doctor *d, const char *folder)
{
    static const char *const own[] = {RECORDS, METRICS};
    char path[PATH_MAX], *real, *within;
    bool is = false;

    dx_doctor_path(d, path, sizeof(path), folder);
    real = realpath(path, NULL);
    for (size_t k = 0; real && k < sizeof(own) / sizeof(own[0]); k++) {
        dx_doctor_path(d, path, sizeof(path), own[k]);
        within = realpath(path, NULL);
        is |= within && is_in(real, within);
        free(within);
    }
    free(real);
    return is;
}

/* Makes a folder of the service's user; the group is there where a package has made it. */
static const char *install_command(struct dx_doctor *d, const char *folder, const char *mode,
                                   const char *then, const char *of)
{
    char pattern[128];
    gid_t gid;

    snprintf(pattern, sizeof(pattern), "sudo install -d -o @%s -m @ @%s",
             dx_doctor_group(d, "dexel", &gid) ? " -g dexel" : "", then);
    return dx_doctor_command(d, pattern, dx_doctor_runs_as(d)->name, mode, folder, of);
}

/* The service's own folder is given to it; of others, which may be anybody's, one within. */
static const char *give_command(struct dx_doctor *d, const char *folder, const char *mode)
{
    char within[PATH_MAX];

    if (is_own(d, folder))
        return dx_doctor_command(d, "sudo chown @ @", dx_doctor_runs_as(d)->name, folder);
    snprintf(within, sizeof(within), "%s/dexeld", strcmp(folder, "/") ? folder : "");
    return install_command(d, within, mode, " && sudoedit @", d->config_path);
}

static const char *make_command(struct dx_doctor *d, const char *folder, const char *mode)
{
    if (is_in(folder, METRICS) && *d->pid)
        return "sudo systemctl restart dexeld";
    return install_command(d, folder, mode, "", "");
}

/* May the service write there? `who` asks for it: a stream, a key. */
static bool is_fit(struct dx_doctor *d, const char *who, const char *folder, const char *mode)
{
    const struct dx_doctor_user *user = dx_doctor_runs_as(d);
    struct stat st;

    if (!dx_doctor_stat(d, folder, &st)) {
        dx_doctor_tell(d, DX_DOCTOR_PROBLEM, make_command(d, folder, mode),
                       "%s: there is no folder %s", who, folder);
    } else if (!S_ISDIR(st.st_mode)) {
        dx_doctor_tell(d, DX_DOCTOR_PROBLEM, dx_doctor_edit_command(d), "%s: %s is no folder", who,
                       folder);
    } else if (!dx_doctor_may_open(user, &st)) {
        const char *mend = give_command(d, folder, mode);

        dx_doctor_tell(d, DX_DOCTOR_PROBLEM, mend, "%s: %s may not write to %s", who, user->name,
                       folder);
    } else {
        return true;
    }
    return false;
}

/* ---- recordings -------------------------------------------------------------------------------
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

/* Which recordings may go is for people to say: one of them may be written just now. */
static void look_at_recordings(struct dx_doctor *d, const struct dx_stream_config *s)
{
    const unsigned need_mib = s->record.keep_mib ? s->record.split_mib : ROOM_MIB;
    unsigned long long room;
    char folder[PATH_MAX];

    dx_doctor_folder(folder, sizeof(folder), s->record.path);
    if (!is_fit(d, s->name, folder, "750"))
        return;
    if (find_room(d, folder, &room) && room / MIB < need_mib)
        dx_doctor_tell(d, room / MIB < 64 ? DX_DOCTOR_PROBLEM : DX_DOCTOR_WARNING,
                       dx_doctor_command(d, "ls -ltr @", folder), "%s: %llu MB are free in %s; %s",
                       s->name, room / MIB, folder,
                       s->record.keep_mib ? "record.keep_mib bounds its recordings, and may be less"
                                          : "nothing bounds its recordings (record.keep_mib)");
    else
        dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "%s: there is room in %s", s->name, folder);
}

/* ---- metrics ----------------------------------------------------------------------------------
 */

static void look_at_metrics(struct dx_doctor *d, const char *file)
{
    char folder[PATH_MAX];
    struct stat st;

    dx_doctor_folder(folder, sizeof(folder), file);
    if (is_in(folder, METRICS) && !*d->pid && !dx_doctor_stat(d, folder, &st))
        dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "metrics_file: %s is made when the service starts",
                       folder);
    else if (is_fit(d, "metrics_file", folder, "755"))
        dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "metrics_file: the service may write to %s", folder);
}

void dx_doctor_disk(struct dx_doctor *d)
{
    unsigned n = 0;

    for (uint32_t k = 0; k < d->config.n_streams; k++) {
        if (!*d->config.streams[k].record.path)
            continue;
        look_at_recordings(d, &d->config.streams[k]);
        n++;
    }
    if (n == 0)
        dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "nothing is configured to be recorded");
    if (*d->config.metrics_file)
        look_at_metrics(d, d->config.metrics_file);
}
