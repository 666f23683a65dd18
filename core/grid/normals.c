/*
 * Vertex normals of one tile: every triangle that can touch its block adds its cross product to its
 * corners. Cells are visited row by row, which is NW, NE, SW, SE for each vertex; then struts in
 * the order of their owners. Sums are those of triangles as the grid has them; where the geometry
 * flips them, the opposites are encoded, which are the sums of the flipped ones to the bit.
 */
#include "core/grid/normals.h"

#include "core/base/bytes.h"
#include "core/grid/strip.h"
#include "core/grid/tile_used.h"

/* Rows and columns are counted from the block's first dexel. Cells that touch the block begin at
 * -1; owners of struts that do lie from -2 to one beyond it (their corners reach from -1 to 2). */
#define RING         1 /* rows of sums around the block: far corners of cells */
#define SIDE         (DX_BLOCK + 2 * RING)
#define STRUT_BEFORE 2
#define STRUT_AFTER  1
#define FIRST_COL    3 /* columns before the block: far corners of struts */

struct field {
    const struct dx_normals_source *source;
    const struct dx_rows *rows;
    int64_t row0; /* of the block's first dexel */
    struct dx_strip strip;
    struct dx_row_points sum[SIDE]; /* from block row -RING on */
};

/* ---- rows of the grid ------------------------------------------------------------------------ */

/* n columns of the strip from lane `lane` on that are neighbours in the grid too, and in one tile.
 */
struct run {
    uint32_t lane, n, tile_col, col; /* in the tile */
};

/* The run that begins at run->lane, of a grid of `cols` columns of tiles of which the last has all
 * the rest. False: there is no further one. */
static bool find_run(struct run *run, const struct dx_strip *s, uint32_t cols)
{
    uint32_t end;
    int32_t col;

    while (run->lane < DX_ROWS_N && s->col[run->lane] < 0)
        run->lane++;
    if (run->lane == DX_ROWS_N)
        return false;
    col = s->col[run->lane];
    run->tile_col = (uint32_t)col / DX_TILE_CELLS;
    run->tile_col = run->tile_col < cols ? run->tile_col : cols - 1;
    run->col = (uint32_t)col - run->tile_col * DX_TILE_CELLS;
    end = run->tile_col + 1 < cols ? DX_TILE_CELLS - run->col : UINT32_MAX;
    run->n = s->n_next[run->lane] < end ? s->n_next[run->lane] : end;
    return true;
}

/* Codes of the cells of one row, by strip column; 0 where there is no cell. */
static void fetch_codes(uint8_t code[DX_ROWS_N], const struct field *f, uint32_t row)
{
    const struct dx_tiling *t = f->source->tiling;
    const uint32_t tile_row = row / DX_TILE_CELLS;

    memset(code, 0, DX_ROWS_N);
    for (struct run r = {0}; find_run(&r, &f->strip, t->cols); r.lane += r.n) {
        const uint8_t *of_tile = f->source->cells(f->source->ctx, tile_row * t->cols + r.tile_col);
        const uint32_t room = r.col < DX_TILE_CELLS ? DX_TILE_CELLS - r.col : 0;

        memcpy(code + r.lane, of_tile + row % DX_TILE_CELLS * DX_TILE_CELLS + r.col,
               r.n < room ? r.n : room);
    }
}

/* Codes of the struts whose owners are in one row, likewise; false: the mesh has none. */
static bool fetch_struts(uint8_t code[DX_ROWS_N], const struct field *f, uint32_t row)
{
    const struct dx_tiling *t = f->source->tiling;
    uint32_t tile_row = row / DX_TILE_CELLS;

    /* the last row and column of dexels belong to the last cells' tile */
    tile_row = tile_row < t->rows ? tile_row : t->rows - 1;
    memset(code, 0, DX_ROWS_N);
    for (struct run r = {0}; find_run(&r, &f->strip, t->cols); r.lane += r.n) {
        const uint8_t *of_tile = f->source->struts(f->source->ctx, tile_row * t->cols + r.tile_col);

        if (!of_tile)
            return false;
        memcpy(code + r.lane, of_tile + (row - tile_row * DX_TILE_CELLS + 1) * DX_BLOCK + r.col + 1,
               r.n);
    }
    return true;
}

static void fetch_exact(struct dx_row_points *out, const struct field *f, uint32_t row)
{
    const struct dx_plane *plane = f->source->plane;

    memset(out, 0, sizeof(*out));
    for (uint32_t j = 0; j < DX_ROWS_N; j++) {
        const float *p = plane->xyz + 3 * ((size_t)row * plane->width + (uint32_t)f->strip.col[j]);

        if (f->strip.col[j] < 0)
            continue;
        out->x[j] = p[0];
        out->y[j] = p[1];
        out->z[j] = p[2];
    }
}

/* Points of a row of the grid; where it has no column, any. */
static void fetch_points(struct dx_row_points *out, struct field *f, uint32_t row)
{
    const struct dx_plane *plane = f->source->plane;
    const float unit_m = f->source->geometry->unit_m;
    float r[DX_ROWS_N] = {0};

    if (plane->xyz) {
        fetch_exact(out, f, row);
        return;
    }
    for (struct run run = {0}; find_run(&run, &f->strip, 1); run.lane += run.n) {
        const size_t k = (size_t)row * plane->width + run.col;

        for (uint32_t j = 0; plane->range_bytes == 2 && j < run.n; j++)
            r[run.lane + j] = (float)((const uint16_t *)plane->range)[k + j] * unit_m;
        for (uint32_t j = 0; plane->range_bytes == 4 && j < run.n; j++)
            r[run.lane + j] = (float)((const uint32_t *)plane->range)[k + j] * unit_m;
    }
    dx_strip_points(out, &f->strip, row, r);
}

/* ---- cells ---------------------------------------------------------------------------------- */

/* Whether a row of the grid is one of its rows of cells. */
static bool has_cells(const struct field *f, int64_t row)
{
    return row >= 0 && row < f->source->tiling->cell_rows;
}

static void add_cells(struct field *f)
{
    struct dx_row_points point[2]; /* of rows i and i + 1, by i & 1 */
    uint8_t code[DX_ROWS_N];

    memset(point, 0, sizeof(point));
    memset(&f->sum[0], 0, sizeof(f->sum[0]));
    for (uint32_t i = 0; i < SIDE - 1; i++) {
        const int64_t row = f->row0 - RING + i;

        if (!has_cells(f, row)) {
            memset(&f->sum[i + 1], 0, sizeof(f->sum[i + 1]));
            continue;
        }
        if (i == 0 || !has_cells(f, row - 1))
            fetch_points(&point[i & 1], f, (uint32_t)row);
        fetch_points(&point[~i & 1], f, (uint32_t)row + 1);
        fetch_codes(code, f, (uint32_t)row);
        f->rows->add_cells(&f->sum[i], &f->sum[i + 1], &point[i & 1], &point[~i & 1], code);
    }
}

/* ---- struts --------------------------------------------------------------------------------- */

/* The point of a corner, as an offset from the row and column of the strut's owner. */
static void point_at(float p[3], const struct field *f, int64_t row, uint32_t lane)
{
    const struct dx_normals_source *s = f->source;
    const uint32_t col = (uint32_t)f->strip.col[lane];
    const size_t k = (size_t)row * s->plane->width + col;

    if (s->plane->xyz)
        memcpy(p, s->plane->xyz + 3 * k, 3 * sizeof(*p));
    else
        dx_geometry_point(s->geometry, (uint32_t)row, col, dx_plane_range(s->plane, k), p);
}

/* (p1 - p0) x (p2 - p0) */
static void cross(float n[3], float p[3][3])
{
    const float u[3] = {p[1][0] - p[0][0], p[1][1] - p[0][1], p[1][2] - p[0][2]};
    const float v[3] = {p[2][0] - p[0][0], p[2][1] - p[0][1], p[2][2] - p[0][2]};

    n[0] = u[1] * v[2] - u[2] * v[1];
    n[1] = u[2] * v[0] - u[0] * v[2];
    n[2] = u[0] * v[1] - u[1] * v[0];
}

/* The triangles of a strut whose owner is in block row i, and in a lane. */
static void add_strut(struct field *f, uint8_t code, int64_t i, uint32_t lane)
{
    struct dx_strut_corner triangle[DX_STRUT_MAX_TRIANGLES][3];
    const unsigned n = dx_strut_triangles(triangle, code);

    for (unsigned t = 0; t < n; t++) {
        const struct dx_strut_corner *c = triangle[t];
        float point[3][3], normal[3];

        for (int m = 0; m < 3; m++)
            point_at(point[m], f, f->row0 + i + c[m].row, (uint32_t)((int32_t)lane + c[m].col));
        cross(normal, point);
        for (int m = 0; m < 3; m++) {
            const int64_t at = i + c[m].row + RING;
            const uint32_t q = (uint32_t)((int32_t)lane + c[m].col);

            if (at < 0 || at >= SIDE)
                continue;
            f->sum[at].x[q] += normal[0];
            f->sum[at].y[q] += normal[1];
            f->sum[at].z[q] += normal[2];
        }
    }
}

static void add_struts(struct field *f)
{
    const uint64_t none[DX_ROWS_N / 8] = {0};
    uint8_t code[DX_ROWS_N];

    for (int64_t i = -STRUT_BEFORE; i < DX_BLOCK + STRUT_AFTER; i++) {
        const int64_t row = f->row0 + i;

        if (row < 0 || row >= f->source->tiling->height)
            continue;
        if (!fetch_struts(code, f, (uint32_t)row))
            return;
        if (memcmp(code, none, sizeof(code)) == 0)
            continue;
        for (uint32_t j = FIRST_COL - STRUT_BEFORE; j < FIRST_COL + DX_BLOCK + STRUT_AFTER; j++)
            if (code[j])
                add_strut(f, code[j], i, j);
    }
}

/* ---- both ----------------------------------------------------------------------------------- */

static void encode(struct dx_tile *tile, const struct field *f)
{
    int8_t bytes[2 * DX_ROWS_N];
    struct dx_used used;

    dx_used_mark(&used, tile->code, tile->strut);
    for (uint32_t i = 0; i < DX_BLOCK; i++) {
        f->rows->octahedral(bytes, &f->sum[i + RING], used.row[i] << FIRST_COL,
                            f->source->geometry->flip);
        memcpy(tile->normal + 2 * (size_t)i * DX_BLOCK, bytes + 2 * FIRST_COL, 2 * DX_BLOCK);
    }
}

void dx_normals_compute(struct dx_tile *tile, const struct dx_normals_source *source)
{
    struct field f;

    f.source = source;
    f.rows = dx_rows_get(DX_SIMD_AUTO);
    f.row0 = (int64_t)tile->row * DX_TILE_CELLS - 1;
    dx_strip_init(&f.strip, source->geometry, f.rows,
                  (int64_t)tile->col * DX_TILE_CELLS - 1 - FIRST_COL);
    add_cells(&f);
    add_struts(&f);
    encode(tile, &f);
    tile->has_normals = true;
}
