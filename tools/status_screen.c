/*
 * The live screen. Three tables of columns, which give way from the least important one on where
 * the terminal is too narrow for all.
 */
#include "tools/status_screen.h"

#include "tools/status_member.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define CELL_LEN 256

enum kind {
    TEXT,
    STATE,  /* in its colour */
    NUMBER, /* as it is */
    RATE,   /* what it grew by, a second; of an object: all its members */
    BYTES,  /* a rate in bytes */
    SPAN,   /* seconds */
};

struct column {
    const char *title;
    unsigned width;
    unsigned rank; /* 0: stays; the highest gives way first */
    enum kind kind;
    const char *key, *member; /* `member`: of the object `key`; NULL: `key` itself */
    int decimals;
    double scale; /* 0: 1 */
};

static const struct column stream_columns[] = {
    {"STREAM", 16, 0, TEXT, "name", NULL, 0, 0},
    {"STATE", 8, 0, STATE, "state", NULL, 0, 0},
    {"FPS", 6, 1, NUMBER, "fps", NULL, 1, 0},
    {"LAG", 8, 1, SPAN, "lag_s", NULL, 0, 0},
    {"P50 MS", 7, 3, NUMBER, "latency_ms", "p50", 2, 0},
    {"P99 MS", 7, 2, NUMBER, "latency_ms", "p99", 2, 0},
    {"DROPS/S", 8, 2, RATE, "drops", NULL, 1, 0},
    {"TILES/S", 8, 4, RATE, "tiles_sent", NULL, 0, 0},
    {"VALID%", 6, 5, NUMBER, "valid", NULL, 1, 100},
    {"NS/DEXEL", 8, 5, NUMBER, "mesh_ns_per_dexel", NULL, 1, 0},
    {"CLIENTS", 7, 3, NUMBER, "subscribers", NULL, 0, 0},
    {.title = NULL},
};

static const struct column device_columns[] = {
    {"STREAM", 16, 0, TEXT, "name", NULL, 0, 0},
    {"DEVICE", 9, 0, STATE, "device", "state", 0, 0},
    {"FOR", 8, 1, SPAN, "device", "since_s", 0, 0},
    {"OPENS", 6, 1, NUMBER, "device", "opens", 0, 0},
    {"UNPLUGGED", 9, 4, NUMBER, "device", "unplugged", 0, 0},
    {"STALLS", 6, 2, NUMBER, "device", "stalls", 0, 0},
    {"FAULTS", 6, 2, NUMBER, "device", "faults", 0, 0},
    {"LOST/S", 7, 2, RATE, "device", "lost", 1, 0},
    {"DAMAGED", 8, 4, NUMBER, "device", "damaged", 0, 0},
    {"SERIAL", 16, 3, TEXT, "device", "serial", 0, 0},
    {"PLACE", 16, 5, TEXT, "device", "place", 0, 0},
    {.title = NULL},
};

static const struct column client_columns[] = {
    {"PID", 8, 0, NUMBER, "pid", NULL, 0, 0},
    {"STREAM", 16, 0, TEXT, "stream", NULL, 0, 0},
    {"ENCODING", 8, 3, TEXT, "encoding", NULL, 0, 0},
    {"MODE", 8, 4, TEXT, "mode", NULL, 0, 0},
    {"MESHES/S", 8, 1, RATE, "epochs", NULL, 1, 0},
    {"BYTES/S", 9, 1, BYTES, "bytes", NULL, 0, 0},
    {"LAG", 8, 1, SPAN, "lag_s", NULL, 0, 0},
    {"COALESCED/S", 11, 2, RATE, "coalesced", NULL, 1, 0},
    {"RESETS", 6, 3, NUMBER, "resets", NULL, 0, 0},
    {.title = NULL},
};

/* What is drawn, and how much of the terminal is left for it. */
struct canvas {
    FILE *out;
    const struct dx_status_screen *screen;
    unsigned rows_left; /* the last one is for what did not fit */
    unsigned n_left_out;
};

/* One line of a table: the same stream or client now and before. */
struct row {
    const json_t *now, *before; /* `before` NULL: not known */
    double seconds;             /* between them */
};

/* ---- values ----------------------------------------------------------------------------------
 */

/* Of an object the sum of its numbers. */
static double value(const json_t *o, const struct column *c)
{
    const json_t *v = json_object_get(o, c->key), *part;
    const char *key;
    double sum = 0;

    if (c->member)
        v = json_object_get(v, c->member);
    if (json_is_number(v))
        return json_number_value(v);
    if (!json_is_object(v))
        return (double)NAN;
    json_object_foreach((json_t *)v, key, part) sum += json_number_value(part);
    return sum;
}

static double rate(const struct row *r, const struct column *c)
{
    double grown = value(r->now, c) - value(r->before, c);

    return r->before && r->seconds > 0 && grown >= 0 ? grown / r->seconds : (double)NAN;
}

static void print_bytes(char cell[CELL_LEN], double v)
{
    static const char *const units[] = {"B", "kB", "MB", "GB"};
    int k = 0;

    for (; v >= 1000 && k < 3; k++)
        v /= 1000;
    if (isnan(v))
        snprintf(cell, CELL_LEN, "-");
    else
        snprintf(cell, CELL_LEN, "%.*f %s", k ? 1 : 0, v, units[k]);
}

static void print_span(char cell[CELL_LEN], double s)
{
    if (isnan(s))
        snprintf(cell, CELL_LEN, "-");
    else if (s < 60)
        snprintf(cell, CELL_LEN, "%.*f s", s < 10 ? 2 : 0, s);
    else if (s < 3600)
        snprintf(cell, CELL_LEN, "%.0f min", floor(s / 60));
    else if (s < 48 * 3600)
        snprintf(cell, CELL_LEN, "%.0f h %02.0f", floor(s / 3600), floor(fmod(s, 3600) / 60));
    else
        snprintf(cell, CELL_LEN, "%.0f d", floor(s / 86400));
}

static const char *words(const struct row *r, const struct column *c)
{
    return c->member ? dx_status_text(json_object_get(r->now, c->key), c->member)
                     : dx_status_text(r->now, c->key);
}

static void print_cell(char cell[CELL_LEN], const struct row *r, const struct column *c)
{
    double v = c->kind == RATE || c->kind == BYTES ? rate(r, c) : value(r->now, c);

    if (c->kind == TEXT || c->kind == STATE)
        snprintf(cell, CELL_LEN, "%s", words(r, c));
    else if (c->kind == SPAN)
        print_span(cell, v);
    else if (c->kind == BYTES)
        print_bytes(cell, v);
    else if (isnan(v))
        snprintf(cell, CELL_LEN, "-");
    else
        snprintf(cell, CELL_LEN, "%.*f", c->decimals, v * (c->scale != 0 ? c->scale : 1));
}

/* ---- lines -----------------------------------------------------------------------------------
 */

static void colour(const struct canvas *v, const char *code)
{
    if (v->screen->colours && code)
        fprintf(v->out, "\033[%sm", code);
}

/* `text`, of `width` characters at most, none of which moves the cursor; returns how many. */
static unsigned put_text(const struct canvas *v, const char *text, unsigned width)
{
    unsigned n = 0;

    for (; *text; text++) {
        unsigned char b = (unsigned char)*text;

        if ((b & 0xc0) == 0x80 && n == 0)
            continue; /* the rest of a character that is not there */
        n += (b & 0xc0) != 0x80;
        if (n > width)
            return width;
        /* C1 controls, which some terminals obey, are 0xc2 and 0x80 to 0x9f */
        if (b == 0xc2 && text[1] && (unsigned char)text[1] < 0xa0) {
            fputc('?', v->out);
            text++;
        } else {
            fputc(b < 0x20 || b == 0x7f ? ' ' : b, v->out);
        }
    }
    return n;
}

static void put_padded(const struct canvas *v, const char *text, unsigned width, bool left,
                       const char *code)
{
    unsigned len = (unsigned)strlen(text);

    if (!left && len < width)
        fprintf(v->out, "%*s", (int)(width - len), "");
    colour(v, code);
    len = put_text(v, text, width);
    colour(v, code ? "0" : NULL);
    if (left)
        fprintf(v->out, "%*s", (int)(width - len), "");
}

/* False: no line is left. */
static bool begin_line(struct canvas *v)
{
    if (v->rows_left <= 1) {
        v->n_left_out++;
        return false;
    }
    v->rows_left--;
    return true;
}

static void end_line(struct canvas *v)
{
    fputs("\033[K\r\n", v->out);
}

static void put_line(struct canvas *v, const char *text, const char *code)
{
    if (!begin_line(v))
        return;
    colour(v, code);
    put_text(v, text, v->screen->columns - 1);
    colour(v, code ? "0" : NULL);
    end_line(v);
}

static const char *colour_of(const char *state)
{
    static const struct {
        const char *state, *code;
    } colours[] = {
        {"live", "32"},   {"streaming", "32"}, {"opening", "33"}, {"stalled", "33"},
        {"absent", "31"}, {"faulted", "31"},   {"gone", "31"},    {"ended", "2"},
    };

    for (size_t k = 0; k < sizeof(colours) / sizeof(colours[0]); k++)
        if (!strcmp(state, colours[k].state))
            return colours[k].code;
    return NULL;
}

/* ---- tables ----------------------------------------------------------------------------------
 */

/* The highest rank whose columns fit with all below it. */
static unsigned rank_that_fits(const struct column *columns, unsigned width)
{
    unsigned rank = 0;

    for (unsigned next = 0; next < 8; next++) {
        unsigned sum = 0;

        for (const struct column *c = columns; c->title; c++)
            sum += c->rank <= next ? c->width + 1 : 0;
        if (sum > width)
            break;
        rank = next;
    }
    return rank;
}

/* `row` NULL: the titles. */
static void put_row(struct canvas *v, const struct column *columns, const struct row *row)
{
    const unsigned rank = rank_that_fits(columns, v->screen->columns);
    unsigned left = v->screen->columns - 1;

    if (!begin_line(v))
        return;
    for (const struct column *c = columns; c->title; c++) {
        const bool is_text = c->kind == TEXT || c->kind == STATE;
        unsigned width = c->width < left ? c->width : left;
        char cell[CELL_LEN];

        if (c->rank > rank || width == 0)
            continue;
        if (row)
            print_cell(cell, row, c);
        put_padded(v, row ? cell : c->title, width, is_text,
                   !row               ? "1"
                   : c->kind == STATE ? colour_of(cell)
                                      : NULL);
        left -= width;
        if (left) {
            fputc(' ', v->out);
            left--;
        }
    }
    end_line(v);
}

/* The one of `all` whose member `key` is as that of `o`. */
static const json_t *same(const json_t *all, const json_t *o, const char *key)
{
    for (size_t k = 0; k < json_array_size(all); k++)
        if (json_equal(json_object_get(json_array_get(all, k), key), json_object_get(o, key)))
            return json_array_get(all, k);
    return NULL;
}

struct table {
    const char *list, *key; /* of the status; what a row is known by */
    const struct column *columns;
    const char *needs; /* rows without this member are left out; NULL: none are */
    void (*more)(struct canvas *v, const json_t *o); /* lines below a row */
};

static void put_table(struct canvas *v, const struct table *t, const json_t *now,
                      const json_t *before)
{
    const json_t *all = json_object_get(now, t->list), *old = json_object_get(before, t->list);
    const double seconds =
        dx_status_number(now, "uptime_s", NULL) - dx_status_number(before, "uptime_s", NULL);
    bool any = false;

    for (size_t k = 0; k < json_array_size(all); k++) {
        const json_t *o = json_array_get(all, k);
        const struct row row = {o, seconds > 0 ? same(old, o, t->key) : NULL, seconds};

        if (t->needs && !json_object_get(o, t->needs))
            continue;
        if (!any) {
            put_line(v, "", NULL);
            put_row(v, t->columns, NULL);
        }
        any = true;
        put_row(v, t->columns, &row);
        if (t->more)
            t->more(v, o);
    }
}

/* ---- the screen ------------------------------------------------------------------------------
 */

static void put_trouble(struct canvas *v, const char *what, const char *text, const char *code)
{
    char line[CELL_LEN * 2];

    if (!strcmp(text, "-"))
        return;
    snprintf(line, sizeof(line), "  %s%s", what, text);
    put_line(v, line, code);
}

static void more_of_stream(struct canvas *v, const json_t *o)
{
    put_trouble(v, "", dx_status_text(o, "reason"), colour_of(dx_status_text(o, "state")));
    put_trouble(v, "recording: ", dx_status_text(json_object_get(o, "recording"), "error_text"),
                "31");
}

static void more_of_device(struct canvas *v, const json_t *o)
{
    put_trouble(v, "", dx_status_text(json_object_get(o, "device"), "trouble"), "33");
}

static void put_head(struct canvas *v, const json_t *now, const json_t *before)
{
    const struct column cpu = {.key = "cpu_s"};
    const struct row process = {now, before,
                                dx_status_number(now, "uptime_s", NULL) -
                                    dx_status_number(before, "uptime_s", NULL)};
    char line[CELL_LEN * 2], up[CELL_LEN], memory[CELL_LEN], used[32] = "-", clock[16];
    double share = rate(&process, &cpu);
    time_t t = time(NULL);
    struct tm day;

    print_span(up, dx_status_number(now, "uptime_s", NULL));
    print_bytes(memory, dx_status_number(now, "rss_bytes", NULL));
    if (!isnan(share))
        snprintf(used, sizeof(used), "%.0f %%", 100 * share);
    strftime(clock, sizeof(clock), "%H:%M:%S", localtime_r(&t, &day));
    snprintf(line, sizeof(line),
             "dexeld %.32s  up %.16s  memory %.16s  cpu %s  clients %zu  %s  q quits",
             dx_status_text(now, "version"), up, memory, used,
             json_array_size(json_object_get(now, "clients")), clock);
    put_line(v, line, NULL);
}

void dx_status_screen_put(FILE *out, const struct dx_status_screen *s, const json_t *now,
                          const json_t *before)
{
    static const struct table tables[] = {
        {"streams", "name", stream_columns, NULL, more_of_stream},
        {"streams", "name", device_columns, "device", more_of_device},
        {"clients", "number", client_columns, NULL, NULL},
    };
    struct canvas v = {out, s, s->rows, 0};

    fputs("\033[H", out);
    put_head(&v, now, before);
    if (s->trouble)
        put_line(&v, s->trouble, "31");
    for (size_t k = 0; k < sizeof(tables) / sizeof(tables[0]); k++)
        put_table(&v, &tables[k], now, before);
    fputs("\033[J", out);
    if (v.n_left_out)
        fprintf(out, "%u more lines", v.n_left_out);
}
