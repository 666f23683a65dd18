/*
 * As much of cmocka as the terrain tests use, for a machine that has no packages: a cross-compiled
 * test ends at its first false assertion.
 */
#ifndef DX_ARM64_CMOCKA_H
#define DX_ARM64_CMOCKA_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define assert_true(x)                                                                             \
    do {                                                                                           \
        if (!(x)) {                                                                                \
            fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #x);                                \
            exit(1);                                                                               \
        }                                                                                          \
    } while (0)
#define assert_false(x)              assert_true(!(x))
#define assert_null(x)               assert_true((x) == NULL)
#define assert_non_null(x)           assert_true((x) != NULL)
#define assert_ptr_equal(x, y)       assert_true((x) == (y))
#define assert_int_equal(x, y)       assert_true((x) == (y))
#define assert_int_not_equal(x, y)   assert_true((x) != (y))
#define assert_in_range(x, lo, hi)   assert_true((x) >= (lo) && (x) <= (hi))
#define assert_memory_equal(x, y, n) assert_true(memcmp(x, y, n) == 0)
#define fail()                       assert_true(!"fail")
#define fail_msg(...)                (fprintf(stderr, __VA_ARGS__), abort())
#define skip()                       return

struct CMUnitTest {
    const char *name;
    void (*test)(void **state);
};

#define cmocka_unit_test(f)                                                                        \
    {                                                                                              \
#f, f                                                                                      \
    }
#define cmocka_run_group_tests(tests, setup, teardown)                                             \
    run_tests(tests, (int)(sizeof(tests) / sizeof((tests)[0])))

static inline int run_tests(const struct CMUnitTest *tests, int n)
{
    for (int k = 0; k < n; k++) {
        tests[k].test(NULL);
        printf("pass  %s\n", tests[k].name);
    }
    return 0;
}

#endif
