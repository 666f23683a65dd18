/* The loops for every processor of the kind that is built for. */
#include "core/rows/rows_priv.h"

/* The eight bytes of `before`, the least significant first, each plus n. */
static inline void put_ranks(uint16_t *out, uint64_t before, uint32_t n)
{
    for (int k = 0; k < 8; k++)
        out[k] = (uint16_t)(n + (before >> 8 * k & 0xff));
}

/* Eight points. */
static inline void put_points(float *restrict out, const float *x, const float *y, const float *z)
{
    for (int k = 0; k < 8; k++) {
        out[3 * k] = x[k];
        out[3 * k + 1] = y[k];
        out[3 * k + 2] = z[k];
    }
}

/* At least six indices, two bytes each, of the corners a, b, d, c: those that `bytes` names
 * (rows_tiles.h). */
static inline void put_corners(uint16_t *out, const uint16_t *top, const uint16_t *bottom,
                               const uint8_t bytes[16])
{
    const uint16_t corner[4] = {top[0], top[1], bottom[0], bottom[1]};

    for (int m = 0; m < 6; m++)
        out[m] = corner[bytes[2 * m] / 2];
}

/* Eight full cells whose corners a and d have ranks from a and d on; bit 8 k of on_bd: cell k is
 * cut from b to d. Triangles a, b, c or d and a or b, c, d; flipped, their last two change places.
 */
static inline void put_full(uint16_t *restrict out, uint64_t on_bd, uint16_t a, uint16_t d,
                            bool flip)
{
    for (int k = 0; k < 8; k++, out += 6) {
        const unsigned bd = on_bd >> 8 * k & 1, top = a + (unsigned)k, bottom = d + (unsigned)k;

        out[0] = (uint16_t)top;
        out[1 + flip] = (uint16_t)(top + 1);
        out[2 - flip] = (uint16_t)(bottom + 1 - bd);
        out[3] = (uint16_t)(top + bd);
        out[4 + flip] = (uint16_t)(bottom + 1);
        out[5 - flip] = (uint16_t)bottom;
    }
}

#include "core/rows/rows_table.h"

const struct dx_rows dx_rows_generic = DX_ROWS_TABLE("generic");
