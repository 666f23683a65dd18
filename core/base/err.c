/*
 * Formatting of error texts. The one file of core that includes <stdio.h>: vsnprintf writes to
 * memory, no stream is touched.
 */
#include "core/base/err.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

int dx_err_set(struct dx_err *err, int code, const char *fmt, ...)
{
    va_list ap;

    if (!err)
        return code;
    va_start(ap, fmt);
    vsnprintf(err->text, sizeof(err->text), fmt, ap);
    va_end(ap);
    return code;
}

void dx_err_prefix(struct dx_err *err, const char *prefix)
{
    char text[sizeof(err->text)];

    if (!err)
        return;
    memcpy(text, err->text, sizeof(text));
    dx_err_set(err, 0, "%s: %.400s", prefix, text);
}
