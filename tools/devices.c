/* Attached devices, printed. */
#include "tools/devices.h"

#include <errno.h>
#include <jansson.h>
#include <string.h>

struct list {
    FILE *out;
    const char *driver; /* that is asked */
    const char *stream; /* that has the device open; NULL: none that is known */
    json_t *json;       /* an array; NULL: YAML */
    unsigned n, n_of_driver;
};

static bool is_refused(const struct dx_device_found *d)
{
    return d->access == -EACCES || d->access == -EPERM;
}

/* Each line of the driver's keys at their place in a stream. */
static void put_keys(FILE *out, const char *yaml)
{
    while (*yaml) {
        int len = (int)strcspn(yaml, "\n");

        if (len)
            fprintf(out, "      %.*s\n", len, yaml);
        yaml += len + (yaml[len] == '\n');
    }
}

/* What it is, as comments. */
static void put_head(struct list *l, const struct dx_device_found *d)
{
    if (l->n == 0)
        fputs("streams:\n", l->out);
    fprintf(l->out, "  # %s\n  # node %s, %s%s, at %s\n", d->name, d->node,
            *d->serial ? "serial " : "no serial", d->serial, d->place);
    if (l->stream)
        fprintf(l->out, "  # stream %s has it open\n", l->stream);
}

static void put_stream(struct list *l, const struct dx_device_found *d)
{
    fprintf(l->out, "  - name: %s-%u\n    %s:%s\n", l->driver, l->n_of_driver, l->driver,
            *d->yaml ? "" : " {}");
    put_keys(l->out, d->yaml);
}

static void put_yaml(struct list *l, const struct dx_device_found *d)
{
    char rule[512];

    put_head(l, d);
    if (d->access)
        fprintf(l->out, "  # %s cannot be opened: %s\n", d->node, strerror(-d->access));
    if (is_refused(d)) {
        dx_device_rule(d->node, rule, sizeof(rule));
        fprintf(l->out, "  # a udev rule grants it: %s\n", rule);
    }
    put_stream(l, d);
}

static void add_json(struct list *l, const struct dx_device_found *d)
{
    json_t *o = json_pack("{s:s,s:s,s:s,s:s,s:s,s:s,s:b}", "driver", l->driver, "name", d->name,
                          "node", d->node, "serial", d->serial, "place", d->place, "yaml", d->yaml,
                          "usable", d->access == 0);
    char rule[512];

    if (d->access)
        json_object_set_new(o, "error", json_string(strerror(-d->access)));
    if (is_refused(d)) {
        dx_device_rule(d->node, rule, sizeof(rule));
        json_object_set_new(o, "rule", json_string(rule));
    }
    json_array_append_new(l->json, o);
}

static void on_found(void *ctx, const struct dx_device_found *d)
{
    struct list *l = ctx;

    l->n_of_driver++;
    if (l->json)
        add_json(l, d);
    else
        put_yaml(l, d);
    l->n++;
}

static void put_none(FILE *out, const struct dx_driver *const *drivers)
{
    unsigned n = 0;

    fputs("# no device is attached that this build has a driver for (", out);
    for (; *drivers; drivers++)
        if ((*drivers)->probe)
            fprintf(out, "%s%s", n++ ? ", " : "", (*drivers)->name);
    fputs(n ? ")\n" : "none)\n", out);
}

int dx_devices_print(FILE *out, const struct dx_driver *const *drivers, bool json)
{
    struct list l = {.out = out, .json = json ? json_array() : NULL};
    int result = 0;

    for (const struct dx_driver *const *d = drivers; *d; d++) {
        struct dx_err err = {""};
        int r;

        if (!(*d)->probe)
            continue;
        l.driver = (*d)->name;
        l.n_of_driver = 0;
        r = (*d)->probe(on_found, &l, &err);
        if (r < 0) {
            fprintf(stderr, "dexel devices: %s: %s\n", l.driver, err.text);
            result = r;
        }
    }
    if (json) {
        json_t *o = json_pack("{s:o}", "devices", l.json);

        json_dumpf(o, out, JSON_COMPACT);
        fputc('\n', out);
        json_decref(o);
    } else if (l.n == 0) {
        put_none(out, drivers);
    }
    return result;
}

/* ---- of a service ----------------------------------------------------------------------------
 */

static const char *text(const json_t *o, const char *key)
{
    const char *s = json_string_value(json_object_get(o, key));

    return s ? s : "";
}

static void put_reply(struct list *l, const json_t *o)
{
    const char *driver = text(o, "driver"), *error = text(o, "error"), *rule = text(o, "rule");
    const struct dx_device_found d = {text(o, "name"),  text(o, "node"), text(o, "serial"),
                                      text(o, "place"), text(o, "yaml"), 0};

    if (!l->driver || strcmp(l->driver, driver) != 0)
        l->n_of_driver = 0;
    l->driver = driver;
    l->stream = json_string_value(json_object_get(o, "stream"));
    l->n_of_driver++;
    put_head(l, &d);
    if (!l->stream && *error)
        fprintf(l->out, "  # the service cannot open it: %s\n", error);
    if (!l->stream && *rule)
        fprintf(l->out, "  # a udev rule grants it: %s\n", rule);
    put_stream(l, &d);
    l->n++;
}

int dx_devices_print_reply(FILE *out, const json_t *reply)
{
    const json_t *errors = json_object_get(reply, "errors"), *o;
    struct list l = {.out = out};
    size_t k;

    json_array_foreach(json_object_get(reply, "devices"), k, o) put_reply(&l, o);
    json_array_foreach(errors, k, o)
        fprintf(stderr, "dexel devices: %s: %s\n", text(o, "driver"), text(o, "error"));
    if (l.n == 0)
        fputs("# the service finds no device that it has a driver for\n", out);
    return json_array_size(errors) ? -EIO : 0;
}
