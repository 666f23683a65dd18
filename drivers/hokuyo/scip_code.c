/* Numbers and check characters of SCIP 2.x. */
#include "drivers/hokuyo/scip_code.h"

#define BIAS 0x30
#define LAST 0x6F

uint32_t dx_scip_get(const uint8_t *chars, size_t n)
{
    uint32_t v = 0;

    for (size_t k = 0; k < n; k++) {
        if (chars[k] < BIAS || chars[k] > LAST)
            return DX_SCIP_INVALID;
        v = v << 6 | (uint32_t)(chars[k] - BIAS);
    }
    return v;
}

void dx_scip_put(uint8_t *chars, size_t n, uint32_t value)
{
    for (size_t k = n; k-- > 0; value >>= 6)
        chars[k] = (uint8_t)((value & 0x3F) + BIAS);
}

uint8_t dx_scip_sum(const uint8_t *bytes, size_t len)
{
    unsigned sum = 0;

    for (size_t k = 0; k < len; k++)
        sum += bytes[k];
    return (uint8_t)((sum & 0x3F) + BIAS);
}

bool dx_scip_sum_holds(const uint8_t *line, size_t len)
{
    return len >= 2 && dx_scip_sum(line, len - 1) == line[len - 1];
}

bool dx_scip_sum_holds_key(const uint8_t *line, size_t len)
{
    if (dx_scip_sum_holds(line, len))
        return true;
    return len >= 3 && line[len - 2] == ';' && dx_scip_sum(line, len - 2) == line[len - 1];
}
