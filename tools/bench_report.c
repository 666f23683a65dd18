/* Tables of measured figures: see bench_report.h. */
#include "tools/bench_report.h"

#include "tools/stats_json.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define CELL 64 /* bytes of one, and longer ones are cut */

void dx_report_init(struct dx_report *r, enum dx_report_format format, const char *name, int argc,
                    char *const *argv)
{
    size_t n;

    *r = (struct dx_report){.format = format, .tables = json_array()};
    snprintf(r->command, sizeof(r->command), "%s", name);
    for (int k = 1; k < argc; k++) {
        if (strcmp(argv[k], "--json") == 0 || strcmp(argv[k], "--markdown") == 0)
            continue;
        n = strlen(r->command);
        snprintf(r->command + n, sizeof(r->command) - n, " %s", argv[k]);
    }
}

json_t *dx_report_row(struct dx_report_table *t)
{
    json_t *row = json_object();

    if (!t->rows)
        t->rows = json_array();
    return json_array_append_new(t->rows, row) == 0 ? row : NULL;
}

/* ---- as text ----------------------------------------------------------------------------------
 */

static void cell_text(char text[CELL], const json_t *row, const struct dx_report_column *c)
{
    const json_t *value = json_object_get(row, c->key);

    if (json_is_string(value))
        snprintf(text, CELL, "%s", json_string_value(value));
    else if (json_is_number(value))
        snprintf(text, CELL, "%.*f", c->decimals, json_number_value(value));
    else
        snprintf(text, CELL, "-");
}

static int column_width(const struct dx_report_table *t, const struct dx_report_column *c)
{
    size_t width = strlen(c->name), k;
    const json_t *row;

    json_array_foreach(t->rows, k, row)
    {
        char text[CELL];

        cell_text(text, row, c);
        width = strlen(text) > width ? strlen(text) : width;
    }
    return (int)width;
}

static void print_text(const struct dx_report_table *t)
{
    const json_t *row;
    size_t k;

    printf("%s\n\n", t->title);
    for (const struct dx_report_column *c = t->columns; c->name; c++)
        printf("%s%*s", c == t->columns ? "" : "  ", column_width(t, c), c->name);
    putchar('\n');
    json_array_foreach(t->rows, k, row)
    {
        for (const struct dx_report_column *c = t->columns; c->name; c++) {
            char text[CELL];

            cell_text(text, row, c);
            printf("%s%*s", c == t->columns ? "" : "  ", column_width(t, c), text);
        }
        putchar('\n');
    }
    putchar('\n');
}

static void print_markdown(const struct dx_report *r, const struct dx_report_table *t)
{
    const json_t *row;
    size_t k;

    printf("## %s\n\n%s\n\n    %s\n\n", t->title, t->text, r->command);
    for (const struct dx_report_column *c = t->columns; c->name; c++)
        printf("| %s ", c->name);
    printf("|\n");
    for (const struct dx_report_column *c = t->columns; c->name; c++)
        printf("|---:");
    printf("|\n");
    json_array_foreach(t->rows, k, row)
    {
        for (const struct dx_report_column *c = t->columns; c->name; c++) {
            char text[CELL];

            cell_text(text, row, c);
            printf("| %s ", text);
        }
        printf("|\n");
    }
    putchar('\n');
}

void dx_report_table(struct dx_report *r, struct dx_report_table *t)
{
    if (r->format == DX_REPORT_TEXT)
        print_text(t);
    else if (r->format == DX_REPORT_MARKDOWN)
        print_markdown(r, t);
    else
        json_array_append_new(r->tables,
                              json_pack("{s:s, s:O?}", "name", t->name, "rows", t->rows));
    json_decref(t->rows);
    t->rows = NULL;
}

int dx_report_close(struct dx_report *r)
{
    double load[1] = {0};
    json_t *j;

    if (r->format != DX_REPORT_JSON) {
        json_decref(r->tables);
        return 0;
    }
    if (getloadavg(load, 1) < 1)
        load[0] = 0;
    j = json_pack("{s:s, s:I, s:f, s:o?}", "command", r->command, "processors",
                  (json_int_t)sysconf(_SC_NPROCESSORS_ONLN), "load", load[0], "tables", r->tables);
    return dx_json_print(j, r->command);
}
