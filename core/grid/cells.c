/* The cell rule, a row at a time. */
#include "core/grid/cells.h"

#include <string.h>

/* Final edges of one row of cells: joined, and both ends alive. */
struct edge_row {
    uint8_t h[DX_TILE_CELLS], h_below[DX_TILE_CELLS], v[DX_TILE_CELLS + 1];
    uint8_t ac[DX_TILE_CELLS], bd[DX_TILE_CELLS];
};

static void final_edges(struct edge_row *e, const struct dx_area *a, uint32_t p)
{
    const uint8_t *top = a->alive[p] + DX_MARGIN, *bottom = a->alive[p + 1] + DX_MARGIN;
    const uint8_t *h = a->joined[DX_EDGE_H][p] + DX_MARGIN;
    const uint8_t *h_below = a->joined[DX_EDGE_H][p + 1] + DX_MARGIN;
    const uint8_t *v = a->joined[DX_EDGE_V][p] + DX_MARGIN;
    const uint8_t *ac = a->joined[DX_EDGE_AC][p] + DX_MARGIN;
    const uint8_t *bd = a->joined[DX_EDGE_BD][p] + DX_MARGIN;

    for (uint32_t j = 0; j < DX_TILE_CELLS; j++) {
        e->h[j] = h[j] & top[j] & top[j + 1];
        e->h_below[j] = h_below[j] & bottom[j] & bottom[j + 1];
        e->ac[j] = ac[j] & top[j] & bottom[j + 1];
        e->bd[j] = bd[j] & top[j + 1] & bottom[j];
    }
    for (uint32_t j = 0; j <= DX_TILE_CELLS; j++)
        e->v[j] = v[j] & top[j] & bottom[j];
}

static void code_row(uint8_t *code, const struct edge_row *e, const uint8_t *prefer_bd, uint32_t n)
{
    for (uint32_t j = 0; j < n; j++) {
        uint8_t ab = e->h[j], dc = e->h_below[j], ad = e->v[j], bc = e->v[j + 1];
        uint8_t t1 = ab & bc & e->ac[j], t2 = dc & ad & e->ac[j];
        uint8_t t3 = ab & ad & e->bd[j], t4 = bc & dc & e->bd[j];
        uint8_t n_ac = (uint8_t)(t1 + t2), n_bd = (uint8_t)(t3 + t4);
        uint8_t use_bd = (n_bd > n_ac) | ((n_bd == n_ac) & prefer_bd[j]);
        uint8_t on_ac = (uint8_t)(t1 + 2 * t2), on_bd = (uint8_t)(t3 + 2 * t4);

        /* enum dx_cell: 0..3 on a-c; 4..6 on b-d, where none is none */
        on_bd = (uint8_t)(on_bd + (on_bd ? 3 : 0));
        code[j] = use_bd ? on_bd : on_ac;
    }
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
    uint8_t prefer_bd[DX_AREA_STRIDE];
    struct edge_row e;

    memset(code, DX_CELL_NONE, DX_TILE_CELLS * DX_TILE_CELLS);
    dx_diagonal_begin(diagonal, a, gates, g);
    for (uint32_t i = 0; i < a->n_rows; i++) {
        const uint32_t p = DX_MARGIN + i;

        final_edges(&e, a, p);
        dx_diagonal_row(prefer_bd, diagonal, a, gates, g, p);
        code_row(code + (size_t)i * DX_TILE_CELLS, &e, prefer_bd + DX_MARGIN, a->n_cols);
        clear_folded(code + (size_t)i * DX_TILE_CELLS, gates,
                     (size_t)dx_area_row(a, p) * tiling->cell_cols +
                         dx_area_col(a, DX_MARGIN, g->width),
                     a->n_cols);
    }
}
