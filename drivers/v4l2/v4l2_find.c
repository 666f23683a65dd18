/* Looking through the nodes of video4linux. */
#include "drivers/v4l2/v4l2_find.h"

#include "drivers/v4l2/v4l2_capture.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

/* ---- one of them --------------------------------------------------------------------------------
 */

struct search {
    const struct dx_v4l2_config *config;
    struct dx_udev_device *out;
    unsigned n_nodes, n_chosen, n_taken; /* seen; that the keys agree with; with the format too */
    char other[80];                      /* a second one, where no key says which */
    int refused;                         /* why a chosen node could not be looked at */
    char refused_node[80];
};

static bool agrees(const struct dx_v4l2_config *c, const struct dx_udev_device *d)
{
    return (!*c->serial || !strcmp(c->serial, d->serial)) &&
           (!*c->port || !strcmp(c->port, d->port)) && (!*c->path || dx_udev_is(d, "", c->path));
}

/* Whether a node captures in a format of depth, and which. Negative: it does not say. */
static int look(const char *node, enum dx_v4l2_format *format)
{
    struct dx_v4l2_capture c;
    int r = dx_v4l2_capture_open(&c, node, NULL);

    if (r)
        return r < 0 ? r : -ENODEV;
    r = dx_v4l2_capture_has(&c, format, NULL);
    dx_v4l2_capture_close(&c);
    return r <= 0 ? r : -ENODEV;
}

static bool consider(void *ctx, const struct dx_udev_device *d)
{
    struct search *s = ctx;
    const struct dx_v4l2_config *c = s->config;
    enum dx_v4l2_format format = c->format;
    int r;

    s->n_nodes++;
    if (!agrees(c, d))
        return true;
    s->n_chosen++;
    r = look(d->node, &format);
    if (r == -EACCES || r == -EPERM) {
        s->refused = r;
        snprintf(s->refused_node, sizeof(s->refused_node), "%s", d->node);
    }
    if (r)
        return true;
    if (s->n_taken++ == 0) {
        *s->out = *d;
        return !*c->path && !*c->serial && !*c->port; /* is there another? */
    }
    snprintf(s->other, sizeof(s->other), "%s", d->node);
    return false;
}

/* "serial 'X', port '1-2'" */
static void say_keys(char text[256], const struct dx_v4l2_config *c)
{
    const char *const key[3][2] = {{"serial", c->serial}, {"port", c->port}, {"path", c->path}};
    size_t len = 0;

    *text = 0;
    for (int k = 0; k < 3; k++)
        if (*key[k][1])
            len += (size_t)snprintf(text + len, 256 - len, "%s%s '%.60s'", len ? ", " : "",
                                    key[k][0], key[k][1]);
}

static int not_found(const struct search *s, struct dx_err *err)
{
    const char *format = s->config->format ? dx_v4l2_format_name(s->config->format) : "Z16 or INZI";
    char keys[256];

    say_keys(keys, s->config);
    if (s->refused)
        return dx_udev_refused(err, s->refused, s->refused_node);
    if (*keys && s->n_chosen)
        return dx_err_set(err, -EINVAL, "v4l2: the camera of %s has no format %s", keys, format);
    if (*keys)
        return dx_err_set(err, DX_DRIVER_E_GONE,
                          "v4l2: no camera of %s among %u video nodes attached", keys, s->n_nodes);
    return dx_err_set(err, DX_DRIVER_E_GONE, "v4l2: no camera with %s among %u video nodes", format,
                      s->n_nodes);
}

int dx_v4l2_find(struct dx_udev_device *out, const struct dx_v4l2_config *config,
                 struct dx_err *err)
{
    struct search s = {.config = config, .out = out};
    int r = dx_udev_each("video4linux", consider, &s, err);

    if (r)
        return r;
    if (s.n_taken == 0)
        return not_found(&s, err);
    if (*s.other)
        return dx_err_set(err, -EINVAL,
                          "v4l2: more than one depth camera (%s, %s): say which by serial, port "
                          "or path",
                          out->node, s.other);
    return 0;
}

/* ---- all of them --------------------------------------------------------------------------------
 */

struct probe {
    void (*found)(void *ctx, const struct dx_device_found *device);
    void *ctx;
};

/* What of a serial the configuration takes. */
static bool is_plain(const char *text)
{
    for (const char *p = text; *p; p++)
        if (!strchr("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-", *p))
            return false;
    return *text;
}

static void tell(const struct probe *p, const struct dx_udev_device *d, enum dx_v4l2_format format,
                 int access)
{
    const char *format_name = dx_v4l2_format_name(format);
    bool is_depth = format == DX_V4L2_Z16 || format == DX_V4L2_INZI;
    char name[192], yaml[256];
    int len;

    if (access)
        snprintf(name, sizeof(name), "%s, perhaps depth", d->name);
    else
        snprintf(name, sizeof(name), "%s, %s", d->name, format_name);
    if (is_plain(d->serial))
        len = snprintf(yaml, sizeof(yaml), "serial: \"%s\"", d->serial);
    else if (*d->port)
        len = snprintf(yaml, sizeof(yaml), "port: \"%s\"", d->port);
    else
        len = snprintf(yaml, sizeof(yaml), "path: \"%s\"", d->place);
    if (!access && !is_depth)
        len += snprintf(yaml + len, sizeof(yaml) - (size_t)len, "\nformat: %s", format_name);
    snprintf(yaml + len, sizeof(yaml) - (size_t)len, "\n#fx: 425 # pixels: see config/sensors");
    p->found(p->ctx, &(struct dx_device_found){.name = name,
                                               .node = d->node,
                                               .serial = d->serial,
                                               .place = d->place,
                                               .yaml = yaml,
                                               .access = access});
}

/* The first node of what may not be opened is told: nobody knows what it has. */
static bool is_first(const struct dx_udev_device *d)
{
    char index[8];

    dx_udev_attribute(d, "index", index, sizeof(index));
    return !strcmp(index, "0") || !*index;
}

/* Any format that can be depth, the surest first. 0, or why there is none. */
static int look_for_any(const char *node, enum dx_v4l2_format *format)
{
    struct dx_v4l2_capture c;
    int r = dx_v4l2_capture_open(&c, node, NULL);

    if (r)
        return r < 0 ? r : -ENODEV;
    r = -ENOTSUP;
    for (*format = DX_V4L2_Z16; *format < DX_V4L2_N_FORMATS; ++*format) {
        r = dx_v4l2_capture_has(&c, format, NULL);
        if (r != -ENOTSUP)
            break;
    }
    dx_v4l2_capture_close(&c);
    return r <= 0 ? r : -ENODEV;
}

static bool probe_one(void *ctx, const struct dx_udev_device *d)
{
    enum dx_v4l2_format format = DX_V4L2_AUTO;
    int r = look_for_any(d->node, &format);

    if (r == 0)
        tell(ctx, d, format, 0);
    else if ((r == -EACCES || r == -EPERM) && is_first(d))
        tell(ctx, d, DX_V4L2_AUTO, r);
    return true;
}

int dx_v4l2_probe(void (*found)(void *ctx, const struct dx_device_found *device), void *ctx,
                  struct dx_err *err)
{
    struct probe p = {found, ctx};

    return dx_udev_each("video4linux", probe_one, &p, err);
}
