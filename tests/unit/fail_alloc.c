/* Wrapped allocation functions: count, fail the one that was asked for, else call the real ones. */
#include "tests/unit/fail_alloc.h"

#include <errno.h>
#include <jansson.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <sys/mman.h>

static atomic_uint_fast64_t left; /* calls until the one that fails */
static atomic_bool failed;

void *__real_malloc(size_t len);
void *__real_calloc(size_t n, size_t len);
void *__real_realloc(void *old, size_t len);
void *__real_aligned_alloc(size_t alignment, size_t len);
int __real_posix_memalign(void **out, size_t alignment, size_t len);
char *__real_strdup(const char *text);
void *__real_mmap(void *at, size_t len, int prot, int flags, int fd, off_t offset);
void *__wrap_malloc(size_t len);
void *__wrap_calloc(size_t n, size_t len);
void *__wrap_realloc(void *old, size_t len);
void *__wrap_aligned_alloc(size_t alignment, size_t len);
int __wrap_posix_memalign(void **out, size_t alignment, size_t len);
char *__wrap_strdup(const char *text);
void *__wrap_mmap(void *at, size_t len, int prot, int flags, int fd, off_t offset);

static bool fails(void)
{
    uint64_t n = atomic_load(&left);

    while (n && !atomic_compare_exchange_weak(&left, &n, n - 1))
        ;
    if (n != 1)
        return false;
    atomic_store(&failed, true);
    errno = ENOMEM;
    return true;
}

void fail_alloc_arm(uint64_t n)
{
    json_set_alloc_funcs(__wrap_malloc, free);
    atomic_store(&failed, false);
    atomic_store(&left, n);
}

bool fail_alloc_has_failed(void)
{
    return atomic_load(&failed);
}

void *__wrap_malloc(size_t len)
{
    return fails() ? NULL : __real_malloc(len);
}

void *__wrap_calloc(size_t n, size_t len)
{
    return fails() ? NULL : __real_calloc(n, len);
}

void *__wrap_realloc(void *old, size_t len)
{
    return fails() ? NULL : __real_realloc(old, len);
}

void *__wrap_aligned_alloc(size_t alignment, size_t len)
{
    return fails() ? NULL : __real_aligned_alloc(alignment, len);
}

int __wrap_posix_memalign(void **out, size_t alignment, size_t len)
{
    return fails() ? ENOMEM : __real_posix_memalign(out, alignment, len);
}

char *__wrap_strdup(const char *text)
{
    return fails() ? NULL : __real_strdup(text);
}

void *__wrap_mmap(void *at, size_t len, int prot, int flags, int fd, off_t offset)
{
    return fails() ? MAP_FAILED : __real_mmap(at, len, prot, flags, fd, offset);
}
