/* The choice of an instruction set. */
#include "core/rows/rows.h"

#include "core/rows/rows_priv.h"

#include <stddef.h>

#if defined(__x86_64__)
static const struct dx_rows *find(enum dx_simd simd)
{
    switch (simd) {
    case DX_SIMD_AVX2:
        return __builtin_cpu_supports("avx2") ? &dx_rows_avx2 : NULL;
    case DX_SIMD_AVX512:
        return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                       __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") &&
                       __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512vbmi2")
                   ? &dx_rows_avx512
                   : NULL;
    default:
        return &dx_rows_generic;
    }
}
#else
static const struct dx_rows *find(enum dx_simd simd)
{
    return simd == DX_SIMD_GENERIC ? &dx_rows_generic : NULL;
}
#endif

const struct dx_rows *dx_rows_get(enum dx_simd simd)
{
    const struct dx_rows *rows = NULL;

    if (simd != DX_SIMD_AUTO)
        return find(simd);
    for (enum dx_simd best = DX_N_SIMD - 1; !rows; best--)
        rows = find(best);
    return rows;
}
