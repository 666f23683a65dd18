/* Groups: who may subscribe and operate, and what the service's user must be in. */
#include "tools/doctor.h"

#include <stdio.h>
#include <string.h>

/* The command that makes users and groups. */
static const char *make_users(const struct dx_doctor *d, const char *by_hand)
{
    struct stat st;

    return dx_doctor_stat(d, "/usr/lib/sysusers.d/dexeld.conf", &st) ||
                   dx_doctor_stat(d, "/usr/local/lib/sysusers.d/dexeld.conf", &st)
               ? "sudo systemd-sysusers"
               : by_hand;
}

/* Whether the user who asks is in a group, in this session as well. */
static void look_at_mine(struct dx_doctor *d, const char *group, const char *what)
{
    const struct dx_doctor_user *me = &d->me;
    gid_t gid;

    if (!dx_doctor_group(d, group, &gid)) {
        dx_doctor_tell(d, DX_DOCTOR_WARNING,
                       make_users(d, dx_doctor_command(d, "sudo groupadd --system @", group)),
                       "there is no group %s: root and the service alone may %s", group, what);
    } else if (me->uid == 0) {
        dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "there is a group %s; root may %s in any case", group,
                       what);
    } else if (dx_doctor_has_gid(me, gid)) {
        dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "%s is in %s, and may %s", me->name, group, what);
    } else if (dx_doctor_is_listed(d, me, group)) {
        dx_doctor_tell(d, DX_DOCTOR_WARNING, dx_doctor_command(d, "newgrp @", group),
                       "%s is in %s, but not yet in this session: log in again, or", me->name,
                       group);
    } else {
        dx_doctor_tell(d, DX_DOCTOR_WARNING,
                       dx_doctor_command(d, "sudo adduser @ @", me->name, group),
                       "%s is not in %s, and may not %s", me->name, group, what);
    }
}

/* The running service has the groups of when it was started. */
static bool is_running_with(const struct dx_doctor *d, gid_t gid)
{
    char path[64], status[4096], line[1024], number[16], *rest;

    snprintf(path, sizeof(path), "/proc/%s/status", d->pid);
    if (!*d->pid || !dx_doctor_read(d, path, status, sizeof(status)) ||
        !dx_doctor_line(status, "Groups:", line, sizeof(line)))
        return true;
    snprintf(number, sizeof(number), "%u", (unsigned)gid);
    for (char *word = strtok_r(line, " ", &rest); word; word = strtok_r(NULL, " ", &rest))
        if (!strcmp(word, number))
            return true;
    if (dx_doctor_line(status, "Gid:", line, sizeof(line)))
        return !strncmp(line, number, strlen(number)) && strcspn(line, " \t") == strlen(number);
    return false;
}

static void look_at_service(struct dx_doctor *d)
{
    static const char *const groups[] = {"dexel", "video", "dialout"};
    unsigned n_bad = 0;

    for (size_t k = 0; k < sizeof(groups) / sizeof(groups[0]); k++) {
        gid_t gid;

        if (!dx_doctor_group(d, groups[k], &gid))
            continue; /* told above, or a machine without it */
        if (!dx_doctor_has_gid(&d->service, gid)) {
            dx_doctor_tell(d, DX_DOCTOR_WARNING,
                           dx_doctor_command(d, "sudo adduser @ @", d->service.name, groups[k]),
                           "the service's user %s is not in %s", d->service.name, groups[k]);
        } else if (!is_running_with(d, gid)) {
            dx_doctor_tell(d, DX_DOCTOR_WARNING, "sudo systemctl restart dexeld",
                           "the service's user %s is in %s, but was not when it was started",
                           d->service.name, groups[k]);
        } else {
            continue;
        }
        n_bad++;
    }
    if (!n_bad)
        dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "the service's user %s has its groups",
                       d->service.name);
}

void dx_doctor_groups(struct dx_doctor *d)
{
    look_at_mine(d, "dexel", "subscribe");
    look_at_mine(d, "dexel-admin", "operate");
    if (d->service.known)
        look_at_service(d);
    else
        dx_doctor_tell(d, DX_DOCTOR_WARNING,
                       make_users(d, "sudo adduser --system --group --no-create-home dexeld"),
                       "there is no user dexeld for the service");
}
