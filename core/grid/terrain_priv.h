/* Inside terrain mode: what publishing (publish.c), committing (terrain.c) and reading out
 * (terrain_tile.c) share. */
#ifndef DX_TERRAIN_PRIV_H
#define DX_TERRAIN_PRIV_H

#include "core/grid/estimator.h"
#include "core/grid/gates.h"
#include "core/grid/rules.h"
#include "core/grid/smoothing.h"
#include "core/grid/terrain.h"

/* What a thread of the pool works in. */
struct dx_terrain_scratch {
    struct dx_rules_scratch rules;
    struct dx_tile tile;
};

struct dx_terrain {
    struct dx_geometry *geometry;
    struct dx_terrain_params params;
    struct dx_tiling tiling;
    struct dx_gates gates;
    bool gates_set; /* with the first frame: the noise may come from it */
    uint32_t fans;  /* DX_CAP_*: fans that would face the scanner */
    struct dx_estimator estimator;
    uint32_t hold;             /* 1/256 sigma */
    struct dx_plane estimated; /* ranges, where estimates are published */
    bool *due;                 /* a tile: whether they are, of the frame that is published, */
    struct dx_rect *moved;     /* and what changed of its dexels in it */
    struct dx_plane published;
    struct dx_smoothing *smoothing; /* NULL: without */
    struct dx_plane *sampled;       /* what publishing writes: the array that is published, or the
                                       one that it is smoothed from */
    uint8_t *code;                  /* DX_TILE_CELLS^2 a tile */
    uint8_t *strut;                 /* DX_BLOCK_DEXELS a tile */
    bool *has_struts;               /* a tile: whether any of them is not 0 */
    uint64_t *hash;                 /* a tile; 0 = no triangles */
    uint64_t *marked, *changed;     /* bits by tile number */
    uint32_t *task;                 /* tile numbers of the commit under way */
    struct dx_terrain_scratch *scratch; /* one a thread of the pool */
    unsigned n_scratch;
};

/* Which rectangle of the grid a tile is, without its outcome and samples. */
void dx_terrain_describe(const struct dx_terrain *t, uint32_t number, struct dx_tile *tile);

/* Marks the tiles whose outcome these published dexels can change. */
void dx_terrain_mark_tiles(struct dx_terrain *t, const struct dx_rect *dexels);

#endif
