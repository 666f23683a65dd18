/* CRC-32 (IEEE 802.3), as MCAP wants it. */
#ifndef DX_CRC32_H
#define DX_CRC32_H

#include <stddef.h>
#include <stdint.h>

/* Of `len` bytes, continuing from `crc` (0 to start). */
uint32_t dx_crc32(uint32_t crc, const void *bytes, size_t len);

#endif
