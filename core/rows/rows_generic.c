/* The loops for every processor of the kind that is built for. */
#include "core/rows/rows_priv.h"

#include "core/base/bytes.h"

#include <assert.h>
#include <math.h>

/* ---- rows to bits --------------------------------------------------------------------------- */

/* Bytes of 0 or 1, a multiple of eight of them. A product puts the lowest bits of eight bytes side
 * by side. */
static inline dx_bits pack_bytes(const uint8_t *is, uint32_t n)
{
    uint64_t word[2] = {0, 0};

    assert(n % 8 == 0);
    for (uint32_t at = 0; at < n; at += 8)
        word[at / 64] |= dx_get_u64(is + at) * 0x0102040810204080u >> 56 << at % 64;
    return word[0] | (dx_bits)word[1] << 64;
}

/* All ones or none, DX_ROWS_N of them, to bits. */
static inline dx_bits pack16(const uint16_t is[DX_ROWS_N])
{
    uint8_t byte[DX_ROWS_N];

    for (uint32_t q = 0; q < DX_ROWS_N; q++)
        byte[q] = is[q] & 1;
    return pack_bytes(byte, DX_ROWS_N);
}

/* The same; n is DX_ROWS_N or DX_ROWS_CELLS. */
static inline dx_bits pack32(const uint32_t *is, uint32_t n)
{
    uint8_t byte[DX_ROWS_N];

    for (uint32_t q = 0; q < n; q++)
        byte[q] = is[q] & 1;
    return pack_bytes(byte, n);
}

/* Bits to lanes of all ones or none, DX_ROWS_N of them: each keeps another bit of 16. */
static inline void unpack16(uint16_t out[DX_ROWS_N], dx_bits is)
{
    static const uint16_t bit[16] = {1,     2,     4,     8,     0x10,   0x20,   0x40,   0x80,
                                     0x100, 0x200, 0x400, 0x800, 0x1000, 0x2000, 0x4000, 0x8000};

    for (uint32_t at = 0; at < DX_ROWS_N; at += 16) {
        const uint16_t lanes = (uint16_t)(is >> at);

        for (uint32_t j = 0; j < 16; j++)
            out[at + j] = (lanes & bit[j]) == bit[j] ? UINT16_MAX : 0;
    }
}

/* 16-bit values where they are used, and 0 elsewhere. */
static inline void keep_used16(uint16_t out[DX_ROWS_N], const uint16_t *value, dx_bits used)
{
    unpack16(out, used);
    for (uint32_t q = 0; q < DX_ROWS_N; q++)
        out[q] &= value[q];
}

static inline void unpack32(uint32_t out[DX_ROWS_N], dx_bits is)
{
    static const uint32_t bit[4] = {1, 2, 4, 8};

    for (uint32_t at = 0; at < DX_ROWS_N; at += 4) {
        const uint32_t lanes = (uint32_t)(is >> at);

        for (uint32_t j = 0; j < 4; j++)
            out[at + j] = (lanes & bit[j]) == bit[j] ? UINT32_MAX : 0;
    }
}

/* Of a row of cells: which numbers are positive, and which are not beyond the margin, or none. */
static struct dx_row_preference tell_f32(const float *more, const float *margin)
{
    uint32_t prefers[DX_ROWS_CELLS], sure[DX_ROWS_CELLS];

    for (uint32_t j = 0; j < DX_ROWS_CELLS; j++) {
        prefers[j] = more[j] > 0 ? UINT32_MAX : 0;
        sure[j] = fabsf(more[j]) > margin[j] ? UINT32_MAX : 0;
    }
    return (struct dx_row_preference){(uint64_t)pack32(prefers, DX_ROWS_CELLS),
                                      (uint64_t)~pack32(sure, DX_ROWS_CELLS)};
}

static void code_row(uint8_t *code, const uint64_t bit[3])
{
    for (uint32_t j = 0; j < DX_ROWS_CELLS; j += 8)
        dx_put_u64(code + j, dx_bits_spread8(bit[0] >> j) | dx_bits_spread8(bit[1] >> j) << 1 |
                                 dx_bits_spread8(bit[2] >> j) << 2);
}

static void bits_row(uint64_t bit[3], const uint8_t *code)
{
    for (int k = 0; k < 3; k++) {
        uint8_t is[DX_ROWS_CELLS];

        for (uint32_t j = 0; j < DX_ROWS_CELLS; j++)
            is[j] = code[j] >> k & 1;
        bit[k] = (uint64_t)pack_bytes(is, DX_ROWS_CELLS);
    }
}

static uint64_t some_row(const uint8_t *bytes)
{
    uint8_t is[64];

    for (uint32_t j = 0; j < 64; j++)
        is[j] = bytes[j] != 0;
    return (uint64_t)pack_bytes(is, 64);
}

/* ---- tiles ---------------------------------------------------------------------------------- */

/* The eight bytes of `before`, the least significant first, each plus n. */
static inline void put_ranks(uint16_t *out, uint64_t before, uint32_t n)
{
    for (int k = 0; k < 8; k++)
        out[k] = (uint16_t)(n + (before >> 8 * k & 0xff));
}

/* Eight points. */
static inline void put_points(dx_packed_f32 *restrict out, const float *x, const float *y,
                              const float *z)
{
    for (int k = 0; k < 8; k++) {
        out[3 * k] = x[k];
        out[3 * k + 1] = y[k];
        out[3 * k + 2] = z[k];
    }
}

/* At least six indices, two bytes each, of the corners a, b, d, c: those that `bytes` names
 * (rows_eights.h). */
static inline void put_corners(dx_packed_u16 *out, const uint16_t *top, const uint16_t *bottom,
                               const uint8_t bytes[16])
{
    const uint16_t corner[4] = {top[0], top[1], bottom[0], bottom[1]};

    for (int m = 0; m < 6; m++)
        out[m] = corner[bytes[2 * m] / 2];
}

/* Eight full cells whose corners a and d have ranks from a and d on; bit 8 k of on_bd: cell k is
 * cut from b to d. Triangles a, b, c or d and a or b, c, d; flipped, their last two change places.
 */
static inline void put_full(dx_packed_u16 *restrict out, uint64_t on_bd, uint16_t a, uint16_t d,
                            bool flip)
{
    for (int k = 0; k < 8; k++, out += 6) {
        const unsigned bd = on_bd >> 8 * k & 1, top = a + (unsigned)k, bottom = d + (unsigned)k;

        out[0] = (uint16_t)top;
        out[1 + flip] = (uint16_t)(top + 1);
        out[2 - flip] = (uint16_t)(bottom + 1 - bd);
        out[3] = (uint16_t)(top + bd);
        out[4 + flip] = (uint16_t)(bottom + 1);
        out[5 - flip] = (uint16_t)bottom;
    }
}

#include "core/rows/rows_eights.h"
#include "core/rows/rows_table.h"

const struct dx_rows dx_rows_generic = DX_ROWS_TABLE("generic");
