/*
 * The status as metrics for Prometheus: each row of a table (metrics_table.c) says which member of
 * the status (status.h) a metric is, and what it means. Functions of their arguments; any thread.
 */
#ifndef DX_METRICS_H
#define DX_METRICS_H

#include <jansson.h>
#include <stdio.h>

enum dx_metrics_format {
    DX_METRICS_OPENMETRICS, /* OpenMetrics 1.0 */
    DX_METRICS_PROMETHEUS,  /* the text format 0.0.4 before it, which node_exporter reads */
    DX_N_METRICS_FORMATS,
};

/* "openmetrics", "prometheus" */
const char *dx_metrics_format_name(enum dx_metrics_format format);
/* What HTTP calls it. */
const char *dx_metrics_content_type(enum dx_metrics_format format);

/* Writes all of a status with histograms. Members that are not there are left out, but each
 * family's head is written always. */
void dx_metrics_print(FILE *out, const json_t *status, enum dx_metrics_format format);

/* ---- the table -------------------------------------------------------------------------------
 */

enum dx_metric_kind {
    DX_METRIC_GAUGE,     /* a number, or true or false as 1 or 0 */
    DX_METRIC_COUNTER,   /* a number that only grows: its sample is NAME_total */
    DX_METRIC_PRESENT,   /* a gauge: 1 where the member is there, 0 where what it is of is */
    DX_METRIC_STATE,     /* a gauge for each word: 1 where the member is it */
    DX_METRIC_INFO,      /* a gauge of 1 whose labels are the members, "a,b" */
    DX_METRIC_HISTOGRAM, /* of latencies, in seconds */
};

/* Of what there is one sample each; its labels are those of metrics.c. */
enum dx_metric_of { DX_METRIC_OF_SERVICE, DX_METRIC_OF_STREAMS, DX_METRIC_OF_CLIENTS };

struct dx_metric {
    const char *name; /* with its unit; rows of one name follow each other, are of one kind, and
                         the first has the help */
    enum dx_metric_kind kind;
    enum dx_metric_of of;
    const char *member;              /* "drops.mailbox" */
    double scale;                    /* of the member to the unit; 0: 1 */
    const char *unit;                /* NULL: none */
    const char *label, *value;       /* one more label; NULL: none */
    const char *(*word)(unsigned k); /* of STATE; NULL past the last */
    const char *help;
};

extern const struct dx_metric dx_metrics[]; /* ends with a NULL name */

#endif
