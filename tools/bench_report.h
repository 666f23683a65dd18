/*
 * Tables of measured figures, as text, as Markdown, as JSON: a benchmark fills the rows of a table
 * and hands it over; text goes out at once, JSON when the report is closed. One thread.
 */
#ifndef DX_BENCH_REPORT_H
#define DX_BENCH_REPORT_H

#include <jansson.h>

#define DX_REPORT_COMMAND 512 /* bytes, and longer ones are cut */

enum dx_report_format { DX_REPORT_TEXT, DX_REPORT_MARKDOWN, DX_REPORT_JSON };

struct dx_report_column {
    const char *name; /* "codes, ns/dexel"; the last column's is followed by one of NULL */
    const char *key;  /* "codes_ns_per_dexel" */
    int decimals;
};

struct dx_report_table {
    const char *name;  /* in JSON */
    const char *title; /* one line */
    const char *text;  /* what is measured and how */
    const struct dx_report_column *columns;
    json_t *rows; /* dx_report_row makes it */
};

struct dx_report {
    enum dx_report_format format;
    char command[DX_REPORT_COMMAND]; /* what repeats it */
    json_t *tables;
};

/* `name` is the command's ("dexel bench rules"), argv[0] is not looked at. --json and --markdown
 * are left out of what repeats it. */
void dx_report_init(struct dx_report *r, enum dx_report_format format, const char *name, int argc,
                    char *const *argv);

/* A new row, the table's: an object whose members are the columns' keys. A number or a text; one
 * that is not set was not measured. Members without a column are for JSON alone. NULL: no memory,
 * which setters of jansson take, and dx_report_close tells. */
json_t *dx_report_row(struct dx_report_table *t);

/* Takes the rows. */
void dx_report_table(struct dx_report *r, struct dx_report_table *t);

/* Prints the JSON object. Errors: -EIO, -ENOMEM, having said so. */
int dx_report_close(struct dx_report *r);

#endif
