/*
 * A tile at a level: which of its dexels are active, the cells that are left as they are, and the
 * larger triangles between them.
 *
 * A cell is half a triangle's size, so its two halves are there when the dexels at their right
 * angles are active: then it keeps its own outcome, diagonal included. Cells that are not full
 * always have both, and with them the dexels that struts hang on.
 */
#include "core/grid/lod_priv.h"
#include "core/grid/tile_used.h"

#include <stdlib.h>
#include <string.h>

#define SIDE (DX_TILE_CELLS + 1)

struct dx_lod_scratch {
    uint8_t active[SIDE][SIDE]; /* by row and column of the tile's corners of cells */
    struct dx_tile cut;         /* the cells that are left */
    struct dx_used used;
    uint16_t rank[DX_RANK_ROOM];
    uint16_t corner[3 * DX_TILE_MAX_TRIANGLES]; /* of the larger triangles: block dexels */
    uint32_t n_corners;
};

struct dx_lod_scratch *dx_lod_scratch_new(void)
{
    return calloc(1, sizeof(struct dx_lod_scratch));
}

void dx_lod_scratch_free(struct dx_lod_scratch *s)
{
    free(s);
}

/* ---- active dexels --------------------------------------------------------------------------- */

/* Beyond the grid's last cells all are: a triangle that lies across their border is always cut. */
static void find_active(uint8_t active[SIDE][SIDE], const struct dx_lod *lod,
                        struct dx_lod_level level, const struct dx_tile *tile)
{
    const struct dx_tiling *t = &lod->terrain->tiling;
    const uint32_t row0 = (uint32_t)tile->row * DX_TILE_CELLS;
    const uint32_t col0 = (uint32_t)tile->col * DX_TILE_CELLS;

    memset(active, 1, SIDE * SIDE);
    for (uint32_t i = 0; i <= tile->cell_rows; i++) {
        const uint16_t *error = lod->error + (size_t)(row0 + i) * t->width;

        for (uint32_t j = 0; j <= tile->cell_cols; j++) {
            const uint32_t h = dx_lod_low_bit(i | j);
            const uint32_t col = col0 + j < t->width ? col0 + j : 0;

            if (h < DX_TILE_CELLS)
                active[i][j] = dx_lod_is_active(level, error[col], h);
        }
    }
}

/* ---- cells ----------------------------------------------------------------------------------- */

/* Outcome by which halves are there: at b and d where row and column are both even or both odd,
 * else at a and c. */
static uint8_t cut_code(uint8_t code, bool mixed, bool upper, bool lower)
{
    if (upper && lower)
        return code;
    if (!upper && !lower)
        return DX_CELL_NONE;
    if (mixed)
        return upper ? DX_CELL_ABD : DX_CELL_BCD;
    return upper ? DX_CELL_ABC : DX_CELL_ACD;
}

static void cut_cells(struct dx_lod_scratch *s, const struct dx_tile *tile)
{
    for (uint32_t i = 0; i < tile->cell_rows; i++)
        for (uint32_t j = 0; j < tile->cell_cols; j++) {
            const uint32_t k = i * DX_TILE_CELLS + j, mixed = (i + j) & 1;
            const bool upper = s->active[i][j + 1 - mixed], lower = s->active[i + 1][j + mixed];

            s->cut.code[k] = cut_code(tile->code[k], mixed, upper, lower);
        }
}

/* ---- larger triangles ------------------------------------------------------------------------ */

struct place {
    int row, col;
};

static uint16_t block_dexel(struct place p)
{
    return (uint16_t)((p.row + 1) * DX_BLOCK + p.col + 1);
}

static int least(int x, int y)
{
    return x < y ? x : y;
}

/* Of right angle p and hypotenuse u-v, which run as a cell's abc does; legs of a cell are left to
 * the cells. */
static void cut_triangle(struct dx_lod_scratch *s, struct place p, struct place u, struct place v)
{
    const struct place m = {(u.row + v.row) / 2, (u.col + v.col) / 2};
    const struct place corner[3] = {p, u, v};

    if (abs(p.row - u.row) + abs(p.col - u.col) == 1 ||
        least(p.row, least(u.row, v.row)) >= s->cut.cell_rows ||
        least(p.col, least(u.col, v.col)) >= s->cut.cell_cols)
        return;
    if (s->active[m.row][m.col]) {
        cut_triangle(s, m, p, u);
        cut_triangle(s, m, v, p);
        return;
    }
    for (int k = 0; k < 3; k++) {
        s->corner[s->n_corners++] = block_dexel(corner[k]);
        dx_used_add(&s->used, block_dexel(corner[k]));
    }
}

/* The tile's own diagonal is the main one where its row and column are both even or both odd. */
static void cut_tile(struct dx_lod_scratch *s)
{
    const struct place a = {0, 0}, b = {0, DX_TILE_CELLS}, c = {DX_TILE_CELLS, DX_TILE_CELLS};
    const struct place d = {DX_TILE_CELLS, 0};

    if ((s->cut.row + s->cut.col) % 2 == 0) {
        cut_triangle(s, b, c, a);
        cut_triangle(s, d, a, c);
    } else {
        cut_triangle(s, a, b, d);
        cut_triangle(s, c, d, b);
    }
}

/* ---- the mesh -------------------------------------------------------------------------------- */

/* The vertices that are used, of those of the whole mesh, in its order. */
static void take_vertices(struct dx_tile_mesh *mesh, const struct dx_tile_mesh *whole,
                          const struct dx_used *used)
{
    uint32_t from = 0, to = 0;

    for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++) {
        if (!(whole->mask[k / 8] >> (k % 8) & 1))
            continue;
        if (dx_used_has(used, k)) {
            memcpy(mesh->xyz + 3 * (size_t)to, whole->xyz + 3 * (size_t)from,
                   3 * sizeof(*mesh->xyz));
            if (whole->attr_bytes)
                mesh->attr[to] = whole->attr[from];
            if (whole->has_normals)
                memcpy(mesh->normal + 2 * (size_t)to, whole->normal + 2 * (size_t)from, 2);
            to++;
        }
        from++;
    }
}

static uint32_t put_larger(uint16_t *index, const struct dx_lod_scratch *s, bool flip)
{
    for (uint32_t k = 0; k < s->n_corners; k += 3) {
        *index++ = s->rank[s->corner[k]];
        *index++ = s->rank[s->corner[k + (flip ? 2 : 1)]];
        *index++ = s->rank[s->corner[k + (flip ? 1 : 2)]];
    }
    return s->n_corners / 3;
}

void dx_lod_mesh(struct dx_tile_mesh *mesh, const struct dx_lod *lod, struct dx_lod_level level,
                 const struct dx_tile *tile, const struct dx_tile_mesh *whole,
                 struct dx_lod_scratch *s)
{
    const bool flip = lod->terrain->geometry->flip;

    s->cut.row = tile->row;
    s->cut.col = tile->col;
    s->cut.cell_rows = tile->cell_rows;
    s->cut.cell_cols = tile->cell_cols;
    memset(s->cut.code, DX_CELL_NONE, sizeof(s->cut.code));
    memcpy(s->cut.strut, tile->strut, sizeof(s->cut.strut));
    find_active(s->active, lod, level, tile);
    cut_cells(s, tile);
    dx_used_mark(&s->used, s->cut.code, s->cut.strut);
    s->n_corners = 0;
    cut_tile(s);
    dx_used_number(&s->used);

    mesh->row = whole->row;
    mesh->col = whole->col;
    mesh->attr_bytes = whole->attr_bytes;
    mesh->has_normals = whole->has_normals;
    dx_used_pack(&s->used, mesh->mask);
    dx_used_rank(&s->used, s->rank);
    mesh->n_vertices = dx_used_count(&s->used);
    take_vertices(mesh, whole, &s->used);
    mesh->n_triangles = dx_tile_emit(&s->cut, &s->used, flip, mesh->index);
    mesh->n_triangles += put_larger(mesh->index + 3 * (size_t)mesh->n_triangles, s, flip);
}
