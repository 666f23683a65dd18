/*
 * The loops of rows.h that keep what is used and leave out the rest, eight dexels or cells at a
 * time: eights of which all are there, as most are, in whole vectors. Included once by each
 * rows_SET.c that has nothing better, after its own put_... (rows_generic.c tells what they do).
 */
#include "core/base/bytes.h"
#include "core/rows/rows_tiles.h"

#include <string.h>

#define EACH 0x0101010101010101u /* of eight bytes */

/* A tile's first column is used by struts alone: the eights begin after it, and there are two
 * columns more behind them. */
#define FIRST_EIGHT 1
#define EIGHTS_END  (DX_ROWS_CELLS + 1)
#define COLUMNS     (DX_ROWS_CELLS + 3)

/* Whether columns [j, j + 8) are all used. */
static inline bool are_used(dx_bits used, uint32_t j)
{
    return (uint8_t)(used >> j) == 0xff;
}

/* ---- points --------------------------------------------------------------------------------- */

/* Columns [j, end): each is written, and kept if it is used. */
static inline dx_packed_f32 *keep_points(dx_packed_f32 *restrict out, const float *x,
                                         const float *y, const float *z, dx_bits used, uint32_t j,
                                         uint32_t end)
{
    for (; j < end; j++) {
        out[0] = x[j];
        out[1] = y[j];
        out[2] = z[j];
        out += 3 * dx_bits_at(used, j);
    }
    return out;
}

static dx_packed_f32 *spin_row(dx_packed_f32 *restrict out, const struct dx_row_spin *spin,
                               const uint32_t *range, dx_bits used)
{
    float x[DX_ROWS_N], y[DX_ROWS_N], z[DX_ROWS_N];

    spin_points(x, y, z, spin, range);
    out = keep_points(out, x, y, z, used, 0, FIRST_EIGHT);
    for (uint32_t j = FIRST_EIGHT; j < EIGHTS_END; j += 8) {
        if (are_used(used, j)) {
            put_points(out, x + j, y + j, z + j);
            out += 24;
        } else {
            out = keep_points(out, x, y, z, used, j, j + 8);
        }
    }
    return keep_points(out, x, y, z, used, EIGHTS_END, COLUMNS);
}

/* ---- values --------------------------------------------------------------------------------- */

static inline uint32_t *keep_values(uint32_t *restrict out, const uint32_t *v, dx_bits used,
                                    uint32_t j, uint32_t end)
{
    for (; j < end; j++) {
        *out = v[j];
        out += dx_bits_at(used, j);
    }
    return out;
}

static uint32_t *keep_row(uint32_t *restrict out, const uint32_t *v, dx_bits used)
{
    out = keep_values(out, v, used, 0, FIRST_EIGHT);
    for (uint32_t j = FIRST_EIGHT; j < EIGHTS_END; j += 8) {
        if (are_used(used, j)) {
            memcpy(out, v + j, 8 * sizeof(*out));
            out += 8;
        } else {
            out = keep_values(out, v, used, j, j + 8);
        }
    }
    return keep_values(out, v, used, EIGHTS_END, COLUMNS);
}

static uint16_t *keep16_row(uint16_t *restrict out, const uint32_t *v, dx_bits used)
{
    uint32_t kept[DX_ROWS_N + DX_ROWS_SLACK];
    const uint32_t n = (uint32_t)(keep_row(kept, v, used) - kept);

    for (uint32_t k = 0; k < DX_ROWS_N; k++)
        out[k] = (uint16_t)kept[k];
    return out + n;
}

/* ---- triangles ------------------------------------------------------------------------------ */

/* Bytes of the corners a, b, d, c (two each) that the outcomes store, in index order and flipped.
 */
#define SIX(a, b, c, d, e, f)                                                                      \
    {                                                                                              \
        2 * (a), 2 * (a) + 1, 2 * (b), 2 * (b) + 1, 2 * (c), 2 * (c) + 1, 2 * (d), 2 * (d) + 1,    \
            2 * (e), 2 * (e) + 1, 2 * (f), 2 * (f) + 1, 128, 128, 128, 128                         \
    }
enum { A, B, D, C };

static const uint8_t order[2][8][16] = {
    {{0},
     SIX(A, B, C, A, A, A),
     SIX(A, C, D, A, A, A),
     SIX(A, B, C, A, C, D),
     SIX(A, B, D, A, A, A),
     SIX(B, C, D, A, A, A),
     SIX(A, B, D, B, C, D)},
    {{0},
     SIX(A, C, B, A, A, A),
     SIX(A, D, C, A, A, A),
     SIX(A, C, B, A, D, C),
     SIX(A, D, B, A, A, A),
     SIX(B, D, C, A, A, A),
     SIX(A, D, B, B, D, C)},
};
static const uint8_t n_indices[8] = {0, 3, 3, 6, 3, 3, 6};

/* Whether eight cells have two triangles each: 3 (abc, acd) or 6 (abd, bcd). */
static inline bool are_full(uint64_t eight)
{
    const uint64_t other = eight ^ 3 * EACH; /* 5 where abd, bcd */

    return (other & ~(5 * EACH)) == 0 && ((other ^ other >> 2) & EACH) == 0;
}

/* Ranks of eight dexels, of which those of `used` are used, and of the one after them; the first
 * one's is n. Eight bytes of 0 or 1 times 1 in each byte are the sums up to each. */
static inline void find_ranks(uint16_t rank[9], uint64_t used, uint16_t n)
{
    const uint64_t eight = dx_bits_spread8(used), sums = eight * EACH;

    put_ranks(rank, sums - eight, n);
    rank[8] = (uint16_t)(n + (sums >> 56));
}

static void rank_row(uint16_t *restrict rank, dx_bits used, uint16_t first)
{
    uint16_t eight[9] = {[8] = first};

    for (uint32_t j = 0; j < DX_ROWS_N; j += 8) {
        find_ranks(eight, (uint64_t)(used >> j), eight[8]);
        memcpy(rank + j, eight, 8 * sizeof(*rank));
    }
}

/* No branch on what a cell is: noise makes the diagonals a coin toss, and drop-outs the rest. All
 * corners of full cells are used, so that their ranks follow each other. */
static dx_packed_u16 *emit_row(dx_packed_u16 *restrict out, const uint8_t *code,
                               const struct dx_row_ranks *ranks, bool flip)
{
    const uint64_t top = (uint64_t)(ranks->top >> 1), bottom = (uint64_t)(ranks->bottom >> 1);
    uint16_t a[9] = {[8] = (uint16_t)(ranks->first_top + (ranks->top & 1))};
    uint16_t d[9] = {[8] = (uint16_t)(ranks->first_bottom + (ranks->bottom & 1))};

    for (uint32_t j = 0; j < DX_ROWS_CELLS; j += 8) {
        const uint64_t eight = dx_get_u64(code + j);

        if (are_full(eight)) {
            put_full(out, eight >> 2 & EACH, a[8], d[8], flip);
            a[8] = (uint16_t)(a[8] + 8);
            d[8] = (uint16_t)(d[8] + 8);
            out += 48;
            continue;
        }
        find_ranks(a, top >> j, a[8]);
        find_ranks(d, bottom >> j, d[8]);
        for (uint32_t k = 0; k < 8; k++) {
            put_corners(out, a + k, d + k, order[flip][code[j + k]]);
            out += n_indices[code[j + k]];
        }
    }
    return out;
}
