/*
 * The characters of SCIP 2.x: numbers in six-bit groups, and the check character (DEVICES 1.2,
 * 1.3). Pure functions.
 */
#ifndef DX_SCIP_CODE_H
#define DX_SCIP_CODE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define DX_SCIP_INVALID UINT32_MAX

/* A number of 1 to 4 characters, most significant first; DX_SCIP_INVALID when one is outside
 * 0x30..0x6F. */
uint32_t dx_scip_get(const uint8_t *chars, size_t n);
/* The low 6 n bits. */
void dx_scip_put(uint8_t *chars, size_t n, uint32_t value);

/* The check character of `len` bytes. */
uint8_t dx_scip_sum(const uint8_t *bytes, size_t len);

/* Whether the last of `len` bytes is the check character of those before it; at least two bytes. */
bool dx_scip_sum_holds(const uint8_t *line, size_t len);

/* The same for "KEY:value;X": the semicolon is not summed; those who sum it are accepted as well.
 */
bool dx_scip_sum_holds_key(const uint8_t *line, size_t len);

#endif
