/*
 * tests/lint_model.h, and of cmocka: an assertion that does not hold does not come back.
 */
#ifndef DX_LINT_MODEL_TESTS_H
#define DX_LINT_MODEL_TESTS_H

#include "tests/lint_model.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

__attribute__((noreturn)) void _fail(const char *const file, const int line);

#undef assert_true
#undef assert_false
#undef assert_null
#undef assert_non_null
#undef assert_int_equal
#undef assert_int_not_equal
#define assert_true(c)             ((c) ? (void)0 : _fail(__FILE__, __LINE__))
#define assert_false(c)            assert_true(!(c))
#define assert_null(p)             assert_true(!(p))
#define assert_non_null(p)         assert_true(p)
#define assert_int_equal(a, b)     assert_true((uintmax_t)(a) == (uintmax_t)(b))
#define assert_int_not_equal(a, b) assert_true((uintmax_t)(a) != (uintmax_t)(b))

#endif
