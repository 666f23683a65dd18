/* The stores of rows_generic.c by the shuffles of AVX2, which compilers do not find. */
#include <immintrin.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

static inline void put_ranks(uint16_t *out, uint64_t before, uint32_t n)
{
    const __m128i wide = _mm_cvtepu8_epi16(_mm_cvtsi64_si128((long long)before));

    _mm_storeu_si128((__m128i *)out, _mm_add_epi16(wide, _mm_set1_epi16((short)n)));
}

/* Every third lane of each store is of one coordinate: turned once, it is where all three want it.
 */
static inline void put_points(dx_packed_f32 *restrict out, const float *x, const float *y,
                              const float *z)
{
    const __m256i turn_x = _mm256_setr_epi32(0, 3, 6, 1, 4, 7, 2, 5);
    const __m256i turn_y = _mm256_setr_epi32(5, 0, 3, 6, 1, 4, 7, 2);
    const __m256i turn_z = _mm256_setr_epi32(2, 5, 0, 3, 6, 1, 4, 7);
    const __m256 px = _mm256_permutevar8x32_ps(_mm256_loadu_ps(x), turn_x);
    const __m256 py = _mm256_permutevar8x32_ps(_mm256_loadu_ps(y), turn_y);
    const __m256 pz = _mm256_permutevar8x32_ps(_mm256_loadu_ps(z), turn_z);
    float *to = (float *)out; /* not aligned: a store that need not be */

    _mm256_storeu_ps(to, _mm256_blend_ps(_mm256_blend_ps(px, py, 0x92), pz, 0x24));
    _mm256_storeu_ps(to + 8, _mm256_blend_ps(_mm256_blend_ps(px, py, 0x24), pz, 0x49));
    _mm256_storeu_ps(to + 16, _mm256_blend_ps(_mm256_blend_ps(px, py, 0x49), pz, 0x92));
}

static inline void put_corners(dx_packed_u16 *out, const uint16_t *top, const uint16_t *bottom,
                               const uint8_t bytes[16])
{
    uint32_t ab, dc;
    __m128i corners;

    memcpy(&ab, top, sizeof(ab));
    memcpy(&dc, bottom, sizeof(dc));
    corners = _mm_cvtsi64_si128((long long)(ab | (uint64_t)dc << 32));
    corners = _mm_shuffle_epi8(corners, _mm_loadu_si128((const __m128i *)bytes));
    _mm_storeu_si128((__m128i *)out, corners);
}

/* Of 48 indices: which cell's diagonal byte each lane takes, what a diagonal b-d adds, where it
 * lies along the row, and whether below. */
struct full_lanes {
    int8_t cell[96];
    int16_t sign[48], along[48], below[48];
};

#define LANE_BYTES(k) (k), -1, (k), -1, (k), -1, (k), -1, (k), -1, (k), -1
#define EIGHT(f)                                                                                   \
    {                                                                                              \
        f(0), f(1), f(2), f(3), f(4), f(5), f(6), f(7)                                             \
    }
#define SIGN(k)       0, 0, -1, 1, 0, 0
#define SIGN_FLIP(k)  0, -1, 0, 1, 0, 0
#define ALONG(k)      (k), (k) + 1, (k) + 1, (k), (k) + 1, (k)
#define ALONG_FLIP(k) (k), (k) + 1, (k) + 1, (k), (k), (k) + 1
#define BELOW(k)      0, 0, -1, 0, -1, -1
#define BELOW_FLIP(k) 0, -1, 0, 0, -1, -1

static const struct full_lanes full_lanes[2] = {
    {EIGHT(LANE_BYTES), EIGHT(SIGN), EIGHT(ALONG), EIGHT(BELOW)},
    {EIGHT(LANE_BYTES), EIGHT(SIGN_FLIP), EIGHT(ALONG_FLIP), EIGHT(BELOW_FLIP)},
};

static inline __m256i load_lanes(const void *p)
{
    return _mm256_loadu_si256((const __m256i *)p);
}

static inline void put_full(dx_packed_u16 *restrict out, uint64_t on_bd, uint16_t a, uint16_t d,
                            bool flip)
{
    const struct full_lanes *l = &full_lanes[flip];
    const __m256i cells = _mm256_set1_epi64x((long long)on_bd);
    const __m256i top = _mm256_set1_epi16((short)a), bottom = _mm256_set1_epi16((short)d);

    for (int k = 0; k < 48; k += 16) {
        __m256i bd = _mm256_shuffle_epi8(cells, load_lanes(l->cell + 2 * k));
        __m256i from = _mm256_blendv_epi8(top, bottom, load_lanes(l->below + k));

        bd = _mm256_sign_epi16(bd, load_lanes(l->sign + k));
        from = _mm256_add_epi16(from, load_lanes(l->along + k));
        _mm256_storeu_si256((__m256i *)(out + k), _mm256_add_epi16(from, bd));
    }
}
