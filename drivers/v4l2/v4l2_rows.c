/* Rows of codes and ranges. f32 products are rounded once and cut: the same everywhere. */
#include "drivers/v4l2/v4l2_rows.h"

#define NO_FIT 65536.0f

void dx_v4l2_row_be(uint16_t *row, const uint8_t *bytes, size_t n)
{
    for (size_t j = 0; j < n; j++)
        row[j] = (uint16_t)(bytes[2 * j] << 8 | bytes[2 * j + 1]);
}

void dx_v4l2_row_10b(uint16_t *row, const uint8_t *bytes, size_t n)
{
    for (size_t j = 0; j < n; j += 4, bytes += 5) {
        row[j] = (uint16_t)(bytes[0] << 2 | bytes[1] >> 6);
        row[j + 1] = (uint16_t)((bytes[1] & 0x3f) << 4 | bytes[2] >> 4);
        row[j + 2] = (uint16_t)((bytes[2] & 0x0f) << 6 | bytes[3] >> 2);
        row[j + 3] = (uint16_t)((bytes[3] & 0x03) << 8 | bytes[4]);
    }
}

void dx_v4l2_row_mask(uint16_t *row, size_t n, uint16_t mask)
{
    for (size_t j = 0; j < n; j++)
        row[j] &= mask;
}

void dx_v4l2_row_limit(uint16_t *row, size_t n, uint16_t lo, uint16_t hi, uint16_t invalid)
{
    for (size_t j = 0; j < n; j++) {
        uint16_t v = row[j];

        v = v >= lo ? v : 0;
        v = v <= hi ? v : 0;
        row[j] = v != invalid ? v : 0;
    }
}

size_t dx_v4l2_row_stretch(uint16_t *row, const float *stretch, size_t n)
{
    uint32_t n_beyond = 0;

    for (size_t j = 0; j < n; j++) {
        float r = (float)row[j] * stretch[j] + 0.5f;
        int32_t fits = r < NO_FIT;

        r = fits ? r : 0;
        row[j] = (uint16_t)(int32_t)r;
        n_beyond += !fits;
    }
    return n_beyond;
}

size_t dx_v4l2_row_lookup(uint16_t *row, const float *depth, const float *stretch, size_t n)
{
    uint32_t n_beyond = 0;

    for (size_t j = 0; j < n; j++) {
        float r = depth[row[j]] * (stretch ? stretch[j] : 1) + 0.5f;
        int32_t fits = r < NO_FIT;

        r = fits ? r : 0;
        row[j] = (uint16_t)(int32_t)r;
        n_beyond += !fits;
    }
    return n_beyond;
}
