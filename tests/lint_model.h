/*
 * What clang-tidy, which reads one file at a time, has to know of functions in others. Included
 * before each file by tests/lint.sh and by nothing else.
 */
#ifndef DX_LINT_MODEL_H
#define DX_LINT_MODEL_H

#include "core/base/err.h"

static inline int dx_lint_second(int text_is_set, int code)
{
    (void)text_is_set;
    return code;
}

/* It returns its code: a failure is none that may have been 0. */
#define dx_err_set(err, code, ...) dx_lint_second((dx_err_set)(err, code, __VA_ARGS__), code)

#endif
