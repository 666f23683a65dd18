/* The formats of this build, and which of them a file is. */
#include "drivers/file/format.h"

#include <string.h>
#include <strings.h>

static const struct dx_format *const formats[] = {&dx_format_ptx, &dx_format_pcd, &dx_format_ros};

#define N_FORMATS (sizeof(formats) / sizeof(formats[0]))

static bool ends_with(const char *text, size_t len, const char *tail)
{
    size_t tail_len = strlen(tail);

    return len >= tail_len && strncasecmp(text + len - tail_len, tail, tail_len) == 0;
}

bool dx_format_has_ext(const char *path, const char *ext)
{
    size_t len = strlen(path);

    if (ends_with(path, len, ".gz"))
        len -= 3;
    return ends_with(path, len, ext);
}

static const struct dx_format *find_by_name(const char *path)
{
    for (size_t k = 0; k < N_FORMATS; k++)
        if (dx_format_has_ext(path, formats[k]->ext))
            return formats[k];
    return NULL;
}

bool dx_format_knows_name(const char *path)
{
    return find_by_name(path) != NULL;
}

const struct dx_format *dx_format_find(const uint8_t *bytes, size_t len, const char *path)
{
    size_t probed = len < 4096 ? len : 4096;

    for (size_t k = 0; k < N_FORMATS; k++)
        if (formats[k]->probe(bytes, probed))
            return formats[k];
    return find_by_name(path);
}
