/* Rectangles of dexels to tiles. */
#include "core/grid/marks.h"

/* Where the dexels of tile row or column `n` of `n_tiles` end: the last ones take the rest. */
static uint32_t part_end(uint32_t n, uint32_t n_tiles, uint32_t side)
{
    return n + 1 < n_tiles ? (n + 1) * DX_TILE_CELLS : side;
}

struct dx_rect dx_marks_part(const struct dx_tiling *g, uint32_t tile)
{
    const uint32_t row = tile / g->cols, col = tile % g->cols;

    return (struct dx_rect){.row0 = row * DX_TILE_CELLS,
                            .row1 = part_end(row, g->rows, g->height) - 1,
                            .col0 = col * DX_TILE_CELLS,
                            .col1 = part_end(col, g->cols, g->width) - 1};
}

static void set(uint64_t *marks, uint32_t n)
{
    marks[n / 64] |= 1ull << (n % 64);
}

static uint32_t clamped(int64_t v, uint32_t n)
{
    return v < 0 ? 0 : v < n ? (uint32_t)v : n - 1;
}

void dx_marks_set(uint64_t *marks, const struct dx_tiling *g, const struct dx_rect *dexels,
                  uint32_t before, uint32_t after)
{
    const uint32_t i0 = clamped((int64_t)dexels->row0 - before, g->cell_rows);
    const uint32_t i1 = clamped((int64_t)dexels->row1 + after, g->cell_rows);
    int64_t j0 = (int64_t)dexels->col0 - before, j1 = (int64_t)dexels->col1 + after;

    if (!g->wrap) {
        j0 = clamped(j0, g->cell_cols);
        j1 = clamped(j1, g->cell_cols);
    }
    for (uint32_t ti = i0 / DX_TILE_CELLS; ti <= i1 / DX_TILE_CELLS; ti++)
        for (int64_t j = j0; j <= j1;) {
            uint32_t col = (uint32_t)((j + 2 * (int64_t)g->cell_cols) % g->cell_cols);
            uint32_t tj = col / DX_TILE_CELLS, end = (tj + 1) * DX_TILE_CELLS;

            set(marks, ti * g->cols + tj);
            j += (end < g->cell_cols ? end : g->cell_cols) - col;
        }
}

void dx_marks_set_all(uint64_t *marks, const struct dx_tiling *g)
{
    for (uint32_t k = 0; k < dx_tiling_n_tiles(g); k++)
        set(marks, k);
}
