/*
 * Tables of measured figures, with the bars they are held to: as text, as Markdown, as JSON. A
 * theme fills a table and hands it over; text goes out at once, JSON when the report is closed. One
 * thread.
 */
#ifndef DX_QUALITY_REPORT_H
#define DX_QUALITY_REPORT_H

#include "drivers/synth/scene.h"

#include <jansson.h>

#define DX_QUALITY_COLUMNS 9
#define DX_QUALITY_ROWS    64
#define DX_QUALITY_BARS    3

enum dx_quality_format { DX_QUALITY_TEXT, DX_QUALITY_MARKDOWN, DX_QUALITY_JSON };

enum dx_quality_bar_kind { DX_QUALITY_NO_BAR, DX_QUALITY_AT_LEAST, DX_QUALITY_AT_MOST };

struct dx_quality_bar {
    enum dx_quality_bar_kind kind;
    unsigned column;
    double limit;
};

struct dx_quality_row {
    struct dx_scene_config scene; /* what was measured: scene, size, noise, seed */
    char note[32];                /* what else tells this row from its neighbours; may be empty */
    double value[DX_QUALITY_COLUMNS]; /* NAN: not measured */
    struct dx_quality_bar bar[DX_QUALITY_BARS];
};

struct dx_quality_table {
    const char *theme;
    const char *title;
    const char *text; /* what is counted, and how it is defined */
    struct {
        const char *name; /* of the column: "coverage %" */
        const char *key;  /* in JSON: "coverage_percent" */
        int decimals;
    } column[DX_QUALITY_COLUMNS]; /* up to the first without a name */
    unsigned n_rows;
    struct dx_quality_row row[DX_QUALITY_ROWS];
};

/* The next row, of what `scene` says. */
struct dx_quality_row *dx_quality_row(struct dx_quality_table *t,
                                      const struct dx_scene_config *scene);

/* Holds a value of the row to a bar; to DX_QUALITY_BARS of them at most. */
void dx_quality_hold(struct dx_quality_row *row, unsigned column, enum dx_quality_bar_kind kind,
                     double limit);

struct dx_quality_report {
    enum dx_quality_format format;
    uint64_t seed;
    bool quick;
    unsigned n_bars, n_short; /* bars so far, and those not met */
    json_t *tables;
};

void dx_quality_report_init(struct dx_quality_report *r, enum dx_quality_format format,
                            uint64_t seed, bool quick);
void dx_quality_report_table(struct dx_quality_report *r, const struct dx_quality_table *t);

/* The summary, and the JSON object. Errors: -EIO, -ENOMEM, having said so. */
int dx_quality_report_close(struct dx_quality_report *r);

#endif
