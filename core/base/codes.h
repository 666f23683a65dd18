/* Cell codes (0 to 6), one a byte, eight in a word: as three bits each, and how many triangles. */
#ifndef DX_CODES_H
#define DX_CODES_H

#include <stdint.h>

/* To 24 bits, the first code's lowest. */
static inline uint64_t dx_codes_pack8(uint64_t x)
{
    x = (x | x >> 5) & 0x003f003f003f003fu;
    x = (x | x >> 10) & 0x00000fff00000fffu;
    return (x | x >> 20) & 0xffffffu;
}

/* Triangles of each, in its byte: one for each code but 0, one more for 3 and 6. */
static inline uint64_t dx_codes_triangles8(uint64_t x)
{
    const uint64_t ones = 0x0101010101010101u;

    return ((x | x >> 1 | x >> 2) & ones) + ((x >> 1) & (x ^ x >> 2) & ones);
}

#endif
