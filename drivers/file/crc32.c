/* CRC-32 from zlib. */
#include "drivers/file/crc32.h"

#include <zlib.h>

uint32_t dx_crc32(uint32_t crc, const void *bytes, size_t len)
{
    /* a null address asks zlib for the start value, whatever the length */
    return len ? (uint32_t)crc32_z(crc, bytes, len) : crc;
}
