/*
 * Cell codes, scalar. A tile's dexels are gathered into a dense block (the seam is gone after
 * that), each row of edges is decided by one pass over it, and a cell's code follows from its six
 * edge bits: t1 = abc, t2 = acd, t3 = abd, t4 = bcd; take b-d where it gives more triangles, or as
 * many and the diagonal rule prefers it; a missing corner makes its edges 0, so three-corner cells
 * are included.
 */
#include "core/grid/cells.h"

#include <math.h>
#include <string.h>

#define N DX_CELL_BLOCK

/* Edge bits of one row of cells, and whether the diagonal rule prefers b-d. */
struct edge_row {
    uint8_t h[N], h_below[N], v[N], ac[N], bd[N], prefer_bd[N];
};

static void gather_row(void *out, const void *row, size_t size, uint32_t col0, uint32_t n,
                       uint32_t width)
{
    uint32_t first = n < width - col0 ? n : width - col0;

    memcpy(out, (const uint8_t *)row + col0 * size, first * size);
    if (first < n) /* past the seam */
        memcpy((uint8_t *)out + first * size, row, (n - first) * size);
}

static void gather_ranges(struct dx_cell_block *b, const struct dx_plane *plane, uint32_t row0,
                          uint32_t col0, bool wide)
{
    uint32_t n = b->n_cols + 1;

    for (uint32_t i = 0; i <= b->n_rows; i++) {
        const uint8_t *row =
            (const uint8_t *)plane->range + (size_t)(row0 + i) * plane->width * plane->range_bytes;

        if (plane->range_bytes == 4) {
            gather_row(b->range32[i], row, 4, col0, n, plane->width);
            continue;
        }
        gather_row(b->range16[i], row, 2, col0, n, plane->width);
        for (uint32_t j = 0; wide && j < n; j++)
            b->range32[i][j] = b->range16[i][j];
    }
}

static inline uint16_t mul_high(uint16_t x, uint16_t y)
{
    return (uint16_t)((uint32_t)x * y >> 16);
}

/* For rows of 16-bit arithmetic: inlined, a constant is seen as part of a wider number, and
 * products with it become 32-bit ones at four times the instructions. */
#define OUT_OF_LINE __attribute__((noinline))

/* Each product its own loop, for the same reason. */
static OUT_OF_LINE void noise_row(uint16_t *restrict out, const uint16_t *range, uint16_t t0,
                                  uint16_t n2)
{
    uint16_t square[N];

    for (uint32_t j = 0; j < N; j++)
        square[j] = mul_high(range[j], range[j]);
    for (uint32_t j = 0; j < N; j++)
        out[j] = (uint16_t)(t0 + mul_high(square[j], n2));
}

/* What a range adds to the gate whatever the edge: once a dexel instead of once an edge. */
static void gather_noise(struct dx_cell_block *b, const struct dx_gates *gates)
{
    for (uint32_t i = 0; i <= b->n_rows; i++)
        noise_row(b->noise[i], b->range16[i], (uint16_t)gates->t0, (uint16_t)gates->n2);
}

static void gather_constants(struct dx_cell_block *b, const struct dx_gates *gates, uint32_t row0,
                             uint32_t col0, uint32_t width)
{
    for (int e = 0; e < DX_N_EDGES; e++)
        for (uint32_t i = 0; i <= b->n_rows; i++) {
            gather_row(b->c[e][i], gates->c[e] + (size_t)(row0 + i) * width, 4, col0, b->n_cols + 1,
                       width);
            for (uint32_t j = 0; !gates->wide && j <= b->n_cols; j++)
                b->c16[e][i][j] = (uint16_t)b->c[e][i][j];
        }
}

static void gather_directions(struct dx_cell_block *b, const struct dx_geometry *g, uint32_t row0,
                              uint32_t col0)
{
    for (uint32_t i = 0; i <= b->n_rows; i++)
        for (uint32_t j = 0; j <= b->n_cols; j++) {
            double d[3], z = 1;

            dx_geometry_direction(g, row0 + i, (col0 + j) % g->width, d);
            if (g->model == DX_MODEL_PINHOLE)
                z = d[2]; /* its ranges are depths: scale the unit vector to depth 1 */
            for (int k = 0; k < 3; k++)
                b->direction[i][j][k] = (int32_t)rint(d[k] / z * 0x1p24);
        }
}

/* ---- the first-order rule ------------------------------------------------------------------- */

/*
 * hi - lo <= noise + (lo * c >> 16) in 16 bits: the sum might not fit, so what the noise term
 * leaves of the difference is compared with the tilt term. No minimum, no maximum: SSE2 has none
 * for unsigned 16 bits, but selecting by a mask becomes vectors. The noise term does not fall with
 * range, so the nearer sample has the smaller one.
 */
static inline uint8_t joined(uint16_t x, uint16_t y, uint16_t noise_x, uint16_t noise_y, uint16_t c)
{
    uint16_t farther = (uint16_t) - (x > y), step = (uint16_t)(x - y), fall = step & farther;
    uint16_t lo = (uint16_t)(x - fall), difference = (uint16_t)(2 * fall - step);
    uint16_t noise = (uint16_t)(noise_x - ((noise_x - noise_y) & farther));

    return (lo != 0) &
           ((difference <= noise) | ((uint16_t)(difference - noise) <= mul_high(lo, c)));
}

static OUT_OF_LINE void join_even(uint8_t *restrict out, const uint16_t *x, const uint16_t *y,
                                  const uint16_t *noise_x, const uint16_t *noise_y, uint16_t c)
{
    for (uint32_t j = 0; j < N; j++)
        out[j] = joined(x[j], y[j], noise_x[j], noise_y[j], c);
}

static void join_uneven(uint8_t *restrict out, const uint16_t *x, const uint16_t *y,
                        const uint16_t *noise_x, const uint16_t *noise_y, const uint16_t *c)
{
    for (uint32_t j = 0; j < N; j++)
        out[j] = joined(x[j], y[j], noise_x[j], noise_y[j], c[j]);
}

static void join_wide(uint8_t *out, const uint32_t *x, const uint32_t *y, const uint32_t *c,
                      uint32_t step, uint32_t t0, uint64_t n2)
{
    for (uint32_t j = 0; j < N; j++) {
        uint64_t lo = x[j] < y[j] ? x[j] : y[j], hi = x[j] < y[j] ? y[j] : x[j];
        unsigned __int128 square = (unsigned __int128)(lo * lo >> 16) * n2 >> 16;
        unsigned __int128 tau = t0 + (lo * c[j * step] >> 16) + square;

        out[j] = (uint8_t)((lo != 0) & (hi - lo <= tau));
    }
}

static void join_valid(uint8_t *out, const struct dx_cell_block *b, bool wide, uint32_t i0,
                       uint32_t j0, uint32_t i1, uint32_t j1)
{
    for (uint32_t j = 0; j < N; j++)
        out[j] = wide ? b->range32[i0][j + j0] && b->range32[i1][j + j1]
                      : b->range16[i0][j + j0] && b->range16[i1][j + j1];
}

/* A row of edges of type e: out[j] joins dexels (i0, j + j0) and (i1, j + j1) of the block. Rows
 * are decided in full, whatever the tile has of them: loops of one length are short ones. */
static void join(uint8_t *out, const struct dx_cell_block *b, const struct dx_gates *gates,
                 enum dx_edge e, uint32_t i0, uint32_t j0, uint32_t i1, uint32_t j1)
{
    const uint32_t *c = gates->per_dexel ? b->c[e][i0] : &gates->c[e][b->row0 + i0];
    const uint16_t *x = b->range16[i0] + j0, *y = b->range16[i1] + j1;
    const uint16_t *noise_x = b->noise[i0] + j0, *noise_y = b->noise[i1] + j1;

    if (!gates->first_order)
        join_valid(out, b, gates->wide, i0, j0, i1, j1);
    else if (gates->wide)
        join_wide(out, b->range32[i0] + j0, b->range32[i1] + j1, c, gates->per_dexel, gates->t0,
                  gates->n2);
    else if (gates->per_dexel)
        join_uneven(out, x, y, noise_x, noise_y, b->c16[e][i0]);
    else
        join_even(out, x, y, noise_x, noise_y, (uint16_t)*c);
}

/* ---- the cap -------------------------------------------------------------------------------- */

static bool within_cap(const struct dx_cell_block *b, const struct dx_gates *gates, uint32_t i0,
                       uint32_t j0, uint32_t i1, uint32_t j1)
{
    int64_t r0 = gates->wide ? b->range32[i0][j0] : b->range16[i0][j0];
    int64_t r1 = gates->wide ? b->range32[i1][j1] : b->range16[i1][j1];
    unsigned __int128 length2 = 0;

    for (int k = 0; k < 3; k++) {
        int64_t d = (r0 * b->direction[i0][j0][k] - r1 * b->direction[i1][j1][k]) >> 12;

        length2 += (unsigned __int128)((__int128)d * d);
    }
    return length2 <= (unsigned __int128)gates->cap * gates->cap;
}

static void cap_row(uint8_t *edge, const struct dx_cell_block *b, const struct dx_gates *gates,
                    uint32_t i0, uint32_t j0, uint32_t i1, uint32_t j1, uint32_t n)
{
    if (gates->cap)
        for (uint32_t j = 0; j < n; j++)
            edge[j] = edge[j] && within_cap(b, gates, i0, j + j0, i1, j + j1);
}

/* ---- the cell rule -------------------------------------------------------------------------- */

static inline uint32_t difference(uint32_t x, uint32_t y)
{
    return x < y ? y - x : x - y;
}

static inline uint16_t difference16(uint16_t x, uint16_t y)
{
    return (uint16_t)(x < y ? y - x : x - y);
}

static void prefer(uint8_t *restrict out, const struct dx_cell_block *b, bool wide, uint32_t i)
{
    const uint16_t *top = b->range16[i], *bottom = b->range16[i + 1];

    if (wide)
        for (uint32_t j = 0; j < b->n_cols; j++)
            out[j] = difference(b->range32[i][j + 1], b->range32[i + 1][j]) <
                     difference(b->range32[i][j], b->range32[i + 1][j + 1]);
    else
        for (uint32_t j = 0; j < DX_TILE_CELLS; j++)
            out[j] = difference16(top[j + 1], bottom[j]) < difference16(top[j], bottom[j + 1]);
}

static void code_row(uint8_t *code, const struct edge_row *e, uint32_t n)
{
    for (uint32_t j = 0; j < n; j++) {
        uint8_t ab = e->h[j], dc = e->h_below[j], ad = e->v[j], bc = e->v[j + 1];
        uint8_t t1 = ab & bc & e->ac[j], t2 = dc & ad & e->ac[j];
        uint8_t t3 = ab & ad & e->bd[j], t4 = bc & dc & e->bd[j];
        uint8_t n_ac = (uint8_t)(t1 + t2), n_bd = (uint8_t)(t3 + t4);
        uint8_t use_bd = (n_bd > n_ac) | ((n_bd == n_ac) & e->prefer_bd[j]);
        uint8_t on_ac = (uint8_t)(t1 + 2 * t2), on_bd = (uint8_t)(t3 + 2 * t4);

        /* enum dx_cell: 0..3 on a-c; 4..6 on b-d, where none is none */
        on_bd = (uint8_t)(on_bd + (on_bd ? 3 : 0));
        code[j] = use_bd ? on_bd : on_ac;
    }
}

static void horizontal(uint8_t *out, const struct dx_cell_block *b, const struct dx_gates *gates,
                       uint32_t i)
{
    join(out, b, gates, DX_EDGE_H, i, 0, i, 1);
    cap_row(out, b, gates, i, 0, i, 1, b->n_cols);
}

static void clear_folded(uint8_t *code, const struct dx_gates *gates, size_t cell0, uint32_t n)
{
    for (uint32_t j = 0; gates->folded && j < n; j++)
        if (gates->folded[(cell0 + j) / 64] >> ((cell0 + j) % 64) & 1)
            code[j] = DX_CELL_NONE;
}

void dx_cells_compute(uint8_t code[DX_TILE_CELLS * DX_TILE_CELLS], struct dx_cell_block *b,
                      const struct dx_plane *plane, const struct dx_tiling *tiling,
                      const struct dx_geometry *g, const struct dx_gates *gates, enum dx_diag diag,
                      uint32_t tile_row, uint32_t tile_col)
{
    uint32_t row0 = tile_row * DX_TILE_CELLS, col0 = tile_col * DX_TILE_CELLS;
    struct edge_row e = {0};

    b->n_rows = tiling->cell_rows - row0 < DX_TILE_CELLS ? tiling->cell_rows - row0 : DX_TILE_CELLS;
    b->n_cols = tiling->cell_cols - col0 < DX_TILE_CELLS ? tiling->cell_cols - col0 : DX_TILE_CELLS;
    memset(code, DX_CELL_NONE, DX_TILE_CELLS * DX_TILE_CELLS);
    gather_ranges(b, plane, row0, col0, gates->wide);
    b->row0 = row0;
    if (!gates->wide)
        gather_noise(b, gates);
    if (gates->per_dexel)
        gather_constants(b, gates, row0, col0, plane->width);
    if (gates->cap)
        gather_directions(b, g, row0, col0);

    horizontal(e.h_below, b, gates, 0);
    for (uint32_t i = 0; i < b->n_rows; i++) {
        memcpy(e.h, e.h_below, sizeof(e.h));
        horizontal(e.h_below, b, gates, i + 1);
        join(e.v, b, gates, DX_EDGE_V, i, 0, i + 1, 0);
        cap_row(e.v, b, gates, i, 0, i + 1, 0, b->n_cols + 1);
        join(e.ac, b, gates, DX_EDGE_AC, i, 0, i + 1, 1);
        cap_row(e.ac, b, gates, i, 0, i + 1, 1, b->n_cols);
        join(e.bd, b, gates, DX_EDGE_BD, i, 1, i + 1, 0);
        cap_row(e.bd, b, gates, i, 1, i + 1, 0, b->n_cols);
        if (diag == DX_DIAG_SHORT)
            prefer(e.prefer_bd, b, gates->wide, i);
        code_row(code + (size_t)i * DX_TILE_CELLS, &e, b->n_cols);
        clear_folded(code + (size_t)i * DX_TILE_CELLS, gates,
                     (size_t)(row0 + i) * tiling->cell_cols + col0, b->n_cols);
    }
}
