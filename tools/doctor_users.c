/* Who runs `dexel doctor`, who the service is, and what groups they have. */
#include "tools/doctor.h"

#include <grp.h>
#include <pwd.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define SERVICE_USER "dexeld"

static FILE *open_list(const struct dx_doctor *d, const char *path)
{
    char whole[PATH_MAX];

    dx_doctor_path(d, whole, sizeof(whole), path);
    return fopen(whole, "re");
}

static void add_gid(struct dx_doctor_user *user, gid_t gid)
{
    if (user->n_gids < DX_DOCTOR_MAX_GROUPS && !dx_doctor_has_gid(user, gid))
        user->gids[user->n_gids++] = gid;
}

/* The user's name by its number (name NULL), or number and first group by its name. */
static bool find_user(const struct dx_doctor *d, struct dx_doctor_user *user, const char *name)
{
    FILE *f = open_list(d, "/etc/passwd");
    const struct passwd *p = NULL;

    while (f && (p = fgetpwent(f)))
        if (name ? !strcmp(p->pw_name, name) : p->pw_uid == user->uid)
            break;
    if (!p && !*d->root) /* from a directory service */
        p = name ? getpwnam(name) : getpwuid(user->uid);
    if (p) {
        snprintf(user->name, sizeof(user->name), "%s", p->pw_name);
        user->uid = p->pw_uid;
        if (name)
            add_gid(user, p->pw_gid);
    }
    if (f)
        fclose(f);
    return p != NULL;
}

static bool is_member(const struct group *g, const char *name)
{
    for (char **member = g->gr_mem; *member; member++)
        if (!strcmp(*member, name))
            return true;
    return false;
}

bool dx_doctor_has_gid(const struct dx_doctor_user *user, gid_t gid)
{
    for (unsigned k = 0; k < user->n_gids; k++)
        if (user->gids[k] == gid)
            return true;
    return false;
}

/* Goes through the groups until one fits; its number and name. */
static bool find_group(const struct dx_doctor *d, const char *name, gid_t *gid, const char *member,
                       char *found, size_t len)
{
    FILE *f = open_list(d, "/etc/group");
    const struct group *g = NULL;

    while (f && (g = fgetgrent(f)))
        if ((name ? !strcmp(g->gr_name, name) : g->gr_gid == *gid) &&
            (!member || is_member(g, member)))
            break;
    if (g) {
        *gid = g->gr_gid;
        if (found)
            snprintf(found, len, "%s", g->gr_name);
    }
    if (f)
        fclose(f);
    return g != NULL;
}

bool dx_doctor_group(const struct dx_doctor *d, const char *name, gid_t *gid)
{
    return find_group(d, name, gid, NULL, NULL, 0);
}

bool dx_doctor_is_listed(const struct dx_doctor *d, const struct dx_doctor_user *user,
                         const char *group)
{
    gid_t gid = 0;

    return find_group(d, group, &gid, user->name, NULL, 0);
}

const char *dx_doctor_group_name(const struct dx_doctor *d, gid_t gid, char *text, size_t len)
{
    if (!find_group(d, NULL, &gid, NULL, text, len))
        snprintf(text, len, "%u", (unsigned)gid);
    return text;
}

bool dx_doctor_may_open(const struct dx_doctor_user *user, const struct stat *st)
{
    const mode_t both = S_IROTH | S_IWOTH;
    const mode_t bits = st->st_uid == user->uid               ? st->st_mode >> 6
                        : dx_doctor_has_gid(user, st->st_gid) ? st->st_mode >> 3
                                                              : st->st_mode;

    return user->uid == 0 || (bits & both) == both;
}

/* This session: what the kernel says of this process. */
static void find_me(struct dx_doctor *d)
{
    char status[4096], line[1024], *p = line, *end;

    d->me.known = dx_doctor_read(d, "/proc/self/status", status, sizeof(status));
    if (dx_doctor_line(status, "Uid:", line, sizeof(line)))
        d->me.uid = (uid_t)strtoul(line, NULL, 10);
    if (dx_doctor_line(status, "Gid:", line, sizeof(line)))
        add_gid(&d->me, (gid_t)strtoul(line, NULL, 10));
    if (dx_doctor_line(status, "Groups:", line, sizeof(line)))
        for (unsigned long gid = strtoul(p, &end, 10); end != p; gid = strtoul(p, &end, 10)) {
            add_gid(&d->me, (gid_t)gid);
            p = end;
        }
    if (!find_user(d, &d->me, NULL))
        snprintf(d->me.name, sizeof(d->me.name), "%u", (unsigned)d->me.uid);
}

/* What its unit adds to the groups that it is listed in. */
static void add_unit_groups(struct dx_doctor *d)
{
    static const char *const keys[] = {"Group=", "SupplementaryGroups="};
    char text[8192], names[256], *rest;

    if (!dx_doctor_read_unit(d, text, sizeof(text)))
        return;
    for (size_t i = 0; i < sizeof(keys) / sizeof(keys[0]); i++) {
        if (!dx_doctor_line(text, keys[i], names, sizeof(names)))
            continue;
        for (char *name = strtok_r(names, " ", &rest); name; name = strtok_r(NULL, " ", &rest)) {
            gid_t gid;

            if (dx_doctor_group(d, name, &gid))
                add_gid(&d->service, gid);
        }
    }
}

static void add_listed_groups(const struct dx_doctor *d, struct dx_doctor_user *user)
{
    FILE *f = open_list(d, "/etc/group");
    const struct group *g;

    while (f && (g = fgetgrent(f)))
        if (is_member(g, user->name))
            add_gid(user, g->gr_gid);
    if (f)
        fclose(f);
}

static void find_service(struct dx_doctor *d)
{
    d->service.known = find_user(d, &d->service, SERVICE_USER);
    if (!d->service.known)
        return;
    add_listed_groups(d, &d->service);
    add_unit_groups(d);
}

/* A service that made its sockets has locks beside them, which tell whose it is also to whom it
 * does not answer. (A socket would tell of the manager that made it.) */
void dx_doctor_find_running(struct dx_doctor *d, const char *socket)
{
    struct dx_doctor_user *user = &d->running;
    char path[PATH_MAX], status[4096], line[64];
    struct stat st;

    if (*d->pid) {
        snprintf(path, sizeof(path), "/proc/%s/status", d->pid);
        if (!dx_doctor_read(d, path, status, sizeof(status)) ||
            !dx_doctor_line(status, "Uid:", line, sizeof(line)))
            return;
        user->uid = (uid_t)strtoul(line, NULL, 10);
    } else {
        snprintf(path, sizeof(path), "%.300s.lock", socket);
        if (!dx_doctor_stat(d, path, &st))
            return;
        user->uid = st.st_uid;
    }
    user->known = true;
    snprintf(user->name, sizeof(user->name), "%u", (unsigned)user->uid);
    if (find_user(d, user, NULL) && find_user(d, user, user->name))
        add_listed_groups(d, user);
}

const struct dx_doctor_user *dx_doctor_runs_as(const struct dx_doctor *d)
{
    if (d->running.known && !(d->service.known && d->running.uid == d->service.uid))
        return &d->running;
    return d->service.known ? &d->service : &d->me;
}

void dx_doctor_find_users(struct dx_doctor *d)
{
    find_me(d);
    find_service(d);
    dx_doctor_read(d, "/sys/fs/cgroup/system.slice/dexeld.service/cgroup.procs", d->pid,
                   sizeof(d->pid));
    d->pid[strcspn(d->pid, "\n")] = 0;
}
