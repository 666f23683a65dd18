/* The request {"request":"metrics"}, with "format" (metrics.h) or without. Loop thread. */
#ifndef DX_CONTROL_METRICS_H
#define DX_CONTROL_METRICS_H

#include <jansson.h>

struct dx_server;

/* {"content_type", "text"}, or {"error":...}. NULL: no memory. */
json_t *dx_control_metrics(struct dx_server *server, const json_t *request);

#endif
