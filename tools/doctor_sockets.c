/* The sockets: are they there, whose are they, does somebody answer? */
#include "tools/doctor.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#define START   "sudo systemctl start dexeld.socket dexeld-control.socket dexeld.service"
#define RESTART "sudo systemctl restart dexeld.socket dexeld-control.socket dexeld.service"

static const char *mesh_path(const struct dx_doctor *d)
{
    return d->socket ? d->socket : d->has_config ? d->config.socket : "/run/dexeld/mesh.sock";
}

const char *dx_doctor_control_path(const struct dx_doctor *d)
{
    return d->control      ? d->control
           : d->has_config ? d->config.control_socket
                           : "/run/dexeld/control.sock";
}

/* 0, or why nobody answers: -errno. */
static int connect_once(const char *path)
{
    struct sockaddr_un addr = {.sun_family = AF_UNIX};
    int fd, r;

    if (strlen(path) >= sizeof(addr.sun_path))
        return -ENAMETOOLONG;
    memcpy(addr.sun_path, path, strlen(path));
    fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd < 0)
        return -errno;
    r = connect(fd, (struct sockaddr *)&addr, sizeof(addr)) == 0 ? 0 : -errno;
    close(fd);
    return r == -EAGAIN ? 0 : r; /* its queue is full: it is there */
}

/* The service's group, where the socket is of it; else who started the service by hand may. */
static void tell_refused(struct dx_doctor *d, const char *path, const struct stat *st,
                         const char *group)
{
    const char *mend;
    char owner[16];
    gid_t gid;

    snprintf(owner, sizeof(owner), "#%u", (unsigned)st->st_uid);
    if (dx_doctor_group(d, group, &gid) && st->st_gid == gid)
        mend = dx_doctor_command(d, "sudo adduser @ @ && newgrp @", d->me.name, group, group);
    else
        mend = dx_doctor_ask_command(d, "sudo -u @ dexel status", owner);
    dx_doctor_tell(d, DX_DOCTOR_WARNING, mend, "%s: %s may not connect", path, d->me.name);
}

/* Whose it is to be: of a service of systemd; one that was started by hand is its user's. */
static void look_at_owner(struct dx_doctor *d, const char *path, const struct stat *st,
                          const char *group)
{
    char name[64];
    gid_t gid;

    if (st->st_mode & S_IWOTH) {
        dx_doctor_tell(d, DX_DOCTOR_WARNING, dx_doctor_command(d, "sudo chmod 0660 @", path),
                       "%s has mode %04o: everybody may connect", path, st->st_mode & 07777);
    } else if (d->service.known && dx_doctor_group(d, group, &gid) && st->st_gid != gid) {
        dx_doctor_tell(d, DX_DOCTOR_WARNING, dx_doctor_command(d, "sudo chgrp @ @", group, path),
                       "%s is of the group %s, not of %s", path,
                       dx_doctor_group_name(d, st->st_gid, name, sizeof(name)), group);
    } else if (!dx_doctor_may_open(&d->me, st)) {
        tell_refused(d, path, st, group);
    }
}

/* Was it named by whoever asks? Then it need not be the service's at all. */
static bool is_named(const struct dx_doctor *d, const char *path)
{
    return path == d->socket || path == d->control;
}

/* The same look at the sockets of the configuration. */
static const char *look_again(struct dx_doctor *d)
{
    const char *without = d->is_control_of_env ? "env -u DEXELD_CONTROL " : "";
    char pattern[64];

    snprintf(pattern, sizeof(pattern), "%sdexel doctor%s", without,
             d->config_path ? " --config @" : "");
    return dx_doctor_command(d, pattern, d->config_path);
}

static const char *kind_of(const struct stat *st)
{
    return S_ISREG(st->st_mode) ? "a file" : S_ISDIR(st->st_mode) ? "a folder" : "something else";
}

const char *dx_doctor_restart_command(struct dx_doctor *d, const char *path)
{
    return is_named(d, path) ? look_again(d) : RESTART;
}

/* Nothing is to be removed but what lies in the service's own folder. */
static void tell_no_socket(struct dx_doctor *d, const char *path, const struct stat *st)
{
    static const char own[] = "/run/dexeld/";
    const char *mend;

    if (is_named(d, path)) {
        dx_doctor_tell(d, DX_DOCTOR_PROBLEM, look_again(d),
                       "%s is %s, and no socket of a service; without its name those of the "
                       "configuration are looked at",
                       path, kind_of(st));
        return;
    }
    if (strncmp(path, own, strlen(own)) || strchr(path + strlen(own), '/'))
        mend = dx_doctor_edit_command(d);
    else if (S_ISDIR(st->st_mode))
        mend = dx_doctor_command(d, "sudo rmdir @ && " START, path);
    else
        mend = dx_doctor_command(d, "sudo rm @ && " START, path);
    dx_doctor_tell(d, DX_DOCTOR_PROBLEM, mend, "%s is no socket, but %s", path, kind_of(st));
}

/* False: nobody answers here. */
static bool look_at_socket(struct dx_doctor *d, const char *path, const char *group)
{
    char whole[PATH_MAX];
    struct stat st;
    int r;

    if (!dx_doctor_stat(d, path, &st)) {
        dx_doctor_tell(d, DX_DOCTOR_PROBLEM, is_named(d, path) ? look_again(d) : START,
                       "%s is not there: the service does not run%s", path,
                       is_named(d, path) ? ", or listens elsewhere" : "");
        return false;
    }
    if (!S_ISSOCK(st.st_mode)) {
        tell_no_socket(d, path, &st);
        return false;
    }
    look_at_owner(d, path, &st, group);
    dx_doctor_path(d, whole, sizeof(whole), path);
    r = connect_once(whole);
    if (r == 0 || r == -EACCES)
        dx_doctor_find_running(d, path);
    if (r == 0)
        dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "%s: somebody answers", path);
    else if (r != -EACCES) /* that is told above */
        dx_doctor_tell(d, DX_DOCTOR_PROBLEM, dx_doctor_restart_command(d, path),
                       "%s: nobody answers (%s)", path, strerror(-r));
    return r == 0;
}

/* Does a configuration that cannot be read tell where they are, and nothing else? */
static bool are_unknown(const struct dx_doctor *d)
{
    struct stat st;

    return d->config_path && !d->has_config && !d->socket && !d->control &&
           !dx_doctor_stat(d, mesh_path(d), &st);
}

void dx_doctor_sockets(struct dx_doctor *d)
{
    if (are_unknown(d)) {
        dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "the sockets were not looked at");
        return;
    }
    look_at_socket(d, mesh_path(d), "dexel");
    d->answers = look_at_socket(d, dx_doctor_control_path(d), "dexel-admin");
}
