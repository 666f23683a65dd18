/* The cell rule, a row at a time. */
#include "core/grid/cells.h"

#include "core/base/bytes.h"

#include <string.h>

static struct dx_row_edges edges_of(const struct dx_area *a, uint32_t p)
{
    return (struct dx_row_edges){.h = a->joined[DX_EDGE_H][p] + DX_MARGIN,
                                 .h_below = a->joined[DX_EDGE_H][p + 1] + DX_MARGIN,
                                 .v = a->joined[DX_EDGE_V][p] + DX_MARGIN,
                                 .ac = a->joined[DX_EDGE_AC][p] + DX_MARGIN,
                                 .bd = a->joined[DX_EDGE_BD][p] + DX_MARGIN,
                                 .alive = a->alive[p] + DX_MARGIN,
                                 .alive_below = a->alive[p + 1] + DX_MARGIN};
}

/* Decides what is unsure and matters: cells whose diagonals would give as many triangles. Returns
 * whether there were any. */
static bool settle(struct dx_preference *preference, const uint8_t even[DX_ROWS_CELLS],
                   const struct dx_area *a, const struct dx_gates *gates,
                   const struct dx_geometry *g, uint32_t p)
{
    bool any = false;

    for (uint32_t j = 0; j < DX_ROWS_CELLS; j += 8) {
        uint64_t eight = dx_get_u64(even + j) & dx_get_u64(preference->unsure + j);

        for (; eight; eight &= eight - 1) {
            const uint32_t k = j + (uint32_t)__builtin_ctzll(eight) / 8;

            preference->bd[k] = dx_diagonal_decide(a, gates, g, p, DX_MARGIN + k);
            any = true;
        }
    }
    return any;
}

static void clear_folded(uint8_t *code, const struct dx_gates *gates, size_t cell0, uint32_t n)
{
    for (uint32_t j = 0; gates->folded && j < n; j++)
        if (gates->folded[(cell0 + j) / 64] >> ((cell0 + j) % 64) & 1)
            code[j] = DX_CELL_NONE;
}

void dx_cells_code(uint8_t code[DX_TILE_CELLS * DX_TILE_CELLS], struct dx_diagonal *diagonal,
                   const struct dx_area *a, const struct dx_gates *gates,
                   const struct dx_geometry *g, const struct dx_tiling *tiling)
{
    uint8_t even[DX_ROWS_CELLS];
    struct dx_preference preference;

    memset(code + a->n_rows * DX_TILE_CELLS, DX_CELL_NONE,
           (DX_TILE_CELLS - a->n_rows) * DX_TILE_CELLS);
    dx_diagonal_begin(diagonal, a, gates, g);
    for (uint32_t i = 0; i < a->n_rows; i++, code += DX_TILE_CELLS) {
        const uint32_t p = DX_MARGIN + i;
        const struct dx_row_edges edges = edges_of(a, p);

        dx_diagonal_row(&preference, diagonal, a, gates, g, p);
        gates->rows->code(code, even, &edges, preference.bd);
        if (settle(&preference, even, a, gates, g, p))
            gates->rows->code(code, even, &edges, preference.bd);
        memset(code + a->n_cols, DX_CELL_NONE, DX_TILE_CELLS - a->n_cols);
        clear_folded(code, gates,
                     (size_t)dx_area_row(a, p) * tiling->cell_cols +
                         dx_area_col(a, DX_MARGIN, g->width),
                     a->n_cols);
    }
}
