/*
 * The edge rule's constants in integers, made once for a geometry and its parameters
 * (ALGORITHMS 1.3 and 1.10): a pair of adjacent dexels with ranges x >= m is joined when x - m <=
 * t0 + (m * c >> 16) + ((m * m >> 16) * n2 >> 16) with c by place and edge type. Immutable after
 * init; read by all tile tasks.
 */
#ifndef DX_GATES_H
#define DX_GATES_H

#include "core/grid/terrain.h"

/* Edges of cell (i,j): H from a to b, V from a to d, AC, BD. */
enum dx_edge { DX_EDGE_H, DX_EDGE_V, DX_EDGE_AC, DX_EDGE_BD, DX_N_EDGES };

struct dx_gates {
    bool first_order; /* false in the paper's mode: the cap decides alone */
    bool wide;        /* 64-bit arithmetic: 32-bit ranges, or a term that can exceed 65535 */
    uint32_t t0;
    uint64_t n2;
    uint64_t cap; /* longest edge, units * 2^12; 0 = no cap */
    /*
     * c of each edge. Even grids: one value a row, c[e][i]. Uneven ones (per_dexel): c[e][i * width
     * + j]. Edges that are not there have 0.
     */
    bool per_dexel;
    uint32_t *c[DX_N_EDGES];
    uint64_t *folded; /* bit per cell i * cell_cols + j whose directions fold; NULL when none can */
};

/* Allocates, and finds the folded cells. Errors: -ENOMEM. */
int dx_gates_init(struct dx_gates *gates, const struct dx_geometry *g);
void dx_gates_fini(struct dx_gates *gates);

/* Computes the constants; allocates nothing, so that it can follow the first frame's noise
 * estimate. */
void dx_gates_set(struct dx_gates *gates, const struct dx_geometry *g,
                  const struct dx_terrain_params *params);

#endif
