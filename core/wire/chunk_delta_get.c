/* Decoder of the delta encoding's codes and ranges: every bit is checked. Pure functions. */
#include "core/wire/bits.h"
#include "core/base/delta.h"
#include "core/wire/chunk_parts.h"

/* ---- cell codes ----------------------------------------------------------------------------- */

/* "0", "10", "110", "111". */
static unsigned get_kind(struct dx_bit_reader *b)
{
    unsigned kind = 0;

    while (kind < 3 && dx_get_bits(b, 1))
        kind++;
    return kind;
}

/* Spreads n codes of three bits, or of one that tells the two full outcomes apart. */
static bool get_group(uint8_t *code, struct dx_bit_reader *b, unsigned n)
{
    const unsigned kind = get_kind(b);
    uint32_t bits = 0;

    if (kind == 1)
        bits = dx_get_bits(b, n);
    else if (kind == 3)
        bits = dx_get_bits(b, 3 * n);
    for (unsigned j = 0; j < n; j++) {
        if (kind == 3)
            code[j] = bits >> 3 * j & 7;
        else if (kind != 2)
            code[j] = bits >> j & 1 ? DX_CELL_ABD_BCD : DX_CELL_ABC_ACD;
        if (code[j] > DX_CELL_ABD_BCD)
            return false;
    }
    return true;
}

const uint8_t *dx_delta_get_codes(struct dx_tile *tile, const uint8_t *p, const uint8_t *end)
{
    struct dx_bit_reader b = dx_bit_reader_init(p, end);

    for (uint32_t i = 0; i < tile->cell_rows; i++)
        for (uint32_t j = 0; j < tile->cell_cols; j += 8) {
            const uint32_t left = tile->cell_cols - j;

            if (!get_group(tile->code + DX_TILE_CELLS * i + j, &b, left < 8 ? left : 8))
                return NULL;
        }
    return dx_finish_bits(&b);
}

/* ---- ranges --------------------------------------------------------------------------------- */

struct decoder {
    struct dx_bit_reader bits;
    enum dx_delta_predictor predictor;
    uint32_t n, width; /* residuals so far; of the block they are in */
    uint32_t last;     /* range */
};

static uint32_t next_residual(struct decoder *d)
{
    if (d->n++ % DX_DELTA_BLOCK == 0) {
        d->width += dx_delta_unfold(dx_get_unary(&d->bits, 2 * DX_DELTA_MAX_WIDTH));
        if (d->width > DX_DELTA_MAX_WIDTH) { /* below 0, too: modulo 2^32 */
            d->bits.failed = true;
            d->width = 0;
        }
    }
    return dx_delta_unfold(dx_get_bits(&d->bits, d->width));
}

/* False: the residuals have run out, or a range is 0. */
static bool get_row(struct decoder *d, struct dx_tile *tile, const struct dx_used *used,
                    uint32_t row)
{
    const dx_bits here = used->row[row], north = row ? used->row[row - 1] : 0;

    for (dx_bits left = here; left; left &= left - 1) {
        const uint32_t col = dx_bits_first(left);
        uint32_t *at = tile->range + row * DX_BLOCK + col;
        const bool has_w = dx_bits_at(here << 1, col), has_n = dx_bits_at(north, col);
        uint32_t expected;

        if (has_w && has_n && dx_bits_at(north << 1, col))
            expected = dx_delta_predict(d->predictor, at[-1], at[-DX_BLOCK], at[-DX_BLOCK - 1]);
        else
            expected = has_w ? at[-1] : has_n ? at[-DX_BLOCK] : d->last;
        *at = d->last = expected + next_residual(d);
        if (*at == 0 || d->bits.failed)
            return false;
    }
    return true;
}

const uint8_t *dx_delta_get_ranges(struct dx_tile *tile, const struct dx_used *used,
                                   const uint8_t *p, const uint8_t *end)
{
    struct decoder d = {0};

    if (end - p < 5 || *p >= DX_N_DELTA_PREDICTORS)
        return NULL;
    d.predictor = *p;
    d.last = dx_get_u32(p + 1);
    d.bits = dx_bit_reader_init(p + 5, end);
    for (uint32_t row = 0; row < DX_BLOCK; row++)
        if (!get_row(&d, tile, used, row))
            return NULL;
    return dx_finish_bits(&d.bits);
}
