/* Gathering a tile's neighbourhood. */
#include "core/grid/area.h"

#include "core/grid/cap.h"

#include <string.h>

/* Elements [col0, col0 + DX_AREA) of a row of the grid; columns go around where it wraps and are
 * zero beyond its ends where it does not. */
static void gather_row(uint8_t *out, const uint8_t *row, size_t size, int64_t col0, bool wrap,
                       uint32_t width)
{
    for (int64_t q = 0; q < DX_AREA;) {
        int64_t col = col0 + q, n = DX_AREA - q;

        if (wrap)
            col = (col + width) % width;
        if (col < 0) {
            n = n < -col ? n : -col;
            memset(out + (size_t)q * size, 0, (size_t)n * size);
        } else if (col >= width) {
            memset(out + (size_t)q * size, 0, (size_t)n * size);
        } else {
            n = n < width - col ? n : width - col;
            memcpy(out + (size_t)q * size, row + (size_t)col * size, (size_t)n * size);
        }
        q += n;
    }
}

static bool in_grid(const struct dx_area *a, uint32_t p, uint32_t height)
{
    return a->row0 + p >= 0 && a->row0 + p < height;
}

static void gather_ranges(struct dx_area *a, const struct dx_plane *plane, bool wrap)
{
    const size_t size = plane->range_bytes;

    for (uint32_t p = a->first; p < a->end; p++) {
        uint8_t *out = size == 4 ? (uint8_t *)a->range[p] : (uint8_t *)a->range16[p];
        const uint8_t *row = plane->range;

        if (in_grid(a, p, plane->height))
            gather_row(out, row + (size_t)dx_area_row(a, p) * plane->width * size, size, a->col0,
                       wrap, plane->width);
        else
            memset(out, 0, DX_AREA * size);
        for (uint32_t q = 0; a->wide && size == 2 && q < DX_AREA; q++)
            a->range[p][q] = a->range16[p][q];
    }
}

static void prepare_narrow(struct dx_area *a, const struct dx_gates *gates)
{
    const struct dx_rows *rows = gates->rows;

    for (uint32_t p = a->first; p < a->end; p++) {
        rows->valid(a->valid[p], a->range16[p]);
        rows->noise(a->noise[p], a->range16[p], (uint16_t)gates->t0, (uint16_t)gates->n2);
        if (gates->diag == DX_DIAG_BEND)
            rows->narrow.inverse(a->inverse.narrow[p], a->range16[p]);
    }
}

static void prepare_wide(struct dx_area *a, const struct dx_gates *gates)
{
    for (uint32_t p = a->first; p < a->end; p++) {
        for (uint32_t q = 0; q < DX_AREA; q++)
            a->valid[p][q] = a->range[p][q] != 0;
        if (gates->diag == DX_DIAG_BEND)
            gates->rows->wide.inverse(a->inverse.wide[p], a->range[p]);
    }
}

static void gather_constants(struct dx_area *a, const struct dx_gates *gates,
                             const struct dx_geometry *g)
{
    for (int e = 0; e < DX_N_EDGES; e++)
        for (uint32_t p = a->first; p < a->end; p++) {
            if (!in_grid(a, p, g->height))
                continue;
            gather_row((uint8_t *)a->c[e][p],
                       (const uint8_t *)(gates->c[e] + (size_t)dx_area_row(a, p) * g->width), 4,
                       a->col0, g->wrap, g->width);
            for (uint32_t q = 0; !gates->wide && q < DX_AREA; q++)
                a->c16[e][p][q] = (uint16_t)a->c[e][p][q];
        }
}

void dx_area_gather(struct dx_area *a, const struct dx_plane *plane, const struct dx_tiling *tiling,
                    const struct dx_geometry *g, const struct dx_gates *gates, uint32_t tile_row,
                    uint32_t tile_col)
{
    uint32_t row = tile_row * DX_TILE_CELLS, col = tile_col * DX_TILE_CELLS;

    a->row0 = (int64_t)row - DX_MARGIN;
    a->col0 = (int64_t)col - DX_MARGIN;
    a->n_rows = tiling->cell_rows - row < DX_TILE_CELLS ? tiling->cell_rows - row : DX_TILE_CELLS;
    a->n_cols = tiling->cell_cols - col < DX_TILE_CELLS ? tiling->cell_cols - col : DX_TILE_CELLS;
    a->first = DX_MARGIN - gates->margin;
    a->end = DX_MARGIN + a->n_rows + 1 + gates->margin;
    a->wide = gates->wide;
    gather_ranges(a, plane, g->wrap);
    if (gates->wide)
        prepare_wide(a, gates);
    else
        prepare_narrow(a, gates);
    if (gates->per_dexel)
        gather_constants(a, gates, g);
    if (gates->cap)
        dx_cap_gather(a, g, gates);
}
