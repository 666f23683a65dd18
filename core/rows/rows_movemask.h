/* From vectors to bits and back by AVX2: what rows_generic.c does there. */
#include "core/rows/rows.h"

#include <immintrin.h>

static inline __m256i load256(const void *p)
{
    return _mm256_loadu_si256((const __m256i *)p);
}

/* Thirty-two. */
static inline uint32_t pack32x16(const uint16_t *is)
{
    const __m256i bytes = _mm256_packs_epi16(load256(is), load256(is + 16));

    /* packing takes halves in turn */
    return (uint32_t)_mm256_movemask_epi8(_mm256_permute4x64_epi64(bytes, 0xd8));
}

static inline dx_bits pack16(const uint16_t is[DX_ROWS_N])
{
    const uint64_t low = pack32x16(is) | (uint64_t)pack32x16(is + 32) << 32;
    const __m256i last = load256(is + 64);
    const __m128i bytes =
        _mm_packs_epi16(_mm256_castsi256_si128(last), _mm256_extracti128_si256(last, 1));

    return low | (dx_bits)(uint32_t)_mm_movemask_epi8(bytes) << 64;
}

static inline dx_bits pack32(const uint32_t *is, uint32_t n)
{
    uint64_t word[2] = {0, 0};

    for (uint32_t at = 0; at < n; at += 8) {
        const __m256 eight = _mm256_castsi256_ps(load256(is + at));

        word[at / 64] |= (uint64_t)(uint32_t)_mm256_movemask_ps(eight) << at % 64;
    }
    return word[0] | (dx_bits)word[1] << 64;
}

static inline void unpack16(uint16_t out[DX_ROWS_N], dx_bits is)
{
    const __m256i bit = _mm256_setr_epi16(1, 2, 4, 8, 0x10, 0x20, 0x40, 0x80, 0x100, 0x200, 0x400,
                                          0x800, 0x1000, 0x2000, 0x4000, (short)0x8000);

    for (int at = 0; at < DX_ROWS_N; at += 16) {
        const __m256i lanes = _mm256_set1_epi16((short)(is >> at));

        _mm256_storeu_si256((__m256i *)(out + at),
                            _mm256_cmpeq_epi16(_mm256_and_si256(lanes, bit), bit));
    }
}

static inline void keep_used16(uint16_t out[DX_ROWS_N], const uint16_t *value, dx_bits used)
{
    unpack16(out, used);
    for (uint32_t q = 0; q < DX_ROWS_N; q++)
        out[q] &= value[q];
}

static inline void unpack32(uint32_t out[DX_ROWS_N], dx_bits is)
{
    const __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 0x10, 0x20, 0x40, 0x80);

    for (int at = 0; at < DX_ROWS_N; at += 8) {
        const __m256i lanes = _mm256_set1_epi32((int)(is >> at));

        _mm256_storeu_si256((__m256i *)(out + at),
                            _mm256_cmpeq_epi32(_mm256_and_si256(lanes, bit), bit));
    }
}

/* `value` in the bytes of the bits that are set. */
static inline __m256i spread32(uint32_t bits, uint8_t value)
{
    const __m256i byte =
        _mm256_setr_epi64x(0, 0x0101010101010101, 0x0202020202020202, 0x0303030303030303);
    const __m256i kept = _mm256_set1_epi64x((long long)0x8040201008040201);
    const __m256i eights = _mm256_shuffle_epi8(_mm256_set1_epi32((int)bits), byte);

    return _mm256_and_si256(_mm256_cmpeq_epi8(_mm256_and_si256(eights, kept), kept),
                            _mm256_set1_epi8((char)value));
}

static inline struct dx_row_preference tell_f32(const float *more, const float *margin)
{
    const __m256 sign = _mm256_set1_ps(-0.0f);
    struct dx_row_preference p = {0, 0};

    for (int at = 0; at < DX_ROWS_CELLS; at += 8) {
        const __m256 x = _mm256_loadu_ps(more + at), size = _mm256_andnot_ps(sign, x);
        const __m256 unsure = _mm256_cmp_ps(size, _mm256_loadu_ps(margin + at), _CMP_NGT_UQ);
        const __m256 bd = _mm256_cmp_ps(x, _mm256_setzero_ps(), _CMP_GT_OQ);

        p.bd |= (uint64_t)(uint32_t)_mm256_movemask_ps(bd) << at;
        p.unsure |= (uint64_t)(uint32_t)_mm256_movemask_ps(unsure) << at;
    }
    return p;
}

static void code_row(uint8_t *code, const uint64_t bit[3])
{
    for (int at = 0; at < DX_ROWS_CELLS; at += 32) {
        const __m256i low = spread32((uint32_t)(bit[0] >> at), 1);
        const __m256i middle = spread32((uint32_t)(bit[1] >> at), 2);
        const __m256i high = spread32((uint32_t)(bit[2] >> at), 4);

        _mm256_storeu_si256((__m256i *)(code + at),
                            _mm256_or_si256(_mm256_or_si256(low, middle), high));
    }
}

static void bits_row(uint64_t bit[3], const uint8_t *code)
{
    const __m256i low = load256(code), high = load256(code + 32);

    for (int k = 0; k < 3; k++) { /* a byte's sign is what masks are made of */
        const uint32_t first = (uint32_t)_mm256_movemask_epi8(_mm256_slli_epi16(low, 7 - k));
        const uint32_t second = (uint32_t)_mm256_movemask_epi8(_mm256_slli_epi16(high, 7 - k));

        bit[k] = first | (uint64_t)second << 32;
    }
}

static uint64_t some_row(const uint8_t *bytes)
{
    const __m256i low = _mm256_cmpeq_epi8(load256(bytes), _mm256_setzero_si256());
    const __m256i high = _mm256_cmpeq_epi8(load256(bytes + 32), _mm256_setzero_si256());

    return ~((uint32_t)_mm256_movemask_epi8(low) | (uint64_t)(uint32_t)_mm256_movemask_epi8(high)
                                                       << 32);
}
