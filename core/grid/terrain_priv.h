/* Inside terrain mode: what publishing (publish.c), committing (terrain.c) and reading out
 * (terrain_tile.c) share. */
#ifndef DX_TERRAIN_PRIV_H
#define DX_TERRAIN_PRIV_H

#include "core/grid/estimator.h"
#include "core/grid/gates.h"
#include "core/grid/smoothing.h"
#include "core/grid/terrain.h"

/* The most rows and columns of dexels that belong to a tile. */
#define DX_PART_SIDE (DX_TILE_CELLS + 1)

struct dx_terrain {
    struct dx_geometry *geometry;
    struct dx_terrain_params params;
    struct dx_tiling tiling;
    struct dx_gates gates;
    bool gates_set; /* with the first frame: the noise may come from it */
    uint32_t fans;  /* DX_CAP_*: fans that would face the scanner */
    struct dx_estimator estimator;
    uint32_t hold;         /* 1/256 sigma */
    uint64_t *estimate;    /* DX_PART_SIDE^2: of the part that is being published */
    struct dx_rect *moved; /* of each 64 columns: what changed in the rows that are published */
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
    struct scratch *scratch;        /* one a thread of the pool */
    unsigned n_scratch;
};

/* Which rectangle of the grid a tile is, without its outcome and samples. */
void dx_terrain_describe(const struct dx_terrain *t, uint32_t number, struct dx_tile *tile);

/* Marks the tiles whose outcome these published dexels can change. */
void dx_terrain_mark_tiles(struct dx_terrain *t, const struct dx_rect *dexels);

#endif
