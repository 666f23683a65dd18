/*
 * From the codes of a tile to its triangles. Shared by the daemon's encoders and the client's
 * decoders, so that both get the same bits.
 */
#include "core/grid/tile_used.h"

void dx_tiling_init(struct dx_tiling *t, uint32_t height, uint32_t width, bool wrap)
{
    *t = (struct dx_tiling){.height = height, .width = width, .wrap = wrap};
    t->cell_rows = height ? height - 1 : 0;
    t->cell_cols = wrap || width == 0 ? width : width - 1;
    t->rows = (t->cell_rows + DX_TILE_CELLS - 1) / DX_TILE_CELLS;
    t->cols = (t->cell_cols + DX_TILE_CELLS - 1) / DX_TILE_CELLS;
}

uint32_t dx_tile_mask(const struct dx_tile *tile, uint8_t mask[DX_MASK_BYTES])
{
    struct dx_used used;

    dx_used_mark(&used, tile->code, tile->strut);
    dx_used_pack(&used, mask);
    return dx_used_count(&used);
}

static dx_packed_u16 *emit_cells(dx_packed_u16 *out, const struct dx_tile *tile,
                                 const struct dx_used *used, bool flip)
{
    const struct dx_rows *rows = dx_rows_get(DX_SIMD_AUTO);

    for (uint32_t i = 0; i < tile->cell_rows; i++) { /* codes beyond cell_cols are 0 */
        const struct dx_row_ranks ranks = {used->row[i + 1], used->row[i + 2], used->first[i + 1],
                                           used->first[i + 2]};

        out = rows->emit(out, tile->code + (size_t)i * DX_TILE_CELLS, &ranks, flip);
    }
    return out;
}

static dx_packed_u16 *emit_strut(dx_packed_u16 *out, const uint16_t *rank, uint8_t code, bool flip)
{
    struct dx_strut_corner triangle[DX_STRUT_MAX_TRIANGLES][3];
    const unsigned n = dx_strut_triangles(triangle, code);

    for (unsigned t = 0; t < n; t++)
        for (int m = 0; m < 3; m++) {
            const struct dx_strut_corner c = triangle[t][flip && m ? 3 - m : m];

            *out++ = rank[c.row * DX_BLOCK + c.col];
        }
    return out;
}

/* Both triangles are written, and kept if they are there. */
static dx_packed_u16 *emit_lone(dx_packed_u16 *out, const uint16_t *rank,
                                const struct dx_lone_strut *s, bool flip)
{
    const int along = s->across ? 1 : DX_BLOCK, beside = s->across ? DX_BLOCK : 1;
    const uint16_t begin = rank[-along], end = rank[along];
    const bool turn = s->across == flip; /* of the first side; the second runs the other way */

    out[0] = begin;
    out[1 + turn] = rank[s->first ? -beside : 0]; /* else it may lie outside the block */
    out[1 + !turn] = end;
    out += 3 * s->first;
    out[0] = begin;
    out[1 + !turn] = rank[s->second ? beside : 0];
    out[1 + turn] = end;
    return out + 3 * s->second;
}

static dx_packed_u16 *emit_struts(dx_packed_u16 *out, const struct dx_tile *tile,
                                  const struct dx_used *used, bool flip)
{
    uint16_t rank[DX_RANK_ROOM];

    dx_used_rank(used, rank);
    for (uint32_t i = 0; i < DX_BLOCK; i++)
        for (dx_bits row = used->strut[i]; row; row &= row - 1) {
            const uint32_t k = i * DX_BLOCK + dx_bits_first(row);
            struct dx_lone_strut s;

            if (dx_strut_is_lone(&s, tile->strut[k]))
                out = emit_lone(out, rank + k, &s, flip);
            else
                out = emit_strut(out, rank + k, tile->strut[k], flip);
        }
    return out;
}

uint32_t dx_tile_emit(const struct dx_tile *tile, const struct dx_used *used, bool flip,
                      dx_packed_u16 *index)
{
    dx_packed_u16 *out = emit_cells(index, tile, used, flip);

    if (used->has_struts)
        out = emit_struts(out, tile, used, flip);
    return (uint32_t)(out - index) / 3;
}
