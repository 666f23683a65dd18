/* Whether what the streams of the configuration name is there. */
#include "tools/doctor.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_USB 32

static bool is_asked(const char *asked, const char *has)
{
    return !asked || !*asked || !strcmp(asked, has);
}

/* The USB device of that driver, serial and port. A scanner tells its serial only when it is asked:
 * one without a serial may be it. */
static bool has_usb(const struct dx_doctor *d, const char *driver, const char *serial,
                    const char *port)
{
    struct dx_doctor_usb usb[MAX_USB];
    unsigned n = dx_doctor_usb_devices(d, driver, usb, MAX_USB);

    for (unsigned k = 0; k < n; k++)
        if (is_asked(port, usb[k].port) && (!*usb[k].serial || is_asked(serial, usb[k].serial)))
            return true;
    return false;
}

/* Is the camera of this folder on that port, with that serial number? Above its interface is the
 * USB device, whose folder has the port's name. */
static bool is_camera(const struct dx_doctor *d, const char *folder, const struct dx_v4l2_config *c)
{
    char usb[PATH_MAX], whole[PATH_MAX], serial[128], *real;
    bool is_it;

    if (!*c->serial && !*c->port)
        return true;
    snprintf(usb, sizeof(usb), "%.300s/device/..", folder);
    dx_doctor_read_at(d, usb, "serial", serial, sizeof(serial));
    dx_doctor_path(d, whole, sizeof(whole), usb);
    real = realpath(whole, NULL);
    is_it = real && is_asked(c->serial, serial) && is_asked(c->port, strrchr(real, '/') + 1);
    free(real);
    return is_it;
}

static bool has_camera(const struct dx_doctor *d, const struct dx_v4l2_config *c)
{
    struct stat st;
    bool has = false;
    glob_t g;

    if (*c->path)
        return dx_doctor_stat(d, c->path, &st);
    dx_doctor_glob(d, "/sys/class/video4linux/video*", &g);
    for (size_t k = 0; k < g.gl_pathc && !has; k++)
        has = is_camera(d, dx_doctor_match(d, &g, k), c);
    globfree(&g);
    return has;
}

static bool has_files(const struct dx_doctor *d, const char *pattern)
{
    glob_t g;
    size_t n = dx_doctor_glob(d, pattern, &g);

    globfree(&g);
    return n > 0;
}

#define WHAT_LEN 256

/* Its name, and what it was chosen by. */
static void describe_usb(char what[WHAT_LEN], const char *name, const char *serial,
                         const char *port)
{
    if (*serial && *port)
        snprintf(what, WHAT_LEN, "%s (serial %.64s, port %.64s)", name, serial, port);
    else if (*serial || *port)
        snprintf(what, WHAT_LEN, "%s (%s %.64s)", name, *serial ? "serial" : "port",
                 *serial ? serial : port);
    else
        snprintf(what, WHAT_LEN, "%s", name);
}

/* Its address, where files of this machine do not tell what is there: on the network, or a place
 * of a camera that is no node. NULL: they do. */
static const char *far_of(const struct dx_stream_config *s)
{
    if (!strcmp(s->driver, "hokuyo") && *s->source.hokuyo.tcp)
        return s->source.hokuyo.tcp;
    if (!strcmp(s->driver, "v4l2") && *s->source.v4l2.path && *s->source.v4l2.path != '/')
        return s->source.v4l2.path;
    return NULL;
}

/* Whether it is there; `what` is what was looked for. */
static bool is_there(const struct dx_doctor *d, const struct dx_stream_config *s,
                     char what[WHAT_LEN])
{
    const struct dx_v4l2_config *v = &s->source.v4l2;
    const struct dx_kinect_config *n = &s->source.kinect;
    const struct dx_hokuyo_config *h = &s->source.hokuyo;
    struct stat st;

    if (!strcmp(s->driver, "v4l2")) {
        describe_usb(what, *v->path ? v->path : "a camera", v->serial, v->port);
        return has_camera(d, v);
    }
    if (!strcmp(s->driver, "kinect")) {
        describe_usb(what, "a Kinect camera", n->serial, n->port);
        return has_usb(d, "kinect", n->serial, n->port);
    }
    if (!strcmp(s->driver, "file")) {
        snprintf(what, WHAT_LEN, "%s", s->source.file.path);
        return has_files(d, s->source.file.path);
    }
    if (strcmp(s->driver, "hokuyo"))
        return true; /* simulated */
    if (*h->tty) {
        snprintf(what, WHAT_LEN, "%s", h->tty);
        return dx_doctor_stat(d, h->tty, &st);
    }
    describe_usb(what, "a Hokuyo scanner on USB", h->serial, h->port);
    return has_usb(d, "hokuyo", h->serial, h->port);
}

/* Of a file: what there is in its place, or else another place. */
static const char *make_mend(struct dx_doctor *d, const struct dx_stream_config *s)
{
    char folder[PATH_MAX];
    struct stat st;

    if (strcmp(s->driver, "file"))
        return "dexel devices";
    dx_doctor_folder(folder, sizeof(folder), s->source.file.path);
    return dx_doctor_stat(d, folder, &st) ? dx_doctor_command(d, "ls -ltr @", folder)
                                          : dx_doctor_edit_command(d);
}

void dx_doctor_streams(struct dx_doctor *d)
{
    for (uint32_t k = 0; k < d->config.n_streams; k++) {
        const struct dx_stream_config *s = &d->config.streams[k];
        const char *far = far_of(s);
        char what[WHAT_LEN];

        d->is_missing[k] = !far && !is_there(d, s, what);
        if (far)
            dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "%s: %s (%s) was not looked at", s->name, far,
                           s->driver);
        else if (d->is_missing[k])
            dx_doctor_tell(d, DX_DOCTOR_PROBLEM, make_mend(d, s), "%s: %s is not there", s->name,
                           what);
        else
            dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "%s: what it reads (%s) is there", s->name,
                           s->driver);
    }
}

bool dx_doctor_is_missing(const struct dx_doctor *d, const char *stream)
{
    const struct dx_stream_config *s = dx_doctor_stream(d, stream);

    return s && d->is_missing[s - d->config.streams];
}
