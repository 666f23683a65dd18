/* The table of metrics over a status, as text. */
#include "daemon/metrics.h"

#include "daemon/latency.h"

#include <stdbool.h>
#include <string.h>

#define MAX_LABELS 8

/* Labels of a sample, in order; their values may be numbers. */
struct labels {
    struct {
        const char *name;
        const char *text; /* NULL: `number` */
        const json_t *number;
    } label[MAX_LABELS];
    int n;
};

struct printer {
    FILE *out;
    enum dx_metrics_format format;
};

static const struct {
    const char *name, *content_type;
} formats[DX_N_METRICS_FORMATS] = {
    {"openmetrics", "application/openmetrics-text; version=1.0.0; charset=utf-8"},
    {"prometheus", "text/plain; version=0.0.4; charset=utf-8"},
};

const char *dx_metrics_format_name(enum dx_metrics_format format)
{
    return formats[format].name;
}

const char *dx_metrics_content_type(enum dx_metrics_format format)
{
    return formats[format].content_type;
}

/* ---- members ---------------------------------------------------------------------------------
 */

/* "drops.mailbox" of an object, the path ending at `len`; NULL: it is not there. */
static const json_t *member_n(const json_t *o, const char *path, size_t len)
{
    while (o && len) {
        const char *dot = memchr(path, '.', len);
        size_t n = dot ? (size_t)(dot - path) : len;

        o = json_object_getn(o, path, n);
        path += dot ? n + 1 : n;
        len -= dot ? n + 1 : n;
    }
    return o;
}

static const json_t *member(const json_t *o, const char *path)
{
    return member_n(o, path, strlen(path));
}

/* What the last part of the path is a member of. */
static const json_t *parent(const json_t *o, const char *path)
{
    const char *dot = strrchr(path, '.');

    return dot ? member_n(o, path, (size_t)(dot - path)) : o;
}

static bool number(double *value, const json_t *v)
{
    *value = json_is_true(v) ? 1 : json_number_value(v); /* of what is no number: 0 */
    return json_is_number(v) || json_is_boolean(v);
}

/* ---- labels ----------------------------------------------------------------------------------
 */

static void add_text(struct labels *l, const char *name, const char *text)
{
    l->label[l->n].name = name;
    l->label[l->n++].text = text ? text : "";
}

static void add_member(struct labels *l, const char *name, const json_t *v)
{
    add_text(l, name, json_string_value(v));
    if (json_is_number(v)) {
        l->label[l->n - 1].text = NULL;
        l->label[l->n - 1].number = v;
    }
}

static void put_number(FILE *out, const json_t *v)
{
    if (json_is_integer(v))
        fprintf(out, "%" JSON_INTEGER_FORMAT, json_integer_value(v));
    else
        fprintf(out, "%.15g", json_real_value(v));
}

static void put_escaped(FILE *out, const char *text)
{
    for (; *text; text++)
        if (*text == '\n')
            fputs("\\n", out);
        else if (*text == '"' || *text == '\\')
            fprintf(out, "\\%c", *text);
        else
            fputc(*text, out);
}

static void put_labels(FILE *out, const struct labels *l)
{
    for (int k = 0; k < l->n; k++) {
        fprintf(out, "%c%s=\"", k ? ',' : '{', l->label[k].name);
        if (l->label[k].text)
            put_escaped(out, l->label[k].text);
        else
            put_number(out, l->label[k].number);
        fputc('"', out);
    }
    if (l->n)
        fputc('}', out);
}

/* Of all samples of a stream or a client. */
static struct labels labels_of(const struct dx_metric *m, const json_t *o)
{
    struct labels l = {.n = 0};

    if (m->of == DX_METRIC_OF_STREAMS) {
        add_member(&l, "stream", json_object_get(o, "name"));
    } else if (m->of == DX_METRIC_OF_CLIENTS) {
        add_member(&l, "client", json_object_get(o, "number"));
        add_member(&l, "pid", json_object_get(o, "pid"));
        add_member(&l, "stream", json_object_get(o, "stream"));
    }
    if (m->label)
        add_text(&l, m->label, m->value);
    return l;
}

/* ---- samples ---------------------------------------------------------------------------------
 */

static void put_sample(const struct printer *p, const struct dx_metric *m, const char *suffix,
                       const struct labels *l, double value)
{
    fprintf(p->out, "%s%s", m->name, suffix);
    put_labels(p->out, l);
    fprintf(p->out, " %.15g\n", value);
}

static void put_value(const struct printer *p, const struct dx_metric *m, const json_t *o)
{
    const struct labels l = labels_of(m, o);
    double value;

    if (number(&value, member(o, m->member)))
        put_sample(p, m, m->kind == DX_METRIC_COUNTER ? "_total" : "", &l,
                   value * (m->scale != 0 ? m->scale : 1));
}

static void put_present(const struct printer *p, const struct dx_metric *m, const json_t *o)
{
    const struct labels l = labels_of(m, o);

    if (parent(o, m->member))
        put_sample(p, m, "", &l, member(o, m->member) != NULL);
}

static void put_states(const struct printer *p, const struct dx_metric *m, const json_t *o)
{
    const char *state = json_string_value(member(o, m->member));

    for (unsigned k = 0; state && m->word(k); k++) {
        struct labels l = labels_of(m, o);

        add_text(&l, "state", m->word(k));
        put_sample(p, m, "", &l, !strcmp(state, m->word(k)));
    }
}

/* Its labels are named as the members, one of which is there at least. */
static void put_info(const struct printer *p, const struct dx_metric *m, const json_t *o)
{
    struct labels l = labels_of(m, o);
    char names[64];
    char *rest = names;
    bool any = false;

    snprintf(names, sizeof(names), "%s", m->member);
    for (char *name; (name = strsep(&rest, ",")) && l.n < MAX_LABELS;) {
        const char *dot = strrchr(name, '.');

        any |= member(o, name) != NULL;
        add_member(&l, dot ? dot + 1 : name, member(o, name));
    }
    if (any)
        put_sample(p, m, "", &l, 1);
}

static void put_histogram(const struct printer *p, const struct dx_metric *m, const json_t *o)
{
    const json_t *spread = member(o, m->member);
    const json_t *within = json_object_get(spread, "within");
    const struct labels l = labels_of(m, o);
    double n = 0;

    if (!within)
        return;
    for (int k = 0; k <= DX_LATENCY_BOUNDS; k++) {
        struct labels le = l;

        n += json_number_value(json_array_get(within, (size_t)k));
        add_text(&le, "le", k < DX_LATENCY_BOUNDS ? dx_latency_bounds[k].seconds : "+Inf");
        put_sample(p, m, "_bucket", &le, n);
    }
    put_sample(p, m, "_sum", &l, json_number_value(json_object_get(spread, "sum_s")));
    put_sample(p, m, "_count", &l, n);
}

static void put_samples(const struct printer *p, const struct dx_metric *m, const json_t *o)
{
    switch (m->kind) {
    case DX_METRIC_GAUGE:
    case DX_METRIC_COUNTER:
        put_value(p, m, o);
        break;
    case DX_METRIC_PRESENT:
        put_present(p, m, o);
        break;
    case DX_METRIC_STATE:
        put_states(p, m, o);
        break;
    case DX_METRIC_INFO:
        put_info(p, m, o);
        break;
    case DX_METRIC_HISTOGRAM:
        put_histogram(p, m, o);
        break;
    }
}

/* ---- families --------------------------------------------------------------------------------
 */

/* OpenMetrics calls the family of a counter NAME, the format before it NAME_total. */
static void put_head(const struct printer *p, const struct dx_metric *m)
{
    const char *type = m->kind == DX_METRIC_COUNTER     ? "counter"
                       : m->kind == DX_METRIC_HISTOGRAM ? "histogram"
                                                        : "gauge";
    const bool is_short = p->format == DX_METRICS_OPENMETRICS || m->kind != DX_METRIC_COUNTER;
    const char *suffix = is_short ? "" : "_total";

    fprintf(p->out, "# HELP %s%s %s\n", m->name, suffix, m->help);
    fprintf(p->out, "# TYPE %s%s %s\n", m->name, suffix, type);
    if (m->unit && p->format == DX_METRICS_OPENMETRICS)
        fprintf(p->out, "# UNIT %s %s\n", m->name, m->unit);
}

static void put_metric(const struct printer *p, const struct dx_metric *m, const json_t *status)
{
    const char *which = m->of == DX_METRIC_OF_STREAMS ? "streams" : "clients";
    const json_t *all = json_object_get(status, which);

    if (m->of == DX_METRIC_OF_SERVICE) {
        put_samples(p, m, status);
        return;
    }
    for (size_t k = 0; k < json_array_size(all); k++)
        put_samples(p, m, json_array_get(all, k));
}

void dx_metrics_print(FILE *out, const json_t *status, enum dx_metrics_format format)
{
    const struct printer p = {out, format};

    for (const struct dx_metric *m = dx_metrics; m->name; m++) {
        if (m == dx_metrics || strcmp(m->name, m[-1].name))
            put_head(&p, m);
        put_metric(&p, m, status);
    }
    if (format == DX_METRICS_OPENMETRICS)
        fputs("# EOF\n", out);
}
