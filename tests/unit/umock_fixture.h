/*
 * A testbed of umockdev for tests that link it first (UMOCK in the Makefile). It knows nothing of
 * device numbers, which umock_attach() adds.
 */
#ifndef UMOCK_FIXTURE_H
#define UMOCK_FIXTURE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "tests/unit/umock_memory.h"

#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <umockdev.h>
#include <unistd.h>

/* umockdev leaks strings of its own, and its threads share some; what is ours is seen all the same.
 */
__attribute__((visibility("default"))) const char *__lsan_default_suppressions(void);
__attribute__((visibility("default"))) const char *__tsan_default_suppressions(void);
const char *__lsan_default_suppressions(void)
{
    return "leak:g_malloc\n";
}

const char *__tsan_default_suppressions(void)
{
    return "race:libumockdev\nrace:libglib-2.0\n";
}

/* In the testbed's own folder: the wrappers lead each path there. */
static inline void umock_link(UMockdevTestbed *bed, const char *folder, const char *name,
                              const char *to)
{
    char path[512];
    struct stat st;

    for (const char *slash = folder; slash; slash = strchr(slash + 1, '/')) {
        snprintf(path, sizeof(path), "%s/%.*s", umockdev_testbed_get_root_dir(bed),
                 (int)(slash - folder), folder);
        mkdir(path, 0755);
    }
    snprintf(path, sizeof(path), "%s/%s", umockdev_testbed_get_root_dir(bed), folder);
    mkdir(path, 0755);
    snprintf(path, sizeof(path), "%s/%s/%s", umockdev_testbed_get_root_dir(bed), folder, name);
    unlink(path);
    if (lstat(path, &st) < 0)
        assert_int_equal(symlink(to, path), 0);
}

/* A name below /dev gets the number of a device, as mknod gives it. */
static inline void umock_number(UMockdevTestbed *bed, const char *name, const char *number)
{
    char flat[128];

    snprintf(flat, sizeof(flat), "%s", name);
    for (char *c = flat; *c; c++)
        if (*c == '/')
            *c = '_';
    umock_link(bed, "dev/.node", flat, number);
}

/* Adds a device (the text of `umockdev-record`) and what else a kernel has of `number` "81:2". */
static inline void umock_attach(UMockdevTestbed *bed, const char *text, const char *number)
{
    const char *node = strstr(text, "\nN: "), *path = strstr(text, "P: ");
    char name[128], to[256];

    assert_true(umockdev_testbed_add_from_string(bed, text, NULL));
    if (!number)
        return;
    snprintf(name, sizeof(name), "%.*s", (int)strcspn(node + 4, "=\n"), node + 4);
    snprintf(to, sizeof(to), "../..%.*s", (int)strcspn(path + 3, "\n"), path + 3);
    umock_number(bed, name, number);
    umock_link(bed, "sys/dev/char", number, to);
}

#endif
