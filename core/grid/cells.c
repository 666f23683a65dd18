/* The cell rule: all rows at a time, but for the diagonals. */
#include "core/grid/cells.h"

/* Decides what is unsure and matters. */
static uint64_t settle(uint64_t prefer_bd, uint64_t unsure, const struct dx_area *a,
                       const struct dx_gates *gates, const struct dx_geometry *g, uint32_t p)
{
    for (; unsure; unsure &= unsure - 1) {
        const uint32_t j = (uint32_t)__builtin_ctzll(unsure);
        const uint64_t bd = dx_diagonal_decide(a, gates, g, p, DX_MARGIN + j);

        prefer_bd = (prefer_bd & ~(UINT64_C(1) << j)) | bd << j;
    }
    return prefer_bd;
}

/* Cells of the tile's row whose directions fold. */
static uint64_t find_folded(const struct dx_gates *gates, size_t cell0, uint32_t n)
{
    uint64_t folded = 0;

    for (uint32_t j = 0; j < n; j++)
        folded |= (gates->folded[(cell0 + j) / 64] >> ((cell0 + j) % 64) & 1) << j;
    return folded;
}

/* Which cells of row p prefer the diagonal b-d, as far as it matters. */
static uint64_t find_preferred(struct dx_diagonal *diagonal, const struct dx_area *a,
                               const struct dx_gates *gates, const struct dx_geometry *g,
                               uint64_t even, uint32_t p)
{
    const struct dx_row_preference row = dx_diagonal_row(diagonal, a, gates, g, p);

    return settle(row.bd, row.unsure & even, a, gates, g, p);
}

static void find_cells(uint64_t is_cell[DX_TILE_CELLS], const struct dx_area *a,
                       const struct dx_gates *gates, const struct dx_geometry *g,
                       const struct dx_tiling *tiling)
{
    const uint64_t own = (uint64_t)dx_bits_below(a->n_cols);

    for (uint32_t i = 0; i < DX_TILE_CELLS; i++)
        is_cell[i] = i < a->n_rows ? own : 0;
    for (uint32_t i = 0; gates->folded && i < a->n_rows; i++)
        is_cell[i] &= ~find_folded(gates,
                                   (size_t)dx_area_row(a, DX_MARGIN + i) * tiling->cell_cols +
                                       dx_area_col(a, DX_MARGIN, g->width),
                                   a->n_cols);
}

void dx_cells_decide(struct dx_cells *cells, const struct dx_area *a, const struct dx_gates *gates,
                     const struct dx_geometry *g, const struct dx_tiling *tiling)
{
    const struct dx_row_rules *rules = &gates->rows->rules;
    uint64_t is_cell[DX_TILE_CELLS], prefer_bd[DX_TILE_CELLS] = {0};
    struct dx_row_cells triangles;

    find_cells(is_cell, a, gates, g, tiling);
    rules->triangles(&triangles, a->edge, DX_MARGIN);
    dx_diagonal_begin(&cells->diagonal, a, gates, g);
    for (uint32_t i = 0; i < a->n_rows; i++)
        prefer_bd[i] = find_preferred(&cells->diagonal, a, gates, g, triangles.even[i] & is_cell[i],
                                      DX_MARGIN + i);
    rules->outcomes(cells->bit, &triangles, prefer_bd, is_cell);
}

void dx_cells_code(uint8_t code[DX_TILE_CELLS * DX_TILE_CELLS], const struct dx_cells *cells,
                   const struct dx_rows *rows)
{
    for (uint32_t i = 0; i < DX_TILE_CELLS; i++) {
        const uint64_t bit[3] = {cells->bit[0][i], cells->bit[1][i], cells->bit[2][i]};

        rows->code(code + (size_t)i * DX_TILE_CELLS, bit);
    }
}
