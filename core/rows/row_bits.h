/*
 * Rows of dexels of which each is so or not, as bits: bit q is column q. What the rules say of
 * whole rows is then a few operations on words. Pure functions; any thread.
 */
#ifndef DX_ROW_BITS_H
#define DX_ROW_BITS_H

#include <stdbool.h>
#include <stdint.h>

typedef unsigned __int128 dx_bits;

static inline bool dx_bits_at(dx_bits row, uint32_t q)
{
    return (q < 64 ? (uint64_t)row : (uint64_t)(row >> 64)) >> q % 64 & 1;
}

/* The first column that is so; there is one. Clearing it (row &= row - 1) leads to the next. */
static inline uint32_t dx_bits_first(dx_bits row)
{
    const uint64_t low = (uint64_t)row, high = (uint64_t)(row >> 64);

    return (uint32_t)(low ? __builtin_ctzll(low) : 64 + __builtin_ctzll(high));
}

/* Columns [0, n), n < 128. */
static inline dx_bits dx_bits_below(uint32_t n)
{
    return ((dx_bits)1 << n) - 1;
}

static inline uint32_t dx_bits_count(dx_bits row)
{
    return (uint32_t)(__builtin_popcountll((uint64_t)row) +
                      __builtin_popcountll((uint64_t)(row >> 64)));
}

/* Rows of a tile's neighbourhood, the low words of all of them apart from the high ones: rules that
 * are operations on words take several rows at a time. */
#define DX_WORDS_ROWS 80 /* whole vectors */

struct dx_row_words {
    uint64_t low[DX_WORDS_ROWS + 2], high[DX_WORDS_ROWS + 2]; /* of row p at p + 1 */
};

static inline dx_bits dx_words_at(const struct dx_row_words *w, uint32_t p)
{
    return w->low[p + 1] | (dx_bits)w->high[p + 1] << 64;
}

static inline void dx_words_put(struct dx_row_words *w, uint32_t p, dx_bits row)
{
    w->low[p + 1] = (uint64_t)row;
    w->high[p + 1] = (uint64_t)(row >> 64);
}

/* Eight bits to eight bytes of 0 or 1: a copy of them in each byte, which keeps another bit. */
static inline uint64_t dx_bits_spread8(uint64_t bits)
{
    const uint64_t each = 0x0101010101010101u, kept = (bits & 0xff) * each & 0x8040201008040201u;

    return (kept + 0x7f * each) >> 7 & each;
}

#endif
