/* Wrapped allocation functions: count, then call the real ones. */
#include "tools/alloc_count.h"

#include <stdatomic.h>
#include <stddef.h>

static atomic_uint_fast64_t count;

void *__real_malloc(size_t len);
void *__real_calloc(size_t n, size_t len);
void *__real_realloc(void *old, size_t len);
void *__wrap_malloc(size_t len);
void *__wrap_calloc(size_t n, size_t len);
void *__wrap_realloc(void *old, size_t len);

static void add_one(void)
{
    atomic_fetch_add_explicit(&count, 1, memory_order_relaxed); /* a statistic */
}

uint64_t dx_alloc_count(void)
{
    return atomic_load_explicit(&count, memory_order_relaxed);
}

void *__wrap_malloc(size_t len)
{
    add_one();
    return __real_malloc(len);
}

void *__wrap_calloc(size_t n, size_t len)
{
    add_one();
    return __real_calloc(n, len);
}

void *__wrap_realloc(void *old, size_t len)
{
    add_one();
    return __real_realloc(old, len);
}
