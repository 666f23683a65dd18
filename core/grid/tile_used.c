/* From the codes of a tile to the dexels they use. */
#include "core/grid/tile_used.h"

#include "core/base/bytes.h"
#include "core/rows/rows.h"

#include <string.h>

void dx_used_add(struct dx_used *used, uint32_t k)
{
    used->row[k / DX_BLOCK] |= (dx_bits)1 << k % DX_BLOCK;
}

static void mark_strut(struct dx_used *used, uint32_t k, uint8_t code)
{
    struct dx_strut_corner triangle[DX_STRUT_MAX_TRIANGLES][3];
    const unsigned n = dx_strut_triangles(triangle, code);

    for (unsigned t = 0; t < n; t++)
        for (int m = 0; m < 3; m++)
            dx_used_add(used, dx_tile_strut_corner(k, triangle[t][m]));
}

/* Ends and sides; of dexels at the block's edge only those that are inside. */
static void mark_lone(struct dx_used *used, uint32_t k, struct dx_lone_strut s)
{
    const uint32_t i = k / DX_BLOCK, above = i - (i > 0), below = i + (i + 1 < DX_BLOCK);
    const dx_bits here = (dx_bits)1 << k % DX_BLOCK;

    used->row[above] |= (!s.across | s.first) ? here : 0;
    used->row[i] |= (s.across | s.first) ? here >> 1 : 0;
    used->row[i] |= (s.across | s.second) ? here << 1 : 0;
    used->row[below] |= (!s.across | s.second) ? here : 0;
}

/* Most tiles have none. */
static bool has_struts(const uint8_t *strut)
{
    uint8_t some = 0;

    for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++)
        some |= strut[k];
    return some;
}

static void mark_struts(struct dx_used *used, const uint8_t *strut)
{
    const struct dx_rows *rows = dx_rows_get(DX_SIMD_AUTO);

    memset(used->strut, 0, sizeof(used->strut));
    for (uint32_t i = 0; used->has_struts && i < DX_BLOCK; i++) {
        const uint8_t *row = strut + i * DX_BLOCK;
        dx_bits owners = rows->some(row);

        for (uint32_t j = 64; j < DX_BLOCK; j++)
            owners |= (dx_bits)(row[j] != 0) << j;
        used->strut[i] = owners;
        for (; owners; owners &= owners - 1) {
            const uint32_t j = dx_bits_first(owners), k = i * DX_BLOCK + j;
            struct dx_lone_strut s;

            if (dx_strut_is_lone(&s, row[j]))
                mark_lone(used, k, s);
            else
                mark_strut(used, k, row[j]);
        }
    }
}

void dx_used_number(struct dx_used *used)
{
    dx_rows_get(DX_SIMD_AUTO)->count(used->first, used->row, DX_BLOCK);
}

void dx_used_of(struct dx_used *used, const uint64_t bit[3][DX_TILE_CELLS], const uint8_t *strut)
{
    dx_rows_get(DX_SIMD_AUTO)->rules.corners(used->row, bit);
    used->has_struts = strut && has_struts(strut);
    mark_struts(used, strut);
    dx_used_number(used);
}

void dx_used_bits(uint64_t bit[3][DX_TILE_CELLS], const uint8_t *code)
{
    const struct dx_rows *rows = dx_rows_get(DX_SIMD_AUTO);

    for (uint32_t i = 0; i < DX_TILE_CELLS; i++) {
        uint64_t row[3];

        rows->bits(row, code + (size_t)i * DX_TILE_CELLS);
        for (int k = 0; k < 3; k++)
            bit[k][i] = row[k];
    }
}

void dx_used_mark(struct dx_used *used, const uint8_t *code, const uint8_t *strut)
{
    uint64_t bit[3][DX_TILE_CELLS];

    dx_used_bits(bit, code);
    dx_used_of(used, bit, strut);
}

void dx_used_rank(const struct dx_used *used, uint16_t rank[DX_RANK_ROOM])
{
    const struct dx_rows *rows = dx_rows_get(DX_SIMD_AUTO);

    for (uint32_t i = 0; i < DX_BLOCK; i++) /* what one row writes too much the next one mends */
        rows->rank(rank + (size_t)i * DX_BLOCK, used->row[i], used->first[i]);
}

/* Rows of 67 bits one after the other: whole words as they fill. */
void dx_used_pack(const struct dx_used *used, uint8_t mask[DX_MASK_BYTES])
{
    uint64_t word[DX_BLOCK_DEXELS / 64 + 2] = {0};

    for (uint32_t i = 0; i < DX_BLOCK; i++) {
        const uint32_t at = i * DX_BLOCK;
        const dx_bits bits = used->row[i] << at % 64; /* 67 and 63 do not fit */
        const uint64_t rest = at % 64 > 61 ? (uint64_t)(used->row[i] >> (128 - at % 64)) : 0;

        word[at / 64] |= (uint64_t)bits;
        word[at / 64 + 1] |= (uint64_t)(bits >> 64);
        word[at / 64 + 2] |= rest;
    }
    for (uint32_t k = 0; k < DX_MASK_BYTES / 8; k++)
        dx_put_u64(mask + 8 * (size_t)k, word[k]);
    for (uint32_t k = DX_MASK_BYTES / 8 * 8; k < DX_MASK_BYTES; k++)
        mask[k] = (uint8_t)(word[k / 8] >> 8 * (k % 8));
}
