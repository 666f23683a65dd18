/*
 * The way of a tile through terrain mode: its neighbourhood is gathered, neighbours are joined,
 * mixed pixels found, cells cut, drop-outs bridged. The scalar reference: the oracle of every
 * faster kernel. Reads the published array and the constants, writes its scratch and the outcome;
 * any number of tiles at once.
 *
 *   area -> edges (first order, rescue, cap) -> mixed -> cells (diagonal) -> struts
 */
#ifndef DX_RULES_H
#define DX_RULES_H

#include "core/grid/cells.h"
#include "core/grid/struts.h"

/* One per thread, zeroed when it is made. */
struct dx_rules_scratch {
    struct dx_area area;
    struct dx_cells cells;
    struct dx_spans spans;
};

/* The outcome of a tile: as in struct dx_tile. */
struct dx_outcome {
    uint32_t row, col; /* of the tile */
    uint8_t *code;     /* DX_TILE_CELLS^2 */
    uint8_t *strut;    /* DX_BLOCK_DEXELS */
    bool *has_struts;  /* whether any of those is not 0: before, and after */
};

/* Fills the codes and struts of `out`, whose row and col say which tile it is. */
void dx_rules_apply(const struct dx_outcome *out, struct dx_rules_scratch *scratch,
                    const struct dx_plane *plane, const struct dx_tiling *tiling,
                    const struct dx_geometry *g, const struct dx_gates *gates);

/* Whether the tile makes any triangle. */
bool dx_rules_any(const struct dx_tile *tile);

#endif
