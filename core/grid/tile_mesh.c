/*
 * The whole mesh of a tile: its points (under the geometry, or as they came), attributes and
 * normals in rank order, triangles. Shared by the daemon's encoders and the client's decoders, so
 * that both get the same bits.
 */
#include "core/grid/runs.h"
#include "core/grid/tile_used.h"
#include "core/rows/rows.h"

#include <string.h>

/* The block's columns in the grid, and for a spinning geometry its table of them. */
struct columns {
    uint32_t at[DX_BLOCK];
    struct dx_row_spin spin;
};

static void find_columns(struct columns *col, const struct dx_tile *tile,
                         const struct dx_tiling *tiling, const struct dx_geometry *g)
{
    struct dx_runs runs;

    memset(col, 0, sizeof(*col));
    col->spin.unit_m = g->unit_m;
    dx_runs_find(&runs, (int64_t)tile->col * DX_TILE_CELLS - 1, DX_BLOCK, true, tiling->width);
    for (const struct dx_run *r = runs.run; r < runs.run + runs.n; r++)
        for (uint32_t j = 0; j < r->n; j++) {
            col->at[r->at + j] = r->col + j;
            if (g->model != DX_MODEL_SPINNING)
                continue;
            col->spin.c[r->at + j] = g->table[2 * (size_t)(r->col + j)];
            col->spin.s[r->at + j] = g->table[2 * (size_t)(r->col + j) + 1];
        }
}

/* The points of one block row, stored one after the other: each is written, and kept if used. */
static dx_packed_f32 *row_points(dx_packed_f32 *out, const struct dx_geometry *g, uint32_t row,
                                 struct columns *col, const uint32_t *range, dx_bits used)
{
    if (g->model == DX_MODEL_SPINNING) {
        col->spin.row = g->table + 2 * (size_t)g->width + 6 * (size_t)row;
        return dx_rows_get(DX_SIMD_AUTO)->spin(out, &col->spin, range, used);
    }
    for (; used; used &= used - 1, out += 3) {
        const uint32_t j = dx_bits_first(used);
        float xyz[3];

        dx_geometry_point(g, row, col->at[j], range[j], xyz);
        memcpy(out, xyz, sizeof(xyz));
    }
    return out;
}

static void exact_points(dx_packed_f32 *out, const struct dx_tile *tile, const struct dx_used *used)
{
    for (uint32_t i = 0; i < DX_BLOCK; i++)
        for (dx_bits row = used->row[i]; row; row &= row - 1, out += 3)
            memcpy(out, tile->xyz + 3 * ((size_t)i * DX_BLOCK + dx_bits_first(row)),
                   3 * sizeof(*tile->xyz));
}

void dx_tile_points(const struct dx_tile *tile, const struct dx_used *used,
                    const struct dx_tiling *tiling, const struct dx_geometry *g, dx_packed_f32 *xyz)
{
    struct columns col;

    if (tile->exact) {
        exact_points(xyz, tile, used);
        return;
    }
    find_columns(&col, tile, tiling, g);
    for (uint32_t i = 0; i < DX_BLOCK; i++)
        if (used->row[i]) /* a row outside the grid has no vertex */
            xyz = row_points(xyz, g, (uint32_t)tile->row * DX_TILE_CELLS + i - 1, &col,
                             tile->range + (size_t)i * DX_BLOCK, used->row[i]);
}

/* Attributes and normals, from block order to rank order. */
static void take_samples(struct dx_tile_mesh *mesh, const struct dx_tile *tile,
                         const struct dx_used *used)
{
    uint32_t n = 0;

    for (uint32_t i = 0; i < DX_BLOCK; i++)
        for (dx_bits row = used->row[i]; row; row &= row - 1, n++) {
            const size_t k = (size_t)i * DX_BLOCK + dx_bits_first(row);

            if (tile->attr_bytes)
                mesh->attr[n] = tile->attr[k];
            if (tile->has_normals)
                memcpy(mesh->normal + 2 * (size_t)n, tile->normal + 2 * k, 2);
        }
}

void dx_tile_mesh_build(struct dx_tile_mesh *mesh, const struct dx_tile *tile,
                        const struct dx_tiling *tiling, const struct dx_geometry *g)
{
    struct dx_used used;

    mesh->row = tile->row;
    mesh->col = tile->col;
    mesh->attr_bytes = tile->attr_bytes;
    mesh->has_normals = tile->has_normals;
    dx_used_mark(&used, tile->code, tile->strut);
    dx_used_pack(&used, mesh->mask);
    mesh->n_vertices = dx_used_count(&used);
    mesh->n_triangles = dx_tile_emit(tile, &used, g->flip, mesh->index);
    dx_tile_points(tile, &used, tiling, g, mesh->xyz);
    if (tile->attr_bytes || tile->has_normals)
        take_samples(mesh, tile, &used);
}
