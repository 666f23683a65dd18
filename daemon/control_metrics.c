/* metrics, of the control socket. */
#include "daemon/control_metrics.h"

#include "daemon/metrics.h"
#include "daemon/status.h"

#include <stdlib.h>
#include <string.h>

/* The format of "format", the first without; -1: there is none such. */
static int format_asked(const json_t *request)
{
    const json_t *given = json_object_get(request, "format");
    const char *name = json_string_value(given);

    if (!given)
        return DX_METRICS_OPENMETRICS;
    for (int k = 0; name && k < DX_N_METRICS_FORMATS; k++)
        if (!strcmp(name, dx_metrics_format_name((enum dx_metrics_format)k)))
            return k;
    return -1;
}

json_t *dx_control_metrics(struct dx_server *server, const json_t *request)
{
    const int format = format_asked(request);
    json_t *status, *answer = NULL;
    char *text = NULL;
    size_t len;
    FILE *out;

    if (format < 0)
        return json_pack("{s:s}", "error", "\"format\": expected openmetrics or prometheus");
    out = open_memstream(&text, &len);
    if (!out)
        return NULL;
    status = dx_status(server, true);
    dx_metrics_print(out, status, (enum dx_metrics_format)format);
    if (fclose(out) == 0)
        answer = json_pack("{s:s,s:s}", "content_type",
                           dx_metrics_content_type((enum dx_metrics_format)format), "text", text);
    json_decref(status);
    free(text);
    return answer;
}
