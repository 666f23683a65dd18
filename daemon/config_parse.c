/*
 * From YAML to struct dx_config: libyaml's events walked along the table of keys. The shape of the
 * file is the table's, so nesting is bounded by it: what a key does not allow is refused at its
 * first event. The file comes from an administrator but is treated as bytes from outside. Parser
 * state lives on the heap for the time of one call.
 */
#include "daemon/config_parse.h"

#include <assert.h>
#include <errno.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <yaml.h>

#define PATH_LEN 128

struct parse {
    yaml_parser_t yaml;
    yaml_event_t event; /* the current one */
    const uint8_t *bytes;
    size_t len;
    const char *file;
    struct dx_err *err;
    struct dx_config *config;
    struct dx_config_marks *marks;
    uint32_t place;      /* in marks: 0 top, 1 + number of the stream */
    void *base;          /* dx_config, or the current dx_stream_config */
    char path[PATH_LEN]; /* of the current key, for messages: "streams[1].mesh.tilt" */
};

static struct dx_config_mark here(const struct parse *p)
{
    return (struct dx_config_mark){(unsigned)p->event.start_mark.line + 1,
                                   (unsigned)p->event.start_mark.column + 1};
}

int dx_config_fail(struct dx_err *err, const char *file, struct dx_config_mark mark,
                   const char *path, const char *fmt, ...)
{
    char text[sizeof(err->text)];
    va_list ap;

    va_start(ap, fmt);
    vsnprintf(text, sizeof(text), fmt, ap);
    va_end(ap);
    return dx_err_set(err, -EINVAL, "%.150s:%u:%u: %s%s%s", file, mark.line, mark.column, path,
                      *path ? ": " : "", text);
}

#define FAIL(p, ...) dx_config_fail((p)->err, (p)->file, here(p), (p)->path, __VA_ARGS__)

/* Line and column (in characters) of a byte, for libyaml's errors that have only an offset. */
static struct dx_config_mark mark_of_offset(const struct parse *p, size_t offset)
{
    struct dx_config_mark mark = {1, 1};

    for (size_t i = 0; i < offset; i++) {
        if (p->bytes[i] == '\n') {
            mark.line++;
            mark.column = 1;
        } else if ((p->bytes[i] & 0xc0) != 0x80) {
            mark.column++;
        }
    }
    return mark;
}

/* Is there a tab in the indentation of a line? libyaml has other words for it. */
static bool is_indented_by_tab(const struct parse *p, unsigned line)
{
    const uint8_t *end = p->bytes + p->len, *at = p->bytes;

    for (; at < end && line > 1; at++)
        line -= *at == '\n';
    while (at < end && *at == ' ')
        at++;
    return at < end && *at == '\t';
}

/* What libyaml has to say. */
static int fail_yaml(struct parse *p)
{
    const yaml_parser_t *y = &p->yaml;
    struct dx_config_mark mark = {(unsigned)y->problem_mark.line + 1,
                                  (unsigned)y->problem_mark.column + 1};

    if (y->error == YAML_MEMORY_ERROR)
        return dx_err_set(p->err, -ENOMEM, "%.150s: out of memory", p->file);
    if (y->error == YAML_READER_ERROR) {
        mark = mark_of_offset(p, y->problem_offset);
        if (y->problem_value < 0)
            return dx_config_fail(p->err, p->file, mark, "",
                                  "found the end, expected the rest of a UTF-8 character");
        return dx_config_fail(p->err, p->file, mark, "", "found 0x%02x, expected UTF-8 text (%s)",
                              (unsigned)y->problem_value, y->problem);
    }
    if (is_indented_by_tab(p, mark.line))
        return dx_config_fail(p->err, p->file, mark, "", "not YAML: found a tab, expected spaces");
    if (y->context)
        return dx_config_fail(p->err, p->file, mark, "", "not YAML: %s (%s, line %zu)", y->problem,
                              y->context, y->context_mark.line + 1);
    return dx_config_fail(p->err, p->file, mark, "", "not YAML: %s", y->problem);
}

/* The anchor and the tag of an event, NULL when it has none. */
static const yaml_char_t *anchor_of(const yaml_event_t *e)
{
    switch (e->type) {
    case YAML_ALIAS_EVENT:
        return e->data.alias.anchor;
    case YAML_SCALAR_EVENT:
        return e->data.scalar.anchor;
    case YAML_SEQUENCE_START_EVENT:
        return e->data.sequence_start.anchor;
    case YAML_MAPPING_START_EVENT:
        return e->data.mapping_start.anchor;
    default:
        return NULL;
    }
}

static const yaml_char_t *tag_of(const yaml_event_t *e)
{
    switch (e->type) {
    case YAML_SCALAR_EVENT:
        return e->data.scalar.tag;
    case YAML_SEQUENCE_START_EVENT:
        return e->data.sequence_start.tag;
    case YAML_MAPPING_START_EVENT:
        return e->data.mapping_start.tag;
    default:
        return NULL;
    }
}

/* The next event becomes the current one. */
static int next(struct parse *p)
{
    char found[DX_CONFIG_QUOTE_LEN];

    yaml_event_delete(&p->event);
    if (!yaml_parser_parse(&p->yaml, &p->event))
        return fail_yaml(p);
    if (anchor_of(&p->event)) {
        dx_config_quote(found, (const char *)anchor_of(&p->event));
        return FAIL(p, "found %s %s; anchors and aliases are not supported",
                    p->event.type == YAML_ALIAS_EVENT ? "alias" : "anchor", found);
    }
    if (tag_of(&p->event)) {
        dx_config_quote(found, (const char *)tag_of(&p->event));
        return FAIL(p, "found tag %s; tags are not supported", found);
    }
    if (p->event.type == YAML_SCALAR_EVENT &&
        strlen((const char *)p->event.data.scalar.value) != p->event.data.scalar.length)
        return FAIL(p, "found a text with a NUL character in it");
    return 0;
}

static const char *scalar(const struct parse *p)
{
    return (const char *)p->event.data.scalar.value;
}

/* Is the current event `key:` with nothing after it, or a null? */
static bool is_nothing(const struct parse *p)
{
    return p->event.type == YAML_SCALAR_EVENT &&
           p->event.data.scalar.style == YAML_PLAIN_SCALAR_STYLE &&
           (!*scalar(p) || !strcmp(scalar(p), "~") || !strcmp(scalar(p), "null"));
}

static int fail_value(struct parse *p, const char *allowed)
{
    char found[DX_CONFIG_QUOTE_LEN];

    if (p->event.type == YAML_MAPPING_START_EVENT)
        strcpy(found, "a map");
    else if (p->event.type == YAML_SEQUENCE_START_EVENT)
        strcpy(found, "a list");
    else if (is_nothing(p))
        strcpy(found, "nothing");
    else
        dx_config_quote(found, scalar(p));
    return FAIL(p, "found %s, expected %s", found, allowed);
}

static int fail_key_value(struct parse *p, const struct dx_config_key *key)
{
    char allowed[DX_CONFIG_ALLOWED_LEN];

    dx_config_value_allowed(key, allowed);
    return fail_value(p, allowed);
}

static int fail_empty(struct parse *p, struct dx_config_mark start, const struct dx_config_key *key)
{
    char allowed[DX_CONFIG_ALLOWED_LEN];

    dx_config_value_allowed(key, allowed);
    return dx_config_fail(p->err, p->file, start, p->path, "found an empty list, expected %s",
                          allowed);
}

static int parse_scalar(struct parse *p, const struct dx_config_key *key)
{
    int r = -EINVAL;

    if (p->event.type == YAML_SCALAR_EVENT && !is_nothing(p))
        r = dx_config_value_set(key, p->base, scalar(p));
    if (r == -EINVAL)
        return fail_key_value(p, key);
    return r ? dx_err_set(p->err, r, "%.150s: %s", p->file, strerror(-r)) : 0;
}

static int parse_numbers(struct parse *p, const struct dx_config_key *key)
{
    char allowed[DX_CONFIG_ALLOWED_LEN];
    size_t path_len = strlen(p->path);
    struct dx_config_mark start = here(p);
    unsigned n = 0;
    int r;

    if (p->event.type != YAML_SEQUENCE_START_EVENT)
        return parse_scalar(p, key);
    while (!(r = next(p)) && p->event.type != YAML_SEQUENCE_END_EVENT) {
        if (n == 3)
            return FAIL(p, "found more than 3 numbers");
        snprintf(p->path + path_len, PATH_LEN - path_len, "[%u]", n);
        r = -EINVAL;
        if (p->event.type == YAML_SCALAR_EVENT)
            r = dx_config_value_set_item(key, p->base, n++, scalar(p));
        if (r == -EINVAL) {
            dx_config_value_allowed_item(key, allowed);
            return fail_value(p, allowed);
        }
        if (r)
            return dx_err_set(p->err, r, "%.150s: %s", p->file, strerror(-r));
        p->path[path_len] = '\0';
    }
    if (!r && n < 3 && key->three)
        return dx_config_fail(p->err, p->file, start, p->path,
                              "found a list of %u, expected one of 3 numbers", n);
    return !r && !n ? fail_empty(p, start, key) : r;
}

/* Puts a key's name behind the path of its map; `len` is where that ends. */
static void push(struct parse *p, size_t len, const char *name)
{
    snprintf(p->path + len, PATH_LEN - len, "%s%s", len ? "." : "", name);
}

/* "file, synthetic": the keys of a map, or only its drivers. */
static void list_keys(char text[256], const struct dx_config_key *map, bool drivers)
{
    const struct dx_config_key *key;
    size_t len = 0;

    *text = '\0';
    for (key = dx_config_keys; key->path && len < 256; key++)
        if (dx_config_key_inside(key, map) && (!drivers || key->type == DX_CONFIG_DRIVER))
            len += (size_t)snprintf(text + len, 256 - len, "%s%s", len ? ", " : "",
                                    dx_config_key_name(key));
}

static int fail_unknown(struct parse *p, const struct dx_config_key *map)
{
    const struct dx_config_key *key = dx_config_key_nearest(map, scalar(p));
    char known[256], name[DX_CONFIG_QUOTE_LEN];

    dx_config_quote(name, scalar(p));
    name[strlen(name) - 1] = '\0';
    push(p, strlen(p->path), name + 1);
    if (key)
        return FAIL(p, "unknown key; did you mean '%s'?", dx_config_key_name(key));
    list_keys(known, map, false);
    return FAIL(p, "unknown key, expected one of %s", known);
}

static int choose_driver(struct parse *p, const struct dx_config_key *driver)
{
    struct dx_stream_config *stream = p->base;
    const struct dx_config_key *key;
    int r = 0;

    if (stream->driver)
        return FAIL(p, "found a second driver beside '%s', expected one", stream->driver);
    stream->driver = dx_config_key_name(driver);
    for (key = dx_config_keys; key->path && !r; key++)
        if (dx_config_key_applies(key, stream->driver) && !dx_config_key_applies(key, ""))
            r = dx_config_value_preset(key, stream);
    return r ? dx_err_set(p->err, r, "%.150s: %s", p->file, strerror(-r)) : 0;
}

/* Looks up the key that is the current event and makes its path the current one. */
static int parse_key(struct parse *p, const struct dx_config_key *map,
                     const struct dx_config_key **out)
{
    const struct dx_config_key *key;
    struct dx_config_mark *mark;

    if (p->event.type != YAML_SCALAR_EVENT)
        return FAIL(p, "found a %s, expected the name of a key",
                    p->event.type == YAML_MAPPING_START_EVENT ? "map" : "list");
    key = dx_config_key_child(map, scalar(p));
    if (!key)
        return fail_unknown(p, map);
    push(p, strlen(p->path), dx_config_key_name(key));
    mark = &p->marks->of[p->place][key - dx_config_keys];
    if (mark->line)
        return FAIL(p, "duplicate key, already on line %u", mark->line);
    *mark = here(p);
    *out = key;
    return key->type == DX_CONFIG_DRIVER ? choose_driver(p, key) : 0;
}

static int fail_missing(struct parse *p, struct dx_config_mark start,
                        const struct dx_config_key *key)
{
    char allowed[DX_CONFIG_ALLOWED_LEN];

    push(p, strlen(p->path), dx_config_key_name(key));
    dx_config_value_allowed(key, allowed);
    return dx_config_fail(p->err, p->file, start, p->path, "missing, expected %s", allowed);
}

static int parse_value(struct parse *p, const struct dx_config_key *key);

/* The keys of a map whose start is the current event; `map` NULL: the top. A map of nothing
 * (`mesh:` and all its keys commented out) is an empty one. */
static int parse_map(struct parse *p, const struct dx_config_key *map)
{
    size_t path_len = strlen(p->path);
    struct dx_config_mark start = here(p);
    const struct dx_config_key *key = NULL;
    bool nothing = is_nothing(p);
    int r = 0;

    if (!nothing && p->event.type != YAML_MAPPING_START_EVENT)
        return fail_value(p, "a map of keys");
    while (!nothing && !(r = next(p)) && p->event.type != YAML_MAPPING_END_EVENT) {
        if ((r = parse_key(p, map, &key)) || (r = next(p)) || (r = parse_value(p, key)))
            return r;
        p->path[path_len] = '\0';
    }
    for (key = dx_config_keys; key->path && !r; key++)
        if (key->required && dx_config_key_inside(key, map) &&
            !p->marks->of[p->place][key - dx_config_keys].line)
            r = fail_missing(p, start, key);
    return r;
}

static int parse_stream(struct parse *p, const struct dx_config_key *streams)
{
    struct dx_stream_config *stream = &p->config->streams[p->config->n_streams++];
    struct dx_config_mark start = here(p);
    const struct dx_config_key *key;
    char drivers[256];
    int r = 0;

    p->base = stream;
    p->place = p->config->n_streams;
    p->marks->stream[p->place] = start;
    stream->line = start.line;
    for (key = dx_config_keys; key->path && !r; key++)
        if (dx_config_key_applies(key, ""))
            r = dx_config_value_preset(key, stream);
    if (r)
        return dx_err_set(p->err, r, "%.150s: %s", p->file, strerror(-r));
    r = parse_map(p, streams);
    list_keys(drivers, streams, true);
    if (!r && !stream->driver)
        r = dx_config_fail(p->err, p->file, start, p->path, "found no driver, expected one of %s",
                           drivers);
    p->base = p->config;
    p->place = 0;
    return r;
}

static int parse_streams(struct parse *p, const struct dx_config_key *key)
{
    size_t path_len = strlen(p->path);
    struct dx_config_mark start = here(p);
    int r;

    if (p->event.type != YAML_SEQUENCE_START_EVENT)
        return fail_key_value(p, key);
    while (!(r = next(p)) && p->event.type != YAML_SEQUENCE_END_EVENT) {
        if (p->config->n_streams == DX_CONFIG_MAX_STREAMS)
            return FAIL(p, "found more than %u streams", DX_CONFIG_MAX_STREAMS);
        snprintf(p->path + path_len, PATH_LEN - path_len, "[%u]", p->config->n_streams);
        r = parse_stream(p, key);
        if (r)
            return r;
        p->path[path_len] = '\0';
    }
    return !r && !p->config->n_streams ? fail_empty(p, start, key) : r;
}

static int parse_value(struct parse *p, const struct dx_config_key *key)
{
    assert(key);
    p->marks->of[p->place][key - dx_config_keys] = here(p);
    if (key->type == DX_CONFIG_STREAMS)
        return parse_streams(p, key);
    if (key->type == DX_CONFIG_MAP || key->type == DX_CONFIG_DRIVER)
        return parse_map(p, key);
    return key->type == DX_CONFIG_NUMBERS ? parse_numbers(p, key) : parse_scalar(p, key);
}

/* A stream of one document that is a map. */
static int parse_file(struct parse *p)
{
    int r = next(p); /* the start of the stream */

    if (!r)
        r = next(p);
    if (!r && p->event.type == YAML_STREAM_END_EVENT)
        return FAIL(p, "found an empty file, expected at least the key 'streams'");
    if (!r)
        r = next(p);
    if (!r)
        r = parse_map(p, NULL);
    if (!r)
        r = next(p); /* the end of the document */
    if (!r)
        r = next(p);
    if (!r && p->event.type != YAML_STREAM_END_EVENT)
        return FAIL(p, "found a second document, expected one");
    return r;
}

int dx_config_parse_yaml(struct dx_config *config, struct dx_config_marks *marks, const char *file,
                         const void *bytes, size_t len, struct dx_err *err)
{
    struct parse p = {
        .bytes = bytes, .len = len, .file = file, .err = err, .config = config, .marks = marks};
    int r;

    if (len >= 3 && !memcmp(bytes, "\xef\xbb\xbf", 3)) { /* a byte order mark */
        p.bytes += 3;
        p.len -= 3;
    }
    p.base = config;
    if (!yaml_parser_initialize(&p.yaml))
        return dx_err_set(err, -ENOMEM, "%.150s: out of memory", file);
    yaml_parser_set_encoding(&p.yaml, YAML_UTF8_ENCODING);
    yaml_parser_set_input_string(&p.yaml, p.bytes, p.len);
    r = parse_file(&p);
    yaml_event_delete(&p.event);
    yaml_parser_delete(&p.yaml);
    return r;
}
