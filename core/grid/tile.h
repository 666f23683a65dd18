/*
 * Tiles: 64x64 cells, each the property of one tile, and what a tile's mesh is made of. Cell (i,j)
 * has the corners a=(i,j), b=(i,j+1), c=(i+1,j+1), d=(i+1,j); columns are modulo the width where
 * the grid wraps. A tile's vertices live in a block of 67x67 dexels whose origin is one row and one
 * column before its first cell (room for struts); a vertex's name inside the tile is its rank among
 * the used ones.
 */
#ifndef DX_TILE_H
#define DX_TILE_H

#include "core/grid/geometry.h"
#include "core/grid/strut.h"
#include "core/rows/rows.h"

#include <string.h>

#define DX_TILE_CELLS        64
#define DX_BLOCK             67
#define DX_BLOCK_DEXELS      (DX_BLOCK * DX_BLOCK)
#define DX_MASK_BYTES        ((DX_BLOCK_DEXELS + 7) / 8)
#define DX_TILE_MAX_VERTICES DX_BLOCK_DEXELS
/* Each triangle covers half a square of the block at the least, and none twice. */
#define DX_TILE_MAX_TRIANGLES (2 * (DX_BLOCK - 1) * (DX_BLOCK - 1))

/* The seven outcomes of a cell. */
enum dx_cell {
    DX_CELL_NONE = 0,
    DX_CELL_ABC = 1,
    DX_CELL_ACD = 2,
    DX_CELL_ABC_ACD = 3,
    DX_CELL_ABD = 4,
    DX_CELL_BCD = 5,
    DX_CELL_ABD_BCD = 6,
};

/* How a grid is cut into tiles. */
struct dx_tiling {
    uint32_t height, width; /* dexels */
    bool wrap;
    uint32_t cell_rows, cell_cols; /* height-1, and width (wrap) or width-1 */
    uint32_t rows, cols;           /* tiles */
};

void dx_tiling_init(struct dx_tiling *t, uint32_t height, uint32_t width, bool wrap);

static inline uint32_t dx_tiling_n_tiles(const struct dx_tiling *t)
{
    return t->rows * t->cols;
}

/* Topology and samples of one tile: all that its chunk says, before any encoding. */
struct dx_tile {
    uint16_t row, col;            /* of the tile */
    uint8_t cell_rows, cell_cols; /* 1..64; less than 64 only in the last ones */
    uint8_t attr_bytes;           /* 0, 1 or 2 */
    uint8_t code[DX_TILE_CELLS *
                 DX_TILE_CELLS];    /* enum dx_cell; row stride 64; 0 outside cell_rows/cols */
    uint8_t strut[DX_BLOCK_DEXELS]; /* code (strut.h) at the missing dexel that owns it; 0 none */
    uint32_t
        range[DX_BLOCK_DEXELS + 16];     /* block order; only used dexels matter; room at the end */
    uint16_t attr[DX_BLOCK_DEXELS + 16]; /* as ranges */
    bool has_normals;
    int8_t normal[2 * DX_BLOCK_DEXELS]; /* octahedral.h; block order */
    bool exact;                         /* vertices are the points below, not those of the ranges */
    float xyz[3 * DX_BLOCK_DEXELS]; /* block order; last: its memory is not touched unless exact */
};

/* The mesh of one tile: what a subscriber sees. */
struct dx_tile_mesh {
    uint16_t row, col;
    uint8_t attr_bytes;
    uint32_t n_vertices, n_triangles;
    uint8_t mask[DX_MASK_BYTES]; /* bit k of byte k/8: block dexel k is a vertex */
    float xyz[3 * DX_TILE_MAX_VERTICES + DX_ROWS_SLACK]; /* scanner frame, metres, in rank order */
    uint16_t attr[DX_TILE_MAX_VERTICES];
    bool has_normals;
    int8_t normal[2 * DX_TILE_MAX_VERTICES];                   /* octahedral.h; rank order */
    uint16_t index[3 * DX_TILE_MAX_TRIANGLES + DX_ROWS_SLACK]; /* ranks */
};

/* Owner of the first strut from block dexel k on; DX_BLOCK_DEXELS: there is none. Looks at eight
 * codes at a time: most tiles have no strut. */
static inline uint32_t dx_strut_next(const uint8_t strut[DX_BLOCK_DEXELS], uint32_t k)
{
    for (; k + 8 <= DX_BLOCK_DEXELS; k += 8) {
        uint64_t codes;

        memcpy(&codes, strut + k, sizeof(codes));
        if (codes)
            break;
    }
    while (k < DX_BLOCK_DEXELS && strut[k] == 0)
        k++;
    return k;
}

/* Block dexel of a corner of the strut that block dexel k owns; it is inside the block. */
static inline uint32_t dx_tile_strut_corner(uint32_t k, struct dx_strut_corner c)
{
    return (uint32_t)((int32_t)k + c.row * DX_BLOCK + c.col);
}

/* Which block dexels the cells and struts use, as the mask of struct dx_tile_mesh; returns how
 * many. */
uint32_t dx_tile_mask(const struct dx_tile *tile, uint8_t mask[DX_MASK_BYTES]);

/* The whole mesh of a tile: mask, vertices under the geometry (or the tile's own points),
 * attributes, normals, triangles: of the cells row by row, then of the struts in block order of
 * their owners. */
void dx_tile_mesh_build(struct dx_tile_mesh *mesh, const struct dx_tile *tile,
                        const struct dx_tiling *tiling, const struct dx_geometry *g);

/* Global vertex id (row * width + column) of block dexel k of a tile. */
static inline uint64_t dx_tile_vertex_id(const struct dx_tiling *t, uint32_t tile_row,
                                         uint32_t tile_col, uint32_t k)
{
    uint64_t row = (uint64_t)tile_row * DX_TILE_CELLS + k / DX_BLOCK - 1;
    uint64_t col = (uint64_t)tile_col * DX_TILE_CELLS + k % DX_BLOCK + t->width - 1;

    return row * t->width + col % t->width;
}

#endif
