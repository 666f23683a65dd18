/*
 * What no single key can tell: values that do not go with each other. Errors point at the value, or
 * at the map that would hold it when the file leaves the key out.
 */
#include "daemon/config_parse.h"

#include "daemon/record_files.h"
#include "drivers/driver.h"
#include "drivers/file/recording.h"
#include "drivers/usb/usb_port.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

struct check {
    const struct dx_config *config;
    const struct dx_config_marks *marks;
    const char *file;
    struct dx_err *err;
};

/* Of a key that the file leaves out, the mark of the map that it would be in; at last of the
 * stream.
 */
static struct dx_config_mark mark_of(const struct check *c, uint32_t place, const char *key)
{
    const struct dx_config_key *row = dx_config_key_find(key);
    struct dx_config_mark mark = {0, 0};
    char map[80];
    char *dot;

    if (row)
        mark = c->marks->of[place][row - dx_config_keys];
    snprintf(map, sizeof(map), "%s", key);
    dot = strrchr(map, '.');
    if (mark.line || !dot)
        return mark.line ? mark : c->marks->stream[place];
    *dot = 0;
    return mark_of(c, place, map);
}

static bool is_in_file(const struct check *c, uint32_t n, const char *key)
{
    char row[80];

    snprintf(row, sizeof(row), "streams[].%s", key);
    return c->marks->of[n + 1][dx_config_key_find(row) - dx_config_keys].line > 0;
}

/* Fails at a key of stream `n`; `key` is its path below the stream. */
static int fail_stream(const struct check *c, uint32_t n, const char *key, const char *text)
{
    char row[96], path[96];

    snprintf(row, sizeof(row), "streams[].%s", key);
    snprintf(path, sizeof(path), "streams[%u].%s", n, key);
    return dx_config_fail(c->err, c->file, mark_of(c, n + 1, row), path, "%s", text);
}

static int check_name(const struct check *c, uint32_t n)
{
    char text[128];

    for (uint32_t i = 0; i < n; i++) {
        if (strcmp(c->config->streams[i].name, c->config->streams[n].name))
            continue;
        snprintf(text, sizeof(text), "found '%s', already the name of streams[%u] (line %u)",
                 c->config->streams[n].name, i, c->config->streams[i].line);
        return fail_stream(c, n, "name", text);
    }
    return 0;
}

static int check_exact(const struct check *c, uint32_t n)
{
    const struct dx_stream_config *s = &c->config->streams[n];
    const char *why = dx_terrain_params_check_exact(&s->mesh);

    if (strcmp(s->driver, "file") || !s->source.file.exact)
        return 0;
    if (s->source.file.thin.keep == DX_KEEP_MEAN)
        why = DX_EXACT_NO_MEAN;
    return why ? fail_stream(c, n, "file.exact", why) : 0;
}

/* A map without the line that it is about does nothing, which nobody writes who knows it: an
 * interlock that a template left empty would be none. Recordings of before `none` have empty ones.
 */
static int check_has_line(const struct check *c, uint32_t n, const char *map, const char *line,
                          const char *value)
{
    char key[64], text[64];

    snprintf(key, sizeof(key), "%s.%s", map, line);
    if (!is_in_file(c, n, map))
        return 0;
    if (is_in_file(c, n, key) && (*value || !strcmp(c->file, DX_RECORDING_CONFIG_NAME)))
        return 0;
    snprintf(text, sizeof(text), "found no %s, expected one, or none", line);
    return fail_stream(c, n, map, text);
}

static int check_port(const struct check *c, uint32_t n, const char *key, const char *port)
{
    char text[128];

    if (!*port || dx_usb_is_port(port))
        return 0;
    snprintf(text, sizeof(text), "found '%.40s', expected a USB port, as 1-2.3", port);
    return fail_stream(c, n, key, text);
}

static int check_kinect(const struct check *c, uint32_t n)
{
    const struct dx_stream_config *s = &c->config->streams[n];

    return strcmp(s->driver, "kinect") ? 0 : check_port(c, n, "kinect.port", s->source.kinect.port);
}

/* Where the image's size is the camera's affair, it is checked when that is there. */
static int check_lens(const struct check *c, uint32_t n)
{
    static const char *const keys[] = {"v4l2.k1", "v4l2.k2", "v4l2.p1", "v4l2.p2", "v4l2.k3"};
    const struct dx_v4l2_config *v = &c->config->streams[n].source.v4l2;
    struct dx_err why = {""};
    size_t k = 0;

    if (!v->width || !dx_lens_check(&v->lens, v->height, v->width, &why))
        return 0;
    while (k + 1 < sizeof(keys) / sizeof(keys[0]) && !is_in_file(c, n, keys[k]))
        k++;
    return fail_stream(c, n, keys[k], why.text);
}

static int check_v4l2(const struct check *c, uint32_t n)
{
    const struct dx_v4l2_config *v = &c->config->streams[n].source.v4l2;
    int r = check_port(c, n, "v4l2.port", v->port);

    if (r)
        return r;
    if (v->max_m > 0 && v->min_m >= v->max_m)
        return fail_stream(c, n, "v4l2.max_depth", "expected 0, or more than min_depth");
    if (v->disparity_given && (v->disparity[0] == 0 || v->disparity[2] != 0))
        return fail_stream(c, n, "v4l2.disparity", "expected [k, d0], k not 0");
    if (v->format == DX_V4L2_Y10B && v->width % 4)
        return fail_stream(c, n, "v4l2.size", "Y10B has columns by fours");
    return check_lens(c, n);
}

/* Is it the same text, of a device that one stream alone can have? */
static bool is_shared(const char *a, const char *b)
{
    return a && b && *a && !strcmp(a, b);
}

/* Two readers of one tty would each get half of what the scanner says. */
static int check_scanner_is_ours(const struct check *c, uint32_t n)
{
    const struct dx_hokuyo_config *h = &c->config->streams[n].source.hokuyo;

    for (uint32_t k = 0; k < n; k++) {
        const struct dx_hokuyo_config *other = &c->config->streams[k].source.hokuyo;

        if (strcmp(c->config->streams[k].driver, "hokuyo"))
            continue;
        if (is_shared(h->tty, other->tty))
            return fail_stream(c, n, "hokuyo.tty",
                               "found that of another stream, expected its own");
        if (is_shared(h->tcp, other->tcp))
            return fail_stream(c, n, "hokuyo.tcp",
                               "found that of another stream, expected its own");
    }
    return 0;
}

static int check_hokuyo(const struct check *c, uint32_t n)
{
    const struct dx_stream_config *s = &c->config->streams[n];
    const struct dx_hokuyo_config *h = &s->source.hokuyo;
    const char *why, *key = "";
    char path[64];

    if (strcmp(s->driver, "hokuyo"))
        return 0;
    if (check_port(c, n, "hokuyo.port", h->port))
        return -EINVAL;
    if (check_has_line(c, n, "hokuyo.stage.encoder", "a", h->stage.angle.encoder.a))
        return -EINVAL;
    why = dx_hokuyo_check(h, &key);
    snprintf(path, sizeof(path), "hokuyo.%s", key);
    if (why)
        return fail_stream(c, n, path, why);
    why = h->stage.exact ? dx_terrain_params_check_exact(&s->mesh) : NULL;
    return why ? fail_stream(c, n, "hokuyo.stage.exact", why) : check_scanner_is_ours(c, n);
}

static int check_has_lines(const struct check *c, uint32_t n)
{
    const struct dx_rig_config *g = &c->config->streams[n].gpio;
    const struct {
        const char *map, *line;
    } maps[] = {
        {"gpio.interlock", g->interlock.line},     {"gpio.laser", g->laser.line},
        {"gpio.trigger_in", g->trigger_in.line},   {"gpio.pps", g->pps.line},
        {"gpio.trigger_out", g->trigger_out.line}, {"gpio.led", g->led.line},
    };
    int r = 0;

    for (size_t k = 0; k < sizeof(maps) / sizeof(maps[0]) && !r; k++)
        r = check_has_line(c, n, maps[k].map, "line", maps[k].line);
    return r;
}

#define MAX_LINES (DX_RIG_N_LINES + 3)

/* The GPIO lines of a stream, first those about it, with keys below "gpio": how many. */
static size_t list_lines(const struct dx_stream_config *s, struct dx_rig_line lines[MAX_LINES])
{
    const struct dx_encoder_config *e = &s->source.hokuyo.stage.angle.encoder;
    size_t n = DX_RIG_N_LINES;

    dx_rig_list(&s->gpio, lines);
    if (!strcmp(s->driver, "hokuyo")) {
        lines[n++] = (struct dx_rig_line){"hokuyo.stage.encoder.a", e->a};
        lines[n++] = (struct dx_rig_line){"hokuyo.stage.encoder.b", e->b};
        lines[n++] = (struct dx_rig_line){"hokuyo.stage.encoder.z", e->z};
    }
    return n;
}

static bool is_among(const char *where, const struct dx_rig_line *lines, size_t n)
{
    for (size_t k = 0; k < n; k++)
        if (dx_gpio_where_same(where, lines[k].where))
            return true;
    return false;
}

/* A line has one user: in a stream one purpose, and no other stream. */
static int check_lines_are_ours(const struct check *c, uint32_t n)
{
    struct dx_rig_line mine[MAX_LINES], other[MAX_LINES];
    size_t n_mine = list_lines(&c->config->streams[n], mine), n_other;
    const char *why = NULL;
    char key[64];

    for (size_t k = 0; k < n_mine; k++) {
        if (is_among(mine[k].where, mine, k))
            why = "this line has another purpose already";
        for (uint32_t s = 0; s < n && !why; s++) {
            n_other = list_lines(&c->config->streams[s], other);
            if (is_among(mine[k].where, other, n_other))
                why = "found a line of another stream, expected its own";
        }
        snprintf(key, sizeof(key), "%s%s", k < DX_RIG_N_LINES ? "gpio." : "", mine[k].key);
        if (why)
            return fail_stream(c, n, key, why);
    }
    return 0;
}

static int check_gpio(const struct check *c, uint32_t n)
{
    const struct dx_stream_config *s = &c->config->streams[n];
    const struct dx_driver *driver = dx_driver_find(s->driver);
    const char *key = "", *why = dx_rig_check(&s->gpio, &key);
    char path[64];
    int r = check_has_lines(c, n);

    if (r)
        return r;
    if (!dx_rig_is_wanted(&s->gpio))
        return check_lines_are_ours(c, n);
    if (!driver || !driver->subsystems)
        return fail_stream(c, n, "gpio", "found lines, which need a driver of a device");
    snprintf(path, sizeof(path), "gpio.%s", key);
    return why ? fail_stream(c, n, path, why) : check_lines_are_ours(c, n);
}

static int check_record(const struct check *c, uint32_t n)
{
    const struct dx_record_config *r = &c->config->streams[n].record;
    const char *why = *r->path ? dx_record_files_check(r->path) : NULL;

    if (why)
        return fail_stream(c, n, "record.path", why);
    for (uint32_t k = 0; k < n && *r->path; k++)
        if (!strcmp(r->path, c->config->streams[k].record.path))
            return fail_stream(c, n, "record.path",
                               "found that of another stream, expected its own");
    if (r->keep_mib && (!r->split_mib || r->keep_mib / 2 < r->split_mib))
        return fail_stream(c, n, "record.keep_mib",
                           "expected at least twice split_mib, which may not be 0 then");
    return 0;
}

static int check_stream(const struct check *c, uint32_t n)
{
    const struct dx_stream_config *s = &c->config->streams[n];
    const char *mesh = dx_terrain_params_check(&s->mesh);
    char text[128];
    int r = check_name(c, n);

    if (r)
        return r;
    if (mesh)
        return fail_stream(c, n, "mesh", mesh);
    if (!strcmp(s->driver, "file") && s->source.file.thin.keep != DX_KEEP_CENTRE &&
        s->source.file.thin.width == 0) {
        snprintf(text, sizeof(text), "found %s, which needs a size",
                 dx_keep_name(s->source.file.thin.keep));
        return fail_stream(c, n, "file.keep", text);
    }
    if (!strcmp(s->driver, "file") && s->source.file.end_s > 0 &&
        s->source.file.end_s <= s->source.file.start_s)
        return fail_stream(c, n, "file.end", "expected more than file.start, or 0");
    if (s->lossless && s->source.file.rate != 0)
        return fail_stream(c, n, "file.lossless", "found yes, which needs rate: max");
    if (s->wait > c->config->max_clients) {
        snprintf(text, sizeof(text), "found %u, expected at most max_clients, which is %u", s->wait,
                 c->config->max_clients);
        return fail_stream(c, n, strcmp(s->driver, "file") ? "synthetic.wait" : "file.wait", text);
    }
    r = check_record(c, n);
    if (!r && !strcmp(s->driver, "v4l2"))
        r = check_v4l2(c, n);
    if (!r)
        r = check_kinect(c, n);
    if (!r)
        r = check_hokuyo(c, n);
    if (!r)
        r = check_gpio(c, n);
    return r ? r : check_exact(c, n);
}

/* The service's own paths: each is another. */
static int check_paths(const struct check *c)
{
    const struct dx_config *config = c->config;
    struct dx_config_mark mark = mark_of(c, 0, "control_socket");
    const char *taken = NULL;

    if (!mark.line)
        mark = mark_of(c, 0, "socket");
    if (!strcmp(config->socket, config->control_socket))
        return dx_config_fail(c->err, c->file, mark, "control_socket",
                              "found the path of socket, expected another");
    if (!strcmp(config->metrics_file, config->socket))
        taken = "socket";
    else if (!strcmp(config->metrics_file, config->control_socket))
        taken = "control_socket";
    else if (!strcmp(config->metrics_file, c->file))
        taken = "this file";
    return taken ? dx_config_fail(c->err, c->file, mark_of(c, 0, "metrics_file"), "metrics_file",
                                  "found the path of %s, expected another", taken)
                 : 0;
}

int dx_config_check(const struct dx_config *config, const struct dx_config_marks *marks,
                    const char *file, struct dx_err *err)
{
    struct check c = {config, marks, file, err};
    int r = check_paths(&c);

    for (uint32_t n = 0; n < config->n_streams && !r; n++)
        r = check_stream(&c, n);
    return r;
}
