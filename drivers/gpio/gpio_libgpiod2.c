/*
 * Lines through libgpiod 2: one request for each chip, with one descriptor, on which the events of
 * all its lines come in order and numbered; a gap in the numbers is a queue of the kernel that ran
 * over (it drops the oldest).
 */
#include "drivers/gpio/gpio_port.h"

#include <errno.h>
#include <gpiod.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define QUEUE 1024 /* events that the kernel keeps: as many as it allows */
#define BATCH 64

struct chip {
    struct gpiod_line_request *request;
    char path[80];
    bool has_edges;
    unsigned long n_events; /* the number of the last one */
};

struct port {
    struct dx_gpio_port port;
    struct gpiod_edge_event_buffer *buffer;
    size_t n_chips, n;
    struct chip chip[DX_GPIO_MAX_LINES];
    struct {
        struct chip *chip;
        unsigned offset;
        char where[96];
    } line[DX_GPIO_MAX_LINES];
};

static int no_memory(struct dx_err *err)
{
    return dx_err_set(err, -ENOMEM, "gpio: no memory");
}

/* The offset of a line of this name on a chip, or -1. */
static int offset_on(const char *path, const char *name)
{
    struct gpiod_chip *chip = gpiod_chip_open(path);
    int offset = chip ? gpiod_chip_get_line_offset_from_name(chip, name) : -1;

    if (chip)
        gpiod_chip_close(chip);
    return offset;
}

static int find(const struct dx_gpio_bank *bank, const char *where, struct dx_gpio_place *place,
                struct dx_err *err)
{
    (void)bank;
    return dx_gpio_find(where, offset_on, place, err);
}

static void release(struct dx_gpio_port *port)
{
    struct port *p = (struct port *)port;

    for (size_t k = 0; k < p->n_chips; k++)
        if (p->chip[k].request)
            gpiod_line_request_release(p->chip[k].request);
    if (p->buffer)
        gpiod_edge_event_buffer_free(p->buffer);
    free(p);
}

static int find_lines(struct port *p, const struct dx_gpio_line *lines, size_t n,
                      struct dx_err *err)
{
    for (size_t k = 0; k < n; k++) {
        struct dx_gpio_place place;
        size_t c = 0;
        int r = find(NULL, lines[k].where, &place, err);

        if (r)
            return r;
        while (c < p->n_chips && strcmp(p->chip[c].path, place.chip))
            c++;
        if (c == p->n_chips)
            snprintf(p->chip[p->n_chips++].path, sizeof(p->chip[c].path), "%s", place.chip);
        p->chip[c].has_edges |= !lines[k].output && lines[k].edges != DX_GPIO_NO_EDGE;
        p->line[k].chip = &p->chip[c];
        p->line[k].offset = place.offset;
        snprintf(p->line[k].where, sizeof(p->line[k].where), "%s", lines[k].where);
    }
    p->n = n;
    return 0;
}

/* 0, or -1 with errno. */
static int apply(struct gpiod_line_settings *s, const struct dx_gpio_line *l)
{
    static const enum gpiod_line_bias bias[] = {GPIOD_LINE_BIAS_AS_IS, GPIOD_LINE_BIAS_DISABLED,
                                                GPIOD_LINE_BIAS_PULL_UP, GPIOD_LINE_BIAS_PULL_DOWN};
    static const enum gpiod_line_edge edge[] = {GPIOD_LINE_EDGE_NONE, GPIOD_LINE_EDGE_RISING,
                                                GPIOD_LINE_EDGE_FALLING, GPIOD_LINE_EDGE_BOTH};

    gpiod_line_settings_reset(s);
    gpiod_line_settings_set_active_low(s, l->active_low);
    if (l->output)
        return gpiod_line_settings_set_direction(s, GPIOD_LINE_DIRECTION_OUTPUT) ||
                       gpiod_line_settings_set_output_value(s, l->value ? GPIOD_LINE_VALUE_ACTIVE
                                                                        : GPIOD_LINE_VALUE_INACTIVE)
                   ? -1
                   : 0;
    gpiod_line_settings_set_debounce_period_us(s, l->debounce_us);
    return gpiod_line_settings_set_direction(s, GPIOD_LINE_DIRECTION_INPUT) ||
                   gpiod_line_settings_set_bias(s, bias[l->bias]) ||
                   gpiod_line_settings_set_edge_detection(s, edge[l->edges]) ||
                   gpiod_line_settings_set_event_clock(s, GPIOD_LINE_CLOCK_MONOTONIC)
               ? -1
               : 0;
}

/* What is asked of the lines of one chip. */
static int configure(struct port *p, const struct chip *c, const struct dx_gpio_line *lines,
                     struct gpiod_line_settings *settings, struct gpiod_line_config *config,
                     struct dx_err *err)
{
    for (size_t k = 0; k < p->n; k++) {
        if (p->line[k].chip != c)
            continue;
        if (apply(settings, &lines[k]) ||
            gpiod_line_config_add_line_settings(config, &p->line[k].offset, 1, settings))
            return dx_gpio_fail(err, -errno, lines[k].where, "cannot be configured");
    }
    return 0;
}

static int ask(struct port *p, struct chip *c, const struct dx_gpio_line *lines,
               struct gpiod_line_config *config, const char *consumer, struct dx_err *err)
{
    struct gpiod_request_config *how = gpiod_request_config_new();
    struct gpiod_chip *chip = gpiod_chip_open(c->path);
    const char *first = "";
    int r = 0;

    for (size_t k = p->n; k-- > 0;)
        if (p->line[k].chip == c)
            first = lines[k].where;
    if (!how) {
        r = no_memory(err);
    } else if (!chip) {
        r = dx_gpio_fail(err, -errno, first, "the chip cannot be opened");
    } else {
        gpiod_request_config_set_consumer(how, consumer);
        gpiod_request_config_set_event_buffer_size(how, QUEUE);
        c->request = gpiod_chip_request_lines(chip, how, config);
        if (!c->request)
            r = dx_gpio_fail(err, -errno, first, "it, or another of its chip, is not given");
    }
    if (chip)
        gpiod_chip_close(chip);
    if (how)
        gpiod_request_config_free(how);
    return r;
}

static int request_chip(struct port *p, struct chip *c, const struct dx_gpio_line *lines,
                        const char *consumer, struct dx_err *err)
{
    struct gpiod_line_settings *settings = gpiod_line_settings_new();
    struct gpiod_line_config *config = gpiod_line_config_new();
    int r;

    if (!settings || !config)
        r = no_memory(err);
    else
        r = configure(p, c, lines, settings, config, err);
    if (!r)
        r = ask(p, c, lines, config, consumer, err);
    if (config)
        gpiod_line_config_free(config);
    if (settings)
        gpiod_line_settings_free(settings);
    return r;
}

static const struct dx_gpio_ops ops;

static int request(struct dx_gpio_port **out, const struct dx_gpio_bank *bank,
                   const struct dx_gpio_line *lines, size_t n, const char *consumer,
                   struct dx_err *err)
{
    struct port *p = calloc(1, sizeof(*p));
    int r;

    (void)bank;
    if (!p)
        return no_memory(err);
    p->port.ops = &ops;
    p->buffer = gpiod_edge_event_buffer_new(BATCH);
    r = p->buffer ? find_lines(p, lines, n, err) : no_memory(err);
    for (size_t k = 0; k < p->n_chips && !r; k++)
        r = request_chip(p, &p->chip[k], lines, consumer, err);
    if (r) {
        release(&p->port);
        return r;
    }
    p->port.is_ordered = p->n_chips < 2;
    p->port.is_debounced = true;
    *out = &p->port;
    return 0;
}

static uint32_t line_at(const struct port *p, const struct chip *c, unsigned offset)
{
    uint32_t k = 0;

    while (k + 1 < p->n && (p->line[k].chip != c || p->line[k].offset != offset))
        k++;
    return k;
}

static int read_chip(struct port *p, struct chip *c, struct dx_gpio_event *out, size_t max,
                     struct dx_err *err)
{
    int n = gpiod_line_request_wait_edge_events(c->request, 0);

    if (n > 0)
        n = gpiod_line_request_read_edge_events(c->request, p->buffer, max < BATCH ? max : BATCH);
    if (n < 0)
        return errno == EINTR ? 0
                              : dx_gpio_fail(err, errno == EIO ? -ENODEV : -errno, c->path,
                                             "events cannot be read");
    for (int i = 0; i < n; i++) {
        struct gpiod_edge_event *e = gpiod_edge_event_buffer_get_event(p->buffer, (unsigned long)i);
        unsigned long number = gpiod_edge_event_get_global_seqno(e);

        out[i] = (struct dx_gpio_event){
            .timestamp_ns = gpiod_edge_event_get_timestamp_ns(e),
            .line = line_at(p, c, gpiod_edge_event_get_line_offset(e)),
            .rising = gpiod_edge_event_get_event_type(e) == GPIOD_EDGE_EVENT_RISING_EDGE,
            .overflow = (uint32_t)number != (uint32_t)(c->n_events + 1),
            .seqno = (uint32_t)number,
        };
        c->n_events = number;
    }
    return n;
}

static int read_events(struct dx_gpio_port *port, struct dx_gpio_event *out, size_t max,
                       struct dx_err *err)
{
    struct port *p = (struct port *)port;
    size_t n = 0;

    for (size_t k = 0; k < p->n_chips; k++) {
        int got = 1;

        while (p->chip[k].has_edges && n < max && got > 0) {
            got = read_chip(p, &p->chip[k], out + n, max - n, err);
            if (got < 0)
                return got;
            n += (size_t)got;
        }
    }
    return (int)n;
}

static int get(struct dx_gpio_port *port, size_t line, struct dx_err *err)
{
    struct port *p = (struct port *)port;
    enum gpiod_line_value value =
        gpiod_line_request_get_value(p->line[line].chip->request, p->line[line].offset);

    return value == GPIOD_LINE_VALUE_ERROR
               ? dx_gpio_fail(err, -errno, p->line[line].where, "its level is not told")
               : (int)(value == GPIOD_LINE_VALUE_ACTIVE);
}

static int set(struct dx_gpio_port *port, size_t line, bool value, struct dx_err *err)
{
    struct port *p = (struct port *)port;

    return gpiod_line_request_set_value(p->line[line].chip->request, p->line[line].offset,
                                        value ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE)
               ? dx_gpio_fail(err, -errno, p->line[line].where, "it cannot be set")
               : 0;
}

static size_t descriptors(const struct dx_gpio_port *port, int fds[DX_GPIO_MAX_LINES])
{
    const struct port *p = (const struct port *)port;
    size_t n = 0;

    for (size_t k = 0; k < p->n_chips; k++)
        if (p->chip[k].has_edges)
            fds[n++] = gpiod_line_request_get_fd(p->chip[k].request);
    return n;
}

static const struct dx_gpio_ops ops = {find, request, read_events, get, set, descriptors, release};
const struct dx_gpio_bank dx_gpio_kernel = {&ops};
