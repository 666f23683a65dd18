/*
 * The loops of rows.h that take rows of bits: what the rules say of whole rows is operations on
 * words, and each iteration is a row, so that vectors take several. Included once by each
 * rows_SET.c.
 */
#include "core/rows/rows.h"

#include <stddef.h>

/* ---- a row ---------------------------------------------------------------------------------- */

struct pair {
    uint64_t low, high;
};

#define ALWAYS static inline __attribute__((always_inline))

ALWAYS struct pair row_of(const struct dx_row_words *w, size_t p)
{
    return (struct pair){w->low[p + 1], w->high[p + 1]};
}

ALWAYS void put_row(struct dx_row_words *w, size_t p, struct pair x)
{
    w->low[p + 1] = x.low;
    w->high[p + 1] = x.high;
}

ALWAYS struct pair both(struct pair x, struct pair y)
{
    return (struct pair){x.low & y.low, x.high & y.high};
}

ALWAYS struct pair either(struct pair x, struct pair y)
{
    return (struct pair){x.low | y.low, x.high | y.high};
}

ALWAYS struct pair without(struct pair x, struct pair y)
{
    return (struct pair){x.low & ~y.low, x.high & ~y.high};
}

ALWAYS struct pair differ(struct pair x, struct pair y)
{
    return (struct pair){x.low ^ y.low, x.high ^ y.high};
}

/* At each column what the one before it, or after it, says. */
ALWAYS struct pair from_before(struct pair x)
{
    return (struct pair){x.low << 1, x.high << 1 | x.low >> 63};
}

ALWAYS struct pair from_after(struct pair x)
{
    return (struct pair){x.low >> 1 | x.high << 63, x.high >> 1};
}

/* ---- edges ---------------------------------------------------------------------------------- */

/* The edges of row p both of whose ends are among the dexels. */
ALWAYS void find_both(struct pair out[DX_ROW_EDGES], const struct dx_row_words *dexels, size_t p)
{
    const struct pair here = row_of(dexels, p), below = row_of(dexels, p + 1);

    out[0] = both(here, from_after(here));
    out[1] = both(here, below);
    out[2] = both(here, from_after(below));
    out[3] = both(from_after(here), below);
}

static void join_there_words(struct dx_row_words joined[restrict DX_ROW_EDGES],
                             struct dx_row_words failed[restrict DX_ROW_EDGES],
                             uint64_t some_failed[restrict DX_WORDS_ROWS],
                             const struct dx_row_words *restrict valid)
{
    for (size_t p = 0; p < DX_WORDS_ROWS; p++) {
        struct pair there[DX_ROW_EDGES], some = {0, 0};

        find_both(there, valid, p);
        for (int e = 0; e < DX_ROW_EDGES; e++) {
            const struct pair near = row_of(&joined[e], p), not_near = without(there[e], near);

            some = either(some, not_near);
            put_row(&joined[e], p, both(there[e], near));
            put_row(&failed[e], p, not_near);
        }
        some_failed[p] = some.low | some.high;
    }
}

static void keep_alive_words(struct dx_row_words edge[restrict DX_ROW_EDGES],
                             const struct dx_row_words joined[restrict DX_ROW_EDGES],
                             const struct dx_row_words *restrict alive)
{
    for (size_t p = 0; p < DX_WORDS_ROWS; p++) {
        struct pair there[DX_ROW_EDGES];

        find_both(there, alive, p);
        for (int e = 0; e < DX_ROW_EDGES; e++)
            put_row(&edge[e], p, both(row_of(&joined[e], p), there[e]));
    }
}

/* ---- mixed samples -------------------------------------------------------------------------- */

static void attached_words(struct dx_row_words *restrict alive,
                           const struct dx_row_words *restrict valid,
                           const struct dx_row_words joined[restrict DX_ROW_EDGES])
{
    for (size_t p = 0; p < DX_WORDS_ROWS; p++) {
        const struct pair here = row_of(valid, p), h = row_of(&joined[0], p);
        const struct pair v = either(row_of(&joined[1], p - 1), row_of(&joined[1], p));
        const struct pair in_row =
            without(both(from_before(here), from_after(here)), either(from_before(h), h));
        const struct pair in_column = without(both(row_of(valid, p - 1), row_of(valid, p + 1)), v);

        put_row(alive, p, without(here, either(in_row, in_column)));
    }
}

/* Sums of one bit each, column by column: up to 3, and whether there were more. */
struct count {
    struct pair ones, twos, more;
};

ALWAYS struct count add_bits(struct count n, struct pair row)
{
    const struct pair carry = both(n.ones, row);

    return (struct count){differ(n.ones, row), differ(n.twos, carry),
                          either(n.more, both(n.twos, carry))};
}

static void well_joined_words(struct dx_row_words *restrict alive,
                              const struct dx_row_words joined[restrict DX_ROW_EDGES])
{
    for (size_t p = 0; p < DX_WORDS_ROWS; p++) {
        struct count n = {{0, 0}, {0, 0}, {0, 0}};

        n = add_bits(n, from_before(row_of(&joined[0], p)));
        n = add_bits(n, row_of(&joined[0], p));
        n = add_bits(n, row_of(&joined[1], p - 1));
        n = add_bits(n, row_of(&joined[1], p));
        n = add_bits(n, from_before(row_of(&joined[2], p - 1)));
        n = add_bits(n, row_of(&joined[2], p));
        n = add_bits(n, row_of(&joined[3], p - 1));
        n = add_bits(n, from_before(row_of(&joined[3], p)));
        put_row(alive, p, both(row_of(alive, p), n.more));
    }
}

/* ---- cells ---------------------------------------------------------------------------------- */

/* The tile's own cells of row p. */
ALWAYS uint64_t own(struct pair x, uint32_t margin)
{
    return x.low >> margin | x.high << (64 - margin);
}

static void triangles_words(struct dx_row_cells *restrict out,
                            const struct dx_row_words edge[restrict DX_ROW_EDGES], uint32_t margin)
{
    for (size_t i = 0; i < CELLS; i++) {
        const size_t p = margin + i; /* in 32 bits it might begin anew at 0: no vectors */
        const struct pair v = row_of(&edge[1], p);
        const uint64_t ab = own(row_of(&edge[0], p), margin);
        const uint64_t dc = own(row_of(&edge[0], p + 1), margin);
        const uint64_t ad = own(v, margin), bc = own(from_after(v), margin);
        const uint64_t ac = own(row_of(&edge[2], p), margin);
        const uint64_t bd = own(row_of(&edge[3], p), margin);
        const uint64_t abc = ab & bc & ac, acd = dc & ad & ac, abd = ab & ad & bd;
        const uint64_t bcd = bc & dc & bd, two = abc & acd & abd & bcd;

        out->abc[i] = abc;
        out->acd[i] = acd;
        out->abd[i] = abd;
        out->bcd[i] = bcd;
        out->even[i] = two | ((abc ^ acd) & (abd ^ bcd));
    }
}

/* Cut from b to d: there are more triangles, or as many and b-d is preferred. The three bits of a
 * code: abc + 2 acd, or on b-d three more than abd + 2 bcd. */
static void outcomes_words(uint64_t bit[restrict 3][CELLS], const struct dx_row_cells *restrict t,
                           const uint64_t prefer_bd[restrict CELLS],
                           const uint64_t is_cell[restrict CELLS])
{
    for (size_t i = 0; i < CELLS; i++) {
        const uint64_t abc = t->abc[i], acd = t->acd[i], abd = t->abd[i], bcd = t->bcd[i];
        const uint64_t more = (abd & bcd & ~(abc & acd)) | ((abd | bcd) & ~(abc | acd));
        const uint64_t on_bd = (more | (t->even[i] & prefer_bd[i])) & is_cell[i];
        const uint64_t on_ac = ~on_bd & is_cell[i];

        bit[0][i] = (on_ac & abc) | (on_bd & ~abd);
        bit[1][i] = (on_ac & acd) | (on_bd & abd & bcd);
        bit[2][i] = on_bd;
    }
}

/* Each corner is spared by exactly one outcome beside "none" (bcd 5, acd 2, abd 4, abc 1). Cells
 * begin at block row and column 1. */
static void corners_words(dx_bits used[CELLS + 3], const uint64_t bit[restrict 3][CELLS])
{
    uint64_t low[CELLS + 3] = {0}, high[CELLS + 3] = {0}; /* of a row of cells' lower corners */

    for (size_t i = 0; i < CELLS; i++) {
        const uint64_t x = bit[0][i], y = bit[1][i], z = bit[2][i], some = x | y | z;
        const uint64_t c = some & ~(z & ~x & ~y), d = some & ~(x & ~y & ~z);

        low[i + 2] = d << 1 | c << 2;
        high[i + 2] = d >> 63 | c >> 62;
    }
    for (size_t i = 0; i < CELLS; i++) {
        const uint64_t x = bit[0][i], y = bit[1][i], z = bit[2][i], some = x | y | z;
        const uint64_t a = some & ~(x & z), b = some & ~(y & ~x & ~z);

        low[i + 1] |= a << 1 | b << 2;
        high[i + 1] |= a >> 63 | b >> 62;
    }
    for (size_t i = 0; i < CELLS + 3; i++)
        used[i] = low[i] | (dx_bits)high[i] << 64;
}

#undef ALWAYS
