/* Gathering a tile's neighbourhood. */
#include "core/grid/area.h"

#include "core/grid/cap.h"
#include "core/grid/runs.h"

#include <string.h>

static bool in_grid(const struct dx_area *a, uint32_t p, uint32_t height)
{
    return a->row0 + p >= 0 && a->row0 + p < height;
}

static void gather_ranges(struct dx_area *a, const struct dx_plane *plane,
                          const struct dx_runs *runs)
{
    for (uint32_t p = a->first; p < a->end; p++) {
        const uint32_t *row = plane->range;

        if (in_grid(a, p, plane->height))
            dx_runs_gather(a->range[p], row + (size_t)dx_area_row(a, p) * plane->width,
                           sizeof(*row), runs, DX_AREA);
        else
            memset(a->range[p], 0, DX_AREA * sizeof(*row));
    }
}

/* Rows that lie in the array as a whole stay there. */
static void point_at_ranges(struct dx_area *a, const struct dx_plane *plane,
                            const struct dx_runs *runs)
{
    const bool together = a->col0 >= 0 && a->col0 + DX_AREA_STRIDE <= plane->width;
    static const uint16_t missing[DX_AREA_STRIDE];

    for (uint32_t p = 0; p <= DX_AREA; p++)
        a->range16[p] = missing;
    for (uint32_t p = a->first; p < a->end; p++) {
        const uint16_t *row = plane->range;

        if (!in_grid(a, p, plane->height))
            continue;
        row += (size_t)dx_area_row(a, p) * plane->width;
        if (!together)
            dx_runs_gather(a->copy16[p], row, sizeof(*row), runs, DX_AREA);
        a->range16[p] = together ? row + a->col0 : a->copy16[p];
        for (uint32_t q = 0; together && q < DX_AREA; q += 32) /* rows are far from each other */
            __builtin_prefetch(a->range16[p] + q);
    }
}

/* What the rules in force read: rows first to end, and as much beside the tile's columns. */
static void find_valid(struct dx_area *a, const struct dx_gates *gates)
{
    const dx_bits columns = dx_bits_below(DX_MARGIN + a->n_cols + 1 + gates->margin) &
                            ~dx_bits_below(DX_MARGIN - gates->margin);
    const struct dx_rows *rows = gates->rows;

    memset(&a->valid, 0, sizeof(a->valid));
    if (!a->wide)
        rows->valid_rows(&a->valid, a->range16, (struct dx_row_run){a->first, a->end}, columns);
    for (uint32_t p = a->first; a->wide && p < a->end; p++)
        dx_words_put(&a->valid, p, rows->valid_wide(a->range[p]) & columns);
}

static void gather_constants(struct dx_area *a, const struct dx_gates *gates,
                             const struct dx_geometry *g, const struct dx_runs *runs)
{
    for (int e = 0; e < DX_N_EDGES; e++)
        for (uint32_t p = a->first; p < a->end; p++) {
            if (!in_grid(a, p, g->height))
                continue;
            dx_runs_gather(a->c[e][p], gates->c[e] + (size_t)dx_area_row(a, p) * g->width,
                           sizeof(a->c[e][p][0]), runs, DX_AREA);
            for (uint32_t q = 0; !gates->wide && q < DX_AREA; q++)
                a->c16[e][p][q] = (uint16_t)a->c[e][p][q];
        }
}

void dx_area_gather(struct dx_area *a, const struct dx_plane *plane, const struct dx_tiling *tiling,
                    const struct dx_geometry *g, const struct dx_gates *gates, uint32_t tile_row,
                    uint32_t tile_col)
{
    uint32_t row = tile_row * DX_TILE_CELLS, col = tile_col * DX_TILE_CELLS;
    struct dx_runs runs;

    a->row0 = (int64_t)row - DX_MARGIN;
    a->col0 = (int64_t)col - DX_MARGIN;
    a->n_rows = tiling->cell_rows - row < DX_TILE_CELLS ? tiling->cell_rows - row : DX_TILE_CELLS;
    a->n_cols = tiling->cell_cols - col < DX_TILE_CELLS ? tiling->cell_cols - col : DX_TILE_CELLS;
    a->first = DX_MARGIN - gates->margin;
    a->end = DX_MARGIN + a->n_rows + 1 + gates->margin;
    a->wide = gates->wide;
    dx_runs_find(&runs, a->col0, DX_AREA, g->wrap, g->width);
    if (plane->range_bytes == 2)
        point_at_ranges(a, plane, &runs);
    else
        gather_ranges(a, plane, &runs);
    if (a->wide && plane->range_bytes == 2)
        dx_area_widen(a);
    find_valid(a, gates);
    if (gates->per_dexel)
        gather_constants(a, gates, g, &runs);
    if (gates->cap)
        dx_cap_gather(a, g, gates);
}
