/* The choice of an instruction set. */
#include "core/rows/rows.h"

#include "core/rows/rows_priv.h"

#include <stddef.h>

#if defined(__x86_64__)
static const struct dx_rows *avx2(void)
{
    return __builtin_cpu_supports("avx2") ? &dx_rows_avx2 : NULL;
}
#else
static const struct dx_rows *avx2(void)
{
    return NULL;
}
#endif

const struct dx_rows *dx_rows_get(enum dx_simd simd)
{
    if (simd == DX_SIMD_GENERIC)
        return &dx_rows_generic;
    if (simd == DX_SIMD_AVX2)
        return avx2();
    return avx2() ? avx2() : &dx_rows_generic;
}
