/* Gathering a tile's neighbourhood. */
#include "core/grid/area.h"

#include "core/grid/cap.h"

#include <string.h>

/* Columns of the area that follow each other in the grid: `n` of them, from area column `at` on. */
struct run {
    uint32_t at, n, col;
};

/* All of them: one where no border and no seam is near. */
struct runs {
    struct run run[DX_AREA];
    uint32_t n, n_columns;
};

/* Columns go around where the grid wraps, and end where it does not. */
static void find_runs(struct runs *runs, int64_t col0, bool wrap, uint32_t width)
{
    runs->n = runs->n_columns = 0;
    for (int64_t q = 0; q < DX_AREA;) {
        const int64_t col = wrap ? (col0 + q + width) % width : col0 + q;
        int64_t n = col < 0 ? -col : width - col;

        if (col >= width)
            break;
        n = n < DX_AREA - q ? n : DX_AREA - q;
        if (col >= 0) {
            runs->run[runs->n++] = (struct run){(uint32_t)q, (uint32_t)n, (uint32_t)col};
            runs->n_columns += (uint32_t)n;
        }
        q += n;
    }
}

/* A row of the grid; columns outside it are 0. */
static void gather_row(uint8_t *out, const uint8_t *row, size_t size, const struct runs *runs)
{
    if (runs->n_columns < DX_AREA)
        memset(out, 0, DX_AREA * size);
    for (const struct run *r = runs->run; r < runs->run + runs->n; r++)
        memcpy(out + r->at * size, row + r->col * size, r->n * size);
}

static bool in_grid(const struct dx_area *a, uint32_t p, uint32_t height)
{
    return a->row0 + p >= 0 && a->row0 + p < height;
}

static void gather_ranges(struct dx_area *a, const struct dx_plane *plane, const struct runs *runs)
{
    const size_t size = plane->range_bytes;

    for (uint32_t p = a->first; p < a->end; p++) {
        uint8_t *out = size == 4 ? (uint8_t *)a->range[p] : (uint8_t *)a->range16[p];
        const uint8_t *row = plane->range;

        if (in_grid(a, p, plane->height))
            gather_row(out, row + (size_t)dx_area_row(a, p) * plane->width * size, size, runs);
        else
            memset(out, 0, DX_AREA * size);
        for (uint32_t q = 0; a->wide && size == 2 && q < DX_AREA; q++)
            a->range[p][q] = a->range16[p][q];
    }
}

static void find_valid(struct dx_area *a, const struct dx_rows *rows)
{
    for (uint32_t p = a->first; p < a->end; p++)
        a->valid[p] = a->wide ? rows->valid_wide(a->range[p]) : rows->valid(a->range16[p]);
}

static void gather_constants(struct dx_area *a, const struct dx_gates *gates,
                             const struct dx_geometry *g, const struct runs *runs)
{
    for (int e = 0; e < DX_N_EDGES; e++)
        for (uint32_t p = a->first; p < a->end; p++) {
            if (!in_grid(a, p, g->height))
                continue;
            gather_row((uint8_t *)a->c[e][p],
                       (const uint8_t *)(gates->c[e] + (size_t)dx_area_row(a, p) * g->width), 4,
                       runs);
            for (uint32_t q = 0; !gates->wide && q < DX_AREA; q++)
                a->c16[e][p][q] = (uint16_t)a->c[e][p][q];
        }
}

void dx_area_gather(struct dx_area *a, const struct dx_plane *plane, const struct dx_tiling *tiling,
                    const struct dx_geometry *g, const struct dx_gates *gates, uint32_t tile_row,
                    uint32_t tile_col)
{
    uint32_t row = tile_row * DX_TILE_CELLS, col = tile_col * DX_TILE_CELLS;
    struct runs runs;

    a->row0 = (int64_t)row - DX_MARGIN;
    a->col0 = (int64_t)col - DX_MARGIN;
    a->n_rows = tiling->cell_rows - row < DX_TILE_CELLS ? tiling->cell_rows - row : DX_TILE_CELLS;
    a->n_cols = tiling->cell_cols - col < DX_TILE_CELLS ? tiling->cell_cols - col : DX_TILE_CELLS;
    a->first = DX_MARGIN - gates->margin;
    a->end = DX_MARGIN + a->n_rows + 1 + gates->margin;
    a->wide = gates->wide;
    find_runs(&runs, a->col0, g->wrap, g->width);
    gather_ranges(a, plane, &runs);
    find_valid(a, gates->rows);
    if (gates->per_dexel)
        gather_constants(a, gates, g, &runs);
    if (gates->cap)
        dx_cap_gather(a, g, gates);
}
