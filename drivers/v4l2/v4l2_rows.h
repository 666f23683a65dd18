/*
 * The loops of the V4L2 decoder: a row of bytes to 16-bit codes, a row of codes to ranges, in
 * place. Written so that compilers make vectors of them; the same ranges whatever they make. Pure
 * functions, any thread.
 */
#ifndef DX_V4L2_ROWS_H
#define DX_V4L2_ROWS_H

#include <stddef.h>
#include <stdint.h>

void dx_v4l2_row_be(uint16_t *row, const uint8_t *bytes, size_t n);
/* Four in five bytes, the first bit of the first byte is the highest of the first; n % 4 == 0. */
void dx_v4l2_row_10b(uint16_t *row, const uint8_t *bytes, size_t n);
void dx_v4l2_row_mask(uint16_t *row, size_t n, uint16_t mask);

/* Codes that are units: what is outside lo..hi, or `invalid`, becomes 0. */
void dx_v4l2_row_limit(uint16_t *row, size_t n, uint16_t lo, uint16_t hi, uint16_t invalid);
/* Depths to ranges, by the range of each for a depth of 1; what does not fit becomes 0. Returns how
 * many. */
size_t dx_v4l2_row_stretch(uint16_t *row, const float *stretch, size_t n);
/* The same for codes whose depths are looked up; `stretch` NULL: depths stay. 0 is no depth. */
size_t dx_v4l2_row_lookup(uint16_t *row, const float *depth, const float *stretch, size_t n);

#endif
