/* From vectors to bits and back by the masks of AVX-512: what rows_generic.c does there. */
#include "core/rows/rows.h"

#include <immintrin.h>

static inline dx_bits pack16(const uint16_t is[DX_ROWS_N])
{
    const uint64_t low = _mm512_movepi16_mask(_mm512_loadu_si512(is)),
                   middle = _mm512_movepi16_mask(_mm512_loadu_si512(is + 32));
    const __m256i last = _mm256_loadu_si256((const __m256i *)(is + 64));

    return low | middle << 32 | (dx_bits)_mm256_movepi16_mask(last) << 64;
}

static inline dx_bits pack32(const uint32_t *is, uint32_t n)
{
    uint64_t word[2] = {0, 0};

    for (uint32_t at = 0; at < n; at += 16)
        word[at / 64] |= (uint64_t)_mm512_movepi32_mask(_mm512_loadu_si512(is + at)) << at % 64;
    return word[0] | (dx_bits)word[1] << 64;
}

static inline void unpack16(uint16_t out[DX_ROWS_N], dx_bits is)
{
    const uint64_t low = (uint64_t)is;

    _mm512_storeu_si512(out, _mm512_movm_epi16((uint32_t)low));
    _mm512_storeu_si512(out + 32, _mm512_movm_epi16((uint32_t)(low >> 32)));
    _mm256_storeu_si256((__m256i *)(out + 64), _mm256_movm_epi16((uint16_t)(is >> 64)));
}

static inline void keep_used16(uint16_t out[DX_ROWS_N], const uint16_t *value, dx_bits used)
{
    const uint64_t low = (uint64_t)used;

    _mm512_storeu_si512(out, _mm512_maskz_loadu_epi16((uint32_t)low, value));
    _mm512_storeu_si512(out + 32, _mm512_maskz_loadu_epi16((uint32_t)(low >> 32), value + 32));
    _mm256_storeu_si256((__m256i *)(out + 64),
                        _mm256_maskz_loadu_epi16((uint16_t)(used >> 64), value + 64));
}

static inline void unpack32(uint32_t out[DX_ROWS_N], dx_bits is)
{
    for (int at = 0; at < DX_ROWS_N; at += 16)
        _mm512_storeu_si512(out + at, _mm512_movm_epi32((uint16_t)(is >> at)));
}

static inline struct dx_row_preference tell_f32(const float *more, const float *margin)
{
    struct dx_row_preference p = {0, 0};

    for (int at = 0; at < DX_ROWS_CELLS; at += 16) {
        const __m512 x = _mm512_loadu_ps(more + at), off = _mm512_loadu_ps(margin + at);
        const __mmask16 unsure = _mm512_cmp_ps_mask(_mm512_abs_ps(x), off, _CMP_NGT_UQ);

        p.bd |= (uint64_t)_mm512_cmp_ps_mask(x, _mm512_setzero_ps(), _CMP_GT_OQ) << at;
        p.unsure |= (uint64_t)unsure << at;
    }
    return p;
}

static void code_row(uint8_t *code, const uint64_t bit[3])
{
    const __m512i low = _mm512_maskz_set1_epi8(bit[0], 1);
    const __m512i two = _mm512_mask_add_epi8(low, bit[1], low, _mm512_set1_epi8(2));

    _mm512_storeu_si512(code, _mm512_mask_add_epi8(two, bit[2], two, _mm512_set1_epi8(4)));
}

static void bits_row(uint64_t bit[3], const uint8_t *code)
{
    const __m512i codes = _mm512_loadu_si512(code);

    for (int k = 0; k < 3; k++)
        bit[k] = _mm512_test_epi8_mask(codes, _mm512_set1_epi8((char)(1 << k)));
}

static uint64_t some_row(const uint8_t *bytes)
{
    const __m512i all = _mm512_loadu_si512(bytes);

    return _mm512_test_epi8_mask(all, all);
}
