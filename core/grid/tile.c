/*
 * From the cells of a tile to its mesh: which dexels are vertices, their ranks, their points, and
 * the triangles. Shared by the daemon's encoders and the client's decoders, so that both get the
 * same bits.
 */
#include "core/grid/tile.h"

#include "core/base/bytes.h"
#include "core/base/hash.h"

#include <string.h>

void dx_tiling_init(struct dx_tiling *t, uint32_t height, uint32_t width, bool wrap)
{
    *t = (struct dx_tiling){.height = height, .width = width, .wrap = wrap};
    t->cell_rows = height ? height - 1 : 0;
    t->cell_cols = wrap || width == 0 ? width : width - 1;
    t->rows = (t->cell_rows + DX_TILE_CELLS - 1) / DX_TILE_CELLS;
    t->cols = (t->cell_cols + DX_TILE_CELLS - 1) / DX_TILE_CELLS;
}

/* One byte for each block dexel: 1 where a cell uses it. */
struct used {
    uint8_t at[DX_BLOCK_DEXELS + 7]; /* zero padding for the packing by eights */
};

static void mark_used(const struct dx_tile *tile, struct used *used)
{
    memset(used, 0, sizeof(*used));
    for (uint32_t i = 0; i < tile->cell_rows; i++) {
        const uint8_t *code = tile->code + (size_t)i * DX_TILE_CELLS;
        uint8_t *top = used->at + (size_t)(i + 1) * DX_BLOCK + 1, *bottom = top + DX_BLOCK;
        uint8_t a[DX_TILE_CELLS], b[DX_TILE_CELLS], c[DX_TILE_CELLS], d[DX_TILE_CELLS];

        /* each corner is spared by exactly one outcome beside "none" */
        for (uint32_t j = 0; j < DX_TILE_CELLS; j++) {
            uint8_t some = code[j] != DX_CELL_NONE;

            a[j] = some & (code[j] != DX_CELL_BCD);
            b[j] = some & (code[j] != DX_CELL_ACD);
            c[j] = some & (code[j] != DX_CELL_ABD);
            d[j] = some & (code[j] != DX_CELL_ABC);
        }
        for (uint32_t j = 0; j < DX_TILE_CELLS; j++) {
            top[j] |= a[j];
            bottom[j] |= d[j];
        }
        for (uint32_t j = 0; j < DX_TILE_CELLS; j++) {
            top[j + 1] |= b[j];
            bottom[j + 1] |= c[j];
        }
    }
}

static void pack_mask(const struct used *used, uint8_t mask[DX_MASK_BYTES])
{
    for (uint32_t k = 0; k < DX_MASK_BYTES; k++) {
        const uint8_t *u = used->at + 8 * (size_t)k;

        mask[k] = (uint8_t)(u[0] | u[1] << 1 | u[2] << 2 | u[3] << 3 | u[4] << 4 | u[5] << 5 |
                            u[6] << 6 | u[7] << 7);
    }
}

/* rank[k] = used dexels before k; returns their number. */
static uint32_t rank_used(const struct used *used, uint16_t rank[DX_BLOCK_DEXELS])
{
    uint32_t n = 0;

    for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++) {
        rank[k] = (uint16_t)n;
        n += used->at[k];
    }
    return n;
}

uint32_t dx_tile_mask(const struct dx_tile *tile, uint8_t mask[DX_MASK_BYTES])
{
    struct used used;
    uint32_t n = 0;

    mark_used(tile, &used);
    pack_mask(&used, mask);
    for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++)
        n += used.at[k];
    return n;
}

/* Corners of the triangle of an outcome that has one: 0 a, 1 b, 2 c, 3 d; in index order, and
 * flipped. */
static const uint8_t corners[2][7][3] = {
    {[DX_CELL_ABC] = {0, 1, 2},
     [DX_CELL_ACD] = {0, 2, 3},
     [DX_CELL_ABD] = {0, 1, 3},
     [DX_CELL_BCD] = {1, 2, 3}},
    {[DX_CELL_ABC] = {0, 2, 1},
     [DX_CELL_ACD] = {0, 3, 2},
     [DX_CELL_ABD] = {0, 3, 1},
     [DX_CELL_BCD] = {1, 3, 2}},
};

static inline bool is_full(uint8_t code)
{
    return 1u << code & (1u << DX_CELL_ABC_ACD | 1u << DX_CELL_ABD_BCD);
}

/* Two indices by one store. */
static inline void put_pair(uint16_t *out, uint32_t first, uint32_t second)
{
    uint32_t pair = dx_host_is_little_endian() ? first | second << 16 : first << 16 | second;

    memcpy(out, &pair, sizeof(pair));
}

/* The two triangles of a full cell: abc, acd or abd, bcd. All its corners are used, so that b
 * follows a, and c follows d. No branch on the diagonal: noise makes that a coin toss. */
static inline void emit_full(uint16_t *out, uint8_t code, bool flip, uint32_t a, uint32_t d)
{
    uint32_t on_bd = code == DX_CELL_ABD_BCD, b = a + 1, c = d + 1;

    put_pair(out, a, flip ? c - on_bd : b);
    put_pair(out + 2, flip ? b : c - on_bd, a + on_bd);
    put_pair(out + 4, flip ? d : c, flip ? c : d);
}

/* Inlined with either orientation. */
static inline __attribute__((always_inline)) uint16_t *emit_row(uint16_t *out, const uint8_t *code,
                                                                uint32_t n, const uint16_t *top,
                                                                const uint16_t *bottom, bool flip)
{
    const uint8_t(*corner)[3] = corners[flip];

    for (uint32_t j = 0; j < n; j++) {
        if (is_full(code[j])) {
            emit_full(out, code[j], flip, top[j], bottom[j]);
            out += 6;
        } else if (code[j] != DX_CELL_NONE) {
            const uint16_t v[4] = {top[j], top[j + 1], bottom[j + 1], bottom[j]};

            for (int m = 0; m < 3; m++)
                *out++ = v[corner[code[j]][m]];
        }
    }
    return out;
}

static uint32_t emit_indices(const struct dx_tile *tile, const uint16_t rank[DX_BLOCK_DEXELS],
                             bool flip, uint16_t *index)
{
    uint16_t *out = index;

    for (uint32_t i = 0; i < tile->cell_rows; i++) {
        const uint8_t *code = tile->code + (size_t)i * DX_TILE_CELLS;
        const uint16_t *top = rank + (size_t)(i + 1) * DX_BLOCK + 1, *bottom = top + DX_BLOCK;

        if (flip)
            out = emit_row(out, code, tile->cell_cols, top, bottom, true);
        else
            out = emit_row(out, code, tile->cell_cols, top, bottom, false);
    }
    return (uint32_t)(out - index) / 3;
}

uint32_t dx_tile_indices(const struct dx_tile *tile, const uint8_t mask[DX_MASK_BYTES], bool flip,
                         uint16_t *index)
{
    uint16_t rank[DX_BLOCK_DEXELS];
    struct used used;

    for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++)
        used.at[k] = mask[k / 8] >> (k % 8) & 1;
    rank_used(&used, rank);
    return emit_indices(tile, rank, flip, index);
}

/* The block's columns in the grid, and for a spinning geometry its table of them. */
struct columns {
    uint32_t at[DX_BLOCK];
    float c[DX_BLOCK], s[DX_BLOCK];
};

static void find_columns(struct columns *col, const struct dx_tile *tile,
                         const struct dx_tiling *tiling, const struct dx_geometry *g)
{
    for (uint32_t j = 0; j < DX_BLOCK; j++) {
        col->at[j] = ((uint32_t)tile->col * DX_TILE_CELLS + j + tiling->width - 1) % tiling->width;
        if (g->model == DX_MODEL_SPINNING) {
            col->c[j] = g->table[2 * (size_t)col->at[j]];
            col->s[j] = g->table[2 * (size_t)col->at[j] + 1];
        }
    }
}

/* The points of one block row, stored one after the other: each is written, and kept if used. The
 * operations are those of dx_geometry_point. */
static float *spin_row(float *restrict out, const float d[6], float unit_m,
                       const struct columns *col, const uint32_t range[DX_BLOCK],
                       const uint8_t used[DX_BLOCK])
{
    float x[DX_BLOCK], y[DX_BLOCK], z[DX_BLOCK];

    for (uint32_t j = 0; j < DX_BLOCK; j++) {
        float r = (float)range[j] * unit_m;
        float u = d[3] + r * d[0], v = d[4] + r * d[1];

        x[j] = u * col->c[j] - v * col->s[j];
        y[j] = u * col->s[j] + v * col->c[j];
        z[j] = d[5] + r * d[2];
    }
    for (uint32_t j = 0; j < DX_BLOCK; j++) {
        out[0] = x[j];
        out[1] = y[j];
        out[2] = z[j];
        out += 3 * used[j];
    }
    return out;
}

static float *row_points(float *out, const struct dx_geometry *g, uint32_t row,
                         const struct columns *col, const uint32_t range[DX_BLOCK],
                         const uint8_t used[DX_BLOCK])
{
    if (g->model == DX_MODEL_SPINNING)
        return spin_row(out, g->table + 2 * (size_t)g->width + 6 * (size_t)row, g->unit_m, col,
                        range, used);
    for (uint32_t j = 0; j < DX_BLOCK; j++)
        if (used[j]) {
            dx_geometry_point(g, row, col->at[j], range[j], out);
            out += 3;
        }
    return out;
}

void dx_tile_mesh_build(struct dx_tile_mesh *mesh, const struct dx_tile *tile,
                        const struct dx_tiling *tiling, const struct dx_geometry *g)
{
    uint16_t rank[DX_BLOCK_DEXELS];
    struct columns col;
    struct used used;
    float *xyz = mesh->xyz;

    mesh->row = tile->row;
    mesh->col = tile->col;
    mesh->attr_bytes = tile->attr_bytes;
    mark_used(tile, &used);
    pack_mask(&used, mesh->mask);
    mesh->n_vertices = rank_used(&used, rank);
    mesh->n_triangles = emit_indices(tile, rank, g->flip, mesh->index);

    find_columns(&col, tile, tiling, g);
    for (uint32_t i = 1; i <= (uint32_t)tile->cell_rows + 1; i++)
        xyz = row_points(xyz, g, (uint32_t)tile->row * DX_TILE_CELLS + i - 1, &col,
                         tile->range + (size_t)i * DX_BLOCK, used.at + (size_t)i * DX_BLOCK);
    if (tile->attr_bytes)
        for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++)
            if (used.at[k])
                mesh->attr[rank[k]] = tile->attr[k];
}

uint64_t dx_tile_hash(const struct dx_tile *tile)
{
    static const uint64_t seed =
        0x7465727261696e; /* so that no tile with triangles hashes to 0 by design */
    uint16_t attr[DX_BLOCK_DEXELS];
    uint32_t range[DX_BLOCK_DEXELS];
    struct used used;
    uint64_t h;

    mark_used(tile, &used);
    for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++)
        range[k] = tile->range[k] & -(uint32_t)used.at[k];
    h = dx_hash(seed, tile->code, sizeof(tile->code));
    h = dx_hash(h, range, sizeof(range));
    if (tile->attr_bytes) {
        for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++)
            attr[k] = (uint16_t)(tile->attr[k] & -used.at[k]);
        h = dx_hash(h, attr, sizeof(attr));
    }
    return h | 1; /* 0 is kept for tiles without triangles */
}
