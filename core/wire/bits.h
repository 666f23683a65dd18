/*
 * Strings of bits, least significant first: bit k of the string is bit k % 8 of byte k / 8. The
 * writer has the room it needs; the reader cannot leave its bytes, and one that ran out stays
 * failed and yields zeros.
 */
#ifndef DX_BITS_H
#define DX_BITS_H

#include "core/base/bytes.h"

struct dx_bit_writer {
    uint8_t *p;
    uint64_t bits;
    unsigned n; /* bits that wait; below 32 between calls */
};

/* The n lowest bits of v, at most 32; v has no others. */
static inline void dx_put_bits(struct dx_bit_writer *b, uint32_t v, unsigned n)
{
    b->bits |= (uint64_t)v << b->n;
    b->n += n;
    if (b->n >= 32) {
        dx_put_u32(b->p, (uint32_t)b->bits);
        b->p += 4;
        b->bits >>= 32;
        b->n -= 32;
    }
}

/* The same of up to 64 bits. */
static inline void dx_put_long_bits(struct dx_bit_writer *b, uint64_t v, unsigned n)
{
    const unsigned low = n < 32 ? n : 32;

    dx_put_bits(b, (uint32_t)v, low);
    dx_put_bits(b, (uint32_t)(v >> low), n - low);
}

/* n ones and a zero. */
static inline void dx_put_unary(struct dx_bit_writer *b, unsigned n)
{
    for (; n >= 31; n -= 31)
        dx_put_bits(b, 0x7fffffffu, 31);
    dx_put_bits(b, (1u << n) - 1, n + 1);
}

/* Fills the last byte with zeros; where the bytes end. */
static inline uint8_t *dx_end_bits(struct dx_bit_writer *b)
{
    for (; b->n > 0; b->n = b->n > 8 ? b->n - 8 : 0, b->bits >>= 8)
        *b->p++ = (uint8_t)b->bits;
    return b->p;
}

struct dx_bit_reader {
    const uint8_t *p, *end;
    uint64_t bits;
    unsigned n; /* bits at hand */
    bool failed;
};

static inline struct dx_bit_reader dx_bit_reader_init(const uint8_t *p, const uint8_t *end)
{
    return (struct dx_bit_reader){.p = p, .end = end};
}

/* At least 32 bits at hand, while there are so many. */
static inline void dx_refill_bits(struct dx_bit_reader *b)
{
    if (b->n >= 32)
        return;
    if (b->end - b->p >= 4) {
        b->bits |= (uint64_t)dx_get_u32(b->p) << b->n;
        b->p += 4;
        b->n += 32;
        return;
    }
    for (; b->p < b->end; b->n += 8)
        b->bits |= (uint64_t)*b->p++ << b->n;
}

/* The next n bits, at most 32. */
static inline uint32_t dx_get_bits(struct dx_bit_reader *b, unsigned n)
{
    uint32_t v;

    dx_refill_bits(b);
    if (n > b->n) {
        b->failed = true;
        return 0;
    }
    v = (uint32_t)(b->bits & ((UINT64_C(1) << n) - 1));
    b->bits >>= n;
    b->n -= n;
    return v;
}

/* How many ones before a zero; more than `max` fail. */
static inline unsigned dx_get_unary(struct dx_bit_reader *b, unsigned max)
{
    unsigned n = 0;

    while (dx_get_bits(b, 1))
        if (++n > max) {
            b->failed = true;
            return 0;
        }
    return n;
}

/* Where the bytes go on; NULL when the reader has failed or the rest of its last byte is not zero.
 */
static inline const uint8_t *dx_finish_bits(struct dx_bit_reader *b)
{
    unsigned spare = b->n % 8;

    if (b->failed || dx_get_bits(b, spare) != 0)
        return NULL;
    return b->p - b->n / 8;
}

#endif
