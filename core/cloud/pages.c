/* Alignment and advice; where the advice is refused, pages are small and nothing else differs. */
#include "core/cloud/pages.h"

#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#define LARGE ((size_t)1 << 21)

void *dx_pages_new(size_t len)
{
    const size_t whole = (len + LARGE - 1) / LARGE * LARGE;
    void *p;

    if (len < 2 * LARGE || whole < len)
        return malloc(len ? len : 1);
    p = aligned_alloc(LARGE, whole);
    if (p)
        (void)madvise(p, whole, MADV_HUGEPAGE);
    return p;
}

void *dx_pages_new_zeroed(size_t len)
{
    void *p = len < 2 * LARGE ? calloc(1, len ? len : 1) : dx_pages_new(len);

    if (p && len >= 2 * LARGE)
        memset(p, 0, len);
    return p;
}
