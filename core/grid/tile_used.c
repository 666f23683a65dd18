/* From the codes of a tile to the dexels they use. */
#include "core/grid/tile_used.h"

#include <string.h>

static void mark_cells(struct dx_used *used, const struct dx_tile *tile)
{
    for (uint32_t i = 0; i < tile->cell_rows; i++) {
        const uint8_t *code = tile->code + (size_t)i * DX_TILE_CELLS;
        uint8_t *top = used->at + (size_t)(i + 1) * DX_BLOCK + 1, *bottom = top + DX_BLOCK;
        uint8_t a[DX_TILE_CELLS], b[DX_TILE_CELLS], c[DX_TILE_CELLS], d[DX_TILE_CELLS];

        /* each corner is spared by exactly one outcome beside "none" */
        for (uint32_t j = 0; j < DX_TILE_CELLS; j++) {
            uint8_t some = code[j] != DX_CELL_NONE;

            a[j] = some & (code[j] != DX_CELL_BCD);
            b[j] = some & (code[j] != DX_CELL_ACD);
            c[j] = some & (code[j] != DX_CELL_ABD);
            d[j] = some & (code[j] != DX_CELL_ABC);
        }
        for (uint32_t j = 0; j < DX_TILE_CELLS; j++) {
            top[j] |= a[j];
            bottom[j] |= d[j];
        }
        for (uint32_t j = 0; j < DX_TILE_CELLS; j++) {
            top[j + 1] |= b[j];
            bottom[j + 1] |= c[j];
        }
    }
}

static void mark_struts(struct dx_used *used, const struct dx_tile *tile)
{
    for (uint32_t k = dx_tile_next_strut(tile, 0); k < DX_BLOCK_DEXELS;
         k = dx_tile_next_strut(tile, k + 1)) {
        struct dx_strut_corner triangle[DX_STRUT_MAX_TRIANGLES][3];
        unsigned n = dx_strut_triangles(triangle, tile->strut[k]);

        for (unsigned t = 0; t < n; t++)
            for (int m = 0; m < 3; m++)
                used->at[dx_tile_strut_corner(k, triangle[t][m])] = 1;
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

uint32_t dx_used_rank(const struct dx_used *used, uint16_t rank[DX_BLOCK_DEXELS])
{
    uint32_t n = 0;

    for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++) {
        rank[k] = (uint16_t)n;
        n += used->at[k];
    }
    return n;
}
