/* The configuration, as `dexeld --check` reads it, and whether what its streams name is there. */
#include "tools/doctor.h"

#include <stdio.h>
#include <string.h>

static const char *find_config(struct dx_doctor *d, char *path, size_t len)
{
    static const char *const places[] = {"/etc/dexeld/dexeld.yaml",
                                         "/usr/local/etc/dexeld/dexeld.yaml"};
    struct stat st;

    if (d->config_path)
        return d->config_path;
    for (size_t k = 0; k < sizeof(places) / sizeof(places[0]); k++)
        if (dx_doctor_stat(d, places[k], &st)) {
            snprintf(path, len, "%s", places[k]);
            return path;
        }
    return NULL;
}

void dx_doctor_config(struct dx_doctor *d)
{
    char found[64], whole[PATH_MAX], mend[PATH_MAX];
    const char *path = find_config(d, found, sizeof(found));
    struct dx_err err;

    if (!path) {
        dx_doctor_tell(
            d, DX_DOCTOR_WARNING,
            "sudo apt-get install --reinstall -o Dpkg::Options::=--force-confmiss dexeld",
            "there is no /etc/dexeld/dexeld.yaml");
        return;
    }
    dx_doctor_path(d, whole, sizeof(whole), path);
    if (dx_config_load(&d->config, whole, &err) < 0) {
        snprintf(mend, sizeof(mend), "sudoedit %.300s && dexeld -c %.300s --check", path, path);
        dx_doctor_tell(d, DX_DOCTOR_PROBLEM, mend, "%s", err.text);
        return;
    }
    d->has_config = true;
    dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "%s: %u streams", path, d->config.n_streams);
}

unsigned dx_doctor_n_streams(const struct dx_doctor *d, const char *driver)
{
    unsigned n = 0;

    for (uint32_t k = 0; k < d->config.n_streams; k++)
        n += !strcmp(d->config.streams[k].driver, driver);
    return n;
}

static const struct dx_encoder_config *encoder_of(const struct dx_stream_config *s)
{
    return strcmp(s->driver, "hokuyo") ? NULL : &s->source.hokuyo.stage.angle.encoder;
}

bool dx_doctor_wants_gpio(const struct dx_doctor *d)
{
    for (uint32_t k = 0; k < d->config.n_streams; k++) {
        const struct dx_stream_config *s = &d->config.streams[k];
        const struct dx_encoder_config *e = encoder_of(s);

        if (dx_rig_is_wanted(&s->gpio) || (e && e->a && *e->a))
            return true;
    }
    return false;
}

/* ---- what streams name ------------------------------------------------------------------------
 */

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

/* A camera: the node of that path, or any; serials and ports are left to the service's log. */
static bool has_camera(const struct dx_doctor *d, const struct dx_v4l2_config *c)
{
    struct stat st;
    glob_t g;
    size_t n;

    if (*c->path)
        return dx_doctor_stat(d, c->path, &st);
    n = dx_doctor_glob(d, "/sys/class/video4linux/video*", &g);
    globfree(&g);
    return n > 0;
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

/* Whether it is there; `what` is what was looked for. */
static bool is_there(const struct dx_doctor *d, const struct dx_stream_config *s,
                     char what[WHAT_LEN])
{
    const struct dx_v4l2_config *v = &s->source.v4l2;
    const struct dx_kinect_config *n = &s->source.kinect;
    const struct dx_hokuyo_config *h = &s->source.hokuyo;
    struct stat st;

    if (!strcmp(s->driver, "v4l2")) {
        snprintf(what, WHAT_LEN, "%s", *v->path ? v->path : "a camera");
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
    if (strcmp(s->driver, "hokuyo") || *h->tcp)
        return true; /* simulated, or on the network: its state tells */
    if (*h->tty) {
        snprintf(what, WHAT_LEN, "%s", h->tty);
        return dx_doctor_stat(d, h->tty, &st);
    }
    describe_usb(what, "a Hokuyo scanner on USB", h->serial, h->port);
    return has_usb(d, "hokuyo", h->serial, h->port);
}

void dx_doctor_streams(struct dx_doctor *d)
{
    for (uint32_t k = 0; k < d->config.n_streams; k++) {
        const struct dx_stream_config *s = &d->config.streams[k];
        char what[WHAT_LEN];

        d->is_missing[k] = !is_there(d, s, what);
        if (d->is_missing[k])
            dx_doctor_tell(d, DX_DOCTOR_PROBLEM, strcmp(s->driver, "file") ? "dexel devices" : NULL,
                           "%s: %s is not there", s->name, what);
        else
            dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "%s: what it reads (%s) is there", s->name,
                           s->driver);
    }
}

bool dx_doctor_is_missing(const struct dx_doctor *d, const char *stream)
{
    for (uint32_t k = 0; k < d->config.n_streams; k++)
        if (d->is_missing[k] && !strcmp(d->config.streams[k].name, stream))
            return true;
    return false;
}
