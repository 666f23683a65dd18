/* The rules in their order. */
#include "core/grid/rules.h"

#include "core/grid/edges.h"
#include "core/grid/mixed.h"

#include <string.h>

void dx_rules_apply(const struct dx_outcome *out, struct dx_rules_scratch *s,
                    const struct dx_plane *plane, const struct dx_tiling *tiling,
                    const struct dx_geometry *g, const struct dx_gates *gates)
{
    dx_area_gather(&s->area, plane, tiling, g, gates, out->row, out->col);
    dx_edges_join(&s->area, gates, g);
    dx_mixed_find(&s->area, gates);
    dx_cells_decide(&s->cells, &s->area, gates, g, tiling);
    dx_cells_code(out->code, &s->cells, gates->rows);
    if (*out->has_struts) /* hardly ever: nothing to write */
        memset(out->strut, 0, DX_BLOCK_DEXELS);
    *out->has_struts = dx_struts_code(out->strut, &s->spans, &s->area, gates, g, tiling);
}

bool dx_rules_any(const struct dx_tile *tile)
{
    for (uint32_t i = 0; i < tile->cell_rows; i++) { /* nearly all tiles tell by their first row */
        uint8_t any = 0;

        for (uint32_t j = 0; j < DX_TILE_CELLS; j++)
            any |= tile->code[i * DX_TILE_CELLS + j];
        if (any)
            return true;
    }
    return dx_strut_next(tile->strut, 0) < DX_BLOCK_DEXELS;
}
