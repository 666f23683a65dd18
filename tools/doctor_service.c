/* The sockets, and what the service says of itself. */
#include "tools/doctor.h"

#include "tools/control_client.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#define START   "sudo systemctl start dexeld.socket dexeld-control.socket dexeld.service"
#define RESTART "sudo systemctl restart dexeld.socket dexeld-control.socket dexeld.service"
#define LOG     "journalctl -u dexeld -n 50"

static const char *mesh_path(const struct dx_doctor *d)
{
    return d->socket ? d->socket : d->has_config ? d->config.socket : "/run/dexeld/mesh.sock";
}

static const char *control_path(const struct dx_doctor *d)
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
    char mend[160];
    gid_t gid;

    if (dx_doctor_group(d, group, &gid) && st->st_gid == gid)
        snprintf(mend, sizeof(mend), "sudo adduser %s %s && newgrp %s", d->me.name, group, group);
    else
        snprintf(mend, sizeof(mend), "sudo -u '#%u' dexel status", (unsigned)st->st_uid);
    dx_doctor_tell(d, DX_DOCTOR_WARNING, mend, "%s: %s may not connect", path, d->me.name);
}

/* Whose it is to be: of a service of systemd; one that was started by hand is its user's. */
static void look_at_owner(struct dx_doctor *d, const char *path, const struct stat *st,
                          const char *group)
{
    char name[64], mend[PATH_MAX];
    gid_t gid;

    if (st->st_mode & S_IWOTH) {
        snprintf(mend, sizeof(mend), "sudo chmod 0660 %.300s", path);
        dx_doctor_tell(d, DX_DOCTOR_WARNING, mend, "%s has mode %04o: everybody may connect", path,
                       st->st_mode & 07777);
    } else if (d->service.known && dx_doctor_group(d, group, &gid) && st->st_gid != gid) {
        snprintf(mend, sizeof(mend), "sudo chgrp %s %.300s", group, path);
        dx_doctor_tell(d, DX_DOCTOR_WARNING, mend, "%s is of the group %s, not of %s", path,
                       dx_doctor_group_name(d, st->st_gid, name, sizeof(name)), group);
    } else if (!dx_doctor_may_open(&d->me, st)) {
        tell_refused(d, path, st, group);
    }
}

/* False: nobody answers here. */
static bool look_at_socket(struct dx_doctor *d, const char *path, const char *group)
{
    char whole[PATH_MAX];
    struct stat st;
    int r;

    dx_doctor_path(d, whole, sizeof(whole), path);
    if (!dx_doctor_stat(d, path, &st)) {
        dx_doctor_tell(d, DX_DOCTOR_PROBLEM, START, "%s is not there: the service does not run",
                       path);
        return false;
    }
    if (!S_ISSOCK(st.st_mode)) {
        char mend[PATH_MAX];

        snprintf(mend, sizeof(mend), "sudo rm %.300s && " START, path);
        dx_doctor_tell(d, DX_DOCTOR_PROBLEM, mend, "%s is no socket", path);
        return false;
    }
    look_at_owner(d, path, &st, group);
    r = connect_once(whole);
    if (r == 0 || r == -EACCES)
        dx_doctor_find_running(d, path);
    if (r == 0)
        dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "%s: somebody answers", path);
    else if (r != -EACCES) /* that is told above */
        dx_doctor_tell(d, DX_DOCTOR_PROBLEM, RESTART, "%s: nobody answers (%s)", path,
                       strerror(-r));
    return r == 0;
}

void dx_doctor_sockets(struct dx_doctor *d)
{
    look_at_socket(d, mesh_path(d), "dexel");
    look_at_socket(d, control_path(d), "dexel-admin");
}

/* ---- its own words ----------------------------------------------------------------------------
 */

static void look_at_state(struct dx_doctor *d, const char *name, const char *state,
                          const char *reason)
{
    if (!strcmp(state, "faulted") || !strcmp(state, "gone"))
        dx_doctor_tell(d, DX_DOCTOR_PROBLEM, !strcmp(state, "gone") ? "dexel devices" : LOG,
                       "%s is %s: %s", name, state, reason ? reason : "");
    else if (!strcmp(state, "stalled") || (reason && *reason))
        dx_doctor_tell(d, DX_DOCTOR_WARNING, LOG, "%s is %s: %s", name, state,
                       reason ? reason : "");
    else
        dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "%s is %s", name, state);
}

static void look_at_stream(struct dx_doctor *d, const json_t *stream)
{
    const char *name = json_string_value(json_object_get(stream, "name"));
    const char *state = json_string_value(json_object_get(stream, "state"));
    const json_t *device = json_object_get(stream, "device");
    const char *trouble = json_string_value(json_object_get(device, "trouble"));
    const char *recording =
        json_string_value(json_object_get(json_object_get(stream, "recording"), "error_text"));

    if (!name || !state)
        return;
    if (!strcmp(state, "live") || !dx_doctor_is_missing(d, name)) /* one fault is told once */
        look_at_state(d, name, state, json_string_value(json_object_get(stream, "reason")));
    if (trouble && *trouble)
        dx_doctor_tell(d, DX_DOCTOR_WARNING, LOG, "%s: %s", name, trouble);
    if (recording)
        dx_doctor_tell(d, DX_DOCTOR_PROBLEM, "dexel status", "%s is not recorded: %s", name,
                       recording);
}

static void look_at_status(struct dx_doctor *d, const json_t *status)
{
    const char *version = json_string_value(json_object_get(status, "version"));
    const json_t *streams = json_object_get(status, "streams");

    if (!version || strcmp(version, DEXELD_VERSION))
        dx_doctor_tell(d, DX_DOCTOR_WARNING, "sudo systemctl restart dexeld",
                       "the service is of version %s, these tools are of " DEXELD_VERSION,
                       version ? version : "unknown");
    else
        dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "the service answers, version %s", version);
    for (size_t k = 0; k < json_array_size(streams); k++)
        look_at_stream(d, json_array_get(streams, k));
}

void dx_doctor_service(struct dx_doctor *d)
{
    char whole[PATH_MAX], *reply;
    struct dx_err err;
    json_t *status;
    int r;

    dx_doctor_path(d, whole, sizeof(whole), control_path(d));
    r = connect_once(whole);
    if (r < 0) /* told of the sockets */
        return;
    if (dx_control_ask(&reply, whole, "{\"request\":\"status\"}", &err) < 0) {
        dx_doctor_tell(d, DX_DOCTOR_PROBLEM, "sudo systemctl restart dexeld", "%s", err.text);
        return;
    }
    status = json_loads(reply, 0, NULL);
    look_at_status(d, status);
    json_decref(status);
    free(reply);
}
