/*
 * The loops of rows.h that keep what is used and leave out the rest, by AVX-512: what is used moves
 * to the front of its vector, however much it is, so that drop-outs cost nothing. Included by
 * rows_avx512.c in place of rows_eights.h.
 */
#include "core/rows/rows_tiles.h"

#include <immintrin.h>

/* ---- points --------------------------------------------------------------------------------- */

/* Where the three coordinates of 16 points go: of each store's 16 lanes, which lane of x or of y
 * (16 and more), and which lanes are z, in their order. */
static const int32_t points_xy[3][16] = {
    {0, 16, 0, 1, 17, 0, 2, 18, 0, 3, 19, 0, 4, 20, 0, 5},
    {21, 0, 6, 22, 0, 7, 23, 0, 8, 24, 0, 9, 25, 0, 10, 26},
    {0, 11, 27, 0, 12, 28, 0, 13, 29, 0, 14, 30, 0, 15, 31, 0},
};
static const int32_t points_z[3][16] = {
    {0, 0, 0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0, 4, 0},
    {0, 5, 0, 0, 6, 0, 0, 7, 0, 0, 8, 0, 0, 9, 0, 0},
    {10, 0, 0, 11, 0, 0, 12, 0, 0, 13, 0, 0, 14, 0, 0, 15},
};
static const __mmask16 points_are_z[3] = {0x4924, 0x2492, 0x9249};

static inline void put_points(dx_packed_f32 *out, __m512 x, __m512 y, __m512 z)
{
    for (int k = 0; k < 3; k++) {
        const __m512 xy = _mm512_permutex2var_ps(x, _mm512_loadu_si512(points_xy[k]), y);
        const __m512i from_z = _mm512_loadu_si512(points_z[k]);

        _mm512_storeu_ps(out + 16 * k, _mm512_mask_permutexvar_ps(xy, points_are_z[k], from_z, z));
    }
}

static dx_packed_f32 *spin_row(dx_packed_f32 *out, const struct dx_row_spin *spin,
                               const uint32_t *range, dx_bits used)
{
    float x[DX_ROWS_N], y[DX_ROWS_N], z[DX_ROWS_N];

    spin_points(x, y, z, spin, range);
    for (int j = 0; j < DX_ROWS_N; j += 16) {
        const __mmask16 some = (__mmask16)(used >> j);

        put_points(out, _mm512_maskz_compress_ps(some, _mm512_loadu_ps(x + j)),
                   _mm512_maskz_compress_ps(some, _mm512_loadu_ps(y + j)),
                   _mm512_maskz_compress_ps(some, _mm512_loadu_ps(z + j)));
        out += 3 * __builtin_popcount(some);
    }
    return out;
}

/* ---- values --------------------------------------------------------------------------------- */

static uint32_t *keep_row(uint32_t *out, const uint32_t *v, dx_bits used)
{
    for (int j = 0; j < DX_ROWS_N; j += 16) {
        const __mmask16 some = (__mmask16)(used >> j);

        _mm512_storeu_si512(out, _mm512_maskz_compress_epi32(some, _mm512_loadu_si512(v + j)));
        out += __builtin_popcount(some);
    }
    return out;
}

static uint16_t *keep16_row(uint16_t *out, const uint32_t *v, dx_bits used)
{
    for (int j = 0; j < DX_ROWS_N; j += 16) {
        const __mmask16 some = (__mmask16)(used >> j);
        const __m256i narrow = _mm512_cvtepi32_epi16(_mm512_loadu_si512(v + j));

        _mm256_storeu_si256((__m256i *)out, _mm256_maskz_compress_epi16(some, narrow));
        out += __builtin_popcount(some);
    }
    return out;
}

/* ---- triangles ------------------------------------------------------------------------------ */

/* What outcomes are made of (enum dx_cell): the first triangle (abc, abd), the second (acd, bcd),
 * and whether they are cut from b to d. */
enum { FIRST = 1, SECOND = 2, ON_BD = 4 };

#define OUTCOMES                                                                                   \
    {                                                                                              \
        0, FIRST, SECOND, FIRST | SECOND, FIRST | ON_BD, SECOND | ON_BD, FIRST | SECOND | ON_BD    \
    }

/* Of the 96 indices of 16 cells: whose they are, as a byte (and 0 from 128 on); which triangle's;
 * and which rank they are, of 32 above and 32 below, where the cell is cut from a to c or from b to
 * d. */
struct index_lanes {
    int8_t cell[192];
    int16_t triangle[96], ac[96], bd[96];
};

#define SIXTEEN(f)                                                                                 \
    {                                                                                              \
        f(0), f(1), f(2), f(3), f(4), f(5), f(6), f(7), f(8), f(9), f(10), f(11), f(12), f(13),    \
            f(14), f(15)                                                                           \
    }
#define CELL(k)            (k), -1, (k), -1, (k), -1, (k), -1, (k), -1, (k), -1
#define TRIANGLE(k)        FIRST, FIRST, FIRST, SECOND, SECOND, SECOND
#define CORNERS_AC(k)      (k), (k) + 1, (k) + 33, (k), (k) + 33, (k) + 32
#define CORNERS_BD(k)      (k), (k) + 1, (k) + 32, (k) + 1, (k) + 33, (k) + 32
#define CORNERS_AC_FLIP(k) (k), (k) + 33, (k) + 1, (k), (k) + 32, (k) + 33
#define CORNERS_BD_FLIP(k) (k), (k) + 32, (k) + 1, (k) + 1, (k) + 32, (k) + 33

static const struct index_lanes index_lanes[2] = {
    {SIXTEEN(CELL), SIXTEEN(TRIANGLE), SIXTEEN(CORNERS_AC), SIXTEEN(CORNERS_BD)},
    {SIXTEEN(CELL), SIXTEEN(TRIANGLE), SIXTEEN(CORNERS_AC_FLIP), SIXTEEN(CORNERS_BD_FLIP)},
};

/* Ranks of 32 dexels, the first of which has rank n: whole numbers where one is used. */
static inline __m512i ranks_of(uint32_t used, uint32_t n)
{
    static const uint16_t numbers[32] = {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10,
                                         11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21,
                                         22, 23, 24, 25, 26, 27, 28, 29, 30, 31};
    const __m512i from_n =
        _mm512_add_epi16(_mm512_loadu_si512(numbers), _mm512_set1_epi16((short)n));

    return _mm512_maskz_expand_epi16(used, from_n);
}

static void rank_row(uint16_t *rank, dx_bits used, uint16_t first)
{
    const uint64_t low = (uint64_t)used;
    uint32_t n = first;

    _mm512_storeu_si512(rank, ranks_of((uint32_t)low, n));
    n += (uint32_t)__builtin_popcount((uint32_t)low);
    _mm512_storeu_si512(rank + 32, ranks_of((uint32_t)(low >> 32), n));
    n += (uint32_t)__builtin_popcount((uint32_t)(low >> 32));
    _mm256_storeu_si256((__m256i *)(rank + 64),
                        _mm512_castsi512_si256(ranks_of((uint32_t)(used >> 64), n)));
}

/* Sixteen cells: of 32 ranks above and below, the first 17. */
static inline dx_packed_u16 *emit_sixteen(dx_packed_u16 *out, const uint8_t *code, __m512i top,
                                          __m512i bottom, const struct index_lanes *l)
{
    static const uint8_t outcomes[16] = OUTCOMES;
    const __m128i codes = _mm_loadu_si128((const __m128i *)code);
    const __m128i outcome = _mm_shuffle_epi8(_mm_loadu_si128((const __m128i *)outcomes), codes);
    const __m512i all = _mm512_broadcast_i32x4(outcome);

    for (int k = 0; k < 96; k += 32) {
        const __m512i is = _mm512_shuffle_epi8(all, _mm512_loadu_si512(l->cell + 2 * k));
        const __mmask32 on_bd = _mm512_test_epi16_mask(is, _mm512_set1_epi16(ON_BD));
        const __mmask32 kept = _mm512_test_epi16_mask(is, _mm512_loadu_si512(l->triangle + k));
        const __m512i ac = _mm512_loadu_si512(l->ac + k);
        const __m512i corner = _mm512_mask_loadu_epi16(ac, on_bd, l->bd + k);
        const __m512i rank = _mm512_permutex2var_epi16(top, corner, bottom);

        _mm512_storeu_si512(out, _mm512_maskz_compress_epi16(kept, rank));
        out += __builtin_popcount(kept);
    }
    return out;
}

/* No branch on what a cell is: noise makes the diagonals a coin toss, and drop-outs the rest. */
static dx_packed_u16 *emit_row(dx_packed_u16 *out, const uint8_t *code,
                               const struct dx_row_ranks *ranks, bool flip)
{
    uint32_t a = ranks->first_top + (uint32_t)(ranks->top & 1);
    uint32_t d = ranks->first_bottom + (uint32_t)(ranks->bottom & 1);

    for (int j = 0; j < DX_ROWS_CELLS; j += 16) {
        const uint32_t top = (uint32_t)(ranks->top >> (j + 1));
        const uint32_t bottom = (uint32_t)(ranks->bottom >> (j + 1));

        out =
            emit_sixteen(out, code + j, ranks_of(top, a), ranks_of(bottom, d), &index_lanes[flip]);
        a += (uint32_t)__builtin_popcount(top & 0xffff);
        d += (uint32_t)__builtin_popcount(bottom & 0xffff);
    }
    return out;
}
