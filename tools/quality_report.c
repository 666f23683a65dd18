/* Tables to text, Markdown and JSON. */
#include "tools/quality_report.h"

#include "tools/stats_json.h"
#include "tools/stdout.h"

#include <assert.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

struct dx_quality_row *dx_quality_row(struct dx_quality_table *t,
                                      const struct dx_scene_config *scene)
{
    struct dx_quality_row *row = &t->row[t->n_rows];

    assert(t->n_rows < DX_QUALITY_ROWS);
    t->n_rows++;
    row->scene = *scene;
    for (unsigned k = 0; k < DX_QUALITY_COLUMNS; k++)
        row->value[k] = NAN;
    return row;
}

void dx_quality_hold(struct dx_quality_row *row, unsigned column, enum dx_quality_bar_kind kind,
                     double limit)
{
    unsigned k = 0;

    while (k < DX_QUALITY_BARS && row->bar[k].kind != DX_QUALITY_NO_BAR)
        k++;
    assert(k < DX_QUALITY_BARS);
    row->bar[k] = (struct dx_quality_bar){kind, column, limit};
}

/* What was not measured does not meet a bar. */
static bool is_met(const struct dx_quality_row *row, const struct dx_quality_bar *bar)
{
    double v = row->value[bar->column];

    return bar->kind == DX_QUALITY_AT_LEAST ? v >= bar->limit : v <= bar->limit;
}

/* ---- pieces of text -------------------------------------------------------------------------- */

/* Text that grows in a buffer of its own; what has no room is cut off. */
struct line {
    char text[256];
    size_t len;
};

__attribute__((format(printf, 2, 3))) static void add(struct line *l, const char *format, ...)
{
    va_list args;
    int n;

    va_start(args, format);
    n = vsnprintf(l->text + l->len, sizeof(l->text) - l->len, format, args);
    va_end(args);
    l->len += n < 0 ? 0 : (size_t)n;
    if (l->len >= sizeof(l->text))
        l->len = sizeof(l->text) - 1;
}

/* "hall 1500x1000, 2 mm, 5 % out": the size as columns x rows. */
static struct line label_of(const struct dx_quality_row *row)
{
    const struct dx_scene_config *s = &row->scene;
    struct line l = {"", 0};

    add(&l, "%s %ux%u", dx_scene_name(s->scene), s->width, s->height);
    add(&l, ", %g mm", s->sigma[0] * 1e3);
    if (s->sigma[1] > 0)
        add(&l, " + %g mm/m", s->sigma[1] * 1e3);
    if (s->sigma[2] > 0)
        add(&l, " + %g mm/m2", s->sigma[2] * 1e3);
    if (s->dropout > 0)
        add(&l, ", %g %% out", s->dropout * 100);
    if (s->mixed > 0)
        add(&l, ", %g %% mixed", s->mixed * 100);
    if (row->note[0])
        add(&l, ", %s", row->note);
    return l;
}

static struct line value_of(const struct dx_quality_table *t, const struct dx_quality_row *row,
                            unsigned column)
{
    struct line l = {"", 0};

    if (isnan(row->value[column]))
        add(&l, "-");
    else
        add(&l, "%.*f", t->column[column].decimals, row->value[column]);
    return l;
}

/* "met: coverage % >= 99.9" or "SHORT: ...", one for each bar. */
static struct line verdict_of(const struct dx_quality_table *t, const struct dx_quality_row *row)
{
    struct line l = {"", 0};

    for (unsigned k = 0; k < DX_QUALITY_BARS && row->bar[k].kind != DX_QUALITY_NO_BAR; k++)
        add(&l, "%s%s: %s %s %g", k ? "; " : "", is_met(row, &row->bar[k]) ? "met" : "SHORT",
            t->column[row->bar[k].column].name,
            row->bar[k].kind == DX_QUALITY_AT_LEAST ? ">=" : "<=", row->bar[k].limit);
    return l;
}

static unsigned n_columns(const struct dx_quality_table *t)
{
    unsigned n = 0;

    while (n < DX_QUALITY_COLUMNS && t->column[n].name)
        n++;
    return n;
}

static struct line command_of(const struct dx_quality_report *r, const struct dx_quality_table *t)
{
    struct line l = {"", 0};

    add(&l, "dexel bench quality %s --seed %" PRIu64 "%s", t->theme, r->seed,
        r->quick ? " --quick" : "");
    return l;
}

/* ---- formats --------------------------------------------------------------------------------- */

static void print_text(const struct dx_quality_report *r, const struct dx_quality_table *t)
{
    int width[DX_QUALITY_COLUMNS], label = 0;
    unsigned n = n_columns(t);

    for (unsigned c = 0; c < n; c++)
        width[c] = (int)strlen(t->column[c].name);
    for (unsigned k = 0; k < t->n_rows; k++) {
        int len = (int)label_of(&t->row[k]).len;

        label = len > label ? len : label;
        for (unsigned c = 0; c < n; c++) {
            len = (int)value_of(t, &t->row[k], c).len;
            width[c] = len > width[c] ? len : width[c];
        }
    }
    printf("%s\n%s\nrepeat: %s\n%-*s", t->title, t->text, command_of(r, t).text, label, "");
    for (unsigned c = 0; c < n; c++)
        printf("  %*s", width[c], t->column[c].name);
    putchar('\n');
    for (unsigned k = 0; k < t->n_rows; k++) {
        printf("%-*s", label, label_of(&t->row[k]).text);
        for (unsigned c = 0; c < n; c++)
            printf("  %*s", width[c], value_of(t, &t->row[k], c).text);
        printf("  %s\n", verdict_of(t, &t->row[k]).text);
    }
    putchar('\n');
}

static void print_markdown(const struct dx_quality_report *r, const struct dx_quality_table *t)
{
    unsigned n = n_columns(t);

    printf("## %s\n\n%s\n\n    %s\n\n| scan |", t->title, t->text, command_of(r, t).text);
    for (unsigned c = 0; c < n; c++)
        printf(" %s |", t->column[c].name);
    printf(" bar |\n|---|");
    for (unsigned c = 0; c < n; c++)
        printf("---:|");
    printf("---|\n");
    for (unsigned k = 0; k < t->n_rows; k++) {
        printf("| %s |", label_of(&t->row[k]).text);
        for (unsigned c = 0; c < n; c++)
            printf(" %s |", value_of(t, &t->row[k], c).text);
        printf(" %s |\n", verdict_of(t, &t->row[k]).text);
    }
    putchar('\n');
}

static json_t *row_json(const struct dx_quality_table *t, const struct dx_quality_row *row)
{
    const struct dx_scene_config *s = &row->scene;
    json_t *j = json_pack("{s:s, s:i, s:i, s:o, s:f, s:f, s:I, s:s}", "scene",
                          dx_scene_name(s->scene), "width", (int)s->width, "height", (int)s->height,
                          "sigma", dx_sigma_json(s->sigma), "dropout", s->dropout, "mixed",
                          s->mixed, "seed", (json_int_t)s->seed, "note", row->note);
    json_t *values = json_object(), *bars = json_array();

    for (unsigned c = 0; c < n_columns(t); c++)
        json_object_set_new(values, t->column[c].key,
                            isnan(row->value[c]) ? json_null() : json_real(row->value[c]));
    for (unsigned k = 0; k < DX_QUALITY_BARS && row->bar[k].kind != DX_QUALITY_NO_BAR; k++)
        json_array_append_new(
            bars, json_pack("{s:s, s:f, s:b}", "figure", t->column[row->bar[k].column].key,
                            row->bar[k].kind == DX_QUALITY_AT_LEAST ? "at_least" : "at_most",
                            row->bar[k].limit, "met", is_met(row, &row->bar[k])));
    json_object_set_new(j, "values", values);
    json_object_set_new(j, "bars", bars);
    return j;
}

static void add_json(struct dx_quality_report *r, const struct dx_quality_table *t)
{
    json_t *rows = json_array();

    for (unsigned k = 0; k < t->n_rows; k++)
        json_array_append_new(rows, row_json(t, &t->row[k]));
    json_array_append_new(r->tables,
                          json_pack("{s:s, s:s, s:s, s:o}", "theme", t->theme, "title", t->title,
                                    "command", command_of(r, t).text, "rows", rows));
}

/* ---- reports --------------------------------------------------------------------------------- */

static const char preamble[] =
    "# Quality\n\n"
    "What terrain mode makes of simulated scans, measured against what the beams really meet.\n"
    "Printed by `dexel bench quality --markdown`; each section names the command that repeats it,\n"
    "on any machine to the last digit. Sizes are columns x rows, noise is one standard deviation\n"
    "of a range. A figure that is held to a bar says whether it is met or falls SHORT.\n\n"
    "![Open ground by the first-order rule alone: a ring of ground is lost at the horizon, every "
    "drop-out is a hole](open-first-order.png)\n\n"
    "![The same scan by all rules](open.png)\n\n"
    "The same scan twice, with 5 mm of noise and 2 % drop-outs: by the first-order rule alone, "
    "and\n"
    "by the default rules.\n\n"
    "    dexel sim open -o open.pcd --size 1200x400 --noise 0.005 --dropouts 0.02 --seed 1\n"
    "    dexel render open.pcd -o open-first-order.png --size 1200x433 \\\n"
    "        --rescue off --bridge 0 --mixed off --diag fixed\n"
    "    dexel render open.pcd -o open.png --size 1200x433\n\n";

void dx_quality_report_init(struct dx_quality_report *r, enum dx_quality_format format,
                            uint64_t seed, bool quick)
{
    *r = (struct dx_quality_report){.format = format, .seed = seed, .quick = quick};
    if (format == DX_QUALITY_JSON)
        r->tables = json_array();
    if (format == DX_QUALITY_MARKDOWN)
        fputs(preamble, stdout);
}

void dx_quality_report_table(struct dx_quality_report *r, const struct dx_quality_table *t)
{
    for (unsigned k = 0; k < t->n_rows; k++)
        for (unsigned b = 0; b < DX_QUALITY_BARS && t->row[k].bar[b].kind != DX_QUALITY_NO_BAR;
             b++) {
            r->n_bars++;
            r->n_short += !is_met(&t->row[k], &t->row[k].bar[b]);
        }
    if (r->format == DX_QUALITY_TEXT)
        print_text(r, t);
    else if (r->format == DX_QUALITY_MARKDOWN)
        print_markdown(r, t);
    else
        add_json(r, t);
    dx_stdout_flush(); /* a theme takes seconds: show what there is */
}

int dx_quality_report_close(struct dx_quality_report *r)
{
    unsigned met = r->n_bars - r->n_short;

    if (r->format == DX_QUALITY_JSON)
        return dx_json_print(json_pack("{s:I, s:b, s:i, s:i, s:o}", "seed", (json_int_t)r->seed,
                                       "quick", r->quick, "bars_met", (int)met, "bars_short",
                                       (int)r->n_short, "tables", r->tables),
                             "dexel bench quality");
    printf("%u of %u bars met\n", met, r->n_bars);
    return 0;
}
