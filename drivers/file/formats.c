/* The formats of this build, and which of them a file is. */
#include "drivers/file/format.h"

#include "drivers/file/mcap.h"
#include "drivers/file/open_regular.h"

#include <string.h>
#include <strings.h>
#include <unistd.h>

static const struct dx_format *const formats[] = {&dx_format_ptx, &dx_format_pcd, &dx_format_ros};

#define N_FORMATS (sizeof(formats) / sizeof(formats[0]))
#define PROBED    4096 /* bytes */

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
    size_t probed = len < PROBED ? len : PROBED;

    for (size_t k = 0; k < N_FORMATS; k++)
        if (formats[k]->probe(bytes, probed))
            return formats[k];
    return find_by_name(path);
}

bool dx_format_may_be(const char *path)
{
    uint8_t head[PROBED];
    ssize_t n;
    int fd;

    if (dx_format_knows_name(path))
        return true;
    fd = dx_open_regular(path, NULL);
    if (fd < 0)
        return true;
    n = read(fd, head, sizeof(head));
    close(fd);
    return n < 0 || (n > 1 && head[0] == 0x1f && head[1] == 0x8b) ||
           (n >= DX_MCAP_MAGIC_LEN && dx_mcap_probe(head, (size_t)n)) ||
           dx_format_find(head, (size_t)n, "") != NULL;
}
