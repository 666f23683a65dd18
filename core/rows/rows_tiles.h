/*
 * The loops of rows.h over tiles: which dexels the cells use, their ranks, points and triangles.
 * Included once by each rows_SET.c, after its own put_... (rows_generic.c tells what they do).
 */
#include "core/base/bytes.h"
#include "core/rows/rows.h"

#define EACH 0x0101010101010101u /* of eight bytes */

/* Each corner is spared by exactly one outcome beside "none" (enum dx_cell: bcd 5, acd 2, abd 4,
 * abc 1). */
static void use_row(uint8_t *restrict top, uint8_t *restrict bottom, const uint8_t *code)
{
    uint8_t a[CELLS], b[CELLS], c[CELLS], d[CELLS];

    for (uint32_t j = 0; j < CELLS; j++) {
        uint8_t some = code[j] != 0;

        a[j] = some & (code[j] != 5);
        b[j] = some & (code[j] != 2);
        c[j] = some & (code[j] != 4);
        d[j] = some & (code[j] != 1);
    }
    for (uint32_t j = 0; j < CELLS; j++) {
        top[j] |= a[j];
        bottom[j] |= d[j];
    }
    for (uint32_t j = 0; j < CELLS; j++) {
        top[j + 1] |= b[j];
        bottom[j + 1] |= c[j];
    }
}

/* Eight bytes of 0 or 1 times 1 in each byte are the sums up to each. */
static uint32_t rank_all(uint16_t *restrict rank, const uint8_t *used, uint32_t n_eights)
{
    uint32_t n = 0;

    for (uint32_t at = 0; at < 8 * n_eights; at += 8) {
        const uint64_t eight = dx_get_u64(used + at), sums = eight * EACH;

        put_ranks(rank + at, sums - eight, n);
        n += (uint32_t)(sums >> 56);
    }
    return n;
}

static uint32_t halves_all(uint16_t *restrict out, const uint32_t *range, const uint8_t *used,
                           uint32_t n_eights)
{
    uint32_t all = 0;

    for (size_t k = 0; k < 8 * (size_t)n_eights; k++) {
        uint32_t r = used[k] ? range[k] : 0;

        out[k] = (uint16_t)r;
        all |= r;
    }
    return all;
}

static inline float *keep_points(float *restrict out, const float *x, const float *y,
                                 const float *z, const uint8_t *used, uint32_t n)
{
    for (uint32_t j = 0; j < n; j++) {
        out[0] = x[j];
        out[1] = y[j];
        out[2] = z[j];
        out += 3 * used[j];
    }
    return out;
}

static inline float *keep_eight(float *restrict out, const float *x, const float *y, const float *z,
                                const uint8_t *used)
{
    if (dx_get_u64(used) != EACH)
        return keep_points(out, x, y, z, used, 8);
    put_points(out, x, y, z);
    return out + 24;
}

/* The operations are those of dx_geometry_point. A tile's first column is used by struts alone: the
 * eights begin after it. */
static float *spin_row(float *restrict out, const struct dx_row_spin *spin, const uint32_t *range,
                       const uint8_t *used)
{
    const float *d = spin->row, unit_m = spin->unit_m;
    float x[DX_ROWS_SPIN], y[DX_ROWS_SPIN], z[DX_ROWS_SPIN];

    for (uint32_t j = 0; j < DX_ROWS_SPIN; j++) {
        float r = (float)range[j] * unit_m;
        float u = d[3] + r * d[0], v = d[4] + r * d[1];

        x[j] = u * spin->c[j] - v * spin->s[j];
        y[j] = u * spin->s[j] + v * spin->c[j];
        z[j] = d[5] + r * d[2];
    }
    out = keep_points(out, x, y, z, used, 1);
    for (uint32_t j = 1; j <= CELLS; j += 8)
        out = keep_eight(out, x + j, y + j, z + j, used + j);
    return keep_points(out, x + CELLS + 1, y + CELLS + 1, z + CELLS + 1, used + CELLS + 1, 2);
}

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

/* No branch on what a cell is: noise makes the diagonals a coin toss, and drop-outs the rest. All
 * corners of full cells are used, so that their ranks follow each other. */
static uint16_t *emit_row(uint16_t *restrict out, const uint8_t *code, const uint16_t *top,
                          const uint16_t *bottom, bool flip)
{
    const uint8_t(*bytes)[16] = order[flip];

    for (uint32_t j = 0; j < CELLS; j += 8) {
        const uint64_t eight = dx_get_u64(code + j);

        if (are_full(eight)) {
            put_full(out, eight >> 2 & EACH, top[j], bottom[j], flip);
            out += 48;
            continue;
        }
        for (uint32_t k = j; k < j + 8; k++) {
            put_corners(out, top + k, bottom + k, bytes[code[k]]);
            out += n_indices[code[k]];
        }
    }
    return out;
}
