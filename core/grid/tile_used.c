/* From the codes of a tile to the dexels they use. */
#include "core/grid/tile_used.h"

#include "core/rows/rows.h"

#include <string.h>

static void mark_cells(struct dx_used *used, const struct dx_tile *tile)
{
    const struct dx_rows *rows = dx_rows_get(DX_SIMD_AUTO);

    for (uint32_t i = 0; i < tile->cell_rows; i++) {
        uint8_t *top = used->at + (size_t)(i + 1) * DX_BLOCK + 1;

        rows->use(top, top + DX_BLOCK, tile->code + (size_t)i * DX_TILE_CELLS);
    }
}

static void mark_strut(uint8_t *used, uint8_t code)
{
    struct dx_strut_corner triangle[DX_STRUT_MAX_TRIANGLES][3];
    const unsigned n = dx_strut_triangles(triangle, code);

    for (unsigned t = 0; t < n; t++)
        for (int m = 0; m < 3; m++)
            used[triangle[t][m].row * DX_BLOCK + triangle[t][m].col] = 1;
}

static void mark_struts(struct dx_used *used, const struct dx_tile *tile)
{
    for (uint32_t k = dx_tile_next_strut(tile, 0); k < DX_BLOCK_DEXELS;
         k = dx_tile_next_strut(tile, k + 1)) {
        uint8_t *at = used->at + k;
        struct dx_lone_strut s;

        if (dx_strut_is_lone(&s, tile->strut[k])) {
            const int along = s.across ? 1 : DX_BLOCK, beside = s.across ? DX_BLOCK : 1;

            at[-along] = at[along] = 1;
            at[-beside] |= s.first;
            at[beside] |= s.second;
        } else {
            mark_strut(at, tile->strut[k]);
        }
    }
}

void dx_used_mark(struct dx_used *used, const struct dx_tile *tile)
{
    memset(used, 0, sizeof(*used));
    mark_cells(used, tile);
    mark_struts(used, tile);
}

void dx_used_pack(const struct dx_used *used, uint8_t mask[DX_MASK_BYTES])
{
    for (uint32_t k = 0; k < DX_MASK_BYTES; k++) {
        const uint8_t *u = used->at + 8 * (size_t)k;

        mask[k] = (uint8_t)(u[0] | u[1] << 1 | u[2] << 2 | u[3] << 3 | u[4] << 4 | u[5] << 5 |
                            u[6] << 6 | u[7] << 7);
    }
}

uint32_t dx_used_rank(const struct dx_used *used, uint16_t rank[DX_USED_ROOM])
{
    return dx_rows_get(DX_SIMD_AUTO)->rank(rank, used->at, DX_USED_ROOM / 8);
}
