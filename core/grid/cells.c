/* The cell rule, a row at a time. */
#include "core/grid/cells.h"

#include <string.h>

/* Triangles that a row of cells can have. */
struct triangles {
    uint64_t abc, acd, abd, bcd;
};

static struct triangles triangles_of(const struct dx_area *a, uint32_t p)
{
    const uint64_t ab = dx_area_own(a->edge[DX_EDGE_H][p]);
    const uint64_t dc = dx_area_own(a->edge[DX_EDGE_H][p + 1]);
    const uint64_t ad = dx_area_own(a->edge[DX_EDGE_V][p]);
    const uint64_t bc = dx_area_own(a->edge[DX_EDGE_V][p] >> 1);
    const uint64_t ac = dx_area_own(a->edge[DX_EDGE_AC][p]);
    const uint64_t bd = dx_area_own(a->edge[DX_EDGE_BD][p]);

    return (struct triangles){ab & bc & ac, dc & ad & ac, ab & ad & bd, bc & dc & bd};
}

/* Cells both of whose diagonals would give as many triangles, and some. */
static uint64_t find_even(const struct triangles *t)
{
    const uint64_t two_ac = t->abc & t->acd, two_bd = t->abd & t->bcd;
    const uint64_t one_ac = t->abc ^ t->acd, one_bd = t->abd ^ t->bcd;

    return (two_ac & two_bd) | (one_ac & one_bd);
}

/* Cells that are cut from b to d: there are more triangles, or as many and b-d is preferred. */
static uint64_t find_on_bd(const struct triangles *t, uint64_t even, uint64_t prefer_bd)
{
    const uint64_t two_ac = t->abc & t->acd, some_ac = t->abc | t->acd;
    const uint64_t two_bd = t->abd & t->bcd, some_bd = t->abd | t->bcd;

    return (two_bd & ~two_ac) | (some_bd & ~some_ac) | (even & prefer_bd);
}

/* The three bits of enum dx_cell: abc + 2 acd, or on b-d three more than abd + 2 bcd. */
static void find_bits(uint64_t bit[3], const struct triangles *t, uint64_t on_bd)
{
    bit[0] = (~on_bd & t->abc) | (on_bd & ~t->abd);
    bit[1] = (~on_bd & t->acd) | (on_bd & t->abd & t->bcd);
    bit[2] = on_bd;
}

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

    for (uint32_t j = 0; gates->folded && j < n; j++)
        folded |= (gates->folded[(cell0 + j) / 64] >> ((cell0 + j) % 64) & 1) << j;
    return folded;
}

static void code_row(uint8_t *code, struct dx_diagonal *diagonal, const struct dx_area *a,
                     const struct dx_gates *gates, const struct dx_geometry *g, uint64_t is_cell,
                     uint32_t p)
{
    const struct dx_row_preference preference = dx_diagonal_row(diagonal, a, gates, g, p);
    struct triangles t = triangles_of(a, p);
    const uint64_t even = find_even(&t);
    const uint64_t prefer_bd =
        settle(preference.bd, preference.unsure & even & is_cell, a, gates, g, p);
    uint64_t bit[3];

    find_bits(bit, &t, find_on_bd(&t, even, prefer_bd));
    for (int k = 0; k < 3; k++)
        bit[k] &= is_cell;
    gates->rows->code(code, bit);
}

void dx_cells_code(uint8_t code[DX_TILE_CELLS * DX_TILE_CELLS], struct dx_diagonal *diagonal,
                   const struct dx_area *a, const struct dx_gates *gates,
                   const struct dx_geometry *g, const struct dx_tiling *tiling)
{
    const uint64_t own = (uint64_t)dx_bits_below(a->n_cols);

    memset(code + a->n_rows * DX_TILE_CELLS, DX_CELL_NONE,
           (DX_TILE_CELLS - a->n_rows) * DX_TILE_CELLS);
    dx_diagonal_begin(diagonal, a, gates, g);
    for (uint32_t i = 0; i < a->n_rows; i++) {
        const uint32_t p = DX_MARGIN + i;
        const size_t cell0 =
            (size_t)dx_area_row(a, p) * tiling->cell_cols + dx_area_col(a, DX_MARGIN, g->width);

        code_row(code + i * DX_TILE_CELLS, diagonal, a, gates, g,
                 own & ~find_folded(gates, cell0, a->n_cols), p);
    }
}
