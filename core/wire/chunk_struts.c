/*
 * The strut section of q16 and delta: u16 n_struts, then each in block order as the number of
 * dexels passed over and its code. Pure functions.
 */
#include "core/wire/chunk_parts.h"

#define PASS 255 /* so many dexels passed over, and no strut here */

uint8_t *dx_chunk_put_struts(uint8_t *p, const struct dx_tile *tile, const struct dx_used *used)
{
    uint8_t *count = p;
    uint32_t n = 0, next = 0;

    p += 2;
    for (uint32_t i = 0; used->has_struts && i < DX_BLOCK; i++)
        for (dx_bits row = used->strut[i]; row; row &= row - 1) {
            const uint32_t k = i * DX_BLOCK + dx_bits_first(row);

            for (; k - next >= PASS; next += PASS)
                *p++ = PASS;
            *p++ = (uint8_t)(k - next);
            *p++ = tile->strut[k];
            next = k + 1;
            n++;
        }
    dx_put_u16(count, (uint16_t)n);
    return p;
}

/* How many triangles the code makes at block dexel k; 0: it is no code, or the owner or a corner is
 * outside the block or the grid. */
static uint32_t check_strut(const struct dx_tile *tile, const struct dx_tiling *tiling, uint32_t k,
                            uint8_t code)
{
    const int p = (int)(k / DX_BLOCK), q = (int)(k % DX_BLOCK);
    struct dx_strut_corner triangle[DX_STRUT_MAX_TRIANGLES][3];
    unsigned n = dx_strut_triangles(triangle, code);

    if (!dx_chunk_in_grid(tiling, tile->row, tile->col, p, q))
        return 0;
    for (unsigned t = 0; t < n; t++)
        for (int m = 0; m < 3; m++)
            if (!dx_chunk_in_grid(tiling, tile->row, tile->col, p + triangle[t][m].row,
                                  q + triangle[t][m].col))
                return 0;
    return n;
}

const uint8_t *dx_chunk_get_struts(struct dx_tile *tile, const uint8_t *p, const uint8_t *end,
                                   const struct dx_tiling *tiling, uint32_t *n_triangles)
{
    struct dx_reader r = dx_reader_init(p, (size_t)(end - p));
    uint32_t k = 0;

    for (uint32_t left = dx_read_u16(&r); left && !r.failed;) {
        uint8_t skip = dx_read_u8(&r);
        uint32_t n;

        k += skip;
        if (k >= DX_BLOCK_DEXELS)
            return NULL;
        if (skip == PASS)
            continue;
        tile->strut[k] = dx_read_u8(&r);
        n = check_strut(tile, tiling, k, tile->strut[k]);
        if (n == 0)
            return NULL;
        *n_triangles += n;
        left--;
        k++;
    }
    return r.failed ? NULL : r.p;
}
